"""Checks of the arguments of public functions. A rule returns a value as the function takes it, or raises ArgumentError with one line:
which argument, which value, which range."""

import functools
import inspect
import os
import reprlib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from .errors import ArgumentError, FileError, MissingFileError, PushbeltError, similar

Rule = Callable[[str, Any], Any]
F = TypeVar("F", bound=Callable[..., Any])


def checks(**rules: Rule) -> Callable[[F], F]:
    """Applies rules to the arguments of these names. Errors of the file system become those of the package."""

    def made(function: F) -> F:
        signature = inspect.signature(function)

        @functools.wraps(function)
        def checked(*given: Any, **named: Any) -> Any:
            try:
                bound = signature.bind(*given, **named)
            except TypeError as error:
                faults = [f"no argument {name}{similar(name, signature.parameters)}" for name in named if name not in signature.parameters]
                what = function.__qualname__.removesuffix(".__init__").rpartition(".")[2]
                raise ArgumentError(f"{what}: {faults[0] if faults else error}") from None
            bound.arguments |= {name: rules[name](name, value) for name, value in bound.arguments.items() if name in rules}
            try:
                return function(*bound.args, **bound.kwargs)
            except OSError as error:
                if isinstance(error, PushbeltError):
                    raise
                why = f"{error.filename}: {error.strerror}" if error.strerror else str(error)
                if isinstance(error, FileNotFoundError):
                    raise MissingFileError(why) from error
                raise FileError(why) from error

        return checked  # type: ignore[return-value]

    return made


def refused(name: str, value: Any, wanted: str) -> str:
    return f"{name} = {' '.join(reprlib.repr(value).split())} is not {wanted}"


def number(unit: str = "", *, above: float = -np.inf, least: float = -np.inf, several: bool = False) -> Rule:
    """A finite number in a range. With `several` also a list of them."""
    limit = f" above {above:g}" if above > -np.inf else f" of at least {least:g}" if least > -np.inf else ""
    unit = f" {unit}" if unit else ""
    wanted = (f"a number{limit}{unit}" if limit else "a finite number") + (", or a list of them" if several else "")

    def rule(name: str, value: Any) -> Any:
        try:
            found = np.asarray(list(value) if several and isinstance(value, Iterable) and not hasattr(value, "__array__") else value)
        except ValueError:
            raise ArgumentError(refused(name, value, wanted)) from None
        if found.dtype.kind not in "iuf" or found.ndim > several:
            raise ArgumentError(refused(name, value, wanted))
        found = found.astype(float)
        if (bad := found[~(np.isfinite(found) & (found > above) & (found >= least))]).size:
            raise ArgumentError(f"{name} = {bad[0]:g}{unit} is not {wanted}")
        return found if found.ndim else float(found)

    return rule


def kind(wanted: str, *types: Any) -> Rule:
    """An object of one of these types."""

    def rule(name: str, value: Any) -> Any:
        if not isinstance(value, types):
            raise ArgumentError(refused(name, value, wanted))
        return value

    return rule


def whole(name: str, value: Any) -> int:
    return int(number(least=1.0)(name, kind("a whole number", int, np.integer)(name, value)))


def optional(rule: Rule) -> Rule:
    return lambda name, value: None if value is None else rule(name, value)


text, file = kind("a name", str), kind("a name or a path", str, os.PathLike)


def path(name: str, value: Any) -> Path:
    return Path(os.fsdecode(file(name, value)))


def names(name: str, value: Any) -> tuple[str, ...]:
    if isinstance(value, str) or not isinstance(value, Iterable):
        raise ArgumentError(refused(name, value, "a list of names"))
    return tuple(text(name, one) for one in value)


def mapping(name: str, value: Any) -> Mapping[str, Any]:
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise ArgumentError(refused(name, value, "a mapping from names to values"))
    return value


def lists(name: str, value: Any) -> Mapping[str, Any]:
    """A mapping from names to lists of values."""
    for key, values in mapping(name, value).items():
        if isinstance(values, str) or not isinstance(values, Iterable):
            raise ArgumentError(refused(f"{name}[{key!r}]", values, "a list of values"))
    return value
