"""Measures the maps of the controllers on the FMU. `ThrustMap.of_maps` makes their thrust-ratio map of them."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pushbelt import side_by_side
from pushbelt.fmu import working_points
from pushbelt.fmu.steady import SteadyStates, attempt
from pushbelt.fmu.unit import Archive
from pushbelt.fmu.working_points import SHAFTS, Along, Line
from pushbelt.map_data import Maps
from pushbelt.map_lines import Store, collect
from pushbelt.map_plan import Grid, Plan
from pushbelt.side_by_side import tick

from .thrust_map import FORCE, OTHER_FORCE, SHIFT_UTILISATIONS, SPEED

SHARES = (0.3, 0.4, 0.55, 0.75, 1.0, 1.3, 1.8, 2.4, 3.0)
"""Primary forces of the shifts, relative to the force that holds the ratio."""
GRID = Grid(
    force=(OTHER_FORCE, FORCE),
    speed=(SPEED,),
    ratio=(0.45, 0.6, 0.8, 1.0, 1.3, 1.7, 2.2),
    utilisation=(-0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.8, 0.85, 0.9, 0.97),
    slip_share=(-1.0, 0.0, 1.0),
    shift_utilisation=SHIFT_UTILISATIONS,
    excess=tuple(map(math.log, SHARES)),
)
"""Axes of the maps."""
LEAST = 3
"""Least number of steady states at a ratio."""


def measure(fmu: Path, parameters: Mapping[str, float], folder: Path) -> Maps:
    """The maps of an FMU with these start values. Finished lines are stored in the folder, so a repeated call solves nothing.

    Raises ValueError if a ratio has too few steady states.
    """
    plan = Plan(fmu, parameters, GRID)
    store = Store(folder, plan)
    rows = store.rows()
    missing = [(index, line) for index, line in enumerate(plan.lines) if index not in rows]
    if missing:
        with Archive.unpack(fmu) as archive:
            calls = [(_solve, (archive, plan.full, plan.along, index, line)) for index, line in missing]
            for found in side_by_side.run_all(calls, len(calls), "thrust-ratio map", os.cpu_count() or 1):
                rows[found["line"]] = found
                store.add(found)
    maps = collect(plan, rows)
    for ratio, count in zip(plan.ratios, maps.valid[-1, 0].sum(axis=-1), strict=True):
        if count < LEAST:
            raise ValueError(f"too few steady states at ratio {ratio:g}: {count} of {len(GRID.utilisation)}")
    return maps


def _solve(archive: Archive, parameters: Mapping[str, float], along: Along, index: int, line: Line) -> dict[str, Any]:
    with SteadyStates(archive, {**parameters, **SHAFTS}) as states:
        found = attempt(lambda: {"found": working_points.measure(states, line, along)})
    tick(1.0)
    return {"line": index, **found}
