"""Runs all simulations of the demo in parallel processes, with a progress bar."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pushbelt.fmu import load_cases
from pushbelt.fmu.data import load_cases as all_load_cases
from pushbelt.fmu.data import manoeuvre_inputs, parameter_set
from pushbelt.fmu.results import LoadCase, LoadCaseResult
from pushbelt.fmu.unit import Archive
from pushbelt.report.side_by_side import run_all as run_side_by_side
from pushbelt.report.side_by_side import tick

from . import manoeuvre, measured
from .results import DemoResults, ManoeuvreResult, MeasuredPoint

VARIATOR = "bench168"
"""Parameter set of the load cases and the manoeuvre."""


@dataclass(frozen=True)
class Plan:
    """Extent of the run."""

    torques: tuple[float, ...] | None = None
    """Torques of the load cases, N·m; None for all."""
    duration: float | None = None
    """Duration of the manoeuvre, s; None for all of it."""


FULL = Plan()
SHORT = Plan(torques=(100.0,), duration=1.0)


def _run_manoeuvre(archive: Archive, variator: str, duration: float) -> ManoeuvreResult:
    def progress(seconds: float) -> None:
        tick(_MANOEUVRE_TICKS * seconds / duration)

    return manoeuvre.run(archive, parameter_set(variator), manoeuvre_inputs(), progress, duration)


def _run_case(archive: Archive, variator: str, case: LoadCase) -> LoadCaseResult:
    result = load_cases.run(archive, parameter_set(variator), case)
    tick(_CASE_TICKS)
    return result


def _run_measured(archive: Archive, variator: str) -> tuple[MeasuredPoint, ...]:
    points = measured.run(archive, parameter_set(variator))
    tick(_CASE_TICKS)
    return points


_CASE_TICKS = 5
_MANOEUVRE_TICKS = 100


def run_all(fmu: Path, plan: Plan = FULL, variator: str = VARIATOR) -> DemoResults:
    """Runs a plan with an FMU and a parameter set."""
    with Archive.unpack(fmu) as archive:
        return _run_all(archive, plan, variator)


def _run_all(archive: Archive, plan: Plan, variator: str) -> DemoResults:
    parameters = parameter_set(variator)
    cases = [case for case in all_load_cases(parameters) if plan.torques is None or case.torque in plan.torques]
    duration = float(manoeuvre_inputs().time[-1]) if plan.duration is None else plan.duration
    run, points, *states = run_side_by_side(
        [
            # The manoeuvre starts first, because it takes longest and cannot be divided.
            (_run_manoeuvre, (archive, variator, duration)),
            (_run_measured, (archive, variator)),
            *((_run_case, (archive, variator, case)) for case in cases),
        ],
        total=_MANOEUVRE_TICKS + _CASE_TICKS * (1 + len(cases)),
        title="load cases and manoeuvre",
    )
    return DemoResults(
        fmu_version=archive.version,
        cases=tuple(states),
        measured=points,
        manoeuvre=run,
        parameters=parameters,
        units=archive.units,
        variator=variator,
    )
