"""Files that are written completely or not at all."""

from __future__ import annotations

import os
from pathlib import Path


def write_whole(path: Path, contents: bytes) -> None:
    """Writes a file completely or not at all, even if the process ends at any time. After an error, such as a full disk, nothing remains."""
    passing = path.with_name(f"{path.name}.{os.getpid()}.partial")
    try:
        with passing.open("wb") as file:
            file.write(contents)
            file.flush()
            os.fsync(file.fileno())
        passing.replace(path)
    finally:
        passing.unlink(missing_ok=True)
