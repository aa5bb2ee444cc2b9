"""A program as a process: characters that its output can't encode, and Ctrl-C."""

from __future__ import annotations

import io
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker

INTERRUPTED = 130
"""Exit code after Ctrl-C."""


def run(main: Callable[[], int | None]) -> int:
    """Runs a program and returns its exit code. Characters that the encoding of the output lacks become question marks."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")
    try:
        return main() or 0
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED


@contextmanager
def interrupts_ignored() -> Iterator[None]:
    """Processes that are started in this context ignore Ctrl-C. This process handles it afterwards. Without effect on Windows."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # The start of the tracker removes the mask that it finds.
    resource_tracker.ensure_running()
    # A process inherits the mask of the thread that starts it. The signal may still reach another thread of this process.
    held: list[int] = []
    main = threading.current_thread() is threading.main_thread()
    handler = signal.signal(signal.SIGINT, lambda number, _: held.append(number)) if main else None
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        if main:
            signal.signal(signal.SIGINT, handler)
        if held:
            signal.raise_signal(signal.SIGINT)
