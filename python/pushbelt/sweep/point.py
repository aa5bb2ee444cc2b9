"""A working point: its start values in the FMU, and the recorded outputs.

The secondary pulley turns at ω_P/i. The primary pulley is driven by the torque of the specified utilisation, and its sheave
is held at the ratio. Shaft torque and clamping force are exact; the primary speed differs by the slip.
"""

import math
from collections.abc import Mapping
from functools import partial
from types import MappingProxyType
from typing import Any

from pushbelt.fmu.bands import DEVIATION, bands, increased
from pushbelt.fmu.closing import closing_at
from pushbelt.fmu.data import torque_capacity
from pushbelt.fmu.enumerations import Axial, Drive
from pushbelt.fmu.gradients import NOTHING, Asked, rates
from pushbelt.fmu.steady import SteadyStates, driven_by_torque
from pushbelt.fmu.unit import TRUTHS, UnitError
from pushbelt.study.tasks import Row

SHORT_STEP = 1e-3
"""Length of the step after which the outputs are read, s. In a steady state they do not change during this step."""

BANDS = ("thrustRatio", "slip", "efficiency", "loss.total")
"""Outputs with a standard deviation and the parameters that make most of it."""

Point = Mapping[str, float]
"""A working point: values by names of FMU variables, and `utilisation`: the primary torque over that at which the belt slips through,
2 μ r_P F_S/cosβ with the whole force F_S of clamp and cylinder; negative where the secondary pulley drives."""

STANDARD = {"initial.ratio": 1.0, "utilisation": 0.6, "initial.primarySpeed": 209.44, "secondary.clampingForce": 12e3}
"""Values of what a point does not have. Its friction is then that of the parameters."""
ACTING: Mapping[str, Mapping[str, float]] = {
    "primary.clampingForce": {"primary.axial": Axial.FORCE.value, "initial.equilibrium": True},
    "primary.pressure": {"primary.axial": Axial.FORCE.value, "initial.equilibrium": True, "primary.clampingForce": 0.0},
    "primary.speedSetpoint": {"primary.drive": Drive.SPEED.value},
    "secondary.torque": {"secondary.drive": Drive.TORQUE.value},
}
"""Boundary conditions under which an input acts: a varied primary force or pressure determines the ratio, for example."""


def capacity(values: Mapping[str, float]) -> float:
    """Primary torque of the utilisation 1 at start values, N·m: 0 with an open pulley."""
    ratio = values["initial.ratio"]
    return torque_capacity(values, ratio, max(closing_at(values, "secondary", ratio, values["initial.primarySpeed"]), 0.0))


def start_values(parameters: Mapping[str, float], point: Point) -> dict[str, float]:
    """All start values of a point by FMU variable. The torque of a utilisation follows from the point's own geometry."""
    axes = {**STANDARD, **point}
    own = {**parameters, **{name: value for name, value in point.items() if name not in STANDARD}}
    ratio, speed, force = (axes[name] for name in ("initial.ratio", "initial.primarySpeed", "secondary.clampingForce"))
    torque = axes["utilisation"] * capacity({**own, **axes})
    # The columns are inputs of the FMU: a pressure acts beside the clamping force.
    values = {**own, **driven_by_torque({}, ratio, speed, torque, force), "initial.equilibrium": False}
    for name, condition in ACTING.items():
        if name in point:
            values |= condition
    return values | {name: value for name, value in point.items() if name not in STANDARD}


def slope(output: str, name: str) -> str:
    """Column of the derivative of an output."""
    return f"d {output}/d {name}"


def solve(
    states: SteadyStates, values: Mapping[str, float], deviations: Mapping[str, float] = MappingProxyType({}), asked: Asked = NOTHING
) -> Row:
    """The steady state at these start values after a short step, with derivatives, and bands by standard deviations of parameters. Raises
    UnitError if there is none or if a call of the FMU fails."""
    unit = states.at(values)
    start, near, own, remarks = unit.outputs(), unit.state(), dict[str, Any](), list[str]()
    try:
        slopes = asked.of(unit, partial(rates, values)) if asked.names else {}
        found = ((slope(output, name), one) for output, of in slopes.items() for name, one in zip(asked.names, of.tolist(), strict=True))
        own = {title: one for title, one in found if math.isfinite(one)}
    except UnitError as error:
        remarks = [str(error)]
    before = start["thrustRatio"]
    unit.step_to(SHORT_STEP)
    outputs = unit.outputs()
    if not all(math.isfinite(value) for value in outputs.values()):
        raise UnitError("an output is not finite")
    drift = outputs["thrustRatio"] / before - 1.0 if before else 0.0
    truths = {name: bool(outputs[name]) for name in TRUTHS}
    remarks += unit.warnings
    if deviations:
        known = {**states.parameters, **values}
        spread = bands(states, start, near, lambda changes: {**values, **increased(unit.variables, known, changes)}, deviations)
        own |= {f"{name}{DEVIATION}": spread[name] for name in BANDS} | {f"{name} by": ", ".join(spread.largest(name)) for name in BANDS}
    return outputs | truths | {"drift": drift, "remarks": "; ".join(remarks) or None, "reason": None} | own
