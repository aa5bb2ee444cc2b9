"""The command `pushbelt`: runs the programs with the FMU of the package, writes FMUs with other start values or flat names, and shows
variables, pages and the cache."""

from __future__ import annotations

import argparse
import difflib
import importlib
import sys
import traceback
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import console
from ._version import __version__

if TYPE_CHECKING:
    from .map_data import Maps

PROGRAMS = {
    "demo": ("load cases, a published steady state and a manoeuvre of 10 s, and a report", "reports"),
    "drive": ("a car on the WLTC or the NEDC, and a report", "reports"),
    "durability": ("fatigue of the ring over a drive or another run, and a report", "durability"),
    "sweep": ("maps of steady states over ratio, torque, friction and speed, and a report", "sweep"),
    "maps": ("maps for vehicle simulations, as NetCDF, MATLAB, Modelica and CSV files, and a report", "sweep"),
    "linearize": ("linear models about steady working points, for controller design, and a report", "reports"),
    "compare": ("comparison of two runs, and a report", "reports"),
    "belt": ("parameter set for a belt of given dimensions, with checks of ratio and stress", "reports"),
    "calibrate": ("parameters from a table of measured points, and a report", "tables"),
}
"""Description of each program, and the extra that installs the packages it needs."""

KINDS = ("parameter", "input", "output", "local")
"""Causalities of variables."""


