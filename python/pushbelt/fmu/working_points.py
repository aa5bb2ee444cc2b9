"""Steady states, capacity, traction and shift rates at working points, measured on the FMU: the core of all maps.

A line is a secondary clamping force, a primary speed and a ratio. Along it the torque varies. The shafts' drag is left out, so that
the primary torque is that of the belt; the secondary bearings have a reference friction, from which their load follows. The belt as a
whole is at rest, so the contact forces on both pulleys have the same resultant.
"""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from .bands import bands, increased
from .data import torque_capacity
from .gradients import Asked, rates
from .steady import StartValues, SteadyStates, driven_by_slip, driven_by_torque
from .unit import Instance, UnitError

REFERENCE_LEVER = 5e-5  # Friction coefficient times radius of the secondary bearings, m
SHAFTS = {
    **{f"{pulley}.drag.{kind}": 0.0 for pulley in ("primary", "secondary") for kind in ("constant", "viscous")},
    "primary.bearing.friction": 0.0,
    "secondary.bearing.friction": 1e-3,
    "secondary.bearing.radius": REFERENCE_LEVER / 1e-3,
    # With the inertia of a car neither shaft would follow a shift, because the primary speed is held.
    "secondary.inertia": 0.03,
}
"""Drag and inertia of the shafts at all points. These are parameters of `SteadyStates` in all functions below."""
FADING_SPEED = 2.0  # Speed below which the drag of a shaft fades, rad/s: as in the FMU
LOSSES = ("loss.sheaves", "loss.ring", "loss.layers", "loss.joints", "loss.spin", "loss.other")  # Losses of the belt
OUTPUTS = ("thrustRatio", "slip", *LOSSES, "belt.speed", "ring.stressMax")
"""Outputs that are recorded at each point, besides the torque loss and the bearing load."""
POINT_COLUMNS = (*OUTPUTS, "beltTorqueLoss", "bearingLoad", "pastPeak")
FIRST_SLIP, SLIP_FACTOR, MOST_SLIP = 0.01, 1.4, 0.6
"""First slip, factor between slips and largest slip in the search for the capacity."""
FLAT = 0.01  # Relative growth of the utilisation from one slip to the next that counts as none
TRIED = 1.05
"""Utilisation up to which points are tried, relative to that at capacity: the search ends before the peak of the traction."""
SHOWN = {"thrustRatio": "thrustRatio", "slip": "slip", "efficiency": "efficiency", "torqueLoss": "secondary.externalTorque"}
"""Quantities with standard deviations and derivatives, and the outputs that these are of."""


class Line(NamedTuple):
    """Secondary clamping force (N), primary speed (rad/s) and geometric ratio."""

    force: float
    speed: float
    ratio: float


class Along(NamedTuple):
    utilisations: Sequence[float]
    """Belt torque on the primary pulley / (2 μ r_P F_S/cosβ), ascending; positive where the primary pulley drives."""
    shares: Sequence[float]
    """Slips at which the traction is measured, divided by the slip at capacity, ascending from −1 to 1."""
    shafts: Mapping[str, float]  # Drag and bearings of the variator, under which points have what follows
    deviations: Mapping[str, float]  # Standard deviations of parameters, for those of points
    asked: Asked  # Derivatives


def camel(name: str) -> str:
    """Name of a table: `lossSheaves` of `loss.sheaves`."""
    return re.sub(r"\.(.)", lambda dot: dot[1].upper(), name)


def slope(name: str, over: str) -> str:
    """Table of a derivative, `slipPerFrictionPulley`."""
    return camel(f"{name}Per.{over}")


def driven_at(states: SteadyStates, line: Line, utilisation: float) -> StartValues:
    torque = utilisation * torque_capacity(states.parameters, line.ratio, line.force)
    return driven_by_torque({}, line.ratio, line.speed, torque, line.force)


def point(unit: Instance, ratio: float) -> dict[str, float]:
    found = {name: float(unit.get(name)) for name in OUTPUTS}
    torques = [unit.get(f"{pulley}.shaftTorque") for pulley in ("primary", "secondary")]
    speed = unit.get("secondary.speed")
    load = unit.get("loss.shafts") / (speed * math.tanh(speed / FADING_SPEED) * REFERENCE_LEVER)
    return found | {"beltTorqueLoss": -torques[0] - torques[1] / ratio, "bearingLoad": load, "pastPeak": float(unit.get("pastPeak"))}


