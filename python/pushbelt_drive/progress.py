"""Progress of work in other processes: they tick in simulated seconds, the bar's process listens."""

from __future__ import annotations

import queue
from collections.abc import Callable
from typing import Any

BAR = "  {desc} {bar:32} {percentage:3.0f} % [{elapsed}<{remaining}]"
"""How tqdm draws it: with the time that is left."""
BATCH = 0.5
"""Simulated seconds that a worker keeps to itself."""

_ticks: Any = None
_pending = 0.0


def prepare_worker(ticks: Any) -> None:
    """In a worker: where it reports, a queue."""
    global _ticks
    _ticks = ticks


def tick(seconds: float) -> None:
    """In a worker: reports simulated seconds, a few steps at once."""
    global _pending
    _pending += seconds
    if _pending >= BATCH:
        _ticks.put(_pending)
        _pending = 0.0


def drain(ticks: Any, heard: Callable[[float], object], timeout: float = 0.2) -> None:
    """Hands on what workers have reported; waits a while, s, for the first of it."""
    try:
        heard(ticks.get(timeout=timeout))
        while True:
            heard(ticks.get_nowait())
    except queue.Empty:
        return
