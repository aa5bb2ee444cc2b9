"""How far measurements miss by what is known of the default belt's parameters.

The miss of a goal, in tolerances, has a standard deviation: half of its difference between plus and minus one deviation of each parameter, added
as independent ones. Parameters are those that make most of the steady outputs' deviations.
"""

from __future__ import annotations

import math
from pathlib import Path

import pushbelt
from pushbelt.fmu.unit import Archive
from pushbelt.report import side_by_side

from .bench import Plan
from .outcome import Part
from .runs import SECTIONS, run_section

NAME = "bench168"
MEASURED = ("slip", "thrust", "shifting", "efficiency", "gaps", "wedge")
"""Sections of measurements. Those that take longest start first."""
STATES = ((0.5, 60.0), (1.0, 60.0), (2.0, 40.0))  # Ratio, and torque in N·m
OUTPUTS = ("thrustRatio", "slip", "efficiency")
SURE = 1.96
"""Half-width of the 95 % band in standard deviations."""


def parameters(fmu: Path) -> list[str]:
    """Those that are among the largest three of an output at one of the states."""
    deviations = pushbelt.parameter_deviations(NAME)
    with pushbelt.Variator(NAME, fmu=fmu) as variator:
        bands = [variator.bands(ratio, torque, deviations) for ratio, torque in STATES]
    return sorted({name for band in bands for output in OUTPUTS for name in band.largest(output)})


def deviations_of_misses(fmu: Path, plan: Plan) -> dict[str, float]:
    """For each measurement with a tolerance, by key, the standard deviation of the distance of its worst value from the goal, in tolerances."""
    values, deviations = pushbelt.parameter_set(NAME), pushbelt.parameter_deviations(NAME)
    changes = [{name: values[name] + sign * deviations[name]} for name in parameters(fmu) for sign in (1.0, -1.0)]
    expected = [SECTIONS[name][2 if plan.short else 1] for name in MEASURED]
    with Archive.unpack(fmu) as archive:
        calls = [(run_section, (archive, name, plan, count, changed)) for changed in changes for name, count in zip(MEASURED, expected, strict=True)]
        sections = side_by_side.run_all(calls, sum(expected) * len(changes), "points of the FMU with other parameters")
    count = len(MEASURED)
    used = [
        {check.key: check.used for section in sections[k : k + count] if section.part is Part.MEASUREMENTS for check in section.checks}
        for k in range(0, len(sections), count)
    ]
    pairs = list(zip(used[::2], used[1::2], strict=True))
    known = [key for key in used[0] if all(one[key] is not None for one in used)]
    return {key: math.hypot(*(0.5 * (above[key] - below[key]) for above, below in pairs)) for key in known}  # type: ignore[operator]


def verdict(used: float | None, deviation: float | None) -> str:
    """Whether the goal is met within the 95 % band; empty where the miss has no tolerance."""
    return "" if used is None or deviation is None else "yes" if used - SURE * deviation <= 1.0 else "no"
