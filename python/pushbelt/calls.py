"""Programs as functions: `pushbelt.sweep(ratio=[0.5, 1.0], output="study")` runs `pushbelt sweep --ratio=0.5,1.0 --output=study`."""

import argparse
import importlib
import sys
from collections.abc import Callable, Iterable, Mapping
from inspect import Parameter, Signature, signature, unwrap
from pathlib import Path
from types import ModuleType
from typing import Any

from . import console, provenance
from .arguments import checks
from .errors import ArgumentError


class Program(ModuleType):
    """A program that is a function, too. Its arguments are those of the command, with `_` for `-`.

    `sweep` returns a pandas.DataFrame, `maps` a `Maps`, `drive` its `runs`, `calibrate` the fitted `parameters`, `fit` and `rows`. Repeated
    options are mappings: `set={"belt.play": 3e-4}`, `bounds={"friction.pulley": (0.05, 0.12)}`. A table may be a pandas.DataFrame.
    Programs start processes, so a script needs the guard `if __name__ == "__main__":` around a call.
    """

    __signature__ = property(lambda self: signature(self._function))

    def __call__(self, *given: Any, **options: Any) -> Any:
        return self._function(*given, **options)

    @property
    def _function(self) -> Callable[..., Any]:
        program = importlib.import_module(f"{self.__name__}.__main__")
        parser, name = program.parser(), self.__name__.rpartition(".")[2]
        known = {one.dest: one for one in parser._actions if one.dest != "help"}
        kinds = {False: Parameter.POSITIONAL_OR_KEYWORD, True: Parameter.KEYWORD_ONLY}
        places = [Parameter(key, kinds[bool(one.option_strings)], default=one.default) for key, one in known.items()]

        def refuse(message: str) -> None:
            raise ArgumentError(f"{name}: {message}")

        def call(*given: Any, **options: Any) -> Any:
            values = dict(zip(signature(call).parameters, given, strict=False)) | options
            folder = Path(options.get("output", known["output"].default))
            words = [word for key, value in values.items() for word in _words(known[key], value, folder)]
            parser.parse_args(words)
            provenance.begin(name, words)
            found = unwrap(program.main)(words)
            return found.result if isinstance(found, console.Done) else None

        call.__qualname__, parser.error = name, refuse
        call.__signature__ = Signature(sorted(places, key=lambda one: one.kind))  # type: ignore[attr-defined]
        return checks()(call)


def callable_module(name: str) -> None:
    """Lets a package of a program be called."""
    sys.modules[name].__class__ = Program


def _words(action: argparse.Action, value: Any, folder: Path) -> list[str]:
    """The words of an argument on the command line. A table is written to the folder of the results."""
    option = next(iter(action.option_strings), "")
    if value is None or isinstance(value, bool):
        return [option] if value else []
    if hasattr(value, "to_csv"):
        folder.mkdir(parents=True, exist_ok=True)
        value.to_csv(path := folder / f"{action.dest}.csv", index=False)
        value = path
    if isinstance(value, Mapping):
        value = [key if one is None else f"{key}={_text(one, '±' if '±' in str(action.metavar) else ':')}" for key, one in value.items()]
    repeated = isinstance(action, argparse._AppendAction) and isinstance(value, list)
    return [f"{option}={text}" if option else text for text in (value if repeated else [_text(value)])]


def _text(value: Any, pair: str = ",") -> str:
    if isinstance(value, str) or not isinstance(value, Iterable):
        return str(value)
    return (pair if isinstance(value, tuple) and len(value) == 2 else ",").join(map(str, value))
