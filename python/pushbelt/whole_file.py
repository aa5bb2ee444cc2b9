"""Files, and copies of archives, that are written completely or not at all."""

import io
import os
import threading
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path


def write_whole(path: Path, contents: bytes) -> None:
    """Writes a file completely or not at all, even if the process ends at any time. After an error, such as a full disk, nothing remains."""
    passing = path.with_name(f"{path.name}.{os.getpid()}-{threading.get_ident()}.partial")
    try:
        with passing.open("wb") as file:
            file.write(contents)
            file.flush()
            os.fsync(file.fileno())
        passing.replace(path)
    finally:
        passing.unlink(missing_ok=True)


def copy_archive(
    archive: Path, copy: Path, changed: Mapping[str, Callable[[bytes], bytes]], added: Mapping[str, bytes | None]
) -> None:
    """Writes a copy of an archive with changed files, and with others added or replaced; None removes one. `copy` may be the archive."""
    whole = io.BytesIO()
    with zipfile.ZipFile(archive) as source, zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as target:
        for entry in source.infolist():
            if entry.filename not in added:
                content = source.read(entry)
                target.writestr(entry, changed[entry.filename](content) if entry.filename in changed else content)
        for name, new in added.items():
            if new is not None:
                target.writestr(name, new)
    write_whole(copy, whole.getvalue())
