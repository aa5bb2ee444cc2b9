"""A working point: its start values in the FMU, and the recorded outputs.

The secondary pulley turns at ω_P/i. The primary pulley is driven by the torque of the specified utilisation, and its sheave
is held at the ratio. Shaft torque and clamping force are exact; the primary speed differs by the slip.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass

from pushbelt.fmu.data import torque_capacity
from pushbelt.fmu.enumerations import Axial, Drive
from pushbelt.fmu.unit import UnitError, Variator

SHORT_STEP = 1e-3
"""Length of the step after which the outputs are read, s. In a steady state they do not change during this step."""

Row = dict[str, float | bool | str | None]
"""A row of the results, by column."""


@dataclass(frozen=True)
class Point:
    """A working point of a study."""

    index: int
    """Index in the study."""
    ratio: float
    """Geometric ratio r_S/r_P."""
    utilisation: float
    """Primary torque divided by the torque at which the belt slips through, 2 μ r_P F_S/cosβ; negative where the secondary pulley drives."""
    friction: float
    """μ between element and sheave."""
    speed: float
    """Speed of the primary pulley without slip, ω_P = i ω_S, rad/s."""
    force: float
    """Secondary clamping force, N."""


def start_values(parameters: Mapping[str, float], point: Point) -> dict[str, float]:
    """Start values of a point by FMU variable. The torque follows from the geometry in the parameters.

    Values are plain numbers, because workers do not have the enumerations of this package.
    """
    values = {**parameters, "friction.pulley": point.friction}
    return {
        "friction.pulley": point.friction,
        "initial.steady": True,
        "initial.equilibrium": False,
        "initial.ratio": point.ratio,
        "initial.primarySpeed": point.speed,
        "primary.drive": Drive.TORQUE.value,
        "primary.axial": Axial.HELD.value,
        "primary.torque": point.utilisation * torque_capacity(values, point.ratio, point.force),
        "secondary.drive": Drive.SPEED.value,
        "secondary.axial": Axial.FORCE.value,
        "secondary.speedSetpoint": point.speed / point.ratio,
        "secondary.clampingForce": point.force,
    }


def solve(unit: Variator, index: int, values: Mapping[str, float]) -> Row:
    """The steady state at these start values after a short step, or the reason for a missing one.

    Raises UnitError if a call of the FMU fails. The instance cannot be used afterwards.
    """
    begin = time.thread_time()
    unit.restart(values)
    unit.initialise()
    if unit.not_steady:
        return failure(index, unit.not_steady, time.thread_time() - begin)
    before = unit.get("thrustRatio")
    unit.step_to(SHORT_STEP)
    outputs = unit.outputs()
    if not all(math.isfinite(value) for value in outputs.values()):
        return failure(index, "an output is not finite", time.thread_time() - begin)
    return {
        "point": index,
        **outputs,
        "macroSlip": bool(outputs["macroSlip"]),
        "drift": outputs["thrustRatio"] / before - 1.0 if before else 0.0,
        "remarks": "; ".join(unit.warnings) or None,
        "reason": None,
        "time": time.thread_time() - begin,
    }


def failure(index: int, reason: str, seconds: float | None = None) -> Row:
    """The row of a point without a steady state."""
    return {"point": index, "reason": reason, "time": seconds}


def solve_or_say_why(unit: Variator, index: int, values: Mapping[str, float]) -> tuple[Row, bool]:
    """Calls `solve` and converts any exception to a reason. Also returns whether the instance can still be used."""
    begin = time.thread_time()
    try:
        return solve(unit, index, values), True
    except UnitError as error:
        return failure(index, str(error), time.thread_time() - begin), False
    except Exception as error:  # noqa: BLE001
        return failure(index, f"{type(error).__name__}: {error}", time.thread_time() - begin), False
