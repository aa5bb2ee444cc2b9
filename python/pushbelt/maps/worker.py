"""Worker side: the FMU is unpacked and loaded once, and solves one line after another.

This module and the required modules of `pushbelt.fmu` are sent to the workers (see `pushbelt.cluster`).
"""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping, Sequence
from typing import Any

from pushbelt.fmu.unit import Archive, UnitError
from pushbelt.fmu.working_points import Along, Bench, Line, measure

Task = tuple[int, Line]
"""Index and line."""


class Solver:
    """The loaded FMU. Lines can be solved in several threads."""

    def __init__(self, archive: Archive, parameters: Mapping[str, float], along: Along) -> None:
        """Loads the FMU, so that errors of loading are not reported for single lines."""
        self._archive, self._parameters, self._along = archive, parameters, along
        self._benches: list[Bench] = []
        self._own = threading.local()
        self._bench()

    def _bench(self) -> Bench:
        if not hasattr(self._own, "bench"):
            self._own.bench = Bench(self._archive, self._parameters)
            self._benches.append(self._own.bench)
        return self._own.bench

    def solve(self, tasks: Sequence[Task]) -> list[dict[str, Any]]:
        """A row for each line: its index, and its results or the reason for missing ones."""
        return [self._solve(index, line) for index, line in tasks]

    def _solve(self, index: int, line: Line) -> dict[str, Any]:
        begin = time.thread_time()
        try:
            row: dict[str, Any] = {"line": index, "found": measure(self._bench(), line, self._along)}
        except UnitError as error:
            row = {"line": index, "reason": str(error)}
        except Exception as error:  # noqa: BLE001
            row = {"line": index, "reason": f"{type(error).__name__}: {error}"}
        return {**row, "time": time.thread_time() - begin}

    def close(self) -> None:
        """Frees the instances."""
        for bench in self._benches:
            bench.close()