def parser() -> argparse.ArgumentParser:
    """The parser of the command line, without the options of the programs."""
    found = argparse.ArgumentParser(
        prog="pushbelt",
        description="A pushbelt CVT variator as an FMU. `pushbelt COMMAND --help` lists the options of a command.",
        epilog="Programs run the FMU of this package by default (see --fmu) and write to the folder pushbelt-COMMAND "
        "(see --output).",
    )
    found.add_argument("--version", action="version", version=f"pushbelt {__version__}")
    commands = found.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, (text, _) in PROGRAMS.items():
        commands.add_parser(name, help=text, add_help=False)
    text = "write a copy of the FMU with other start values, or with flat names"
    fmu = commands.add_parser("fmu", help=text, description=f"{text[0].upper()}{text[1:]}.")
    fmu.add_argument("copy", type=Path, metavar="OUT.fmu", help="output file")
    fmu.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="start value of a parameter or an input, in SI units; enumerations by name; can be repeated",
    )
    fmu.add_argument(
        "--variator", metavar="NAME", help="parameter set that is applied first: bench168, belt155 or a file ….json"
    )
    fmu.add_argument(
        "--ssv",
        type=Path,
        metavar="SET.ssv",
        help="parameter set that is applied next, System Structure Parameter Values 1.0",
    )
    fmu.add_argument(
        "--flat",
        action="store_true",
        help="flat names, such as primary_torque instead of primary.torque, for tools that read a dot as a bus or a record; "
        "--set and --ssv have the names with dots",
    )
    fmu.add_argument("--fmu", type=Path, help="FMU to copy [default: the FMU of the package]")
    text = "write an FMU of a variator from maps"
    maps = commands.add_parser("map-fmu", help=text, description=f"{text.capitalize()}, without a compiler.")
    maps.add_argument("copy", type=Path, metavar="OUT.fmu", help="output file")
    maps.add_argument(
        "--maps", type=Path, metavar="FILE", help="file of `pushbelt maps`: maps.nc, maps.npz or maps.json"
    )
    maps.add_argument(
        "--variator",
        metavar="NAME",
        help="solve for the maps of a parameter set: bench168, belt155 or a file ….json; "
        "84 lines of steady states take 4 minutes of processor time",
    )
    maps.add_argument("--short", action="store_true", help="with --variator: solve for 12 lines only")
    maps.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="start value, in SI units; can be repeated"
    )
    maps.add_argument("--fmu", type=Path, help="FMU of maps to copy [default: PushbeltMap.fmu in `target`]")
    text = "show the folder of unpacked FMUs and its size"
    cache = commands.add_parser("cache", help=text, description=f"{text.capitalize()}.")
    cache.add_argument("--clear", action="store_true", help="remove them")
    text = "list the variables of the FMU: parameters, inputs and outputs, with unit, start value and range"
    variables = commands.add_parser("variables", help=text, description=f"{text.capitalize().replace('fmu', 'FMU')}.")
    variables.add_argument(
        "words", nargs="*", metavar="WORD", help="only variables whose name or description contains all words"
    )
    variables.add_argument("--kind", choices=KINDS, help="only these")
    variables.add_argument("--fmu", type=Path, help="the FMU [default: the FMU of the package]")
    text = "show the pages of the documentation, or one of them"
    docs = commands.add_parser("docs", help=text, description=f"{text.capitalize()}.")
    docs.add_argument("page", nargs="?", metavar="PAGE", help="page, such as linear")
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a command and returns its exit code."""
    return console.run(lambda: _main(list(sys.argv[1:] if arguments is None else arguments)))


def _main(arguments: list[str]) -> int:
    if arguments and arguments[0] in PROGRAMS:
        return run_program(arguments[0], arguments[1:])
    options = parser().parse_args(arguments)
    try:
        commands = {
            "fmu": write_fmu,
            "map-fmu": write_map_fmu,
            "cache": show_cache,
            "variables": show_variables,
            "docs": show_docs,
        }
        return commands[options.command](options)
    except BrokenPipeError:
        # The reader of the output, such as `head`, has enough.
        sys.stdout = None
        return 0
    except (OSError, ValueError) as error:
        print(f"pushbelt {options.command}: {error}", file=sys.stderr)
        return 1


def run_program(name: str, arguments: list[str]) -> int:
    """Runs a program. By default it uses the FMU of the package and a separate output folder."""
    from .fmu.files import default_fmu

    extra, help_only = PROGRAMS[name][1], bool({"-h", "--help"}.intersection(arguments))
    try:
        if not help_only and not any(word == "--fmu" or word.startswith("--fmu=") for word in arguments):
            arguments = ["--fmu", str(default_fmu()), *arguments]
        program = importlib.import_module(f"{__package__}.{name}.__main__")
        with warnings.catch_warnings():
            warnings.showwarning = lambda message, *_, **__: print(f"  warning: {message}", file=sys.stderr)
            return program.main(["--output", f"pushbelt-{name}", *arguments])
    except ModuleNotFoundError as error:
        if help_only:
            from .help_without_extras import show

            show(lambda: importlib.import_module(f"{__package__}.{name}.__main__").main(["--help"]))
            print(f"\nnot installed: {error.name}. pip install 'pushbelt[{extra}]'")
            return 0
        print(f"pushbelt {name} needs the package {error.name}: pip install 'pushbelt[{extra}]'", file=sys.stderr)
    except (OSError, ValueError, RuntimeError, KeyError) as error:
        if not (isinstance(error, OSError) or raised_here(error)):
            raise
        print(f"pushbelt {name}: {error.args[0] if isinstance(error, KeyError) else error}", file=sys.stderr)
    return 1


def raised_here(error: BaseException) -> bool:
    """Whether a statement of this package raised an error, so that its message is complete without a traceback."""
    frames = traceback.extract_tb(error.__traceback__)
    return (
        bool(frames)
        and Path(__file__).parent in Path(frames[-1].filename).parents
        and bool(frames[-1].line and frames[-1].line.startswith("raise"))
    )


def write_fmu(options: argparse.Namespace) -> int:
    """`pushbelt fmu`: checks the values against the variable table and on the FMU itself, and writes the copy."""
    from .fmu import cache, flat, start_values
    from .fmu.data import parameter_set
    from .fmu.files import default_fmu
    from .fmu.unit import UnitError, Variator
    from .fmu.untrusted import described

    if options.copy.suffix != ".fmu":
        raise ValueError(f"{options.copy} does not end in .fmu: importers would not accept it")
    fmu = options.fmu or default_fmu()
    if options.flat and not (options.set or options.variator or options.ssv):
        described(fmu)
        flat.write_copy(fmu, options.copy)
        print(f"{options.copy.resolve()} (flat names)")
        return 0
    archive = cache.unpacked(fmu)
    if archive.description.variableNamingConvention == "flat":
        raise ValueError(f"{fmu} has flat names: write its start values together with --flat into a copy of the original")
    variables = {variable.name: variable for variable in archive.description.modelVariables}
    given: dict[str, Any] = parameter_set(options.variator) if options.variator else {}
    if options.ssv:
        from .fmu import ssv

        given |= ssv.read(options.ssv, variables)
    given |= _assignments(options.set)
    values = start_values.checked(variables, given)
    try:
        with Variator(archive, values) as unit:
            unit.initialise()
            remarks = unit.warnings
    except UnitError as error:
        raise ValueError(f"the FMU rejects these values: {error}") from error
    start_values.write_copy(fmu, options.copy, values)
    if options.flat:
        flat.write_copy(options.copy, options.copy)
    for remark in remarks:
        print(f"  warning of the FMU: {remark}", file=sys.stderr)
    print(f"{options.copy.resolve()} ({len(values)} start values{', flat names' if options.flat else ''})")
    return 0


def _assignments(texts: Sequence[str]) -> dict[str, str]:
    """Values by name, from texts `NAME=VALUE`."""
    given = {}
    for text in texts:
        name, separator, value = text.partition("=")
        if not separator:
            raise ValueError(f"--set {text} is not of the form NAME=VALUE")
        given[name.strip()] = value.strip()
    return given


def write_map_fmu(options: argparse.Namespace) -> int:
    """`pushbelt map-fmu`: writes tables and start values into a copy of the FMU of maps, and starts the copy once."""
    from . import map_unit
    from .fmu.unit import Archive, UnitError, Variator
    from .map_data import Maps

    if options.copy.suffix != ".fmu":
        raise ValueError(f"{options.copy} does not end in .fmu: importers would not accept it")
    if options.maps and options.variator:
        raise ValueError("--maps and --variator exclude each other: a file of maps has its variator's parameters")
    if options.short and not options.variator:
        raise ValueError("--short is for maps that are solved for: it needs --variator")
    if options.variator:
        maps: Maps | bytes = _solved_maps(options.variator, options.copy.parent, short=options.short)
    else:
        maps = Maps.read(options.maps) if options.maps else map_unit.default_maps().read_bytes()
    map_unit.write_fmu(options.copy, maps, options.fmu, _assignments(options.set))
    try:
        with Archive.unpack(options.copy) as archive, Variator(archive, {}) as unit:
            unit.initialise()
            remarks = unit.warnings
    except UnitError as error:
        options.copy.unlink()
        raise ValueError(f"the FMU rejects these maps or values: {error}") from error
    for remark in remarks:
        print(f"  warning of the FMU: {remark}", file=sys.stderr)
    print(options.copy.resolve())
    return 0


def _solved_maps(variator: str, folder: Path, *, short: bool) -> Maps:
    """The default maps of a parameter set, or a few lines of them. Finished lines remain in a folder beside the FMU."""
    from .fmu.files import default_fmu
    from .map_data import Maps

    output = folder / "pushbelt-maps"
    program = importlib.import_module(f"{__package__}.maps.__main__")
    words = ["--fmu", str(default_fmu()), "--output", str(output), "--variator", variator, *["--short"] * short]
    if program.main(words) != 0:
        raise ValueError("there are no maps")
    return Maps.read(output / "maps.nc")


def show_cache(options: argparse.Namespace) -> int:
    """`pushbelt cache`."""
    from .fmu import cache

    folder = cache.folder()
    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) if folder.is_dir() else 0
    if options.clear:
        cache.clear()
        print(f"removed {folder} ({size / 1e6:.1f} MB)")
    else:
        print(f"{folder} ({size / 1e6:.1f} MB)")
    return 0


def show_variables(options: argparse.Namespace) -> int:
    """`pushbelt variables`."""
    from .fmu.files import default_fmu
    from .fmu.untrusted import described

    words = [word.lower() for word in options.words]
    variables = described(options.fmu or default_fmu()).modelVariables
    found = [
        one
        for one in variables
        if (options.kind is None or one.causality == options.kind)
        and all(word in f"{one.name} {one.description or ''}".lower() for word in words)
        and ("profile." in " ".join(words) or not one.name.startswith(("profile.", "profile_")))
    ]
    if not found:
        near = difflib.get_close_matches(" ".join(options.words), [one.name for one in variables], n=3)
        hint = f"; similar names: {', '.join(near)}" if near else ""
        raise ValueError(
            f"no {options.kind or 'variable'} has {' and '.join(options.words)} in its name or description{hint}"
        )
    for one in found:
        unit = "" if one.unit in (None, "1") else f" {one.unit}"
        parts = [one.causality]
        if one.start is not None:
            parts.append(f"start {_item_name(one, one.start)}{unit}")
        if one.min is not None and one.max is not None and one.type in ("Real", "Integer"):
            parts.append(f"range {float(one.min):g} to {float(one.max):g}{unit}")
        elif one.type == "Enumeration":
            parts.append(f"one of {', '.join(item.name for item in one.declaredType.items)}")
        elif unit:
            parts.append(unit.strip())
        print(f"{one.name}\n    {', '.join(parts)}\n    {one.description}")
    print(
        f"{len(found)} of {len(variables)} variables"
        + ("" if "profile." in " ".join(words) else "; `pushbelt variables profile.` lists the fields")
    )
    return 0


def _item_name(variable: Any, value: Any) -> str:
    """A start value; that of an enumeration by name."""
    if variable.type != "Enumeration":
        return str(value)
    return next((item.name for item in variable.declaredType.items if str(item.value) == str(value)), str(value))


def show_docs(options: argparse.Namespace) -> int:
    """`pushbelt docs`."""
    from .fmu.files import DOCS

    # Pages that consist of a file of the source tree are left out.
    texts = {path.stem: path.read_text(encoding="utf-8") for path in DOCS.glob("*.md")}
    pages = sorted(name for name, text in texts.items() if "{{#include ../" not in text and name != "SUMMARY")
    if options.page is None:
        print(f"{DOCS}: {', '.join(pages)}\n`pushbelt docs PAGE` prints a page.")
        return 0
    name = options.page.removesuffix(".md")
    if name not in pages:
        near = difflib.get_close_matches(name, pages, n=3)
        raise ValueError(
            f"no page {name}; " + (f"similar names: {', '.join(near)}" if near else f"there are {', '.join(pages)}")
        )
    print(texts[name])
    return 0


if __name__ == "__main__":
    sys.exit(main())
