"""Start values of steady states for different conditions at shafts and sheaves. Speeds in rad/s, torques in N·m, forces in N.

Enumerations are plain numbers, for workers that do not have this package.
"""

from __future__ import annotations

from collections.abc import Mapping

from .enumerations import Axial, Drive

StartValues = dict[str, float]


def _steady(
    parameters: Mapping[str, float], ratio: float, speed: float, force: float, drives: tuple[Drive, Drive], axial: Axial
) -> StartValues:
    return {
        **parameters,
        "initial.steady": True,
        "initial.ratio": ratio,
        "initial.primarySpeed": speed,
        "primary.drive": drives[0].value,
        "primary.axial": axial.value,
        "secondary.drive": drives[1].value,
        "secondary.axial": Axial.FORCE.value,
        "secondary.clampingForce": force,
    }


def driven_by_torque(
    parameters: Mapping[str, float], ratio: float, speed: float, torque: float, force: float
) -> StartValues:
    """Primary shaft driven by a torque, secondary held at speed/ratio; primary sheave held, secondary force specified."""
    values = _steady(parameters, ratio, speed, force, (Drive.TORQUE, Drive.SPEED), Axial.HELD)
    return values | {"primary.torque": torque, "secondary.speedSetpoint": speed / ratio}


def driven_by_slip(
    parameters: Mapping[str, float], ratio: float, speed: float, slip: float, force: float
) -> StartValues:
    """Both shafts held at speeds with a slip between them; primary sheave held, secondary force specified."""
    values = _steady(parameters, ratio, speed, force, (Drive.SPEED, Drive.SPEED), Axial.HELD)
    return values | {"primary.speedSetpoint": speed, "secondary.speedSetpoint": speed / ratio * (1.0 - slip)}


def driven_at_speed(
    parameters: Mapping[str, float], ratio: float, speed: float, load: float, force: float, held: bool = False
) -> StartValues:
    """Primary shaft held at a speed, secondary shaft under a load torque (0: no load); both clamping forces specified.
    The run starts with the primary force that holds the ratio. With `held` the primary sheave is held instead."""
    axial = Axial.HELD if held else Axial.FORCE
    values = _steady(parameters, ratio, speed, force, (Drive.SPEED, Drive.TORQUE), axial)
    return values | {"primary.speedSetpoint": speed, "secondary.torque": load}
