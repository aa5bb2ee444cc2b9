"""Types and options of command lines that several programs have."""

from __future__ import annotations

import argparse
import re

from .fmu.enumerations import RingModel
from .rig import units


def numbers(text: str) -> tuple[float, ...]:
    """Comma-separated numbers."""
    return tuple(float(number) for number in text.split(","))


def assignment(text: str) -> tuple[str, float]:
    """`name=value`."""
    name, separator, value = text.partition("=")
    if not separator:
        raise argparse.ArgumentTypeError(f"{text} is not of the form name=value")
    return name, float(value)


def stress(text: str) -> float:
    """A stress in MPa, or with its unit: 2000, 2000MPa, 2GPa. Returns it in Pa."""
    found = re.fullmatch(r"\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*(\S*)\s*", text)
    unit = units.find(found[2] or "MPa", "stress") if found else None
    if found is None or unit is None:
        raise argparse.ArgumentTypeError(f"{text} is not a stress such as 2000, 2000MPa or 2GPa")
    return unit.si(float(found[1]))


def count(text: str) -> int:
    """A whole number above 0."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text} is not a whole number above 0")
    return int(text)


def add_cluster(parser: argparse.ArgumentParser) -> None:
    """Adds the options of a program that solves points on a cluster: where, and for which variator."""
    parser.add_argument("--scheduler", metavar="ADDRESS", help="dask scheduler, tcp://host:port [default: a local cluster]")
    parser.add_argument("--workers", type=count, metavar="N", help="processes of the local cluster [default: one per processor]")
    parser.add_argument("--variator", default="bench168", help="name of a parameter set, or a file ….json")
    parser.add_argument("--model", choices=list(RingModel.__members__), default="ALE", help="ring model")
    parser.add_argument("--set", type=assignment, action="append", default=[], metavar="NAME=VALUE", help="a parameter")
