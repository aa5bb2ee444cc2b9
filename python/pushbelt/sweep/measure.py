"""Measurement of the points per second of a cluster."""

from __future__ import annotations

import os
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import pyarrow.compute as pc

from .run import Progress, sweep
from .study import Grid, Study, rpm, spread

GRID = Grid(
    friction=(0.07, 0.09),
    speed=rpm(1000, 2000),
    ratio=spread(0.5, 2.0, 5),
    utilisation=(0.2, 0.4, 0.5, 0.6, 0.8, 0.9),
)
"""120 points."""


LOAD = hasattr(os, "getloadavg")
"""Whether the system has a load average; Windows has none."""


@dataclass(frozen=True)
class Speed:
    """Speed of a cluster."""

    workers: int
    points: int
    seconds: float
    """Wall-clock time from sending the first chunk to receiving the last one, without the start of the cluster."""
    processor_time: float
    """Processor time of all points, s."""


def measure(study: Study, scheduler: str | None, workers: int | None) -> Speed:
    """Solves all points of a study, including finished ones."""
    times: list[tuple[float, Progress]] = []
    with tempfile.TemporaryDirectory() as folder:
        table = sweep(
            study,
            Path(folder),
            scheduler=scheduler,
            workers=workers,
            progress=lambda progress: times.append((time.perf_counter(), progress)),
        )
    (begin, _), (end, last) = times[0], times[-1]
    return Speed(last.workers, len(table), end - begin, pc.sum(table["time"]).as_py())


def table(study: Study, scheduler: str | None, workers: int | None) -> str:
    """A table of the speed of a cluster: with one and two workers, or as specified.

    The load of this machine before the measurement shows whether other programs were running.
    """
    busy = f"This machine has {os.cpu_count()} processors; the load average before was {os.getloadavg()[0]:.1f}." if LOAD else ""
    counts = [workers] if scheduler or workers else [1, 2]
    lines = ["| workers | points | s | points/s | processor time per point, s |", "|---|---|---|---|---|"]
    for count in counts:
        speed = measure(study, scheduler, count)
        lines.append(
            f"| {speed.workers} | {speed.points} | {speed.seconds:.1f} | {speed.points / speed.seconds:.2f} "
            f"| {speed.processor_time / speed.points:.3f} |"
        )
    return "\n".join([*lines, busy]).rstrip()
