"""What a report was made from: the command with its options, hashes of the FMU and the inputs, and the date."""

from __future__ import annotations

import hashlib
import os
import re
import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path

COMMAND = "PUSHBELT_COMMAND"
"""Environment variable with the command that started the program, if another tool did."""
DIGITS = 16
"""Hexadecimal digits of a hash that are shown."""


@dataclass(frozen=True)
class Input:
    """A file that was read."""

    name: str
    sha256: str

    @property
    def short(self) -> str:
        """Start of the hash."""
        return self.sha256[:DIGITS]


@dataclass(frozen=True)
class Provenance:
    """Origin of a report."""

    program: str
    command: str
    inputs: tuple[Input, ...]
    date: str
    """UTC, to the minute."""


_current: Provenance | None = None


def begin(program: str, arguments: Sequence[str] | None, module: str | None = None) -> Provenance:
    """Records the start of a program; `arguments` is that of its `main`. Files among the arguments are the inputs.

    `module` is its module inside this package if the command `pushbelt` does not start it.
    """
    global _current
    words = list(sys.argv[1:] if arguments is None else arguments)
    started = os.environ.get(COMMAND) if arguments is None else None
    as_module = ["python", "-m", f"pushbelt.{module or program}"]
    as_command = ["pushbelt", program]
    command = started or shlex.join([*(as_module if arguments is None or module else as_command), *words])
    date = datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
    _current = Provenance(program, command, tuple(_inputs(words)), date)
    return _current


def current(program: str) -> Provenance | None:
    """Origin of the reports of a program; None if this process has not started it by its command line."""
    return _current if _current is not None and _current.program == program else None


def _inputs(words: Sequence[str]) -> list[Input]:
    found = {}
    for word in words:
        # `--fmu=FILE`, `name=FILE` and lists.
        for part in (word, *re.split(r"[=,]", word)):
            path = Path(part)
            if part and part not in found and _is_file(path):
                found[part] = Input(path.name, hashlib.sha256(path.read_bytes()).hexdigest())
    return list({one.sha256: one for one in found.values()}.values())


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:
        return False
