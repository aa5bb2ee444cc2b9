"""Options of the command line that say how a rig's table is read."""

from __future__ import annotations

import argparse

from ..fmu.data import parameter_set
from .points import Oil, Reading

DECIMAL = {"point": "point", ".": "point", "comma": "comma", ",": "comma"}


def mapped(text: str) -> tuple[str, str]:
    """`title=name`."""
    title, separator, name = text.partition("=")
    if not separator or not title.strip() or not name.strip():
        raise argparse.ArgumentTypeError(f"{text} is not of the form title=name")
    return title.strip(), name.strip()


def decimal(text: str) -> str:
    """The name of a decimal sign."""
    if text not in DECIMAL:
        raise argparse.ArgumentTypeError(f"{text} is neither point nor comma")
    return DECIMAL[text]


class _Removed(argparse.Action):
    """Refuses an option in whose place there are parameters."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        """Ends with the parameters in place of the option."""
        parser.error(f"{self.option_strings[0]} has been removed: set {self.metavar} in the parameter set or by --set")


def add_reading(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """Adds those of any table; returns their group."""
    group = parser.add_argument_group("how the table is read")
    group.add_argument(
        "--map",
        type=mapped,
        action="append",
        default=[],
        metavar="TITLE=NAME",
        help='what a column is, such as --map i=ratio.geometric, --map n_P="primary.speed [rpm]", --map T_P=-primary.torque or '
        "--map i=1/ratio.speed; can be repeated",
    )
    group.add_argument("--decimal", type=decimal, metavar="SIGN", help="point or comma [default: what the whole file shows]")
    group.add_argument("--sheet", metavar="NAME", help="sheet of an .xlsx file [default: the one with most known columns]")
    return group


def add(parser: argparse.ArgumentParser) -> None:
    """Adds all options."""
    group = add_reading(parser)
    group.add_argument("--as-written", action="store_true", help="take values that are not plausible on a variator as they are written")
    for option, name in (("--piston-area", "area"), ("--centrifugal", "centrifugal")):
        names = " and ".join(f"{pulley}.cylinder.{name}" for pulley in ("primary", "secondary"))
        group.add_argument(option, action=_Removed, help=argparse.SUPPRESS, metavar=names)


def reading(options: argparse.Namespace) -> Reading:
    """Choices of the command line."""
    return Reading(options.decimal, dict(options.map), options.sheet, getattr(options, "as_written", False))


def oil(options: argparse.Namespace) -> Oil:
    """Cylinders of the parameter set and of --set; the geometry is that of `bench168`, the default of the FMU, unless they have their own."""
    return Oil({**parameter_set("bench168"), **parameter_set(options.variator), **dict(getattr(options, "set", []))})
