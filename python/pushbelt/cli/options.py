"""The common words of the commands: what an option is called, what it means, and how its value is read."""

import argparse
import os
import re
import shlex
import sys
from collections.abc import Callable
from dataclasses import fields
from functools import partial
from pathlib import Path

import numpy as np

from ..errors import MissingFileError
from ..fmu.data import known_deviations
from ..fmu.enumerations import RingModel
from ..fmu.files import default_fmu
from ..fmu.gradients import HELD, Asked
from ..provenance import COMMAND
from ..steel import Material
from ..tables import units
from ..tables.sheet import Reading

MOST_NUMBERS = 10_000  # Largest number of values of a range
DECIMAL = {"point": "point", ".": "point", "comma": "comma", ",": "comma"}
VARIATOR = "parameter set: bench168, belt155, chain168 or a file ….json"


def program(name: str, description: str | None, writes: str, fmu: str = "the FMU to run", needed: bool = True) -> argparse.ArgumentParser:
    """The parser of a program, with `--fmu` and `--output`. `fmu` says what the FMU is for; without `needed` its absence is no error."""
    found = argparse.ArgumentParser(prog=typed(name), description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    # A default that is a text is read like a word of the command line, so a missing FMU is an error only where it is needed.
    kind, text = _fmu if needed else _fmu_if_any, f"{fmu} [default: that of the package]"
    found.add_argument("--fmu", type=kind, default="", metavar="FILE", help=text)
    found.add_argument("--output", type=Path, default=f"pushbelt-{name}", metavar="FOLDER", help=f"folder for {writes} [default: %(default)s]")
    return found


def typed(name: str) -> str:
    """The words with which a user has started a program."""
    if command := os.environ.get(COMMAND):
        return shlex.join(shlex.split(command)[:3])
    as_module = Path(sys.argv[0]).name == "__main__.py" and Path(sys.argv[0]).parent.name != "pushbelt"
    return f"python -m pushbelt.{name}" if as_module else f"pushbelt {name}"


def _fmu(text: str) -> Path:
    return Path(text) if text else default_fmu()


def _fmu_if_any(text: str) -> Path | None:
    try:
        return _fmu(text)
    except MissingFileError:
        return None


def add_variator(parser: argparse.ArgumentParser, default: str | None = "bench168", *names: str) -> None:
    """`--variator`, also under other names."""
    shown = f" [default: {default or 'start values of the FMU'}]"
    parser.add_argument("--variator", *names, default=default, metavar="NAME", help=VARIATOR + shown)


def add_set(parser: argparse.ArgumentParser, what: str = "value of a parameter") -> None:
    text = f"{what}, in SI units; enumerations by name; can be repeated"
    parser.add_argument("--set", type=assignment, action="append", default=[], metavar="NAME=VALUE", help=text)


def add_ring(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--ring", "--model", choices=list(RingModel.__members__), default="ALE", help="ring model [default: ALE]")


def add_short(parser: argparse.ArgumentParser, what: str) -> None:
    parser.add_argument("--short", action="store_true", help=f"a first look: {what}")


def add_study(parser: argparse.ArgumentParser) -> None:
    """Options of a study: its variator, where its tasks are solved, and whether stored ones are used."""
    add_variator(parser)
    add_ring(parser)
    add_set(parser)
    parser.add_argument("--workers", type=count, metavar="N", help="processes of this machine [default: one per processor]")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of dask, tcp://host:port [default: a cluster of this machine]")
    parser.add_argument("--anew", action="store_true", help="discard what an earlier run has stored")
    parser.add_argument("--measure", action="store_true", help="only measure the time; nothing stored is used")


def add_sensitivities(parser: argparse.ArgumentParser) -> None:
    """Options of studies: standard deviations and derivatives at each point."""
    text = "add standard deviations of outputs by those of the parameter set, in thirty times the time, of maps in fifteen times"
    parser.add_argument("--bands", action="store_true", help=text)
    text = "add derivatives of outputs over parameters, inputs, ratio, torque, speed and force"
    parser.add_argument("--gradient", type=names, default=(), metavar="NAME,…", help=text)
    parser.add_argument("--hold", choices=list(HELD), help="what they keep [default: ratio, or given forces]")


def add_material(parser: argparse._ActionsContainer, *safety: str) -> None:
    """Strength of the ring's steel; `safety` are other names of `--stress-safety`."""
    for one in fields(Material):
        in_mpa = one.metadata["range"][2] == " MPa"
        value: float = getattr(Material, one.name)
        kind, default = (stress, 1e-6 * value) if in_mpa else (float, value)
        names = ["--stress-safety", *safety] if one.name == "safety" else [f"--{one.name}"]
        text = f"{one.metadata['help']} [default: {default:g}]"
        parser.add_argument(*names, type=kind, default=value, metavar=kind.__name__.upper(), help=text)


def material(options: argparse.Namespace) -> Material:
    return Material(**{one.name: getattr(options, "stress_safety" if one.name == "safety" else one.name) for one in fields(Material)})


def add_reading(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """How a table is read; returns the group of these options."""
    group = parser.add_argument_group("how the table is read")
    example = "such as --map i=ratio.geometric, --map n_P=\"primary.speed [rpm]\", --map T_P=-primary.torque or --map i=1/ratio.speed"
    text = f"what a column is, {example}; can be repeated"
    mapped = partial(assignment, form="title=name", empty=False)
    group.add_argument("--map", type=mapped, action="append", default=[], metavar="TITLE=NAME", help=text)
    group.add_argument("--decimal", choices=DECIMAL, metavar="SIGN", help="point or comma [default: what the whole file shows]")
    group.add_argument("--sheet", metavar="NAME", help="sheet of an .xlsx file [default: the one with most known columns]")
    text = "of a text file, such as shift_jis, gbk, euc_kr or cp1251 [default: UTF-8, what its first bytes say, or cp1252]"
    group.add_argument("--encoding", metavar="NAME", help=text)
    return group


def reading(options: argparse.Namespace) -> Reading:
    """Choices of the command line, of how a table is read."""
    as_written = getattr(options, "as_written", False)
    return Reading(DECIMAL.get(options.decimal), dict(options.map), options.sheet, options.encoding, as_written)


def numbers(text: str) -> tuple[float, ...]:
    """`A,B,…`, or `LOW:HIGH:N`: N values, evenly spaced. Raises ValueError for another text."""
    if ":" not in text:
        return tuple(float(number) for number in text.split(","))
    low, high, number = text.split(":")
    if not 2 <= int(number) <= MOST_NUMBERS:
        raise ValueError(f"there are 2 to {MOST_NUMBERS} values in a range")
    return tuple(np.linspace(float(low), float(high), int(number)).tolist())


def sensitivities(options: argparse.Namespace) -> tuple[dict[str, float], Asked]:
    """Standard deviations of parameters, and derivatives, of these options."""
    return known_deviations(options.variator) if options.bands else {}, Asked(options.gradient, options.hold)


def names(text: str) -> tuple[str, ...]:
    return tuple(dict.fromkeys(filter(None, map(str.strip, text.split(",")))))


def assignment(text: str, form: str = "NAME=VALUE", empty: bool = True) -> tuple[str, str]:
    name, separator, value = (part.strip() for part in text.partition("="))
    if not separator or not name or not (value or empty):
        raise argparse.ArgumentTypeError(f"{text} is not of the form {form}")
    return name, value


def quantity(dimension: str, default: str, example: str) -> Callable[[str], float]:
    """Reads a number in the unit `default`, or with its unit. Returns it in SI units."""

    def read(text: str) -> float:
        found = re.fullmatch(r"\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*(\S*)\s*", text)
        unit = units.find(found[2] or default, dimension) if found else None
        if found is None or unit is None:
            raise argparse.ArgumentTypeError(f"{text} is not a {dimension} such as {example}")
        return unit.si(float(found[1]))

    return read


def stress(text: str) -> float:
    """A stress in MPa, or with its unit; in Pa."""
    return quantity("stress", "MPa", "2000, 2000MPa or 2GPa")(text)


def count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text} is not a whole number above 0")
    return int(text)
