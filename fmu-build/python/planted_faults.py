"""Plants the faults of `tests/faults.txt` one by one in a copy of the checkout: a test must find each.

    target/venv/bin/python fmu-build/python/planted_faults.py [words of titles]

A block of the list: `# title`, a file, `-` lines of its text, `+` lines instead, `$ command`. The text must be there exactly once; the command must
pass without the fault and fail with it. The copy, what cargo compiles of it and the log stay in `target/faults`. Python tests need the FMUs in `target`.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
PLACE = ROOT / "target" / "faults"
COPY = PLACE / "checkout"
# Compiled anew for each fault: fast, and with the results of the release profile.
PROFILE = {"OPT_LEVEL": "1", "INCREMENTAL": "true", "CODEGEN_UNITS": "16", "STRIP": "none"}
ENVIRONMENT = {"CARGO_TARGET_DIR": str(PLACE / "target"), "PYTHONPATH": "", **{f"CARGO_PROFILE_RELEASE_{key}": value for key, value in PROFILE.items()}}


class Fault(NamedTuple):
    title: str
    file: str
    text: str
    instead: str
    command: str

    def planted(self) -> str:
        """The file with the fault. Raises ValueError if the text is not there exactly once."""
        whole = (ROOT / self.file).read_text(encoding="utf-8")
        if whole.count(self.text) != 1:
            raise ValueError(f"stale: `{self.text}` is {whole.count(self.text)} times in {self.file}")
        return whole.replace(self.text, self.instead)


def listed() -> list[Fault]:
    blocks = (ROOT / "tests" / "faults.txt").read_text(encoding="utf-8").strip().split("\n\n")
    parts = [(title[2:], file, lines, command[2:]) for title, file, *lines, command in map(str.splitlines, blocks)]
    return [Fault(title, file, *("\n".join(line[2:] for line in lines if line[0] == sign) for sign in "-+"), command) for title, file, lines, command in parts]


def write(name: str, content: bytes) -> None:
    """Writes a file of the copy if it differs: cargo compiles what is written."""
    path = COPY / name
    if not path.is_file() or path.read_bytes() != content:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


def passes(command: str) -> bool:
    """Runs a command in a session of its own, so that all its processes end with this one."""
    words = [sys.executable, "-m", *command.split(), "-p", "no:cacheprovider"] if command.startswith("pytest") else command.split()
    with (PLACE / "log.txt").open("ab") as log:
        log.write(f"\n$ {command}\n".encode())
        log.flush()
        started = subprocess.Popen(words, cwd=COPY, env={**os.environ, **ENVIRONMENT}, stdout=log, stderr=log, start_new_session=True)
        try:
            return started.wait() == 0
        except BaseException:
            os.killpg(started.pid, signal.SIGKILL)
            started.wait()
            raise


def problem(fault: Fault) -> str:
    """Why the fault is not found; empty if it is."""
    try:
        write(fault.file, fault.planted().encode())
        if fault.command.startswith("cargo") and not passes(f"{fault.command.split(' -- ')[0]} --no-run"):
            return "does not compile"
        return "NOT FOUND" if passes(fault.command) else ""
    except ValueError as error:
        return str(error)
    finally:
        write(fault.file, (ROOT / fault.file).read_bytes())


def main(words: list[str]) -> int:
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    # Neighbours with one command compile the same.
    faults = sorted((fault for fault in listed() if all(word in fault.title for word in words)), key=lambda fault: fault.command)
    COPY.mkdir(parents=True, exist_ok=True)
    if not (COPY / "target").exists():
        (COPY / "target").symlink_to(ROOT / "target")
    for name in subprocess.run(["git", "ls-files", "-zco", "--exclude-standard"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.split("\0"):
        if (ROOT / name).is_file():
            write(name, (ROOT / name).read_bytes())
    begin = time.monotonic()
    lost = [f"`{command}` fails without a fault" for command in dict.fromkeys(fault.command for fault in faults) if not passes(command)]
    print(f"{time.monotonic() - begin:5.0f} s  compiled, and each command without a fault", flush=True)
    for fault in faults:
        start, found = time.monotonic(), problem(fault)
        print(f"{time.monotonic() - start:5.0f} s  {fault.title}: {found or 'found'}", flush=True)
        lost += [f"{fault.title}: {found}"] if found else []
    print(f"{len(faults)} faults planted in {(time.monotonic() - begin) / 60.0:.0f} min, problems: {len(lost)}", *lost, sep="\n")
    return min(len(lost), 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
