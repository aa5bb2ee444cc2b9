"""FMUs that stay unpacked, in this user's cache folder: an instance of one starts without unpacking it again."""

from __future__ import annotations

import hashlib
import shutil
import tempfile
from pathlib import Path

import fmpy
import platformdirs

from . import untrusted
from .unit import Archive


def folder() -> Path:
    """The cache's folder; it need not be there."""
    return Path(platformdirs.user_cache_dir("pushbelt", appauthor=False))


def clear() -> None:
    """Removes the cache."""
    if folder().exists():
        shutil.rmtree(folder())


def unpacked(fmu: Path) -> Archive:
    """An FMU unpacked into the cache, unless it is there already. It stays there: don't remove the archive.

    Raises OSError if the FMU can't be read or the cache can't be written, ValueError if it is no FMU or none for this
    machine.
    """
    place = folder() / hashlib.sha256(fmu.read_bytes()).hexdigest()[:16]
    if not place.is_dir():
        _unpack(fmu, place)
    archive = Archive(place, fmpy.read_model_description(str(place)))
    binaries = sorted(path.name for path in (place / "binaries").glob("*"))
    if fmpy.platform not in binaries:
        raise ValueError(
            f"{fmu} has no binary for {fmpy.platform}, as this machine needs, but for {', '.join(binaries)}"
        )
    return archive


def _unpack(fmu: Path, place: Path) -> None:
    place.parent.mkdir(parents=True, exist_ok=True)
    draft = Path(tempfile.mkdtemp(dir=place.parent, prefix="unpacking-"))
    try:
        untrusted.unpacked(fmu, draft)
        # Renamed when it is whole: another process never sees a part of it.
        draft.rename(place)
    except OSError:
        # Another process was first.
        if not place.is_dir():
            raise
    finally:
        shutil.rmtree(draft, ignore_errors=True)
