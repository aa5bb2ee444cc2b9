"""Types and options of command lines that several programs have."""

from __future__ import annotations

import argparse

from .fmu.enumerations import RingModel


def numbers(text: str) -> tuple[float, ...]:
    """Comma-separated numbers."""
    return tuple(float(number) for number in text.split(","))


def assignment(text: str) -> tuple[str, float]:
    """`name=value`."""
    name, separator, value = text.partition("=")
    if not separator:
        raise argparse.ArgumentTypeError(f"{text} is not of the form name=value")
    return name, float(value)


def add_cluster(parser: argparse.ArgumentParser) -> None:
    """Adds the options of a program that solves points on a cluster: where, and for which variator."""
    parser.add_argument("--scheduler", metavar="ADDRESS", help="dask scheduler, tcp://host:port [default: a local cluster]")
    parser.add_argument("--workers", type=int, metavar="N", help="processes of the local cluster [default: one per processor]")
    parser.add_argument("--variator", default="bench168", help="name of a parameter set, or a file ….json")
    parser.add_argument("--model", choices=list(RingModel.__members__), default="ALE", help="ring model")
    parser.add_argument("--set", type=assignment, action="append", default=[], metavar="NAME=VALUE", help="a parameter")
