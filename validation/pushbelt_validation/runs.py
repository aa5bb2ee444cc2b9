"""The sections of the report. They run in parallel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType

from pushbelt.fmu.unit import Archive
from pushbelt.report import side_by_side
from pushbelt.report.side_by_side import tick

from .bench import Bench, Plan
from .outcome import Section
from .sections import chain, continuum, default_belt, efficiency, gaps, shifting, single_elements, slip, steps, thrust, wedge

SECTIONS: dict[str, tuple[ModuleType, int, int]] = {
    "steps": (steps, 121, 52),
    "continuum": (continuum, 45, 11),
    "chain": (chain, 68, 11),
    "default_belt": (default_belt, 18, 4),
    "elements": (single_elements, 125, 26),
    "shifting": (shifting, 81, 44),
    "efficiency": (efficiency, 270, 50),
    "slip": (slip, 400, 90),
    "gaps": (gaps, 5, 5),
    "thrust": (thrust, 280, 20),
    "wedge": (wedge, 18, 18),
}
"""Sections in the order of the report, with their approximate numbers of points in a full and in a short run."""
FIRST = ("steps", "continuum", "chain", "slip", "thrust", "shifting")
"""Sections that take longest start first."""


@dataclass(frozen=True)
class Results:
    """All sections of a run."""

    version: str
    sections: tuple[Section, ...]
    short: bool


def run_section(archive: Archive, name: str, plan: Plan, expected: int, changed: Mapping[str, float]) -> Section:
    """One section, in a worker, with some parameters of the variator changed."""
    done = 0

    def solved() -> None:
        nonlocal done
        done += 1
        if done <= expected:
            tick(1.0)

    with Bench(archive, solved=solved, changed=changed) as bench:
        found = SECTIONS[name][0].run(bench, plan)
        failures = tuple(bench.failures)
    tick(max(expected - done, 0))
    return replace(found, failures=failures)


def run_all(fmu: Path, plan: Plan, names: tuple[str, ...] = tuple(SECTIONS)) -> Results:
    """Runs sections with an FMU."""
    points = {name: SECTIONS[name][2 if plan.short else 1] for name in names}
    order = sorted(names, key=lambda name: FIRST.index(name) if name in FIRST else len(FIRST))
    with Archive.unpack(fmu) as archive:
        calls = [(run_section, (archive, name, plan, points[name], {})) for name in order]
        found = dict(zip(order, side_by_side.run_all(calls, sum(points.values()), "points of the FMU"), strict=True))
        return Results(archive.version, tuple(found[name] for name in SECTIONS if name in found), plan.short)
