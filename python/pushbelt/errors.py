"""The base class of all errors of this package, and errors that several modules raise."""

from __future__ import annotations


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


class MissingPackageError(PushbeltError, ModuleNotFoundError):
    """A package is not installed. The message names the extra that installs it."""


class VariatorWarning(UserWarning):
    """A warning of the FMU, for example that a run does not start from the requested state, or of this package."""