def limit(traction: Callable[[float], float], sign: float) -> tuple[float, float]:
    """Slip and utilisation at capacity, in the direction of a sign. Slips grow by `SLIP_FACTOR` until the utilisation
    grows by less than `FLAT`; beyond this slip the belt slips through."""
    slip = FIRST_SLIP
    found = sign * traction(sign * slip)
    while slip * SLIP_FACTOR < MOST_SLIP:
        following = sign * traction(sign * slip * SLIP_FACTOR)
        if following < (1.0 + FLAT) * found:
            break
        slip, found = slip * SLIP_FACTOR, following
    return sign * slip, sign * found


def drag(parameters: Mapping[str, float], pulley: str, speed: Any, load: Any) -> Any:
    """Drag torque of a shaft at a speed (rad/s) under a bearing load (N), N·m: tanh(ω/ω_0) (T_0 + μ r R) + b ω."""
    lever = parameters[f"{pulley}.bearing.friction"] * parameters[f"{pulley}.bearing.radius"]
    loaded = parameters[f"{pulley}.drag.constant"] + lever * load
    return np.tanh(speed / FADING_SPEED) * loaded + parameters[f"{pulley}.drag.viscous"] * speed


def around(states: SteadyStates, line: Line, torque: float, found: Mapping[str, float], along: Along) -> dict[str, Any]:
    """Standard deviations of a point, the parameters that make most of them, and derivatives: those that it has, by table."""
    torque += drag(along.shafts, "primary", line.speed / (1.0 - found["slip"]), found["bearingLoad"])
    values = driven_by_torque(along.shafts, line.ratio, line.speed, torque, line.force)
    known, row = {**states.parameters, **values}, dict[str, Any]()
    with suppress(UnitError):
        unit = states.at(values, True)
        outputs, near = unit.outputs(), unit.state()
        with suppress(UnitError):
            slopes = along.asked.of(unit, partial(rates, values)) if along.asked.names else {}
            # The torque loss is T_P + T_S/i.
            of_loss = slopes["primary.externalTorque"] + slopes["secondary.externalTorque"] / line.ratio
            slopes["torqueLoss"] = of_loss - outputs["secondary.externalTorque"] / line.ratio**2 * slopes["ratio.geometric"]
            row |= {slope(name, over): float(slopes[name][k]) for k, over in enumerate(along.asked.names) for name in SHOWN}
        if along.deviations:
            spread = bands(states, outputs, near, lambda changes: values | increased(unit.variables, known, changes), along.deviations)
            row |= {f"{name}Deviation": spread[output] / (1.0 if name == output else line.ratio) for name, output in SHOWN.items()}
            row["by"] = {name: ", ".join(spread.largest(output)) for name, output in SHOWN.items()}
    return row


def measure(states: SteadyStates, line: Line, along: Along) -> dict[str, Any]:
    """All results on a line: points, with a reason where there is no steady state, and plain lists of numbers."""
    at = states.sequence()
    capacity = torque_capacity(states.parameters, line.ratio, line.force)

    def traction(slip: float) -> float:
        unit = at(driven_by_slip({}, line.ratio, line.speed, slip, line.force))
        return -unit.get("primary.shaftTorque") / capacity

    (low, least), (high, most) = (limit(traction, sign) for sign in (-1.0, 1.0))

    def solved(utilisation: float) -> dict[str, Any]:
        try:
            if not TRIED * least < utilisation < TRIED * most:
                raise UnitError(f"beyond the capacity, a utilisation of {(most if utilisation > 0.0 else least):.3f}")
            return point(at(driven_at(states, line, utilisation)), line.ratio)
        except UnitError as error:
            return {"reason": str(error)}

    known = {-1.0: least, 1.0: most}
    points = [solved(utilisation) for utilisation in along.utilisations]
    found = {
        "points": points, "capacity": [least, most], "capacitySlip": [low, high],
        "traction": [known[s] if s in known else traction(s * high if s > 0.0 else -s * low) for s in along.shares],
    }  # fmt: skip
    for utilisation, one in zip(along.utilisations, points, strict=True):
        if "reason" not in one and (along.deviations or along.asked.names):
            one.update(around(states, line, utilisation * capacity, one, along))
    return found
