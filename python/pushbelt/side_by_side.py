"""Simulations side by side in processes of their own, with one progress bar for all."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from typing import Any

from .progress import progress_bar

Call = tuple[Callable[..., Any], tuple[Any, ...]]
"""A function of a module and its arguments."""

BATCH = 0.5
"""Least progress that a worker reports at once."""

_ticks: Any = None
"""In a worker: where it reports progress."""
_pending = 0.0
"""In a worker: what it has not reported yet."""


def _prepare_worker(ticks: Any) -> None:
    global _ticks
    _ticks = ticks


def tick(amount: float) -> None:
    """Called in a worker: so much is done. Reported a few at once."""
    global _pending
    _pending += amount
    if _pending >= BATCH:
        _ticks.put(_pending)
        _pending = 0.0


def run_all(calls: Sequence[Call], total: float, title: str, workers: int = 4) -> list[Any]:
    """Results of the calls, in their order; they start in this order too. The first failure is raised at once.

    `total` is what all calls of `tick` add up to; at most `workers` processes and one a processor work at a time.
    """
    with progress_bar(total, title) as bar:
        return run_in_workers(calls, bar.update, max(1, min(os.cpu_count() or 1, workers)))


def run_in_workers(calls: Sequence[Call], update: Callable[[float], object], workers: int) -> list[Any]:
    """Results of the calls, in their order; `update` gets what they `tick`. The first failure is raised at once."""
    with worker_pool(workers) as run:
        return run(calls, update)


@contextmanager
def worker_pool(workers: int) -> Iterator[Callable[[Sequence[Call], Callable[[float], object]], list[Any]]]:
    """Processes that stay for one round of calls after the other; gives the function that runs a round."""
    context = multiprocessing.get_context("spawn")
    ticks = context.Queue()
    with ProcessPoolExecutor(workers, context, _prepare_worker, (ticks,)) as pool:

        def run(calls: Sequence[Call], update: Callable[[float], object]) -> list[Any]:
            futures = [pool.submit(function, *arguments) for function, arguments in calls]
            try:
                _follow(futures, ticks, update)
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise
            return [future.result() for future in futures]

        yield run


def _follow(futures: list[Future[Any]], ticks: Any, update: Callable[[float], object]) -> None:
    """Waits for all, passing progress on; the first failure is raised at once."""
    waiting = set(futures)
    while waiting:
        finished, waiting = wait(waiting, timeout=0.1, return_when=FIRST_COMPLETED)
        while not ticks.empty():
            update(ticks.get())
        for future in finished:
            future.result()
    while not ticks.empty():
        update(ticks.get())
