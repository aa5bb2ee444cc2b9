"""Worker side: the FMU is unpacked and loaded once, and solves one line after another.

This module and the required modules of `pushbelt.fmu` are sent to the workers (see `pushbelt.cluster`).
"""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from distributed import WorkerPlugin

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


class MapsPlugin(WorkerPlugin):
    """Installs an FMU on every worker, including workers that join later."""

    def __init__(self, name: str, fmu: bytes, parameters: Mapping[str, float], along: Along) -> None:
        self.name = name
        self._fmu, self._parameters, self._along = fmu, parameters, along

    def setup(self, worker: Any) -> None:
        """Unpacks the FMU into the worker's folder and loads it."""
        self._cleanup = ExitStack()
        folder = Path(worker.local_directory) / self.name
        folder.mkdir(parents=True, exist_ok=True)
        file = folder / "unit.fmu"
        file.write_bytes(self._fmu)
        archive = Archive.unpack(file, folder / "unpacked")
        self._cleanup.callback(archive.remove)
        self.solver = Solver(archive, self._parameters, self._along)
        self._cleanup.callback(self.solver.close)

    def teardown(self, worker: Any) -> None:
        """Frees the instances and removes the unpacked FMU."""
        self._cleanup.close()
