"""Points to workers and rows back, through dask: a cluster on this machine, or one that is there already."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from types import ModuleType
from typing import Any

import cloudpickle
from distributed import CancelledError, Client, Future, KilledWorker, LocalCluster, as_completed, get_worker

import pushbelt.fmu

from . import point, worker
from .point import Row, failure
from .worker import Chunk, UnitPlugin

POLL = 0.1
"""How often finished chunks are asked for, s."""
CONNECT_TIMEOUT = 10.0
"""How long a scheduler may take to answer, s."""
WORKERS_TIMEOUT = 60.0
"""How long a cluster may take to have its first worker, s."""


class ClusterError(RuntimeError):
    """The cluster can't be reached or is gone."""


@contextmanager
def connect(scheduler: str | None, workers: int | None) -> Iterator[Client]:
    """A client of the scheduler at an address such as `tcp://host:port`, or of a cluster of processes made here.

    Raises ClusterError if there is no worker after a while.
    """
    with ExitStack() as stack:
        try:
            if scheduler is None:
                with interrupts_ignored():
                    local = LocalCluster(
                        n_workers=workers,
                        threads_per_worker=1,
                        memory_limit=0,
                        dashboard_address=":0",
                        silence_logs="ERROR",
                    )
                scheduler = stack.enter_context(local)
            client = stack.enter_context(Client(scheduler, timeout=CONNECT_TIMEOUT))
            client.wait_for_workers(1, timeout=WORKERS_TIMEOUT)
        except (OSError, TimeoutError) as error:
            raise ClusterError(f"{scheduler}: {error or 'no worker'}") from error
        yield client


@contextmanager
def interrupts_ignored() -> Iterator[None]:
    """Processes started meanwhile leave Ctrl-C to this one."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def shipped(client: Client, fmu: bytes) -> Iterator[Callable[[Chunk], list[Row]]]:
    """Brings the FMU and the code to the workers; gives the function that solves chunks there.

    Raises ClusterError where a worker can't load them.
    """
    name = f"pushbelt-{client.id}"
    try:
        with by_value(pushbelt.fmu, worker, point):
            client.register_plugin(UnitPlugin(name, fmu))
    except Exception as error:  # Of any kind: it comes from a worker.
        raise ClusterError(f"a worker can't load the FMU: {error}") from error
    try:
        yield solver(name)
    finally:
        if client.status == "running":
            client.unregister_worker_plugin(name)


def solver(name: str) -> Callable[[Chunk], list[Row]]:
    """The function that solves a chunk on a worker.

    It is local so that it is pickled by value: neither scheduler nor workers have this project's modules.
    """

    def solve(chunk: Chunk) -> list[Row]:
        return get_worker().plugins[name].solver.solve(chunk)

    return solve


@contextmanager
def by_value(*modules: ModuleType) -> Iterator[None]:
    """What belongs to these modules or their submodules is pickled with its code."""
    for module in modules:
        cloudpickle.register_pickle_by_value(module)
    try:
        yield
    finally:
        for module in modules:
            cloudpickle.unregister_pickle_by_value(module)


def rows(
    client: Client, solve: Callable[[Chunk], list[Row]], chunks: Iterable[Chunk], waiting: Callable[[], object]
) -> Iterator[list[Row]]:
    """Rows of the chunks as they finish; `waiting` is called now and then.

    Chunks of a worker that is lost go to another. A chunk that loses one worker after the other is taken apart: its
    points come last, each with no other on its way, so that the one that kills is distinguished from its neighbours.
    """
    given = {client.submit(solve, chunk, pure=False): chunk for chunk in chunks}
    suspects: list[Any] = []
    for future in _finished(as_completed(given), waiting):
        chunk, result = given.pop(future), _result(future)
        if result is None:
            suspects.extend(chunk)
        else:
            yield result
    for suspect in suspects:
        future = client.submit(solve, [suspect], pure=False)
        for _ in _finished(as_completed([future]), waiting):
            result = _result(future)
            yield [failure(suspect[0], WORKER_LOST)] if result is None else result


WORKER_LOST = "the worker process died, several times over"


def _finished(futures: as_completed, waiting: Callable[[], object]) -> Iterator[Future]:
    """Futures as they finish or fail for good."""
    while not futures.is_empty():
        if not futures.has_ready():
            waiting()
            time.sleep(POLL)
            continue
        for future in futures.next_batch(block=False):
            # A result that was not fetched is lost with its worker: it is solved for again.
            if future.status in ("pending", "lost"):
                futures.add(future)
            else:
                yield future


def _result(future: Future) -> list[Row] | None:
    """Rows of a chunk; none if it lost too many workers."""
    try:
        return future.result()
    except KilledWorker:
        return None
    except CancelledError as error:
        raise ClusterError("the connection to the scheduler is lost") from error
    finally:
        future.release()
