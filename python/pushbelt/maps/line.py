"""A line of the maps: what `pushbelt.fmu.working_points` measures, states up to the capacity, and shift rates."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from pushbelt.fmu.data import torque_capacity
from pushbelt.fmu.steady import At, SteadyStates, driven_at_speed, driven_by_slip, driven_by_torque
from pushbelt.fmu.unit import Instance, UnitError
from pushbelt.fmu.working_points import Along, Line, driven_at, point
from pushbelt.fmu.working_points import measure as of_points

HELD = 0.95  # Largest utilisation of shifts, relative to that at capacity
WINDOW = (0.06, 0.12)
"""Start and end of the window for the mean slope in a shift measurement, s after the jump: after its transient, before the ratio changes much."""
TIME_STEP = 0.01  # Largest communication step in it, s
SHIFT_REACH = 0.05  # Largest change of ln i in a shift measurement
STEP_ANGLE = 0.5  # Largest angle of the primary pulley in a communication step of a shift measurement, rad


def measure(
    states: SteadyStates, line: Line, along: Along, shares: Sequence[float], shifted: Sequence[float], excesses: Sequence[float]
) -> dict[str, Any]:
    """All results on a line. `shares` are torques divided by that at capacity, from −1 to 1; `shifted` and `excesses` are those of
    the shifts, torque utilisations and ln(F_P/(κ F_S)) without 0. None stands for a missing steady state."""
    found, at, carried = of_points(states, line, along), states.sequence(), torque_capacity(states.parameters, line.ratio, line.force)
    (least, most), slips = found["capacity"], found["capacitySlip"]

    def loaded(share: float) -> Instance:
        if abs(share) == 1.0:
            return at(driven_by_slip({}, line.ratio, line.speed, slips[share > 0.0], line.force))
        return at(driven_by_torque({}, line.ratio, line.speed, abs(share) * carried * (most if share > 0.0 else least), line.force))

    def state(share: float) -> dict[str, float] | None:
        try:
            return point(loaded(share), line.ratio)
        except UnitError:
            return None

    def shifts(utilisation: float) -> list[float] | list[None]:
        try:
            return shift_rates(states, at, line, min(max(utilisation, HELD * least), HELD * most), excesses)
        except UnitError:
            return [None] * len(excesses)

    return found | {"shares": [state(share) for share in shares], "shiftRate": [shifts(utilisation) for utilisation in shifted]}


def shift_rates(states: SteadyStates, at: At, line: Line, utilisation: float, excesses: Sequence[float]) -> list[float]:
    """−d(ln i)/dt / ω_P, 1/rad, for each excess ln(F_P/(κ F_S)) after a jump of the primary force. The primary speed is held, and the
    secondary shaft has the load torque of the steady state. The rate is the mean slope over the window, or, if ln i changes by
    `SHIFT_REACH` before its end, in the second half of the time. Until then κ changes with the ratio: the rate is in proportion to the
    remaining excess."""
    load = at(driven_at(states, line, utilisation)).get("secondary.externalTorque")
    # Towards ratio 1, away from the end stops.
    beside = -math.copysign(SHIFT_REACH, math.log(line.ratio))
    forces = []
    for change in (beside, 0.0):
        unit = at(driven_at_speed({}, line.ratio * math.exp(change), line.speed, load, line.force))
        forces.append(unit.get("primary.axialForce"))
    slope = math.log(forces[0] / forces[1]) / beside
    begin, state, rates = unit.time, unit.state(), []
    step = min(TIME_STEP, STEP_ANGLE / line.speed)
    first, last = (round(moment / step) for moment in WINDOW)
    for excess in excesses:
        unit.restore(state, begin)
        unit.set({"primary.clampingForce": forces[1] * math.exp(excess)})
        changes = [0.0]
        while len(changes) <= last and abs(changes[-1]) < SHIFT_REACH:
            unit.step_to(begin + len(changes) * step)
            changes.append(math.log(unit.get("ratio.geometric") / line.ratio))
        within = changes[first if len(changes) > last else (len(changes) - 1) // 2 :]
        rate = (within[0] - within[-1]) / ((len(within) - 1) * step * line.speed)
        rates.append(rate * excess / (excess - slope * float(np.mean(within))))
    return rates
