"""Parameter studies with the pushbelt FMU: steady states over a grid of five axes, or a design of any parameters and inputs (`design`).

    study (points) → `pushbelt.study` (cluster, store) → results.parquet → maps, checks → report
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pushbelt.study.run import Progress, solve

from .design import Design, DesignError
from .study import CHUNK, Grid, Study

if TYPE_CHECKING:
    import pyarrow

__all__ = ["Design", "DesignError", "Grid", "Progress", "Study", "sweep"]


def sweep(
    study: Study, folder: Path, *, scheduler: Any = None, workers: int | None = None, chunk: int | None = None,
    progress: Callable[[Progress], object] = lambda _: None,
) -> pyarrow.Table:  # fmt: skip
    """Solves the points of a study and returns one row a point; the other arguments are those of `pushbelt.study.run.solve`."""
    # Only what solves needs the packages of the extra.
    from .results import table

    rows = solve(study, folder, scheduler=scheduler, workers=workers, chunk=chunk or CHUNK, progress=progress)
    return table(study, rows)
