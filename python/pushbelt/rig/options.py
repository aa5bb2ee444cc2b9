"""Options of the command line that say how a rig's table is read."""

from __future__ import annotations

import argparse
import re

from . import units
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


def areas(text: str) -> tuple[float, float]:
    """Areas of the primary and the secondary piston, m²; one for both, with or without a unit."""
    found = []
    for part in text.split(","):
        match = re.fullmatch(r"\s*([0-9.eE+-]+)\s*(\S*)\s*", part)
        unit = units.find(match.group(2) or "m2", "area") if match else None
        try:
            value = float(match.group(1)) if match else 0.0
        except ValueError:
            value = 0.0
        if unit is None or not 1e-5 <= unit.si(value) <= 1.0:
            raise argparse.ArgumentTypeError(f"{text} is not an area of 1e-5 to 1 m², such as 0.012 or 120cm2,90cm2")
        found.append(unit.si(value))
    return _both(found, text)


def coefficients(text: str) -> tuple[float, float]:
    """Coefficients of the primary and the secondary pulley, N·s²; one for both."""
    try:
        found = [float(part) for part in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text} is not a number, or two with a comma between them") from None
    return _both(found, text)


def _both(found: list[float], text: str) -> tuple[float, float]:
    if len(found) > 2:
        raise argparse.ArgumentTypeError(f"{text} has {len(found)} values: one for both pulleys, or primary,secondary")
    return found[0], found[-1]


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
    group.add_argument(
        "--piston-area",
        type=areas,
        metavar="A[,A]",
        help="areas of the primary and the secondary piston, m² or such as 120cm2: oil pressures give the forces p A",
    )
    group.add_argument(
        "--centrifugal",
        type=coefficients,
        metavar="C[,C]",
        help="coefficients of the oil's centrifugal force, N·s²: the forces are p A + c ω²",
    )
    group.add_argument("--as-written", action="store_true", help="take values that are not plausible on a variator as they are written")


def reading(options: argparse.Namespace) -> Reading:
    """Choices of the command line."""
    return Reading(options.decimal, dict(options.map), options.sheet, getattr(options, "as_written", False))


def oil(options: argparse.Namespace) -> Oil:
    """Pistons of the command line."""
    return Oil(options.piston_area, options.centrifugal)
