"""Designs of experiments: any parameters and inputs as a full grid, a Latin hypercube, or a list of points.

Columns that are not varied have these values: ratio 1, utilisation 0.6, 2000 rpm, 12 kN, and the friction of the parameter set. The whole
force, with pressure, spring and rotating oil, gives the torque of a utilisation.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pushbelt.cli.options import numbers
from pushbelt.errors import ArgumentError
from pushbelt.fmu.start_values import SETTABLE, StartValueError, checked
from pushbelt.tables import sheet as sheets
from pushbelt.tables import units
from pushbelt.tables.columns import CONDITIONS
from pushbelt.tables.names import Column
from pushbelt.tables.sheet import Fault, Reading, TableError

from .point import Point

UTILISATION = "utilisation"
AXIS_OF = {
    "ratio": "initial.ratio", "speed": "initial.primarySpeed", "force": "secondary.clampingForce", "friction": "friction.pulley",
    "ratio.geometric": "initial.ratio", "primary.speed": "initial.primarySpeed",
}  # fmt: skip
"""Short names of columns, by which a point is defined."""
OF_RIGS = ("ratio.geometric", "primary.speed", "primary.torque", "primary.clampingForce", "secondary.clampingForce")
"""Columns that may have the names of a rig's table, such as F_S. Its secondary torque has no sign, so it is not among them."""
MOST_POINTS = 1_000_000  # Largest number of points of a design


class Varied(NamedTuple):
    """A varied column: its values, or its range for a Latin hypercube."""

    name: str
    values: tuple[float, ...] = ()
    span: tuple[float, float] | None = None


class Points:
    """Points with values of columns: `initial.ratio`, `utilisation`, parameters and inputs of the FMU, in SI units."""

    columns: tuple[str, ...]
    rows: tuple[tuple[float, ...], ...]

    def __len__(self) -> int:
        return len(self.rows)

    def points(self) -> list[Point]:
        """All points; their places number them."""
        return [dict(zip(self.columns, row, strict=True)) for row in self.rows]

    def check(self, variables: Mapping[str, Any]) -> None:
        """Raises ArgumentError for a column that is no parameter or input of the FMU, or a value out of its range."""
        for number, point in enumerate(self.points(), 1):
            try:
                checked(variables, {name: value for name, value in point.items() if name != UTILISATION}, SETTABLE)
            except StartValueError as error:
                raise ArgumentError(f"point {number} of the design: {error}") from None


@dataclass(frozen=True)
class Design(Points):
    """Points of any columns."""

    kind: str  # `grid`, `Latin hypercube` or `list`
    columns: tuple[str, ...]
    rows: tuple[tuple[float, ...], ...]

    def __post_init__(self) -> None:
        if not self.columns or not self.rows:
            raise ArgumentError("the design has no points")
        if doubled := sorted({name for name in self.columns if self.columns.count(name) > 1}):
            raise ArgumentError(f"{', '.join(doubled)} is in the design twice")
        if {"utilisation", "primary.torque"} <= set(self.columns):
            raise ArgumentError("utilisation and primary.torque determine each other: vary one of them")
        for line, row in enumerate(self.rows, 1):
            if len(row) != len(self.columns) or not all(map(math.isfinite, row)):
                raise ArgumentError(f"point {line} of the design is not complete: {row}")


def varied(text: str) -> Varied:
    """`NAME=A,B,…`, `NAME=LOW:HIGH:N` (N values, evenly spaced) or `NAME=LOW:HIGH` (for a Latin hypercube)."""
    name, _, values = (part.strip() for part in text.partition("="))
    name = AXIS_OF.get(name, name)
    try:
        if values.count(":") != 1:
            return Varied(name, numbers(values))
        low, high = map(float, values.split(":"))
        if low < high:
            return Varied(name, span=(low, high))
    except ValueError:
        pass
    raise ArgumentError(f"--vary {text} is not of the form NAME=A,B,C, NAME=LOW:HIGH:N or, with --samples, NAME=LOW:HIGH")


