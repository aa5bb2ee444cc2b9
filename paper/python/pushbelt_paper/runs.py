"""The simulations of the report, and those of the computing times."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import pandas as pd

from pushbelt import side_by_side
from pushbelt.fmu.data import load_case_speed, load_cases, parameter_set
from pushbelt.fmu.results import LoadCase, SteadyState
from pushbelt.fmu.unit import Archive, UnitError
from pushbelt.side_by_side import Call, tick

from . import cases, rings, times
from .results import CHOSEN_CASE, MODELS, CaseRun, Effort, Failure, PaperResults
from .rings import Rings

VARIATOR = "bench168"
"""Parameter set of the load cases."""


@dataclass(frozen=True)
class Plan:
    """Extent of the runs."""

    effort: Effort
    cases: tuple[str, ...] | None
    """Names of the load cases; None for all."""
    timed: tuple[str, ...]
    """Load cases of the short form of the computing times, which simulates `clocked` revolutions."""
    clocked: float
    speeds: tuple[float, ...]
    """Primary speeds of steady states of the `timed` cases, relative to the load cases'."""
    sheaves: tuple[str, ...]
    """Load cases whose steady states are also solved with `ALE0` about the axes and with rigid sheaves."""
    shift: float
    """Duration of the shift on two meshes, s."""
    short: bool


FULL = Plan(
    Effort(settling=0.4, looking=1.0, samples=480),
    None,
    ("overdrive-50", "medium-50", "underdrive-50"),
    0.02,
    (0.5, 1.0, 1.5),
    ("overdrive-30", "overdrive-50", "overdrive-100"),
    shift=0.3,
    short=False,
)
SHORT = Plan(
    Effort(settling=0.02, looking=0.05, samples=480), ("medium-50", CHOSEN_CASE), ("medium-50",), 0.02, (), (), shift=0.1, short=True
)
WHOLE = (0.25, 1.0)
"""Revolutions of settling, and least of the evaluated part, of the long form of the computing times."""
SLOW = ("RCM", "ANCF")
"""Models that a long form runs once a pass; the others take so little time that each pass runs them thrice."""

RINGS_WEIGHT = 20.0
"""Share of the tests of rings alone in the progress bar."""
WEIGHTS = {"RCM": 60.0, "ANCF": 90.0}
"""Weight of a revolution by model in the progress bar; 1 for other models."""

WORKERS = 2
"""Number of parallel simulations. More would compete for caches and memory, and distort computing times."""


def _weight(model: str) -> float:
    return WEIGHTS.get(model, 1.0)


def _rings(program: Path, output: Path, short: bool) -> Rings:
    return rings.run(program, output, short, lambda share: tick(RINGS_WEIGHT * share))


def _case(archive: Archive, model: str, case: LoadCase, state: SteadyState, effort: Effort) -> CaseRun | Failure:
    parameters = parameter_set(VARIATOR)
    try:
        return cases.run(archive, parameters, model, case, state, effort, lambda turns: tick(_weight(model) * turns))
    except UnitError as error:
        return Failure(model, case, str(error))


def _time(archive: Archive, case: LoadCase, state: SteadyState, variant: str, *what: object) -> dict[str, str | float]:
    parameters, progress = parameter_set(VARIATOR), lambda turns: tick(_weight(variant) * turns)
    return times.measure(archive, parameters, case, state, variant, *what, progress)  # type: ignore[arg-type]


def _time_calls(
    archive: Archive, states: dict[LoadCase, SteadyState], repetitions: Iterable[int], revolutions: tuple[float, float]
) -> tuple[list[Call], float]:
    """Calls of all models beside each other, so that other load on the machine is the same for them, and their weight."""
    calls: list[Call] = []
    total = 0.0
    for repetition, (case, state), load, variant in product(repetitions, states.items(), times.LOADS, times.VARIANTS):
        turn = cases.revolution(parameter_set(VARIATOR), state)
        for again in range(1 if variant in SLOW else 3):
            number = repetition if variant in SLOW else 3 * (repetition - 1) + again + 1
            calls.append((_time, (archive, case, state, variant, load, number, revolutions)))
            total += _weight(variant) * sum(times.spans(turn, load, *revolutions)) / turn
    return calls, total


def _states(archive: Archive, names: tuple[str, ...] | None) -> dict[LoadCase, SteadyState]:
    parameters = parameter_set(VARIATOR)
    chosen = [case for case in load_cases(parameters) if names is None or case.name in names]
    return {case: cases.steady(archive, parameters, case) for case in chosen}


def whole_times(fmu: Path, repetitions: int) -> tuple[pd.DataFrame, str]:
    """Computing times of whole simulations, and the FMU's version. The first failure is raised."""
    with Archive.unpack(fmu) as archive:
        calls, total = _time_calls(archive, _states(archive, None), range(1, repetitions + 1), WHOLE)
        return pd.DataFrame(side_by_side.run_all(calls, total, "whole simulations", WORKERS)), archive.version


def run_all(fmu: Path, program: Path, output: Path, plan: Plan) -> PaperResults:
    """Runs all simulations. `program` is the one for rings alone, and `output` is the folder for its files."""
    with Archive.unpack(fmu) as archive:
        return _run_all(archive, program, output, plan)


def _run_all(archive: Archive, program: Path, output: Path, plan: Plan) -> PaperResults:
    parameters = parameter_set(VARIATOR)
    states = _states(archive, plan.cases)
    calls: list[Call] = [(_rings, (program, output / "rings", plan.short))]
    # The longest runs start first.
    models = sorted(MODELS, key=lambda model: -_weight(model))
    calls += [(_case, (archive, model, case, states[case], plan.effort)) for model in models for case in states]
    total = RINGS_WEIGHT + len(states) * (plan.effort.settling + plan.effort.looking) * sum(map(_weight, MODELS))
    timed = {case: state for case, state in states.items() if case.name in plan.timed}
    clocks, weight = _time_calls(archive, timed, [1], (0.0, plan.clocked))
    found, *done = side_by_side.run_all([*calls, *clocks], total + weight, "rings alone and load cases", WORKERS)
    runs, short_times = done[: len(calls) - 1], pd.DataFrame(done[len(calls) - 1 :])
    failures = tuple(run for run in runs if isinstance(run, Failure))
    left_out = {failure.case for failure in failures}
    if left_out == set(states):
        raise UnitError("; ".join(f"{f.case.name}, {f.model}: {f.reason}" for f in failures))
    left = [case for case in states if case not in left_out]
    speeds = tuple(factor * load_case_speed() for factor in plan.speeds)
    return PaperResults(
        fmu_version=archive.version,
        parameters=parameters,
        # In the paper's order.
        runs=tuple(run for model in MODELS for run in runs if run.model == model and run.case not in left_out),
        rings=found,
        speeds={c.name: cases.at_speeds(archive, parameters, c, speeds) for c in left if c.name in plan.timed and speeds},
        sheaves={c.name: cases.on_sheaves(archive, parameters, c) for c in left if c.name in plan.sheaves},
        meshes={c.name: cases.on_meshes(archive, parameters, c) for c in left},
        shifts=cases.shifts(archive, parameters, plan.shift),
        misaligned=cases.misaligned(archive, parameters, left[0]),
        short_times=short_times,
        failures=failures,
        effort=plan.effort,
        short=plan.short,
    )
