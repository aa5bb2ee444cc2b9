"""Cache of unpacked FMUs in the user's cache folder, so that an instance starts without unpacking."""

import hashlib
import os
import tempfile
import zipfile
from functools import lru_cache
from pathlib import Path

import fmpy
import platformdirs

from ..errors import warn
from ..whole_file import write_whole
from .unit import Archive, binaries_of, refuse_others
from .untrusted import InputFileError, described, named

VARIABLE = "PUSHBELT_CACHE"  # Environment variable with the folder of the cache


def folder() -> Path:
    """The folder of the cache: that of the environment variable `PUSHBELT_CACHE`, or the user's. It may not exist."""
    return Path(os.environ.get(VARIABLE) or platformdirs.user_cache_dir("pushbelt", appauthor=False))


def unpacked(fmu: Path) -> Archive:
    """An FMU that is unpacked in the cache; files that are missing or have another size are unpacked again. Do not
    remove the archive: it remains in the cache. If the cache cannot be written, a VariatorWarning is issued, and the
    archive is in a temporary folder of this process. Raises OSError if the FMU cannot be read, InputFileError if the
    file is not an FMU of FMI 2.0 with a binary for this machine."""
    name = hashlib.sha256(fmu.read_bytes()).hexdigest()[:16]
    description = described(fmu)
    refuse_others(fmu, description)
    place = folder() / name
    try:
        _complete(fmu, place)
    except OSError as error:
        place = Path(_temporary().name, name)
        warn(f"the FMU is unpacked in {place}, because the cache cannot be written: {error}. {VARIABLE} names another folder")
        _complete(fmu, place)
    if binaries_of(place) is None:
        others = ", ".join(sorted(path.name for path in (place / "binaries").glob("*")))
        raise InputFileError(f"{fmu} has no binary for {fmpy.platform_tuple}, only for {others or 'no machine'}")
    return Archive(place, description)


@lru_cache(maxsize=1)
def _temporary() -> tempfile.TemporaryDirectory[str]:
    """A folder that only this user can write, and that is removed at the end of the process."""
    return tempfile.TemporaryDirectory(prefix="pushbelt-", ignore_cleanup_errors=True)


def _complete(fmu: Path, place: Path) -> None:
    """Unpacks the files that are not in a folder in their size. Each appears at once, so other processes never read a part of it."""
    with named(fmu), zipfile.ZipFile(fmu) as archive:
        for entry in archive.infolist():
            path = place / entry.filename
            if entry.is_dir() or (path.is_file() and path.stat().st_size == entry.file_size):
                continue
            path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(path, archive.read(entry))
