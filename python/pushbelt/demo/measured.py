"""The FMU at the points of a measured transmission. The loss of the variator alone must be below that of the transmission."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi

from pushbelt.fmu.data import EfficiencyPoint, clamping_force, measured_efficiencies, pitch_radius
from pushbelt.fmu.load_cases import NotFoundError
from pushbelt.fmu.starts import driven_by_torque
from pushbelt.fmu.unit import Archive, Instance

from .results import MeasuredPoint

SAFETY = 1.3
"""Safety factor of the clamping force, equal to that of the load cases."""

LEAST_FORCE = 4e3
"""Least clamping force, N."""


def run(archive: Archive, parameters: Mapping[str, float]) -> tuple[MeasuredPoint, ...]:
    """Steady states at the measured ratios, speeds and torques."""
    return tuple(_at(archive, parameters, point) for point in measured_efficiencies())


def _at(archive: Archive, parameters: Mapping[str, float], point: EfficiencyPoint) -> MeasuredPoint:
    radius = pitch_radius(parameters, point.ratio)
    friction, wedge_angle = parameters["friction.pulley"], parameters["geometry.wedgeAngle"]
    force = max(clamping_force(point.torque, radius, friction, wedge_angle, SAFETY), LEAST_FORCE)
    start_values = driven_by_torque(parameters, point.ratio, point.speed * pi / 30.0, point.torque, force)
    with Instance(archive, start_values) as unit:
        unit.initialise()
        if unit.not_steady:
            raise NotFoundError(
                f"at ratio {point.ratio:g}, {point.speed:g} rpm, {point.torque:g} N·m the FMU reports: {unit.not_steady}"
            )
        spin = unit.get("loss.spin") / (unit.get("primary.externalTorque") * unit.get("primary.speed"))
        return MeasuredPoint(point, force, unit.get("efficiency"), spin)
