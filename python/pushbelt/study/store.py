"""Finished tasks of a study, which may be interrupted at any time: files that are written completely or not at all."""

from __future__ import annotations

import gzip
import json
import zlib
from collections.abc import Mapping
from pathlib import Path

from pushbelt.whole_file import write_whole

from .tasks import Row, Tasks


class Store:
    """Finished tasks, in a folder of the study's identity. Each chunk is a file."""

    def __init__(self, folder: Path, tasks: Tasks) -> None:
        self.folder = folder / "studies" / tasks.identity[:16]
        self.folder.mkdir(parents=True, exist_ok=True)
        text = json.dumps({"study": tasks.identity, **tasks.document()}, indent=1)
        write_whole(self.folder / "study.json", text.encode())

    def add(self, rows: Mapping[int, Row]) -> None:
        name = f"tasks-{min(rows)}-{max(rows)}.json.gz"
        write_whole(self.folder / name, gzip.compress(json.dumps(list(rows.items())).encode(), 1))

    def clear(self) -> None:
        for path in self.folder.glob("tasks-*"):
            path.unlink()

    def rows(self) -> dict[int, Row]:
        """All stored tasks by their numbers. A damaged file is removed, and its tasks are solved again. Raises OSError
        if a file cannot be read; the file is then not removed."""
        found: dict[int, Row] = {}
        for path in sorted(self.folder.glob("tasks-*.json.gz")):
            content = path.read_bytes()
            try:
                found |= {int(number): dict(row) for number, row in json.loads(gzip.decompress(content))}
            except (ValueError, TypeError, EOFError, zlib.error, gzip.BadGzipFile):
                path.unlink()
        return found
