"""The simulations of the report."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pushbelt import side_by_side
from pushbelt.fmu.data import load_case_speed, load_cases, parameter_set
from pushbelt.fmu.results import LoadCase, SteadyState
from pushbelt.fmu.unit import Archive, UnitError
from pushbelt.side_by_side import Call, tick

from . import rings
from .cases import Runner, at_speeds, misaligned, on_meshes, on_sheaves, shift_on_meshes, steady
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
    wavy: tuple[str, ...]
    """Load cases that are also run with an oscillating load."""
    speeds: tuple[float, ...]
    """Primary speeds relative to the load cases'."""
    sheaves: tuple[str, ...]
    """Load cases whose steady states are also solved with `ALE0` about the axes and with rigid sheaves."""
    shift: float
    """Duration of the shift on two meshes, s."""
    short: bool


FULL = Plan(
    Effort(settling=0.4, looking=1.0, samples=480, clocked=0.05, repetitions=3),
    None,
    ("overdrive-50", "medium-50", "underdrive-50"),
    (0.5, 1.0, 1.5),
    ("overdrive-30", "overdrive-50", "overdrive-100"),
    shift=0.3,
    short=False,
)
SHORT = Plan(
    Effort(settling=0.02, looking=0.05, samples=480, clocked=0.02, repetitions=1),
    ("medium-50", CHOSEN_CASE),
    ("medium-50",),
    (),
    (),
    shift=0.1,
    short=True,
)

RINGS_WEIGHT = 20.0
"""Share of the tests of rings alone in the progress bar."""
WEIGHTS = {"RCM": 60.0, "ANCF": 25.0}
"""Weight of a revolution by model in the progress bar; 1 for other models."""

WORKERS = 2
"""Number of parallel simulations. More would compete for caches and memory, and distort computing times."""


def run_all(fmu: Path, program: Path, output: Path, plan: Plan) -> PaperResults:
    """Runs all simulations. `program` is the one for rings alone, and `output` is the folder for its files."""
    with Archive.unpack(fmu) as archive:
        return _run_all(archive, program, output, plan)


def _rings(program: Path, output: Path, short: bool) -> Rings:
    done = 0.0

    def progress(share: float, _name: str) -> None:
        nonlocal done
        tick(RINGS_WEIGHT * (share - done))
        done = share

    return rings.run(program, output, short, progress)


def _case(
    archive: Archive, model: str, case: LoadCase, state: SteadyState, effort: Effort, wavy: bool
) -> CaseRun | Failure:
    def progress(revolutions: float) -> None:
        tick(WEIGHTS.get(model, 1.0) * revolutions)

    try:
        return Runner(archive, parameter_set(VARIATOR), model, case, state, effort, progress).run(wavy)
    except UnitError as error:
        return Failure(model, case, str(error))


def _run_all(archive: Archive, program: Path, output: Path, plan: Plan) -> PaperResults:
    parameters = parameter_set(VARIATOR)
    cases = [case for case in load_cases(parameters) if plan.cases is None or case.name in plan.cases]
    states = {case: steady(archive, parameters, case) for case in cases}
    calls: list[Call] = [(_rings, (program, output / "rings", plan.short))]
    total = RINGS_WEIGHT
    # The longest runs start first.
    for model in sorted(MODELS, key=lambda model: -WEIGHTS.get(model, 1.0)):
        for case in cases:
            wavy = case.name in plan.wavy
            total += WEIGHTS.get(model, 1.0) * plan.effort.revolutions(wavy)
            calls.append((_case, (archive, model, case, states[case], plan.effort, wavy)))
    found, *runs = side_by_side.run_all(calls, total, "rings alone and load cases", WORKERS)
    failures = tuple(run for run in runs if isinstance(run, Failure))
    left_out = {failure.case for failure in failures}
    if left_out == set(cases):
        raise UnitError("; ".join(f"{f.case.name}, {f.model}: {f.reason}" for f in failures))
    cases = [case for case in cases if case not in left_out]
    speeds = tuple(factor * load_case_speed() for factor in plan.speeds)
    return PaperResults(
        fmu_version=archive.version,
        parameters=parameters,
        runs=tuple(run for run in runs if run.case not in left_out),
        rings=found,
        speeds={c.name: at_speeds(archive, parameters, c, speeds) for c in cases if c.name in plan.wavy and speeds},
        sheaves={c.name: on_sheaves(archive, parameters, c) for c in cases if c.name in plan.sheaves},
        meshes={c.name: on_meshes(archive, parameters, c) for c in cases},
        shifts=shift_on_meshes(archive, parameters, plan.shift),
        misaligned=misaligned(archive, parameters, cases[0]),
        failures=failures,
        effort=plan.effort,
        short=plan.short,
    )
