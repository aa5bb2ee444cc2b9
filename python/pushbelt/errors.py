"""The base class of all errors of this package, errors that several modules raise, and warnings."""

import difflib
import importlib
import importlib.metadata
import re
import sys
import warnings
from collections.abc import Iterable
from typing import Any


class PushbeltError(Exception):
    """Base class of all errors of this package. The message has one line: what is wrong, with its value, and what to do."""


class ArgumentError(PushbeltError, ValueError):
    """An argument cannot be used."""


class UnknownNameError(PushbeltError, KeyError):
    """There is no such name. The message contains similar ones."""

    # That of KeyError is the representation of the text.
    __str__ = Exception.__str__


class MissingFileError(PushbeltError, FileNotFoundError):
    """A file is missing. The message names what would provide it."""


class FileError(PushbeltError, OSError):
    """A file cannot be read or written."""


class MissingPackageError(PushbeltError, ModuleNotFoundError):
    """A package is not installed. The message names the extra that installs it."""


def similar(name: str, names: Iterable[str]) -> str:
    """Similar names, as the end of a message; empty if there is none."""
    near = difflib.get_close_matches(str(name), list(names), n=3)
    return f"; similar names: {', '.join(near)}" if near else ""


class VariatorWarning(UserWarning):
    """A warning of the FMU, for example that a run does not start from the requested state, or of this package."""


def package(name: str, what: str, extra: str) -> Any:
    """A module of an optional package. Without it raises MissingPackageError: what needs it, and the extra that installs it."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        raise MissingPackageError(f"{what}: pip install 'pushbelt[{extra}]'", name=error.name) from error


def require(extra: str) -> None:
    """Raises MissingPackageError if a package of an extra is missing, or older than pushbelt declares. A source tree declares none."""
    try:
        declared = importlib.metadata.requires("pushbelt") or []
    except importlib.metadata.PackageNotFoundError:
        return
    extras = [extra]
    for one in extras:
        for text in (line for line in declared if re.search(f"extra == .{one}\\W*$", line)):
            name, inner, least = re.match(r"([\w.-]+)(?:\[(.*?)\])? *(?:>= *([\d.]+))?", text).groups()  # type: ignore[union-attr]
            if name == "pushbelt":
                extras += inner.split(",")
                continue
            install = f"pip install 'pushbelt[{extra}]'"
            try:
                there = importlib.metadata.version(name)
            except importlib.metadata.PackageNotFoundError as error:
                raise MissingPackageError(f"the package {name} is missing: {install}", name=name) from error
            if least and [*map(int, re.findall(r"\d+", there))] < [*map(int, least.split("."))]:
                raise MissingPackageError(f"{name} {there} is older than {least}: {install}", name=name)


def warn(text: str) -> None:
    """Issues a VariatorWarning that is attributed to the first caller outside of this package."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_globals.get("__name__", "").split(".")[0] == __package__:
        level, frame = level + 1, frame.f_back
    warnings.warn(text, VariatorWarning, stacklevel=level)
