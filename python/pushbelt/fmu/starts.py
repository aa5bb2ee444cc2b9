"""Start values of steady states for different conditions at shafts and sheaves. Speeds in rad/s, torques in N·m, forces in N.

Enumerations are plain numbers, for workers that do not have this package.
"""

from __future__ import annotations

from collections.abc import Mapping

from .enumerations import Axial, Drive

StartValues = dict[str, float]


def _steady(parameters: Mapping[str, float], ratio: float, speed: float, force: float) -> StartValues:
    return {
        **parameters,
        "initial.steady": True,
        "initial.ratio": ratio,
        "initial.primarySpeed": speed,
        "secondary.axial": Axial.FORCE.value,
        "secondary.clampingForce": force,
    }


def driven_by_torque(
    parameters: Mapping[str, float], ratio: float, speed: float, torque: float, force: float
) -> StartValues:
    """Primary shaft driven by a torque, secondary held at speed/ratio; primary sheave held, secondary force specified."""
    return {
        **_steady(parameters, ratio, speed, force),
        "primary.drive": Drive.TORQUE.value,
        "primary.axial": Axial.HELD.value,
        "primary.torque": torque,
        "secondary.drive": Drive.SPEED.value,
        "secondary.speedSetpoint": speed / ratio,
    }


def driven_by_slip(
    parameters: Mapping[str, float], ratio: float, speed: float, slip: float, force: float
) -> StartValues:
    """Both shafts held at speeds with a slip between them; primary sheave held, secondary force specified."""
    return {
        **_steady(parameters, ratio, speed, force),
        "primary.drive": Drive.SPEED.value,
        "primary.axial": Axial.HELD.value,
        "primary.speedSetpoint": speed,
        "secondary.drive": Drive.SPEED.value,
        "secondary.speedSetpoint": speed / ratio * (1.0 - slip),
    }


def driven_at_speed(
    parameters: Mapping[str, float], ratio: float, speed: float, load: float, force: float, held: bool = False
) -> StartValues:
    """Primary shaft held at a speed, secondary shaft under a load torque (0: no load); both clamping forces specified.

    The run starts with the primary force that holds the ratio. With `held` the primary sheave is held instead.
    """
    return {
        **_steady(parameters, ratio, speed, force),
        "primary.drive": Drive.SPEED.value,
        "primary.axial": (Axial.HELD if held else Axial.FORCE).value,
        "primary.speedSetpoint": speed,
        "secondary.drive": Drive.TORQUE.value,
        "secondary.torque": load,
    }
