"""The command `pushbelt`: runs the programs with the FMU of the package, writes FMUs with other start values or for stricter importers,
and shows variables, pages and the cache."""

import argparse
import importlib
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
KINDS = ("parameter", "input", "output", "local")  # Causalities of variables


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

    def command(name: str, runs: str, text: str) -> argparse.ArgumentParser:
        made = commands.add_parser(name, help=text, description=f"{text[0].upper()}{text[1:]}.")
        made.set_defaults(runs=runs)
        return made

    fmu = command("fmu", "write_fmu", "write a copy of the FMU with other start values, or for stricter importers")
    fmu.add_argument("copy", type=Path, metavar="OUT.fmu", help="output file")
    options.add_set(fmu, "start value of a parameter or an input")
    fmu.add_argument("--variator", metavar="NAME", help=f"applied first, {options.VARIATOR}")
    fmu.add_argument("--ssv", type=Path, metavar="SET.ssv", help="applied next, a parameter set: System Structure Parameter Values 1.0")
    text = "flat names, such as primary_torque instead of primary.torque, for tools that read a dot as a bus or a record; "
    fmu.add_argument("--flat", action="store_true", help=text + "--set and --ssv have the names with dots")
    text = "for importers that read all outputs as Real: the others become local, macroSlipReal and pastPeakReal are 1 for true"
    fmu.add_argument("--real-outputs", action="store_true", help=text)
    text = "with --fmi3, for importers that read no arrays: each element is a variable, such as profile.pushForce[1]"
    fmu.add_argument("--scalars", action="store_true", help=text)
    text = "for importers on ARM that look in linux64, such as fmpy: that folder of the copy has the library for ARM"
    fmu.add_argument("--arm", action="store_true", help=text)
    fmu.add_argument("--fmi3", action="store_true", help="for FMI 3.0 instead of 2.0")
    fmu.add_argument("--fmu", type=Path, help="FMU to copy [default: the FMU of the package]")
    maps = command("map-fmu", "write_map_fmu", "write an FMU of a variator from maps")
    maps.add_argument("copy", type=Path, metavar="OUT.fmu", help="output file")
    maps.add_argument("--maps", type=Path, metavar="FILE", help="file of `pushbelt maps`: maps.nc, maps.npz or maps.json")
    options.add_set(maps, "start value")
    maps.add_argument("--fmi3", action="store_true", help="for FMI 3.0 instead of 2.0")
    maps.add_argument("--fmu", type=Path, help="FMU of maps to copy [default: PushbeltMap.fmu of the package]")
    cache = command("cache", "show_cache", "show the folder of unpacked FMUs and its size")
    cache.add_argument("--clear", action="store_true", help="remove them")
    text = "list the variables of the FMU: parameters, inputs and outputs, with unit, start value and range"
    variables = command("variables", "show_variables", text)
    variables.add_argument("words", nargs="*", metavar="WORD", help="only variables whose name or description contains all words")
    variables.add_argument("--kind", choices=KINDS, help="only these")
    variables.add_argument("--fmu", type=Path, help="the FMU [default: the FMU of the package]")
    examples = command("examples", "write_examples", "write the examples in Python and C and the notebook to a folder")
    examples.add_argument("folder", type=Path, metavar="FOLDER", help="a new folder")
    docs = command("docs", "show_docs", "show the pages of the documentation, or one of them")
    docs.add_argument("page", nargs="?", metavar="PAGE", help="page, such as linear")
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    words = list(sys.argv[1:] if arguments is None else arguments)
    if words and words[0] in PROGRAMS:
        with warnings.catch_warnings():
            # One line each.
            warnings.showwarning = lambda message, *_, **__: print(f"  warning: {message}", file=sys.stderr)
            return importlib.import_module(f"pushbelt.{words[0]}.__main__").main(words[1:])
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
