"""The sections of the report. They run in parallel."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType

from pushbelt import side_by_side
from pushbelt.fmu.unit import Archive
from pushbelt.side_by_side import tick

from .bench import Bench, Plan
from .outcome import Section
from .sections import chain, continuum, efficiency, gaps, sensitivity, shifting, slip, stress, thrust, variators, wedge

SECTIONS: dict[str, ModuleType] = {
    "continuum": continuum,
    "shifting": shifting,
    "efficiency": efficiency,
    "slip": slip,
    "gaps": gaps,
    "thrust": thrust,
    "wedge": wedge,
    "stress": stress,
    "chain": chain,
    "variators": variators,
    "sensitivity": sensitivity,
}
"""Sections in the order of the report."""


@dataclass(frozen=True)
class Results:
    """All sections of a run."""

    version: str
    sections: tuple[Section, ...]
    short: bool


def _run(archive: Archive, name: str, plan: Plan) -> Section:
    """One section, in a worker."""
    section = SECTIONS[name]
    expected, done = section.count(plan), 0

    def solved() -> None:
        nonlocal done
        done += 1
        if done <= expected:
            tick(1.0)

    with Bench(archive, solved=solved) as bench:
        found = section.run(bench, plan)
        failures = tuple(bench.failures)
    tick(max(expected - done, 0))
    return replace(found, failures=failures)


def run_all(fmu: Path, plan: Plan, names: tuple[str, ...] = tuple(SECTIONS)) -> Results:
    """Runs sections with an FMU. Sections with many points start first."""
    order = sorted(names, key=lambda name: -SECTIONS[name].count(plan))
    with Archive.unpack(fmu) as archive:
        calls: list[tuple[Callable[..., Section], tuple[Archive, str, Plan]]] = [
            (_run, (archive, name, plan)) for name in order
        ]
        total = sum(SECTIONS[name].count(plan) for name in order)
        found = dict(zip(order, side_by_side.run_all(calls, total, "points of the FMU"), strict=True))
        return Results(archive.version, tuple(found[name] for name in SECTIONS if name in found), plan.short)
