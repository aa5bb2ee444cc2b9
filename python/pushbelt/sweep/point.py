"""A working point: its start values in the FMU, and the recorded outputs.

The secondary pulley turns at ω_P/i. The primary pulley is driven by the torque of the specified utilisation, and its sheave
is held at the ratio. Shaft torque and clamping force are exact; the primary speed differs by the slip.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from pushbelt.fmu.data import torque_capacity
from pushbelt.fmu.enumerations import Axial, Drive
from pushbelt.fmu.steady import SteadyStates, driven_by_torque
from pushbelt.fmu.unit import UnitError
from pushbelt.study.tasks import Row

SHORT_STEP = 1e-3
"""Length of the step after which the outputs are read, s. In a steady state they do not change during this step."""

Point = Mapping[str, float]
"""A working point: values by names of FMU variables, and `utilisation`: the primary torque over that at which the belt slips through,
2 μ r_P F_S/cosβ; negative where the secondary pulley drives."""

STANDARD = {"initial.ratio": 1.0, "utilisation": 0.6, "initial.primarySpeed": 209.44, "secondary.clampingForce": 12e3}
"""Values of what a point does not have. Its friction is then that of the parameters."""
ACTING: Mapping[str, Mapping[str, float]] = {
    "primary.clampingForce": {"primary.axial": Axial.FORCE.value, "initial.equilibrium": True},
    "primary.speedSetpoint": {"primary.drive": Drive.SPEED.value},
    "secondary.torque": {"secondary.drive": Drive.TORQUE.value},
}
"""Boundary conditions under which an input acts: a varied primary force determines the ratio, for example."""


def start_values(parameters: Mapping[str, float], point: Point) -> dict[str, float]:
    """All start values of a point by FMU variable. The torque of a utilisation follows from the point's own geometry."""
    axes = {**STANDARD, **point}
    own = {**parameters, **{name: value for name, value in point.items() if name not in STANDARD}}
    ratio, speed, force = (axes[name] for name in ("initial.ratio", "initial.primarySpeed", "secondary.clampingForce"))
    torque = axes["utilisation"] * torque_capacity(own, ratio, force)
    values = {**driven_by_torque(own, ratio, speed, torque, force), "initial.equilibrium": False}
    for name, condition in ACTING.items():
        if name in point:
            values |= condition
    return values | {name: value for name, value in point.items() if name not in STANDARD}


def solve(states: SteadyStates, values: Mapping[str, float]) -> Row:
    """The steady state at these start values after a short step. Raises UnitError if there is none or if a call of the
    FMU fails."""
    unit = states.at(values)
    before = unit.get("thrustRatio")
    unit.step_to(SHORT_STEP)
    outputs = unit.outputs()
    if not all(math.isfinite(value) for value in outputs.values()):
        raise UnitError("an output is not finite")
    drift = outputs["thrustRatio"] / before - 1.0 if before else 0.0
    slips, remarks = bool(outputs["macroSlip"]), "; ".join(unit.warnings) or None
    return outputs | {"macroSlip": slips, "drift": drift, "remarks": remarks, "reason": None}
