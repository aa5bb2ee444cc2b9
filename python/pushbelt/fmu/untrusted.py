"""Files that come from others: archives and JSON are looked at before they are used, and what is wrong is one clear error."""

from __future__ import annotations

import json
import stat
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import fmpy

LARGEST_FILE = 500_000_000
"""What an archive may hold once it is unpacked, bytes: a hundred times this project's FMU."""
MOST_FILES = 10_000
LARGEST_JSON = 50_000_000
"""Bytes. A parameter set has 7 kB."""


class InputFileError(ValueError):
    """A file that can't be used; the text names it and says why."""


def checked_archive(path: Path) -> None:
    """Looks through an FMU, an SSP package or another ZIP file before it is unpacked.

    Raises InputFileError for what is no ZIP file, for a path that leads out of the folder, a link, a path that is there twice,
    and for more than LARGEST_FILE bytes or MOST_FILES files. Raises OSError if the file can't be read.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
    except (zipfile.BadZipFile, ValueError, NotImplementedError) as error:
        raise InputFileError(f"{path} is no FMU or other archive that can be read: {error}") from error
    if len(entries) > MOST_FILES:
        raise InputFileError(f"{path} holds {len(entries)} files: more than {MOST_FILES} are not unpacked")
    seen = set()
    for entry in entries:
        if why := _objection(entry):
            raise InputFileError(f"{path} is not unpacked: {entry.filename!r} {why}")
        if entry.filename in seen:
            raise InputFileError(f"{path} is not unpacked: {entry.filename!r} is there twice")
        seen.add(entry.filename)
    size = sum(entry.file_size for entry in entries)
    if size > LARGEST_FILE:
        raise InputFileError(f"{path} would unpack to {size / 1e6:.0f} MB: more than {LARGEST_FILE / 1e6:.0f} MB are not unpacked")


def _objection(entry: zipfile.ZipInfo) -> str | None:
    """Why a file of an archive is not unpacked. zipfile has cut the name at a zero, and made backslashes of Windows slashes."""
    name = entry.orig_filename
    parts = name.removesuffix("/").split("/")
    if "\\" in name or "\0" in name or ":" in name:
        return "has a character that a path must not have"
    if any(part in ("", ".", "..") for part in parts):
        return "leads out of the folder or is no plain path"
    if stat.S_ISLNK(entry.external_attr >> 16):
        return "is a link"
    if entry.flag_bits & 0x1:
        return "is encrypted"
    return None


def unpacked(path: Path, directory: Path | None = None) -> tuple[Path, Any]:
    """An FMU, unpacked to a directory or to a temporary one, and its model description.

    Raises InputFileError if it is no FMU that can be used, OSError if it can't be read.
    """
    description = described(path)
    with _named(path):
        return Path(fmpy.extract(str(path), directory)), description


def described(path: Path) -> Any:
    """The model description of an FMU, read from the archive. Raises what `unpacked` raises."""
    checked_archive(path)
    with _named(path):
        return fmpy.read_model_description(str(path))


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Names the file in every error, of whatever kind: fmpy, lxml and zipfile have no common one."""
    try:
        yield
    except OSError:
        raise
    except Exception as error:
        raise InputFileError(f"{path} is no FMU that can be used: {_first_line(error)}") from error


def read_json(path: Path) -> Any:
    """The content of a JSON file.

    Raises InputFileError if it is none, or larger than LARGEST_JSON; OSError if it can't be read.
    """
    size = path.stat().st_size
    if size > LARGEST_JSON:
        raise InputFileError(f"{path} has {size / 1e6:.0f} MB: more than {LARGEST_JSON / 1e6:.0f} MB are not read")
    try:
        return json.loads(path.read_bytes(), parse_constant=_no_constant)
    except RecursionError:
        raise InputFileError(f"{path} is no JSON that can be read: it is nested too deeply") from None
    except ValueError as error:
        raise InputFileError(f"{path} is no JSON that can be read: {_first_line(error)}") from error


def _no_constant(name: str) -> float:
    raise ValueError(f"{name} is no number")


def read_parameters(path: Path) -> dict[str, Any]:
    """The values of a parameter set: `{"parameters": {name: {"value": …}}}`, numbers, truth values or text.

    Raises InputFileError for another form, and what `read_json` raises.
    """
    document = read_json(path)
    parameters = document.get("parameters") if isinstance(document, dict) else None
    if not isinstance(parameters, dict):
        raise InputFileError(f'{path} is no parameter set: it has no object "parameters" in an object')
    values = {}
    for name, entry in parameters.items():
        value = entry.get("value") if isinstance(entry, dict) else None
        if not isinstance(value, (bool, int, float, str)):
            raise InputFileError(f'{path}: {name} has no "value" that is a number, true, false or text')
        values[name] = value
    return values


def _first_line(error: Exception) -> str:
    lines = str(error).strip().splitlines()
    return lines[0][:300] if lines else type(error).__name__
