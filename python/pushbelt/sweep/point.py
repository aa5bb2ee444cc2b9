"""A working point: its start values in the FMU, and the recorded outputs.

The secondary pulley turns at ω_P/i. The primary pulley is driven by the torque of the specified utilisation, and its sheave
is held at the ratio. Shaft torque and clamping force are exact; the primary speed differs by the slip.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from pushbelt.fmu.data import torque_capacity
from pushbelt.fmu.starts import driven_by_torque
from pushbelt.fmu.steady import SteadyStates
from pushbelt.fmu.unit import UnitError

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
    """Start values of a point by FMU variable. The torque follows from the geometry in the parameters."""
    given = {"friction.pulley": point.friction, "initial.equilibrium": False}
    torque = point.utilisation * torque_capacity({**parameters, **given}, point.ratio, point.force)
    return driven_by_torque(given, point.ratio, point.speed, torque, point.force)


def solve(states: SteadyStates, values: Mapping[str, float]) -> Row:
    """The steady state at these start values after a short step.

    Raises UnitError if there is none or if a call of the FMU fails.
    """
    unit = states.at(values)
    before = unit.get("thrustRatio")
    unit.step_to(SHORT_STEP)
    outputs = unit.outputs()
    if not all(math.isfinite(value) for value in outputs.values()):
        raise UnitError("an output is not finite")
    return {
        **outputs,
        "macroSlip": bool(outputs["macroSlip"]),
        "drift": outputs["thrustRatio"] / before - 1.0 if before else 0.0,
        "remarks": "; ".join(unit.warnings) or None,
        "reason": None,
    }
