"""The worker process: loads the FMU once and solves points of the table in sequence."""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import fmpy

from pushbelt.fmu import capacity
from pushbelt.fmu.enumerations import Axial, StartState
from pushbelt.fmu.steady import SteadyStates, driven_by_torque
from pushbelt.fmu.unit import Archive, Instance, UnitError
from pushbelt.report.side_by_side import tick
from pushbelt.tables.columns import SAMPLED
from pushbelt.tables.points import Point

SETTLING, WINDOW = 1.0, 1.0
"""Revolutions of the primary pulley after which a shift is steady, and over which its rate is taken."""
SHIFT_INERTIA = 1e-3
"""Moment of inertia of the primary pulley in a shift, kg·m². It is so small that the belt torque equals the point's torque."""
SHIFT_TOLERANCE = 1e-7
"""Tolerance of the integration in a shift. Differences over a third of `model.STEP` scatter by 0.6 %, with 1e-6 by 4 %."""
STEADY = ("thrustRatio", "slip", "efficiency")
RATIO_TOLERANCE, MOST_SOLVES = 1e-5, 10
"""Relative error of the speed ratio up to which the results are corrected by their derivatives, and largest number of steady states in the search."""
LOST_SOLVES = 20
"""Cost of a point without a steady state, in steady states: the search for the torque that it carries takes 0.3 to 1 s."""

Job = tuple[Mapping[str, float], Point]  # Values of the fitted variables, and a point
_open: dict[Path, SteadyStates] = {}  # Instances in this process, by unpacked FMU
RECORD_INPUTS = ("primary.torque", "primary.clampingForce", "secondary.clampingForce", "secondary.speedSetpoint")
"""Inputs of a recorded shift."""


class Found(NamedTuple):
    """Results of the model at a point."""

    values: Mapping[str, float]  # Model values by quantity; empty without a steady state
    reason: str | None = None  # Reason why there is no steady state
    missing: float = 0.0  # Without a steady state 1 plus the share of the torque that the belt does not carry
    solves: int = 1  # Number of steady states that were solved, or their cost
    near: bytes = b""  # The stored steady state
    by_ratio: tuple[float, ...] = ()  # As that of a point


def solve_all(fmu: Path, directory: Path, parameters: Mapping[str, float], jobs: Sequence[Job]) -> list[Found]:
    """Solves for points with an FMU that is already unpacked in a directory."""
    found = []
    for values, point in jobs:
        found.append(solve(fmu, directory, {**parameters, **values}, point))
        tick(1)
    return found


def solve(fmu: Path, directory: Path, parameters: Mapping[str, float], point: Point) -> Found:
    """Results of the model at a point. An error of the FMU becomes the reason."""
    if directory not in _open:
        _open[directory] = SteadyStates(Archive(directory, fmpy.read_model_description(str(fmu))))
    kind = _record if point.samples else _shift if point.shifting else _at_speed_ratio if point.ratio is None else _steady
    try:
        return kind(_open[directory], parameters, point)
    except UnitError as error:
        _open.pop(directory).close()
        return Found({}, str(error), 2.0)


def _started(
    states: SteadyStates, parameters: Mapping[str, float], point: Point, ratio: float, speed_ratio: float, primary_force: float | None = None
) -> Instance | Found:
    """The instance in a steady state, first sought near that of the point, or why there is none. The secondary pulley turns at ω_P/i, the
    torque drives the primary pulley; its sheave is held at the ratio, or in a shift moves under its force."""
    # The forces of a point are whole: cylinders are in them.
    own = {name: value for name, value in parameters.items() if ".cylinder." not in name} | {"initial.equilibrium": False}
    if primary_force is None and (why := capacity.shortfall(own, ratio, point.torque, point.force)):
        # This capacity is that of the secondary pulley. The primary one carries at least about half of it.
        return Found({}, f"no steady state: {why}", 2.0 - 0.5 * capacity.torque_capacity(own, ratio, point.force) / abs(point.torque))
    values = driven_by_torque(own, ratio, point.speed / speed_ratio * ratio, point.torque, point.force)
    if primary_force is not None:
        values |= {"primary.axial": Axial.FORCE, "primary.clampingForce": primary_force, "primary.inertia": SHIFT_INERTIA}
    unit = states.started(values, point.near)
    if unit.not_steady is None:
        return unit
    carried = 0.0
    if unit.get("initial.found") == StartState.REDUCED_TORQUE and point.torque:
        carried = min(max(-unit.get("primary.shaftTorque") / point.torque, 0.0), 1.0)
    return Found({}, unit.not_steady, 2.0 - carried, LOST_SOLVES)


