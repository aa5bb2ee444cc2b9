"""Files from untrusted sources: archives and JSON are checked before use, and each problem is reported as one error."""

import json
import math
import re
import stat
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import fmpy

from ..errors import PushbeltError

LARGEST_FILE = 500_000_000  # Largest unpacked size of an archive, bytes
MOST_FILES = 10_000
IDENTIFIER = re.compile("[A-Za-z_][A-Za-z0-9_]*")  # A name in C


class InputFileError(PushbeltError, ValueError):
    """A file cannot be used. The message contains its name and the reason."""


def checked_archive(path: Path) -> None:
    """Checks an FMU, an SSP package or another ZIP file before it is unpacked. Raises InputFileError if the file is not
    a ZIP file, contains a path outside the folder, a link or a duplicate path, or exceeds LARGEST_FILE bytes or
    MOST_FILES files. Raises OSError if the file cannot be read."""
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
    except (zipfile.BadZipFile, ValueError, NotImplementedError) as error:
        raise InputFileError(f"{path} is not a readable FMU or other archive: {error}") from error
    if len(entries) > MOST_FILES:
        raise InputFileError(f"{path} contains {len(entries)} files, above the limit of {MOST_FILES}")
    seen: set[str] = set()
    for entry in entries:
        if why := "appears twice" if entry.filename in seen else _objection(entry):
            raise InputFileError(f"{path} is not unpacked: {entry.filename!r} {why}")
        seen.add(entry.filename)
    size = sum(entry.file_size for entry in entries)
    if size > LARGEST_FILE:
        raise InputFileError(f"{path} would unpack to {size / 1e6:.0f} MB, above the limit of {LARGEST_FILE / 1e6:.0f} MB")


def _objection(entry: zipfile.ZipInfo) -> str | None:
    """Reason why a file of an archive is not unpacked. zipfile truncates names at a zero byte and normalises path separators."""
    name = entry.orig_filename
    objections = {
        "contains a character that is not allowed in a path": any(sign in name for sign in ("\\", "\0", ":")),
        "is outside the folder or is not a plain path": any(part in ("", ".", "..") for part in name.removesuffix("/").split("/")),
        "is a link": stat.S_ISLNK(entry.external_attr >> 16),
        "is encrypted": bool(entry.flag_bits & 0x1),
    }
    return next((why for why, true in objections.items() if true), None)


def described(path: Path) -> Any:
    """The model description of an FMU, read from the archive. Raises InputFileError if it is not a usable FMU, OSError if it cannot be read."""
    checked_archive(path)
    with named(path):
        description = fmpy.read_model_description(str(path))
    for kind in (description.coSimulation, description.modelExchange):
        # It is the name of the library, so it could lead out of the folder.
        if kind is not None and not IDENTIFIER.fullmatch(kind.modelIdentifier):
            raise InputFileError(f"{path} is not a usable FMU: its modelIdentifier {kind.modelIdentifier!r} is not a name in C")
    return description


@contextmanager
def named(path: Path, what: str = "a usable FMU") -> Iterator[None]:
    """Adds the file name, and what it should be, to every error, in a line: those of fmpy, lxml and zipfile have no common base class."""
    try:
        yield
    except OSError:
        raise
    except Exception as error:
        text = " ".join(str(error).split())[:300] or type(error).__name__
        raise InputFileError(f"{path} is not {what}: {text}") from error


def read_json(path: Path) -> Any:
    """The content of a JSON file. Raises InputFileError if it is not JSON, OSError if it cannot be read."""
    with named(path, "readable JSON"):
        return json.loads(path.read_bytes(), parse_constant=_no_constant)


def _no_constant(name: str) -> float:
    raise InputFileError(f"{name} is not a number")


def read_parameters(path: Path) -> tuple[dict[str, Any], dict[str, float], str | None]:
    """The values of a parameter set: `{"parameters": {name: {"value": …}}}`, numbers, Booleans or text; the standard deviations, numbers above
    0, of those that have a `deviation`; and its `base`. Raises InputFileError for another form, and the errors of `read_json`."""
    document = read_json(path)
    parameters = document.get("parameters") if isinstance(document, dict) else None
    if not isinstance(parameters, dict):
        raise InputFileError(f'{path} is not a parameter set: it must be an object with an object "parameters"')
    base = document.get("base")
    if base is not None and not isinstance(base, str):
        raise InputFileError(f"{path}: the base {base!r} is no name of a set")
    values, deviations = {}, {}
    for name, entry in parameters.items():
        value = entry.get("value") if isinstance(entry, dict) else None
        if not isinstance(value, (bool, int, float, str)):
            raise InputFileError(f'{path}: {name} has no "value" that is a number, true, false or text')
        values[name] = value
        if "deviation" in entry:
            if isinstance(found := entry["deviation"], bool) or not isinstance(found, (int, float)) or not 0.0 < found < math.inf:
                raise InputFileError(f"{path}: the deviation {found!r} of {name} is no number above 0")
            deviations[name] = float(found)
    return values, deviations, base
