"""Runs a study: what is missing goes to the cluster in chunks, and each is stored as it comes back."""

from __future__ import annotations

import math
import random
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa
from distributed import Client

from . import cluster
from .store import Store, table, with_metadata
from .study import Study
from .worker import Chunk

CHUNK = 8
"""Points of a chunk: some seconds, so that little is lost with a worker and the overhead is none."""
MOST_CHUNKS = 5000
"""Larger studies have larger chunks: each is a file."""
WORKERS_INTERVAL = 1.0
"""How often the scheduler is asked for its workers, s."""


@dataclass(frozen=True)
class Progress:
    """Where a study stands."""

    points: int
    done: int
    """Points finished, in earlier runs too."""
    failed: int
    """Of them without a steady state."""
    workers: int


def chunks(study: Study, finished: set[int], size: int | None = None) -> list[Chunk]:
    """What is missing, in chunks.

    Points are shuffled: points without a steady state take longest and lie together, so the time of one chunk
    would say nothing about the next.
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
    chunk: int | None = None,
    progress: Callable[[Progress], object] = lambda _: None,
) -> pa.Table:
    """Solves the points of a study and returns one row a point.

    Finished points are stored in `folder`; a study with the same FMU, parameters and grid goes on from there. `scheduler`
    is the address of a dask scheduler; without one, `workers` processes are started here (as many as there are
    processors). Called from a program, the latter needs `if __name__ == "__main__":` around it. `progress` is called
    after each chunk of `chunk` points, and about once a second in between.

    Raises ClusterError where the cluster can't be reached or is gone; what was finished stays.
    """
    store = Store(folder, study)
    kept = store.rows()
    missing = chunks(study, {row["point"] for row in kept}, chunk)
    lost = []
    if missing:
        with cluster.connect(scheduler, workers) as client:
            lost = _solve(client, study, store, missing, kept, progress)
    return with_metadata(study, table(study, [*store.rows(), *lost]))


def _solve(client: Client, study: Study, store: Store, missing: list[Chunk], kept: list, progress: Callable) -> list:
    """Solves what is missing; returns the points that lost their workers, which the next run tries again."""
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
