"""Runs all of it, one after the other in one process: computing times of runs side by side could not be compared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pushbelt_demo.data import load_case_speed, load_cases, parameter_set
from pushbelt_demo.results import LoadCase
from pushbelt_demo.unit import Archive
from tqdm import tqdm

from . import rings
from .cases import Effort, Runner, at_speeds, find_load, ring_models
from .results import CaseRun, PaperResults, SpeedPoint

VARIATOR = "bench168"
"""Parameter set of the load cases."""


@dataclass(frozen=True)
class Plan:
    """How much is run."""

    effort: Effort
    cases: tuple[str, ...] | None
    """Names of the load cases; None for all."""
    wavy: tuple[str, ...]
    """Load cases that are also run with a load that swings."""
    speeds: tuple[float, ...]
    """Primary speeds relative to the load cases'."""
    short: bool


FULL = Plan(
    Effort(settling=2.0, samples=240, repetitions=3),
    None,
    ("overdrive-50", "medium-50", "underdrive-50"),
    (0.5, 1.0, 1.5),
    short=False,
)
SHORT = Plan(
    Effort(settling=0.25, samples=60, repetitions=1), ("medium-50", "underdrive-30"), ("medium-50",), (1.0,), short=True
)

RINGS_WEIGHT = 40.0
"""Share of the tests of rings alone in the progress bar."""
WEIGHTS = {"RCM": 10.0, "ANCF": 10.0}
"""Share of one run of a load case; of the other models 1."""


def run_all(fmu: Path, program: Path, output: Path, plan: Plan) -> PaperResults:
    """Runs everything; `program` is the one for rings alone, `output` the folder for what it writes."""
    archive = Archive.unpack(fmu)
    try:
        return _run_all(archive, program, output, plan)
    finally:
        archive.remove()


def _run_all(archive: Archive, program: Path, output: Path, plan: Plan) -> PaperResults:
    parameters = parameter_set(VARIATOR)
    cases = [case for case in load_cases(parameters) if plan.cases is None or case.name in plan.cases]
    models = tuple(ring_models(archive))
    runs = sum(plan.effort.runs(case.name in plan.wavy) for case in cases)
    weight = runs * sum(WEIGHTS.get(model, 1.0) for model in models)
    with tqdm(
        total=RINGS_WEIGHT + weight,
        disable=None,
        desc="rings alone",
        bar_format="  {desc:34} {bar:24} {percentage:3.0f} % [{elapsed}<{remaining}]",
    ) as bar:
        done = 0.0

        def rings_progress(share: float, name: str) -> None:
            nonlocal done
            bar.set_description(name, refresh=False)
            bar.update(RINGS_WEIGHT * (share - done))
            done = share

        found = rings.run(program, output / "rings", plan.short, rings_progress)
        runs, speeds = _variator(archive, parameters, cases, models, plan, bar)
    return PaperResults(
        fmu_version=archive.description.version or "",
        parameters=parameters,
        models=models,
        runs=tuple(runs),
        rings=found,
        speeds=speeds,
        short=plan.short,
    )


def _variator(
    archive: Archive,
    parameters: Mapping[str, float],
    cases: list[LoadCase],
    models: tuple[str, ...],
    plan: Plan,
    bar: tqdm,
) -> tuple[list[CaseRun], dict[str, tuple[SpeedPoint, ...]]]:
    runs = []
    speeds = {}
    for case in cases:
        bar.set_description(f"{case.name}: load", refresh=True)
        steady = find_load(archive, parameters, case)
        for model in models:
            bar.set_description(f"{case.name}: {model}", refresh=True)
            weight = WEIGHTS.get(model, 1.0)
            runner = Runner(archive, parameters, model, case, steady, plan.effort)
            runs.append(runner.run(case.name in plan.wavy, lambda weight=weight: bar.update(weight)))
        if case.name in plan.wavy:
            bar.set_description(f"{case.name}: other speeds", refresh=True)
            speeds[case.name] = at_speeds(
                archive, parameters, case, tuple(factor * load_case_speed() for factor in plan.speeds)
            )
    return runs, speeds
