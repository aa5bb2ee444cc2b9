"""Worker side of a study: the FMU is unpacked and loaded once, and reset between points.

This module, `point` and the required modules of `pushbelt.fmu` are sent to the workers with the study (see `cluster`):
a worker needs Python packages (`distributed`, `fmpy`, `numpy`), but not this project.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence

from pushbelt.fmu.unit import Archive, Variator

from .point import Row, solve_or_say_why

Chunk = Sequence[tuple[int, Mapping[str, float]]]
"""Points of one task: index and start values."""


class Solver:
    """The loaded FMU. Points can be solved in several threads."""

    def __init__(self, archive: Archive) -> None:
        """Loads the FMU, so that errors of loading are not reported for single points."""
        self.instances = 1
        """Number of instances created so far."""
        self._archive = archive
        self._idle = [Variator(archive, {})]
        self._lock = threading.Lock()

    def solve(self, chunk: Chunk) -> list[Row]:
        """Rows of the points of a chunk. The row of a failed point contains the reason."""
        return [self._solve(index, values) for index, values in chunk]

    def _solve(self, index: int, values: Mapping[str, float]) -> Row:
        with self._lock:
            unit = self._idle.pop() if self._idle else None
            self.instances += unit is None
        unit = unit or Variator(self._archive, {})
        row, usable = solve_or_say_why(unit, index, values)
        if usable:
            with self._lock:
                self._idle.append(unit)
        else:
            unit.free()
        return row

    def close(self) -> None:
        """Frees the instances."""
        while self._idle:
            self._idle.pop().free()
