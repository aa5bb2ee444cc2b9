"""Measures the maps of the controllers on the FMU. `ThrustMap.of_maps` makes their thrust-ratio map of them."""

import math
from collections.abc import Mapping
from pathlib import Path

from pushbelt.errors import ArgumentError
from pushbelt.maps.data import Maps
from pushbelt.maps.plan import Grid, Plan, collect
from pushbelt.study.run import solve_in_processes

from .thrust_map import FORCE, OTHER_FORCE, SHIFT_UTILISATIONS, SPEED

SHARES = (0.3, 0.4, 0.55, 0.75, 1.0, 1.3, 1.8, 2.4, 3.0)
"""Primary forces of the shifts, relative to the force that holds the ratio."""
GRID = Grid(
    force=(OTHER_FORCE, FORCE), speed=(SPEED,), ratio=(0.45, 0.6, 0.8, 1.0, 1.3, 1.7, 2.2),
    utilisation=(-0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.8, 0.85, 0.9, 0.97), slip_share=(-1.0, 0.0, 1.0), torque_share=(-1.0, 0.0, 1.0),
    shift_utilisation=SHIFT_UTILISATIONS, excess=tuple(map(math.log, SHARES)),
)  # fmt: skip
"""Axes of the maps."""
LEAST = 3  # Least number of steady states at a ratio


def measure(fmu: Path, parameters: Mapping[str, float], folder: Path) -> Maps:
    """The maps of an FMU with these start values. Finished lines are stored in the folder, so a repeated call solves nothing.
    Raises ValueError if a ratio has too few steady states."""
    plan = Plan(fmu, parameters, GRID)
    maps = collect(plan, solve_in_processes(plan, folder, "thrust-ratio map"))
    for ratio, count in zip(plan.ratios, maps.valid[-1, 0].sum(axis=-1), strict=True):
        if count < LEAST:
            raise ArgumentError(f"too few steady states at ratio {ratio:g}: {count} of {len(GRID.utilisation)}")
    return maps
