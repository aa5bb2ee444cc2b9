"""Solves the tasks of a study: missing ones are sent to the cluster in chunks, and each finished chunk is stored in a file of its own."""

import argparse
import gzip
import json
import os
import random
import time
import zlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from pushbelt.fmu.unit import Archive
from pushbelt.report import side_by_side
from pushbelt.report.side_by_side import progress_bar
from pushbelt.whole_file import write_whole

from . import tasks as study
from .tasks import Row, Solver, Tasks

MOST_CHUNKS = 5000  # Largest number of chunks. Larger studies have larger chunks, because each chunk is a file.


class Store:
    """Finished tasks, in a folder of the study's identity. Each chunk is a file."""

    def __init__(self, folder: Path, tasks: Tasks) -> None:
        self.folder = folder / "studies" / tasks.identity[:16]
        self.folder.mkdir(parents=True, exist_ok=True)
        text = json.dumps({"study": tasks.identity, **tasks.document()}, indent=1)
        write_whole(self.folder / "study.json", text.encode())

    def add(self, rows: Mapping[int, Row]) -> None:
        name = f"tasks-{min(rows)}-{max(rows)}.json.gz"
        write_whole(self.folder / name, gzip.compress(json.dumps(list(rows.items())).encode(), 1))

    def rows(self) -> dict[int, Row]:
        """All stored tasks by their numbers. A damaged file is removed, and its tasks are solved again. Raises OSError
        if a file cannot be read; the file is then not removed."""
        found: dict[int, Row] = {}
        for path in sorted(self.folder.glob("tasks-*.json.gz")):
            content = path.read_bytes()
            try:
                found |= {int(number): dict(row) for number, row in json.loads(gzip.decompress(content))}
            except (ValueError, TypeError, EOFError, zlib.error, gzip.BadGzipFile):
                path.unlink()
        return found


class Effort(NamedTuple):
    tasks: int  # Number of tasks solved in this run
    seconds: float  # Wall-clock time including the start of the cluster, s
    processor_time: float  # Processor time of all tasks, also of earlier runs, s

    def __str__(self) -> str:
        each = f", {self.tasks / self.seconds:.2f} a second" if self.tasks else ""
        return f"{self.seconds:.0f} s{each}, processor time {self.processor_time:.1f} s on {os.cpu_count()} processors"


def chunks(tasks: Tasks, finished: set[int], size: int) -> list[list[tuple[int, Any]]]:
    """Missing tasks with their numbers, in chunks of at least `size`. They are shuffled, because neighbours take similar times."""
    missing = [(number, task) for number, task in enumerate(tasks.tasks()) if number not in finished]
    random.Random(0).shuffle(missing)
    size = max(size, -(-len(missing) // MOST_CHUNKS))
    return [missing[start : start + size] for start in range(0, len(missing), size)]


def solve(
    tasks: Tasks, folder: Path, *, scheduler: Any = None, workers: int | None = None, chunk: int = 1, anew: bool = False,
    progress: Callable[[int, int, int], object] = lambda *_: None,
) -> dict[int, Row]:  # fmt: skip
    """Rows of all tasks by their numbers. Finished ones are stored in `folder`; the same tasks continue from them, unless `anew`.
    `scheduler` is the address of a dask scheduler, or a cluster of dask. By default `workers` local processes are started, one per
    processor; a program that starts them needs the guard `if __name__ == "__main__":`. `progress` is called at the beginning and after
    each chunk, with the numbers of finished tasks, including earlier runs, of those among them without a result, and of workers. Tasks
    that lost their workers are not stored; the next run tries them again. Raises ClusterError if the cluster is not reached or lost."""
    store = Store(folder, tasks)
    for path in store.folder.glob("tasks-*") if anew else ():
        path.unlink()
    rows = store.rows()
    failed = sum(row.get("reason") is not None for row in rows.values())
    progress(len(rows), failed, 0)
    missing = chunks(tasks, set(rows), chunk)
    if not missing:
        return rows
    # Only studies on a cluster need the packages of dask.
    from . import cluster

    load = partial(Solver, parameters=tasks.common, measure=tasks.measure)
    with cluster.connect(scheduler, workers) as client, cluster.shipped(client, tasks.archive, load, study, *tasks.procedure) as solver:
        for found in map(dict, cluster.rows(client, solver, missing)):
            rows |= found
            failed += sum(row.get("reason") is not None for row in found.values())
            if not any(row.get("reason") == cluster.WORKER_LOST for row in found.values()):
                store.add(found)
            progress(len(rows), failed, len(client.nthreads()))
    return rows


def solve_in_processes(tasks: Tasks, folder: Path, title: str) -> dict[int, Row]:
    """The same in processes of this machine, with a progress bar and without dask."""
    store = Store(folder, tasks)
    if missing := chunks(tasks, set(store.rows()), 1):
        with Archive.unpack(tasks.fmu) as archive:
            calls = [(_solve_chunk, (store, chunk, archive, tasks.common, tasks.measure)) for chunk in missing]
            side_by_side.run_all(calls, len(calls), title, os.cpu_count() or 1)
    return store.rows()


def _solve_chunk(store: Store, chunk: Sequence[tuple[int, Any]], *solver: Any) -> None:
    with closing(Solver(*solver)) as opened:
        store.add(dict(opened.solve(chunk)))
    side_by_side.tick(len(chunk))


def from_command_line(
    tasks: Tasks, options: argparse.Namespace, what: str, chunk: int = 1, scheduler: Any = None
) -> tuple[dict[int, Row], Effort]:
    """`solve` with a progress bar and the options of `cli.options.add_study`. After Ctrl-C it prints how many tasks are finished."""
    begin, counts, total = time.perf_counter(), list[int](), len(tasks.tasks())
    with progress_bar(total, what) as bar:

        def shown(done: int, failed: int, workers: int) -> None:
            if not counts:
                bar.initial = bar.n = done
                if done:
                    print(f"  {done} of {total} {what} are already stored")
            counts.append(done)
            bar.set_postfix_str(f"{failed} failed, {workers} workers", refresh=False)
            bar.update(done - bar.n)

        given = {"workers": options.workers, "chunk": chunk, "anew": options.anew or options.measure}
        try:
            rows = solve(tasks, options.output, scheduler=scheduler or options.scheduler, progress=shown, **given)
        except KeyboardInterrupt:
            if counts:
                print(f"\n{counts[-1]} of {total} {what} are finished; the same command continues from them.")
            raise
    used = sum(row.get("time") or 0.0 for row in rows.values())
    return rows, Effort(len(rows) - counts[0], time.perf_counter() - begin, used)
