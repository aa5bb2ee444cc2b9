"""Programs as functions: `pushbelt.sweep(ratio=[0.5, 1.0], output="study")` runs `pushbelt sweep --ratio=0.5,1.0 --output=study`."""

from __future__ import annotations

import argparse
import importlib
import inspect
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from . import console, provenance
from .arguments import checks
from .fmu.results import item


class Program(ModuleType):
    """A program that is a function, too. Its arguments are those of the command, with `_` for `-`; it returns the results.

    Lists are lists, repeated options are mappings: `set={"belt.play": 3e-4}`, `bounds={"friction.pulley": (0.05, 0.12)}`. A table may be a
    pandas.DataFrame. A program that starts processes needs the guard `if __name__ == "__main__":` around its call.
    """

    @property
    def __signature__(self) -> inspect.Signature:
        kinds = {True: inspect.Parameter.KEYWORD_ONLY, False: inspect.Parameter.POSITIONAL_OR_KEYWORD}
        arguments = [inspect.Parameter(name, kinds[bool(one.option_strings)], default=one.default) for name, one in self._arguments().items()]
        return inspect.Signature(sorted(arguments, key=lambda one: one.kind))

    def _arguments(self) -> dict[str, argparse.Action]:
        return {one.dest: one for one in importlib.import_module(f"{self.__name__}.__main__").parser()._actions if one.dest != "help"}

    @checks()
    def __call__(self, *given: Any, **options: Any) -> Any:
        known, name = self._arguments(), self.__name__.rpartition(".")[2]
        places = [one for one, action in known.items() if not action.option_strings]
        options |= dict(zip(places, given, strict=False))
        if len(given) > len(places):
            raise console.ArgumentError(f"{name} takes {len(places)} arguments without a name: the others are {', '.join(known)}")
        folder = Path(options.get("output") or known["output"].default)
        words = [word for one, value in options.items() for word in _words(item(known, one, "program", "argument"), value, folder)]
        provenance.begin(name, words)
        found = inspect.unwrap(importlib.import_module(f"{self.__name__}.__main__").main)(words)
        return found.result if isinstance(found, console.Done) else None


def _words(action: argparse.Action, value: Any, folder: Path) -> list[str]:
    """The words of an argument on the command line. A table is written to the folder of the results."""
    option, metavar = next(iter(action.option_strings), ""), str(action.metavar)
    if value is None or isinstance(value, bool):
        return [option] if value else []
    if hasattr(value, "to_csv"):
        folder.mkdir(parents=True, exist_ok=True)
        value.to_csv(path := folder / f"{action.dest}.csv", index=False)
        value = path
    values = value
    if isinstance(value, Mapping):
        pair = "±" if "±" in metavar else ":"
        values = [name if one is None else f"{name}={_text(one, pair)}" for name, one in value.items()]
    if isinstance(values, str) or not isinstance(action, argparse._AppendAction):
        values = [_text(values)]
    return [f"{option}={text}" if option else text for text in values]


def _text(value: Any, pair: str = ",") -> str:
    if isinstance(value, str | os.PathLike) or not isinstance(value, Iterable):
        return str(value)
    return (pair if isinstance(value, tuple) and len(value) == 2 else ",").join(map(str, value))
