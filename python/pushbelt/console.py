"""A program as a process: its errors, characters that its output can't encode, Ctrl-C and SIGTERM."""

import functools
import io
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

from . import provenance
from .errors import PushbeltError

INTERRUPTED, TERMINATED = 130, 143  # Exit codes after Ctrl-C and SIGTERM


class Terminated(KeyboardInterrupt):
    """SIGTERM, as `kill` and batch systems send it. Like Ctrl-C, it ends the workers of a program."""


class Done(NamedTuple):
    """The end of a program: its exit code, and what it returns to Python."""

    code: int
    result: Any


def run(main: Callable[[], int | Done | None]) -> int:
    """Runs a program and returns its exit code. Characters that the encoding of the output lacks become question marks."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")
    try:
        with _handled(signal.SIGTERM, _terminate):
            found = main()
            return found.code if isinstance(found, Done) else found or 0
    except Terminated:
        print("terminated", file=sys.stderr)
        return TERMINATED
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED


def _terminate(*_: object) -> None:
    raise Terminated("ended by the signal SIGTERM")


def program(name: str, extra: str) -> Callable[[Callable[[Sequence[str] | None], int | Done]], Callable[..., int]]:
    """The main function of a program, with the words of its command line, which its reports name. Its errors are one line
    each; packages that are missing are those of an extra."""

    def made(main: Callable[[Sequence[str] | None], int | Done]) -> Callable[..., int]:
        @functools.wraps(main)
        def started(arguments: Sequence[str] | None = None) -> int:
            try:
                provenance.begin(name, arguments)
                return run(lambda: main(arguments))
            except (OSError, PushbeltError) as error:
                said = f"{name}: {error}"
            except ModuleNotFoundError as error:
                if not error.name or error.name.startswith("pushbelt"):
                    raise
                said = f"{name} needs the package {error.name}: pip install 'pushbelt[{extra}]'"
            print(f"pushbelt {said}", file=sys.stderr)
            return 1

        return started

    return made


@contextmanager
def starting_processes() -> Iterator[None]:
    """Processes that are started in this context ignore Ctrl-C; so does this one, until they are. Without effect on Windows. SIGTERM acts at the end:
    a process that is started in part ends with a traceback, and nothing ends one that is not known yet."""
    late: list[int] = []
    try:
        with _handled(signal.SIGTERM, lambda number, _: late.append(number)), _handled(signal.SIGINT, signal.SIG_IGN):
            yield
    finally:
        for number in late[:1]:
            signal.raise_signal(number)


@contextmanager
def _handled(number: int, handler: Any) -> Iterator[None]:
    """A handler of a signal, which only the main thread can set."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(number, handler)
    try:
        yield
    finally:
        signal.signal(number, before)
