"""Runs a study: missing points are sent to the cluster in chunks, and each finished chunk is stored."""

from __future__ import annotations

import math
import random
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa
from distributed import Client

from pushbelt.slurm import Slurm

from . import cluster
from .store import Store, table, with_metadata
from .study import Study
from .worker import Chunk

CHUNK = 8
"""Points per chunk. A chunk takes some seconds, so that little is lost with a worker and the overhead is negligible."""
MOST_CHUNKS = 5000
"""Largest number of chunks. Larger studies have larger chunks, because each chunk is a file."""
WORKERS_INTERVAL = 1.0
"""Interval of polling the number of workers, s."""


@dataclass(frozen=True)
class Progress:
    """Progress of a study."""

    points: int
    done: int
    """Number of finished points, including earlier runs."""
    failed: int
    """Number of finished points without a steady state."""
    workers: int


def chunks(study: Study, finished: set[int], size: int | None = None) -> list[Chunk]:
    """Missing points, in chunks.

    Points are shuffled: points without a steady state take longest and are neighbours, so without shuffling the chunks would
    take very different times.
    """
    missing = [point for point in study.grid.points() if point.index not in finished]
    random.Random(0).shuffle(missing)
    size = size or max(CHUNK, -(-len(missing) // MOST_CHUNKS))
    return [
        [(point.index, study.start_values(point)) for point in missing[start : start + size]]
        for start in range(0, len(missing), size)
    ]


def sweep(
    study: Study,
    folder: Path,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    slurm: Slurm | None = None,
    chunk: int | None = None,
    progress: Callable[[Progress], object] = lambda _: None,
) -> pa.Table:
    """Solves the points of a study and returns one row a point.

    Finished points are stored in `folder`; a study with the same FMU, parameters and grid continues from them. `scheduler`
    is the address of a dask scheduler; `slurm` submits jobs. By default `workers` local processes are started, one per processor. A program that
    starts local processes needs the guard `if __name__ == "__main__":`. `progress` is called after each chunk of `chunk`
    points, and about once per second in between.

    Raises ClusterError if the cluster cannot be reached or is lost. Finished points remain stored.
    """
    store = Store(folder, study)
    kept = store.rows()
    missing = chunks(study, {row["point"] for row in kept}, chunk)
    lost = []
    if missing:
        with cluster.connect(scheduler, workers, slurm) as client:
            lost = _solve(client, study, store, missing, kept, progress)
    return with_metadata(study, table(study, [*store.rows(), *lost]))


def _solve(client: Client, study: Study, store: Store, missing: list[Chunk], kept: list, progress: Callable) -> list:
    """Solves missing points. Returns the points that lost their workers; the next run tries them again."""
    done, failed, lost = len(kept), sum(row["reason"] is not None for row in kept), []
    workers, asked = 0, -math.inf

    def report() -> None:
        nonlocal workers, asked
        if time.monotonic() > asked + WORKERS_INTERVAL:
            workers, asked = len(client.nthreads()), time.monotonic()
        progress(Progress(len(study.grid), done, failed, workers))

    with cluster.shipped(client, study.archive) as solve:
        for rows in cluster.rows(client, solve, missing, report):
            if rows[0]["reason"] == cluster.WORKER_LOST:
                lost += rows
            else:
                store.add(rows)
            done += len(rows)
            failed += sum(row["reason"] is not None for row in rows)
            report()
    return lost
