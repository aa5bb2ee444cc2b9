"""Spiral running: how far elements move in and out along an arc, by the law of tilt and contact.

The axial pressure p_ax of the belt tilts a sheave by ψ under the moment ∫p_ax ϱ (cos θ, sin θ), first by its clearance, then by
bending, and so opens the groove by w = ϱ (ψ_x cos θ + ψ_y sin θ). A flank under the normal force p per length is pressed in by g = p/(k_c cos β). An element
runs further in by the sum of both over the slope of the groove,

    Δϱ = −(w + g)/tan β.

The normal force is read from the fields along the belt, and scaled so that it gives the axial force. With a uniform
pressure and no g the spread over an arc of angle α would be (ϱ ψ/tan β) (1 − cos(α/2)), ψ the tilt under F ϱ sin(α/2)/(α/2). That
is no measure: the pressure rises up to 2.5-fold towards the exit and turns the tilt by up to 45°.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from pushbelt.fmu.data import curve_at
from pushbelt.fmu.fields import EDGE
from pushbelt.fmu.results import BeltState, LoadCaseResult
from pushbelt.fmu.tilt import tilt_under

TOLERANCE = 0.1
"""Of the predicted spread, upwards and downwards: twice what the points of the profile leave out.

They are 10 mm apart, and friction along the flank has an axial share that the normal force does not show. So the normal
forces at the points miss the axial force by up to 5 %."""


@dataclass(frozen=True)
class SpiralRunning:
    """Spread of the running radius between the points of the profile on one arc."""

    pulley: str
    axial_force: float
    """N."""
    axial_force_at_points: float
    """Sum of the normal forces at the points of the profile, along the axis, N."""
    wrap_angle: float
    """rad."""
    tilt: float
    """|ψ|, rad."""
    uniform: float
    """Spread under a uniform pressure, by tilt alone, m."""
    predicted: float
    """Spread by the law, m."""
    found: float
    """Spread in the profile, m."""

    @property
    def left_out(self) -> float:
        """Share of the axial force that the normal forces at the points miss, either way."""
        return abs(self.axial_force_at_points / self.axial_force - 1.0)

    @property
    def error(self) -> float:
        """Of the predicted spread, relative."""
        return self.found / self.predicted - 1.0


def spiral_running(state: BeltState, parameters: Mapping[str, float], pulley: str) -> SpiralRunning:
    """Spread on the arc of a pulley, found and predicted."""
    curve, profile = curve_at(parameters, state), state.profile
    beta = parameters["geometry.wedgeAngle"]
    sheave = parameters[f"{pulley}.tiltStiffness"], parameters[f"{pulley}.tiltClearance"]
    force, radius = state[f"{pulley}.axialForce"], state[f"{pulley}.radius"]
    distance, half_arc = curve.from_middle(pulley, profile.position), 0.5 * curve.arc_length(pulley)
    angle = distance / curve.radius(pulley)

    pressing = np.where(np.abs(distance) < half_arc + EDGE, profile.normal_force, 0.0)
    share = pressing / pressing.sum()
    moment = force * radius * np.array([share @ np.cos(angle), share @ np.sin(angle)])
    psi = moment * (tilt_under(float(np.hypot(*moment)), *sheave) / np.hypot(*moment))
    opening = radius * (psi[0] * np.cos(angle) + psi[1] * np.sin(angle))
    penetration = profile.normal_force / (parameters["contact.stiffness"] * np.cos(beta))

    on_arc, half_angle = np.abs(distance) <= half_arc, half_arc / curve.radius(pulley)
    lever = radius * np.sin(half_angle) / half_angle
    return SpiralRunning(
        pulley,
        force,
        float(pressing.sum() * np.cos(beta) * curve.length / len(profile.position) * radius / curve.radius(pulley)),
        2.0 * half_angle,
        float(np.hypot(*psi)),
        tilt_under(force * lever, *sheave) * radius * (1.0 - np.cos(half_angle)) / np.tan(beta),
        float(np.ptp((opening + penetration)[on_arc]) / np.tan(beta)),
        float(np.ptp(profile.radial_deviation[on_arc])),
    )


def spiral_rows(
    cases: Iterable[LoadCaseResult], parameters: Mapping[str, float]
) -> list[tuple[LoadCaseResult, SpiralRunning]]:
    """All load cases on both pulleys."""
    return [
        (result, spiral_running(result.steady, parameters, pulley))
        for result in cases
        for pulley in ("primary", "secondary")
    ]
