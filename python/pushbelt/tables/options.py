"""Options of the command line that say how a rig's table is read."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..fmu.data import parameter_set
from . import points
from .points import Rig
from .sheet import Reading

DECIMAL = {"point": "point", ".": "point", "comma": "comma", ",": "comma"}


def mapped(text: str) -> tuple[str, str]:
    """`title=name`."""
    title, separator, name = (part.strip() for part in text.partition("="))
    if not (separator and title and name):
        raise argparse.ArgumentTypeError(f"{text} is not of the form title=name")
    return title, name


def add_reading(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """Adds those of any table; returns their group."""
    group = parser.add_argument_group("how the table is read")
    example = "such as --map i=ratio.geometric, --map n_P=\"primary.speed [rpm]\", --map T_P=-primary.torque or --map i=1/ratio.speed"
    group.add_argument("--map", type=mapped, action="append", default=[], metavar="TITLE=NAME",
                       help=f"what a column is, {example}; can be repeated")  # fmt: skip
    group.add_argument("--decimal", choices=DECIMAL, metavar="SIGN", help="point or comma [default: what the whole file shows]")
    group.add_argument("--sheet", metavar="NAME", help="sheet of an .xlsx file [default: the one with most known columns]")
    return group


def add(parser: argparse.ArgumentParser) -> None:
    """Adds all options."""
    text = "take values that are not plausible on a variator as they are written"
    add_reading(parser).add_argument("--as-written", action="store_true", help=text)


def reading(options: argparse.Namespace) -> Reading:
    """Choices of the command line."""
    return Reading(DECIMAL.get(options.decimal), dict(options.map), options.sheet, getattr(options, "as_written", False))


def read(path: Path, options: argparse.Namespace) -> Rig:
    """What a rig's table measures. Cylinders are those of the parameter set and of --set; the geometry is that of `bench168`, the default of
    the FMU, unless they have their own."""
    parameters = {**parameter_set("bench168"), **parameter_set(options.variator), **dict(options.set)}
    return points.read(path, reading(options), parameters)
