"""The simulations of the report."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from pushbelt.fmu.data import load_case_speed, load_cases, parameter_set
from pushbelt.fmu.results import LoadCase, SteadyState
from pushbelt.fmu.unit import Archive, UnitError
from pushbelt.report import side_by_side
from pushbelt.report.side_by_side import Call, tick

from . import cases, rings, times
from .results import CHOSEN_CASE, MODELS, CaseRun, Effort, Failure, PaperResults
from .rings import Rings

VARIATOR = "bench168"
"""Parameter set of the load cases."""


class Plan(NamedTuple):
    """Extent of the runs: names of the load cases (None for all), primary speeds of steady states at 50 N·m relative to the load cases',
    load cases whose steady states are also solved with `ALE0` about the axes and with rigid sheaves, duration of the shift in s, and
    whether the load cases are also run with a swinging load."""

    effort: Effort
    cases: tuple[str, ...] | None
    speeds: tuple[float, ...]
    sheaves: tuple[str, ...]
    shift: float
    short: bool
    swinging: bool = False


FULL = Plan(
    Effort(settling=0.4, looking=1.0, samples=480),
    None,
    (0.5, 1.0, 1.5),
    ("overdrive-30", "overdrive-50", "overdrive-100"),
    shift=0.3,
    short=False,
)
SHORT = Plan(Effort(settling=0.01, looking=0.03, samples=480), ("medium-50", CHOSEN_CASE), (), (), shift=0.1, short=True)

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


def _case(
    archive: Archive, variant: str, case: LoadCase, state: SteadyState, load: str, effort: Effort
) -> list[CaseRun] | Failure:
    """All repetitions of a run."""
    parameters, progress = parameter_set(VARIATOR), lambda turns: tick(_weight(variant) * turns)
    try:
        return [
            cases.run(archive, parameters, variant, case, state, load, effort, progress)
            for _ in range(1 if variant in times.SLOW else 3)
        ]
    except UnitError as error:
        return Failure(variant, case, str(error))


def _states(archive: Archive, names: tuple[str, ...] | None) -> dict[LoadCase, SteadyState]:
    parameters = parameter_set(VARIATOR)
    chosen = [case for case in load_cases(parameters) if names is None or case.name in names]
    return {case: cases.steady(archive, parameters, case) for case in chosen}


def run_all(fmu: Path, program: Path, output: Path, plan: Plan) -> PaperResults:
    """Runs all simulations. `program` is the one for rings alone, and `output` is the folder for its files."""
    with Archive.unpack(fmu) as archive:
        return _run_all(archive, program, output, plan)


def _run_all(archive: Archive, program: Path, output: Path, plan: Plan) -> PaperResults:
    parameters = parameter_set(VARIATOR)
    states = _states(archive, plan.cases)
    calls: list[Call] = [(_rings, (program, output / "rings", plan.short))]
    total = RINGS_WEIGHT
    # All models beside each other, so that other load on the machine is the same for them.
    for case, load, variant in product(states, times.LOADS[: 1 + plan.swinging], times.VARIANTS):
        calls.append((_case, (archive, variant, case, states[case], load, plan.effort)))
        total += _weight(variant) * (plan.effort.settling + plan.effort.looking)
    found, *runs = side_by_side.run_all(calls, total, "rings alone and load cases", WORKERS)
    failures = tuple(run for run in runs if isinstance(run, Failure))
    left_out = {failure.case for failure in failures}
    if left_out == set(states):
        raise UnitError("; ".join(f"{f.case.name}, {f.model}: {f.reason}" for f in failures))
    left = [case for case in states if case not in left_out]
    repeated = [run for run in runs if not isinstance(run, Failure) and run[0].case in left]
    speeds = tuple(factor * load_case_speed() for factor in plan.speeds)
    return PaperResults(
        fmu_version=archive.version,
        parameters=parameters,
        runs=tuple(run for model in MODELS for run, *_ in repeated if run.model == model and run.window is not None),
        rings=found,
        speeds={c.name: cases.at_speeds(archive, parameters, c, speeds) for c in left if c.torque == 50.0 and speeds},
        sheaves={c.name: cases.on_sheaves(archive, parameters, c) for c in left if c.name in plan.sheaves},
        meshes={c.name: cases.on_meshes(archive, parameters, c) for c in left},
        shifts=cases.shifts(archive, parameters, plan.shift),
        misaligned=cases.misaligned(archive, parameters, left[0]),
        times=pd.DataFrame([run.times for repetitions in repeated for run in repetitions]),
        failures=failures,
        effort=plan.effort,
        short=plan.short,
    )
