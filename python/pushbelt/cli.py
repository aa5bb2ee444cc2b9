"""The command `pushbelt`: runs the programs with the FMU of the package, writes FMUs with other start values, and shows the cache."""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._version import __version__

if TYPE_CHECKING:
    from .map_data import Maps

PROGRAMS = {
    "demo": ("load cases, a published steady state and a manoeuvre of 10 s, and a report", "reports"),
    "drive": ("a car on the WLTC or the NEDC, and a report", "reports"),
    "durability": ("fatigue of the ring over a drive or another run, and a report", "durability"),
    "sweep": ("maps of steady states over ratio, torque, friction and speed, and a report", "sweep"),
    "maps": ("maps for vehicle simulations, as NetCDF, MATLAB, Modelica and CSV files, and a report", "sweep"),
    "validate": ("comparison of the FMU with theory and measurements, and a report", "reports"),
    "linearize": ("linear models about steady working points, for controller design, and a report", "reports"),
    "compare": ("comparison of two runs, and a report", "reports"),
    "calibrate": ("parameters from a table of measured points, and a report", "reports"),
}
"""Description of each program, and the extra that installs the packages it needs."""


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
    text = "write a copy of the FMU with other start values"
    fmu = commands.add_parser("fmu", help=text, description=f"{text.capitalize()}.")
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
        "--ssv", type=Path, metavar="SET.ssv", help="parameter set that is applied next, System Structure Parameter Values 1.0"
    )
    fmu.add_argument("--fmu", type=Path, help="FMU to copy [default: the FMU of the package]")
    text = "write an FMU of a variator from maps"
    maps = commands.add_parser("map-fmu", help=text, description=f"{text.capitalize()}, without a compiler.")
    maps.add_argument("copy", type=Path, metavar="OUT.fmu", help="output file")
    maps.add_argument("--maps", type=Path, metavar="FILE", help="file of `pushbelt maps`: maps.nc, maps.npz or maps.json")
    maps.add_argument(
        "--variator", metavar="NAME", help="solve for the maps of a parameter set: bench168, belt155 or a file ….json (minutes)"
    )
    maps.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="start value, in SI units; can be repeated"
    )
    maps.add_argument("--fmu", type=Path, help="FMU of maps to copy [default: PushbeltMap.fmu in `target`]")
    text = "show the folder of unpacked FMUs and its size"
    cache = commands.add_parser("cache", help=text, description=f"{text.capitalize()}.")
    cache.add_argument("--clear", action="store_true", help="remove them")
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a command and returns its exit code."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    if arguments and arguments[0] in PROGRAMS:
        return run_program(arguments[0], arguments[1:])
    options = parser().parse_args(arguments)
    try:
        return {"fmu": write_fmu, "map-fmu": write_map_fmu, "cache": show_cache}[options.command](options)
    except (OSError, ValueError) as error:
        print(f"pushbelt {options.command}: {error}", file=sys.stderr)
        return 1


def run_program(name: str, arguments: list[str]) -> int:
    """Runs a program. By default it uses the FMU of the package and a separate output folder."""
    from .fmu.files import default_fmu

    extra = PROGRAMS[name][1]
    try:
        if not any(word == "--fmu" or word.startswith("--fmu=") for word in arguments):
            arguments = ["--fmu", str(default_fmu()), *arguments]
        program = importlib.import_module(f"{__package__}.{name}.__main__")
        return program.main(["--output", f"pushbelt-{name}", *arguments])
    except FileNotFoundError as error:
        print(f"pushbelt {name}: {error}", file=sys.stderr)
    except ModuleNotFoundError as error:
        print(f"pushbelt {name} needs the package {error.name}: pip install 'pushbelt[{extra}]'", file=sys.stderr)
    return 1


def write_fmu(options: argparse.Namespace) -> int:
    """`pushbelt fmu`: checks the values against the variable table and on the FMU itself, and writes the copy."""
    from .fmu import cache, start_values
    from .fmu.data import parameter_set
    from .fmu.files import default_fmu
    from .fmu.unit import UnitError, Variator

    if options.copy.suffix != ".fmu":
        raise ValueError(f"{options.copy} does not end in .fmu: importers would not accept it")
    fmu = options.fmu or default_fmu()
    archive = cache.unpacked(fmu)
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
    for remark in remarks:
        print(f"  warning of the FMU: {remark}", file=sys.stderr)
    print(f"{options.copy.resolve()} ({len(values)} start values)")
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
    if options.variator:
        maps: Maps | bytes = _solved_maps(options.variator, options.copy.parent)
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


def _solved_maps(variator: str, folder: Path) -> Maps:
    """The default maps of a parameter set. Finished lines remain in a folder beside the FMU."""
    from .fmu.files import default_fmu
    from .map_data import Maps

    output = folder / "pushbelt-maps"
    program = importlib.import_module(f"{__package__}.maps.__main__")
    words = ["--fmu", str(default_fmu()), "--output", str(output), "--variator", variator]
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


if __name__ == "__main__":
    sys.exit(main())
