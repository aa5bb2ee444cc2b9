"""Progress bars, and simulations in parallel processes with a common one."""

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from typing import Any

from ..console import starting_processes

Call = tuple[Callable[..., Any], tuple[Any, ...]]  # A module-level function and its arguments
BATCH = 0.5  # Least progress per report of a worker
_ticks: Any = None  # In a worker: queue for reports of progress
_pending = 0.0  # In a worker: progress that is not yet reported


def progress_bar(total: float, description: str) -> Any:
    """A bar with the remaining time, on a terminal only."""
    # Only what shows a bar needs the package.
    from tqdm import tqdm

    layout = "  {desc} {bar:32} {percentage:3.0f} % [{elapsed}<{remaining}{postfix}]"
    return tqdm(total=total, disable=None, desc=description, bar_format=layout)


def _prepare_worker(ticks: Any) -> None:
    global _ticks
    _ticks = ticks
    # For Windows, where `starting_processes` has no effect.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def tick(amount: float) -> None:
    """Adds progress in a worker. Small amounts are reported together."""
    global _pending
    _pending += amount
    if _pending >= BATCH:
        _ticks.put(_pending)
        _pending = 0.0


def run_all(calls: Sequence[Call], total: float, title: str, workers: int = 4) -> list[Any]:
    """Results of the calls, in their order, in which they also start. The first failure is raised at once. `total` is the sum of all calls
    of `tick`. At most `workers` processes run at a time, and at most one per processor."""
    with progress_bar(total, title) as bar, worker_pool(max(1, min(os.cpu_count() or 1, workers))) as run:
        return run(calls, bar.update)


@contextmanager
def worker_pool(workers: int) -> Iterator[Callable[[Sequence[Call], Callable[[float], object]], list[Any]]]:
    """Pool of processes for several rounds of calls. Yields the function that runs a round. A failure or Ctrl-C here ends them at once."""
    context = multiprocessing.get_context("spawn")
    ticks, others = context.Queue(), set(multiprocessing.active_children())
    with ProcessPoolExecutor(workers, context, _prepare_worker, (ticks,)) as pool:

        def run(calls: Sequence[Call], update: Callable[[float], object]) -> list[Any]:
            try:
                with starting_processes():
                    futures = [pool.submit(function, *arguments) for function, arguments in calls]
                _follow(futures, ticks, update)
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                for process in set(multiprocessing.active_children()) - others:
                    process.terminate()
                raise
            return [future.result() for future in futures]

        yield run


def _follow(futures: list[Future[Any]], ticks: Any, update: Callable[[float], object]) -> None:
    """Waits for all calls and forwards their progress. The first failure is raised at once."""
    waiting = set(futures)
    while waiting:
        finished, waiting = wait(waiting, timeout=0.1, return_when=FIRST_COMPLETED)
        for future in finished:
            future.result()
        while not ticks.empty():
            update(ticks.get())
