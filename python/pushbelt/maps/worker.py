"""Worker side: the FMU is unpacked and loaded once, and solves one line after another.

This module and the required modules of `pushbelt.fmu` are sent to the workers (see `pushbelt.cluster`).
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

from pushbelt.fmu.steady import Pool
from pushbelt.fmu.unit import Archive, UnitError
from pushbelt.fmu.working_points import SHAFTS, Along, Line, measure

Task = tuple[int, Line]
"""Index and line."""


class Solver:
    """The loaded FMU. Lines can be solved in several threads."""

    def __init__(self, archive: Archive, parameters: Mapping[str, float], along: Along) -> None:
        self._pool, self._along = Pool(archive, {**parameters, **SHAFTS}), along

    def solve(self, tasks: Sequence[Task]) -> list[dict[str, Any]]:
        """A row for each line: its index, and its results or the reason for missing ones."""
        return [self._solve(index, line) for index, line in tasks]

    def _solve(self, index: int, line: Line) -> dict[str, Any]:
        begin = time.thread_time()
        try:
            with self._pool.one() as states:
                row: dict[str, Any] = {"line": index, "found": measure(states, line, self._along)}
        except UnitError as error:
            row = {"line": index, "reason": str(error)}
        except Exception as error:  # noqa: BLE001
            row = {"line": index, "reason": f"{type(error).__name__}: {error}"}
        return {**row, "time": time.thread_time() - begin}

    def close(self) -> None:
        """Frees the instances."""
        self._pool.close()
