"""The points of a study on a cluster: `pushbelt.cluster` with the worker of a study."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager

from distributed import Client

from pushbelt import cluster
from pushbelt.cluster import WORKER_LOST, ClusterError, by_value, connect
from pushbelt.console import interrupts_ignored

from . import point, worker
from .point import Row, failure
from .worker import Chunk

__all__ = ["WORKER_LOST", "ClusterError", "by_value", "connect", "interrupts_ignored", "rows", "shipped"]


def shipped(client: Client, fmu: bytes) -> AbstractContextManager[Callable[[Chunk], list[Row]]]:
    """Sends the FMU and the code to the workers; returns the function that solves chunks there."""
    return cluster.shipped(client, fmu, worker.Solver, worker, point)


def rows(
    client: Client, solve: Callable[[Chunk], list[Row]], chunks: Iterable[Chunk], waiting: Callable[[], object]
) -> Iterator[list[Row]]:
    """Rows of the chunks in the order of completion. `waiting` is called periodically."""
    return cluster.rows(client, solve, chunks, waiting, lambda task: failure(task[0], WORKER_LOST))
