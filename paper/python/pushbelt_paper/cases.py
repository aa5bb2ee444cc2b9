"""The load cases of the paper's section 5.4 with the FMU: the same loads and the same run for every ring model.

The paper's secondary loads are unpublished measurements. Here the clamping force is that of `variators.json`, and the load
torque is the one for which the belt torque on P in the steady state of `ALE` is the case's; all models have this load.
Lagrangian rings have no steady state, so every model runs for a while from the unit's initial state, and the end of the run
is evaluated.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from enum import IntEnum

import numpy as np

from pushbelt.fmu.data import load_case_speed
from pushbelt.fmu.enumerations import Drive
from pushbelt.fmu.geometry import Array, ratio_of
from pushbelt.fmu.load_cases import solve
from pushbelt.fmu.results import LoadCase, SteadyState, Trace
from pushbelt.fmu.steady import driven_at_speed
from pushbelt.fmu.unit import Archive, Instance, output_names

from . import times
from .results import CaseRun, Effort, Shift, Window


class RingModel(IntEnum):
    """Values of `ring.model` in PushbeltPaper.fmu. A test compares them with its model description."""

    ALE0 = 1
    ALE = 2
    RCM = 3
    ANCF = 4
    ALE0Centred = 5


Parameters = Mapping[str, float]

STEP = 1e-3
"""Communication step, s."""

FINE = {"mesh.primaryArc": 60, "mesh.secondaryArc": 60, "mesh.strand": 36}
EVEN = {"mesh.aligned": False}
MESHES: Mapping[str, Parameters] = {"aligned": {}, "even": EVEN, "even, fine": {**EVEN, **FINE}, "fine": FINE}
"""Meshes of `ALE`: the default, the same number of elements evenly spaced, and three times as many of either."""

OFFSET = 5e-4
"""Axial offset of the pulleys in the run in space, m."""

RIGID = 1e12
"""Stiffness above which a sheave is rigid, N·m/rad."""
SHIFT_FORCE = 1.2
"""Primary clamping force of the shift on two meshes, relative to that at rest."""


def steady(
    archive: Archive, parameters: Parameters, case: LoadCase, model: str = "ALE", speed: float | None = None
) -> SteadyState:
    """The steady state of a model with the belt torque of the case on P; primary speed in rad/s."""
    values = {**parameters, "ring.model": RingModel[model]}
    speed = load_case_speed() if speed is None else speed
    start = driven_at_speed(values, ratio_of(case.theta), speed, 0.0, case.clamping_force, held=True)
    with Instance(archive, start) as unit:
        return solve(unit, start, case.torque)


def at_speeds(archive: Archive, parameters: Parameters, case: LoadCase, speeds: tuple[float, ...]) -> dict[float, float]:
    """Thrust ratios of the steady states of `ALE` at other primary speeds, rad/s, with the same belt torque."""
    return {speed: steady(archive, parameters, case, speed=speed)["thrustRatio"] for speed in speeds}


def on_sheaves(archive: Archive, parameters: Parameters, case: LoadCase) -> dict[str, dict[str, SteadyState]]:
    """Steady states of `ALE` and of `ALE0` with free centres and about the axes, on sheaves that tilt and on rigid ones."""
    rigid = {"primary.tiltStiffness": RIGID, "secondary.tiltStiffness": RIGID}
    models = ("ALE", "ALE0", "ALE0Centred")
    return {
        sheaves: {model: steady(archive, {**parameters, **stiffness}, case, model) for model in models}
        for sheaves, stiffness in (("elastic", {}), ("rigid", rigid))
    }


def on_meshes(archive: Archive, parameters: Parameters, case: LoadCase) -> dict[str, SteadyState]:
    """The steady state of `ALE` on meshes with and without borders at the arcs, and on finer ones."""
    return {name: steady(archive, {**parameters, **mesh}, case) for name, mesh in MESHES.items()}


def misaligned(archive: Archive, parameters: Parameters, case: LoadCase) -> SteadyState:
    """The steady state of `ALE` in space with pulleys that are out of line."""
    return steady(archive, {**parameters, "ring.spatial": True, "geometry.pulleyOffset": OFFSET}, case)


def shifts(archive: Archive, parameters: Parameters, duration: float) -> dict[str, Shift]:
    """`ALE` on two meshes, and with A_i = [t, n], from its equilibrium at ratio 1 under a primary clamping force that is
    `SHIFT_FORCE` times as large."""
    found = {}
    for name, changes in (("aligned", {}), ("even", EVEN), ("directions", {"ring.referenceDirections": True})):
        start = {**parameters, **changes, "ring.model": RingModel.ALE, "primary.drive": Drive.SPEED}
        with Instance(archive, start) as unit:
            unit.initialise()
            unit.set({"primary.clampingForce": SHIFT_FORCE * unit.get("primary.axialForce")})
            outputs = unit.reals(("ratio.geometric", "energy.residual", "stored.energy"))
            rows, begin = [unit.get_reals(outputs)], time.process_time()
            for moment in moments(duration):
                unit.step_to(moment)
                rows.append(unit.get_reals(outputs))
            spent = time.process_time() - begin
            jacobians = int(unit.get("solver.jacobians"))
        found[name] = Shift(spent, jacobians, *np.array(rows).T)
    return found


def run(
    archive: Archive,
    parameters: Parameters,
    variant: str,
    case: LoadCase,
    state: SteadyState,
    load: str,
    effort: Effort,
    progress: Callable[[float], None],
) -> CaseRun:
    """Runs a load case with one of `times.VARIANTS`, and measures it. `state` is the steady state of `ALE`; `progress` is called with the
    revolutions of each step."""
    turn = (parameters["geometry.beltLength"] - 2.0 * np.pi * parameters["belt.pitchOffset"]) / state["belt.speed"]
    settling, looking = effort.settling * turn, times.duration(effort.looking * turn, load)
    spent = {"start": 0.0, "settled": 0.0, "looked": 0.0}
    begin = time.process_time()
    with Instance(archive, _start_values(parameters, variant, case, state.load_torque, turn)) as unit:
        unit.initialise()
        spent["start"] = time.process_time() - begin
        is_steady = unit.not_steady is None

        def step_to(moment: float, part: str) -> None:
            progress((moment - unit.time) / turn)
            begin = time.process_time()
            if load == times.SWINGING:
                unit.set({"secondary.torque": times.wave(state.load_torque, unit.time)})
            unit.step_to(moment)
            spent[part] += time.process_time() - begin

        for moment in moments(settling):
            step_to(moment, "settled")
        window = None
        if load == times.SWINGING:
            for moment in moments(looking):
                step_to(settling + moment, "looked")
        else:
            places = np.linspace(0.0, effort.looking, round(effort.looking * effort.samples) + 1)
            window = _sampled(unit, settling + turn * places, lambda moment: step_to(moment, "looked"))
        counts = {count: int(unit.get(f"solver.{count}")) for count in times.COUNTS}
    row = {"case": case.name, "model": variant, "load": load, "settling": settling, "looking": looking, **spent, **counts}
    return CaseRun(variant, case, state.load_torque, window, is_steady, row)


def _start_values(parameters: Parameters, variant: str, case: LoadCase, load: float, turn: float) -> dict[str, float]:
    """The primary sheave and the primary speed are held."""
    values = driven_at_speed(parameters, ratio_of(case.theta), load_case_speed(), 0.0, case.clamping_force, held=True)
    model = {"ring.model": RingModel[variant.partition(",")[0]], "secondary.torque": load}
    return {**values, **model, **times.changes(variant, turn)}


def _sampled(unit: Instance, moments: Array, step_to: Callable[[float], None]) -> Window:
    """Outputs and fields along the belt at times; the first one is that of the unit."""
    outputs = unit.reals(output_names(unit.variables.values()))
    rows, push, radial, slipped = [], [], [], False
    for moment in moments.tolist():
        if moment > unit.time:
            step_to(moment)
        rows.append(unit.get_reals(outputs))
        slipped |= bool(unit.get("macroSlip"))
        profile = unit.profile()
        push.append(profile.push_force)
        radial.append(profile.radial_deviation)
    columns = dict(zip(outputs.names, np.array(rows).T, strict=True))
    return Window(Trace(moments - moments[0], columns), np.array(push), np.array(radial), profile.position, slipped)


def moments(end: float) -> list[float]:
    """Communication points of a run until `end`, s."""
    count = max(round(end / STEP), 1)
    return (end * np.arange(1, count + 1) / count).tolist()