def _steady(states: SteadyStates, parameters: Mapping[str, float], point: Point, ratio: float | None = None) -> Found:
    ratio = point.ratio if ratio is None else ratio
    assert ratio is not None, "a point without a ratio has a speed ratio"
    unit = _started(states, parameters, point, ratio, point.speed_ratio or ratio)
    if isinstance(unit, Found):
        return unit
    return Found({name: unit.get(name) for name in STEADY}, near=unit.state())


def _at_speed_ratio(states: SteadyStates, parameters: Mapping[str, float], point: Point) -> Found:
    """The geometric ratio for a speed ratio, i = i_speed (1 − slip), by Newton's method with derivatives of this or an earlier state."""
    speed_ratio, by_ratio = point.speed_ratio, point.by_ratio
    assert speed_ratio is not None
    ratio = speed_ratio * (1.0 - point.slip)
    for count in range(1, MOST_SOLVES + 1):
        found = _steady(states, parameters, point, ratio)
        if found.reason is not None:
            return found
        if not by_ratio:
            found_by = states.unit.gradient(["initial.ratio"])
            rows = {one["name"]: row[0] or 0.0 for one, row in zip(found_by["outputs"], found_by["gradient"], strict=True)}
            by_ratio = tuple(rows[name] for name in STEADY)
        change = (speed_ratio * (1.0 - found.values["slip"]) - ratio) / (1.0 + speed_ratio * by_ratio[STEADY.index("slip")])
        if abs(change / ratio) < RATIO_TOLERANCE:
            values = {name: value + slope * change for (name, value), slope in zip(found.values.items(), by_ratio, strict=True)}
            return found._replace(values=values, solves=count + (not point.by_ratio), by_ratio=by_ratio)
        point, ratio = replace(point, near=found.near), ratio + change
    return Found({}, f"no geometric ratio gives the speed ratio {speed_ratio:g}")


def _shift(states: SteadyStates, parameters: Mapping[str, float], point: Point) -> Found:
    """The shift rate at the ratio of the point, which a run that shifts as measured has in the middle of the window."""
    assert point.ratio is not None and point.primary_force is not None
    (measured,) = point.measured
    revolution = 2.0 * math.pi / point.speed
    # d(ln i)/dt, also of s = 1/i
    rate = measured.value / point.ratio if measured.quantity == "di/dt" else -measured.value * point.ratio
    begin = point.ratio * math.exp(-rate * (SETTLING + 0.5 * WINDOW) * revolution)
    unit = _started(states, {**parameters, "solver.tolerance": SHIFT_TOLERANCE}, point, begin, point.ratio, point.primary_force)
    if isinstance(unit, Found):
        return unit
    logs, near = [], unit.state()
    for time in (SETTLING * revolution, (SETTLING + WINDOW) * revolution):
        unit.step_to(time)
        logs.append(math.log(unit.get("ratio.geometric")))
    found = (logs[1] - logs[0]) / (WINDOW * revolution)
    return Found({"di/dt": point.ratio * found, "ds/dt": -found / point.ratio}, near=near)


def _record(states: SteadyStates, parameters: Mapping[str, float], record: Point) -> Found:
    """The ratio at each sample of a recorded shift. The run starts in the steady state at the first ratio. Torque, forces and secondary
    speed, the primary one over the ratio, are the recorded ones, linear between the samples."""
    inputs = [(time, (torque, first, second, speed / ratio)) for time, speed, torque, first, second, ratio in record.samples]
    _, _, _, primary_force, _, ratio = record.samples[0]
    unit = _started(states, parameters, record, ratio, ratio, primary_force)
    if isinstance(unit, Found):
        return unit
    reals, found, near = unit.reals(RECORD_INPUTS), {}, unit.state()
    for k, ((time, here), (following, there)) in enumerate(itertools.pairwise(inputs), 1):
        rates = [(after - before) / (following - time) for before, after in zip(here, there, strict=True)]
        unit.set_ramps(reals, here, rates)
        unit.step_to(following)
        found[f"{SAMPLED}@{k}"] = unit.get("ratio.geometric")
    return Found(found, near=near)