def crossed(columns: Sequence[Varied], samples: int | None = None, seed: int = 0) -> Design:
    """All combinations of the lists of values. With `samples`, each of them with a Latin hypercube over the ranges."""
    lists, ranges = ([column for column in columns if (column.span is not None) == wanted] for wanted in (False, True))
    if ranges and samples is None:
        raise ArgumentError(f"{ranges[0].name} has a range: add a number of values, LOW:HIGH:N, or --samples")
    if samples is not None and not ranges:
        raise ArgumentError("--samples requires --vary NAME=LOW:HIGH")
    sampled: Sequence[tuple[float, ...]] = [()] if samples is None else _hypercube(ranges, samples, seed)
    if len(sampled) * math.prod(len(column.values) for column in lists) > MOST_POINTS:
        raise ArgumentError(f"the design has more than {MOST_POINTS} points")
    combinations = itertools.product(*(column.values for column in lists))
    rows = tuple((*combination, *sample) for combination in combinations for sample in sampled)
    return Design("grid" if samples is None else "Latin hypercube", tuple(column.name for column in [*lists, *ranges]), rows)


def _hypercube(ranges: Sequence[Varied], samples: int, seed: int) -> list[tuple[float, ...]]:
    """A Latin hypercube: each of `samples` equal intervals of each range has one point."""
    from scipy.stats import qmc

    if samples < 2:
        raise ArgumentError("a Latin hypercube needs at least 2 samples")
    unit = qmc.LatinHypercube(len(ranges), rng=seed).random(samples)
    return list(map(tuple, qmc.scale(unit, *zip(*(column.span for column in ranges if column.span), strict=True)).tolist()))


def listed(path: Path, variables: Mapping[str, Any], reading: Reading | None = None) -> tuple[Design, list[str]]:
    """A list of points from a table with the FMU's names in its header, and remarks on what is not read. Without a unit
    a column is in SI. Raises TableError with all faults of the table, OSError if it cannot be read."""
    sheet = sheets.read(path, _known(variables), reading)
    names = [name for name in sheet.taken if name == UTILISATION or (name in variables and variables[name].causality in SETTABLE)]
    sheet.check()
    if not names:
        raise TableError("no column is a parameter or an input of the FMU", path)
    sheet.faults += [
        Fault("the cell has no value", int(sheet.lines[row]), sheet.title(name))
        for name in names
        for row in np.flatnonzero(np.isnan(sheet.values[name]))
    ]
    sheet.check()
    if not len(sheet):
        raise TableError(sheet.left_out or "there are no points below the header", path)
    rows = tuple(tuple(map(float, row)) for row in np.column_stack([sheet.values[name] for name in names]))
    outputs = [one.title for name, one in sheet.taken.items() if name not in names]
    remarks = [
        *sheet.remarks,
        *(f"column {title} is no parameter or input of the FMU and is not read" for title in [*sheet.ignored, *outputs]),
        *(f"{fault}: the row is left out" for fault in sheet.left_out),
    ]
    return Design("list", tuple(names), rows), remarks


def _known(variables: Mapping[str, Any]) -> dict[str, Column]:
    """Columns that a list of points may have: variables of the FMU and the torque utilisation."""
    aliases: dict[str, list[str]] = {}
    for alias, name in AXIS_OF.items():
        aliases.setdefault(name, []).append(alias)
    for name in OF_RIGS:
        aliases.setdefault(AXIS_OF.get(name, name), []).extend(CONDITIONS[name].aliases)
    found = {UTILISATION: Column("ratio", -math.inf, math.inf, "primary torque over the torque of full slip")}
    for name, variable in variables.items():
        if name not in AXIS_OF and variable.type in ("Real", "Integer", "Boolean", "Enumeration"):
            unit = variable.unit or "1"
            dimension = "pressure" if name.endswith(".pressure") else units.OF_FMU[unit]
            found[name] = Column(dimension, -math.inf, math.inf, variable.description or "", tuple(aliases.get(name, ())), unit)
    return found
