"""What a report was made from: the command with its options, hashes of the FMU and the inputs, and the date."""

import hashlib
import os
import re
import shlex
import sys
from collections.abc import Sequence
from datetime import datetime, timezone
from pathlib import Path
from typing import NamedTuple

COMMAND = "PUSHBELT_COMMAND"  # Environment variable with the command that started the program, if another tool did


class Provenance(NamedTuple):
    """Origin of a report."""

    program: str
    command: str
    inputs: dict[str, str]  # Names of the files that were read, by their SHA-256
    date: str  # UTC, to the minute


_current: Provenance | None = None


def begin(program: str, arguments: Sequence[str] | None, module: str | None = None) -> Provenance:
    """Records the start of a program; `arguments` is that of its `main`. Files among the arguments, and runs in
    folders among them, are the inputs. `module` is its module if the command `pushbelt` does not start it."""
    global _current
    words = list(sys.argv[1:] if arguments is None else arguments)
    started = os.environ.get(COMMAND) if arguments is None else None
    start = ["python", "-m", module or f"pushbelt.{program}"] if arguments is None or module else ["pushbelt", program]
    date = datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
    _current = Provenance(program, started or shlex.join([*start, *words]), _inputs(words), date)
    return _current


def current(program: str) -> Provenance | None:
    """Origin of the reports of a program; None if this process has not started it by its command line."""
    return _current if _current is not None and _current.program == program else None


def _inputs(words: Sequence[str]) -> dict[str, str]:
    """Names by hash of files among the words and runs in folders among them, once each. The folder of the results is none."""
    found: dict[str, str] = {}
    output = re.search(r"(?:^|\0)--output[=\0]([^\0]+)", "\0".join(words))
    written = Path(output[1]).resolve() if output else None
    for word in filter(None, words):
        # `--fmu=FILE`, `name=FILE` and lists.
        files = [(Path(part).name, Path(part)) for part in (word, *re.split(r"[=,]", word)) if os.path.isfile(part)]
        if not word.startswith("-") and os.path.isdir(word) and Path(word).resolve() != written:
            files = [(f"{path.parent.name}/{path.name}", path) for path in sorted(Path(word).resolve().glob("*.csv"))]
        for name, path in files:
            found.setdefault(hashlib.sha256(path.read_bytes()).hexdigest(), name)
    return found
