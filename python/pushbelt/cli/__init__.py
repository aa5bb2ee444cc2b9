"""The command `pushbelt`: runs the programs with the FMU of the package, writes FMUs with other start values or for stricter importers,
and shows variables, pages and the cache."""

from __future__ import annotations

import argparse
import importlib
import json
import sys
import warnings
from collections.abc import Sequence
from pathlib import Path

from .. import console
from .._version import __version__

PROGRAMS = {
    "demo": "load cases, a published steady state and a manoeuvre of 10 s, and a report",
    "drive": "a car on the WLTC or the NEDC, and a report",
    "durability": "fatigue of the ring over a drive or another run, and a report",
    "sweep": "maps of steady states over ratio, torque, friction and speed, and a report",
    "maps": "maps for vehicle simulations, as NetCDF, MATLAB, Modelica and CSV files, and a report",
    "linearize": "linear models about steady working points, for controller design, and a report",
    "compare": "comparison of two runs, and a report",
    "belt": "parameter set for a belt of given dimensions, with checks of ratio and stress",
    "calibrate": "parameters from a table of measured points, and a report",
}


def parser() -> argparse.ArgumentParser:
    """The parser of the command line, without the options of the programs."""
    from . import options

    found = argparse.ArgumentParser(
        prog="pushbelt",
        description="A pushbelt CVT variator as an FMU. `pushbelt COMMAND --help` lists the options of a command.",
        epilog="Programs run the FMU of this package by default (see --fmu) and write to the folder pushbelt-COMMAND (see --output).",
    )
    found.add_argument("--version", action="version", version=f"pushbelt {__version__}")
    commands = found.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, text in PROGRAMS.items():
        commands.add_parser(name, help=text, add_help=False)

    kinds = {"path": Path, "assignment": options.assignment}
    for name, (runs, text, arguments) in json.loads(Path(__file__).with_name("commands.json").read_text(encoding="utf-8")).items():
        made = commands.add_parser(name, help=text, description=f"{text[0].upper()}{text[1:]}.")
        made.set_defaults(runs=runs)
        for word, about in arguments.items():
            made.add_argument(word, **about | ({"type": kinds[about["type"]]} if "type" in about else {}))
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    words = list(sys.argv[1:] if arguments is None else arguments)
    if words and words[0] in PROGRAMS:
        return run_program(words[0], words[1:])
    options = parser().parse_args(words)
    return console.program(options.command, "all")(lambda _: _run(options))()


def _run(options: argparse.Namespace) -> int:
    # Imported here, so that the help is fast.
    from . import commands

    try:
        return getattr(commands, options.runs)(options)
    except BrokenPipeError:
        # The reader of the output, such as `head`, has enough.
        sys.stdout = None
        return 0


def run_program(name: str, words: list[str]) -> int:
    """Runs a program, whose warnings are one line each."""
    with warnings.catch_warnings():
        warnings.showwarning = lambda message, *_, **__: print(f"  warning: {message}", file=sys.stderr)
        return importlib.import_module(f"pushbelt.{name}.__main__").main(words)
