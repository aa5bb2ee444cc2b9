"""What runs on a worker: the FMU, unpacked and loaded once, and reset from point to point.

This module, `point` and the modules they need of `pushbelt.fmu` travel to the workers with the study (see `cluster`):
a worker needs Python packages (`distributed`, `fmpy`, `numpy`), but none of this project.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from distributed import WorkerPlugin

from pushbelt.fmu.unit import Archive, Variator

from .point import Row, solve_or_say_why

Chunk = Sequence[tuple[int, Mapping[str, float]]]
"""Points to solve in one go: index and start values."""


class Solver:
    """The FMU ready to solve points, from as many threads as there are."""

    def __init__(self, archive: Archive) -> None:
        """Loads the FMU: what can't be loaded is no matter of a point."""
        self.instances = 1
        """Instances made so far."""
        self._archive = archive
        self._idle = [Variator(archive, {})]
        self._lock = threading.Lock()

    def solve(self, chunk: Chunk) -> list[Row]:
        """The points of a chunk; one that fails says why in its row."""
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


class UnitPlugin(WorkerPlugin):
    """Brings an FMU to every worker, those that join later included."""

    def __init__(self, name: str, fmu: bytes) -> None:
        self.name = name
        self._fmu = fmu

    def setup(self, worker: Any) -> None:
        """Unpacks the FMU into the worker's own folder, and loads it."""
        self._cleanup = ExitStack()
        folder = Path(worker.local_directory) / self.name
        folder.mkdir(parents=True, exist_ok=True)
        file = folder / "unit.fmu"
        file.write_bytes(self._fmu)
        archive = Archive.unpack(file, folder / "unpacked")
        self._cleanup.callback(archive.remove)
        self.solver = Solver(archive)
        self._cleanup.callback(self.solver.close)

    def teardown(self, worker: Any) -> None:  # noqa: ARG002
        """Frees the instances and removes the folder's contents."""
        self._cleanup.close()
