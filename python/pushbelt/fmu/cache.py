"""Cache of unpacked FMUs in the user's cache folder, so that an instance starts without unpacking."""

from __future__ import annotations

import hashlib
import shutil
import tempfile
from pathlib import Path

import fmpy
import platformdirs

from . import platforms, untrusted
from .unit import Archive


def folder() -> Path:
    """The folder of the cache. It may not exist."""
    return Path(platformdirs.user_cache_dir("pushbelt", appauthor=False))


def clear() -> None:
    """Removes the cache."""
    if folder().exists():
        shutil.rmtree(folder())


def unpacked(fmu: Path) -> Archive:
    """An FMU that is unpacked in the cache; it is unpacked if necessary. Do not remove the archive: it remains in the cache.

    Raises OSError if the FMU cannot be read or the cache cannot be written, ValueError if the file is not an FMU or has no
    binary for this machine.
    """
    place = folder() / hashlib.sha256(fmu.read_bytes()).hexdigest()[:16]
    if not place.is_dir():
        _unpack(fmu, place)
    archive = Archive(place, fmpy.read_model_description(str(place)))
    if platforms.folder(place / "binaries") is None:
        others = ", ".join(sorted(path.name for path in (place / "binaries").glob("*")))
        raise ValueError(f"{fmu} has no binary for {fmpy.platform_tuple}, only for {others or 'no machine'}")
    return archive


def _unpack(fmu: Path, place: Path) -> None:
    place.parent.mkdir(parents=True, exist_ok=True)
    draft = Path(tempfile.mkdtemp(dir=place.parent, prefix="unpacking-"))
    try:
        untrusted.unpacked(fmu, draft)
        # The folder is renamed when it is complete, so that other processes never read a part of it.
        draft.rename(place)
    except OSError:
        # Another process has unpacked it first.
        if not place.is_dir():
            raise
    finally:
        shutil.rmtree(draft, ignore_errors=True)
