"""Worker side of a study: the FMU is unpacked and loaded once, and reset between points.

This module, `point` and the required modules of `pushbelt.fmu` are sent to the workers with the study (see `cluster`):
a worker needs Python packages (`distributed`, `fmpy`, `numpy`), but not this project.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pushbelt.fmu.steady import Pool
from pushbelt.fmu.unit import Archive

from .point import Row, solve_or_say_why

Chunk = Sequence[tuple[int, Mapping[str, float]]]
"""Points of one task: index and start values."""


class Solver:
    """The loaded FMU. Points can be solved in several threads."""

    def __init__(self, archive: Archive) -> None:
        self.pool = Pool(archive)

    def solve(self, chunk: Chunk) -> list[Row]:
        """Rows of the points of a chunk. The row of a failed point contains the reason."""
        return [solve_or_say_why(self.pool, index, values) for index, values in chunk]

    def close(self) -> None:
        """Frees the instances."""
        self.pool.close()
