"""Solves the lines of a plan on a cluster and stores each finished line."""

from __future__ import annotations

import math
import random
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from pushbelt import cluster
from pushbelt.map_data import Maps
from pushbelt.map_lines import Store, collect
from pushbelt.map_plan import Plan

from . import worker

WORKERS_INTERVAL = 1.0
"""Interval of polling the number of workers, s."""


@dataclass(frozen=True)
class Progress:
    """Progress of a plan."""

    lines: int
    done: int
    """Number of finished lines, including earlier runs."""
    failed: int
    workers: int


def solve(
    plan: Plan,
    folder: Path,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Callable[[Progress], object] = lambda _: None,
) -> tuple[Maps, float]:
    """Solves the lines of a plan. Returns the maps and the processor time of all lines, s.

    Finished lines are stored in `folder`; the same plan continues from them. `scheduler` is the address of a dask scheduler. By default
    `workers` local processes are started, one per processor. `progress` is called about once per second.

    Raises ClusterError if the cluster cannot be reached or is lost, and ValueError if no line has a steady state.
    """
    store = Store(folder, plan)
    rows = store.rows()
    missing = [(index, line) for index, line in enumerate(plan.lines) if index not in rows]
    # Neighbours take similar times, so the lines are shuffled.
    random.Random(0).shuffle(missing)
    if missing:
        with cluster.connect(scheduler, workers) as client:
            last = -math.inf
            count = 0

            def report() -> None:
                nonlocal last, count
                if time.monotonic() > last + WORKERS_INTERVAL:
                    count, last = len(client.nthreads()), time.monotonic()
                failed = sum("reason" in row for row in rows.values())
                progress(Progress(len(plan.lines), len(rows), failed, count))

            load = partial(worker.Solver, parameters=plan.full, along=plan.along)
            chunks = [[task] for task in missing]
            with cluster.shipped(client, plan.archive, load, worker) as solver:
                for (row,) in cluster.rows(client, solver, chunks, report, _lost):
                    rows[row["line"]] = row
                    if row.get("reason") != cluster.WORKER_LOST:
                        store.add(row)
                    report()
    return collect(plan, rows), sum(row.get("time") or 0.0 for row in rows.values())


def _lost(task: Any) -> dict[str, Any]:
    return {"line": task[0], "reason": cluster.WORKER_LOST, "time": None}
