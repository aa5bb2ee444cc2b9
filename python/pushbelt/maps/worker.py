"""Worker side: the FMU is unpacked and loaded once, and solves one line after another.

This module and the required modules of `pushbelt.fmu` are sent to the workers (see `pushbelt.cluster`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pushbelt.fmu.steady import Pool, attempt
from pushbelt.fmu.unit import Archive
from pushbelt.fmu.working_points import SHAFTS, Along, Line, measure

Task = tuple[int, Line]
"""Index and line."""


class Solver:
    """The loaded FMU. Lines can be solved in several threads."""

    def __init__(self, archive: Archive, parameters: Mapping[str, float], along: Along) -> None:
        self._pool, self._along = Pool(archive, {**parameters, **SHAFTS}), along

    def solve(self, tasks: Sequence[Task]) -> list[dict[str, Any]]:
        """A row for each line: its index, and its results or the reason for missing ones."""
        return [{"line": index, **attempt(lambda line=line: self._found(line))} for index, line in tasks]

    def _found(self, line: Line) -> dict[str, Any]:
        with self._pool.one() as states:
            return {"found": measure(states, line, self._along)}

    def close(self) -> None:
        """Frees the instances."""
        self._pool.close()
