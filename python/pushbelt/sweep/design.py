"""Designs of experiments: any parameters and inputs as a full grid, a Latin hypercube, or a list of points.

Columns that are not varied have these values: ratio 1, utilisation 0.6, 2000 rpm, 12 kN, and the friction of the parameter set.
"""

from __future__ import annotations

import csv
import itertools
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pushbelt.fmu.data import torque_capacity
from pushbelt.fmu.enumerations import Axial, Drive
from pushbelt.fmu.start_values import SETTABLE, StartValueError, checked

from .point import Point, start_values

STANDARD = {
    "initial.ratio": 1.0,
    "utilisation": 0.6,
    "initial.primarySpeed": 209.44,
    "secondary.clampingForce": 12e3,
}
"""Values of the axes that a design does not vary."""
AXIS_OF = {
    "ratio": "initial.ratio",
    "speed": "initial.primarySpeed",
    "force": "secondary.clampingForce",
    "friction": "friction.pulley",
    "ratio.geometric": "initial.ratio",
    "primary.speed": "initial.primarySpeed",
}
"""Short names of columns, by which a point is defined."""
CONDITIONS: Mapping[str, Mapping[str, float]] = {
    "primary.clampingForce": {"primary.axial": Axial.FORCE.value, "initial.equilibrium": True},
    "primary.speedSetpoint": {"primary.drive": Drive.SPEED.value},
    "secondary.torque": {"secondary.drive": Drive.TORQUE.value},
}
"""Boundary conditions under which an input acts: a varied primary force determines the ratio, for example."""
UNITS = {
    "rpm": math.pi / 30.0,
    "1/min": math.pi / 30.0,
    "kN": 1e3,
    "N": 1.0,
    "mm": 1e-3,
    "um": 1e-6,
    "µm": 1e-6,
    "MPa": 1e6,
    "GPa": 1e9,
    "%": 1e-2,
    "deg": math.pi / 180.0,
    "kNm": 1e3,
    "Nm": 1.0,
    "N·m": 1.0,
}
"""Units of columns besides those of the FMU, in SI units."""
MOST_POINTS = 1_000_000
"""Largest number of points of a design."""


class DesignError(ValueError):
    """A design that cannot be solved: an unknown column, a value out of range, or too many points."""


@dataclass(frozen=True)
class Varied:
    """A varied column: its values, or its range for a Latin hypercube."""

    name: str
    values: tuple[float, ...] = ()
    span: tuple[float, float] | None = None


@dataclass(frozen=True)
class DesignPoint:
    """A point of a design: values of the varied columns."""

    index: int
    values: Mapping[str, float]


@dataclass(frozen=True)
class Design:
    """Points with values of any columns: `initial.ratio`, `utilisation`, parameters and inputs of the FMU, in SI units."""

    kind: str
    """`grid`, `Latin hypercube` or `list`."""
    columns: tuple[str, ...]
    rows: tuple[tuple[float, ...], ...]

    def __post_init__(self) -> None:
        if not self.columns or not self.rows:
            raise DesignError("the design has no points")
        doubled = sorted({name for name in self.columns if self.columns.count(name) > 1})
        if doubled:
            raise DesignError(f"{', '.join(doubled)} is in the design twice")
        if {"utilisation", "primary.torque"} <= set(self.columns):
            raise DesignError("utilisation and primary.torque determine each other: vary one of them")
        for line, row in enumerate(self.rows, 1):
            if len(row) != len(self.columns) or not all(map(math.isfinite, row)):
                raise DesignError(f"point {line} of the design is not complete: {row}")

    def __len__(self) -> int:
        return len(self.rows)

    def points(self) -> list[DesignPoint]:
        """All points by index."""
        return [DesignPoint(k, dict(zip(self.columns, row, strict=True))) for k, row in enumerate(self.rows)]

    def check(self, variables: Mapping[str, Any]) -> None:
        """Raises DesignError for a column that is no parameter or input of the FMU, or a value out of its range."""
        for point in self.points():
            known = {name: value for name, value in point.values.items() if name != "utilisation"}
            try:
                checked(variables, known, SETTABLE)
            except StartValueError as error:
                raise DesignError(f"point {point.index + 1} of the design: {error}") from None


def full_values(parameters: Mapping[str, float], point: DesignPoint) -> dict[str, float]:
    """All start values of a point, by FMU variable. The torque follows from the point's own geometry."""
    given = point.values
    axes = {**STANDARD, "friction.pulley": parameters.get("friction.pulley", 0.0), **given}
    defined = {*STANDARD, "friction.pulley"}
    own = {**parameters, **{name: value for name, value in given.items() if name not in defined}}
    law = Point(
        point.index,
        ratio=axes["initial.ratio"],
        utilisation=axes["utilisation"],
        friction=axes["friction.pulley"],
        speed=axes["initial.primarySpeed"],
        force=axes["secondary.clampingForce"],
    )
    values = {**own, **start_values(own, law)}
    for name, condition in CONDITIONS.items():
        if name in given:
            values |= condition
    return values | {name: given[name] for name in given if name not in defined}


def utilisation_of(values: Mapping[str, float]) -> float:
    """Torque utilisation of start values."""
    return values["primary.torque"] / torque_capacity(values, values["initial.ratio"], values["secondary.clampingForce"])


# Reading


def varied(text: str) -> Varied:
    """`NAME=A,B,…`, `NAME=LOW:HIGH:N` (N values, evenly spaced) or `NAME=LOW:HIGH` (for a Latin hypercube)."""
    name, separator, values = (part.strip() for part in text.partition("="))
    name = AXIS_OF.get(name, name)
    try:
        if not separator:
            raise ValueError(f"{text} is none of the forms")
        numbers = [float(part) for part in re.split("[:,]", values)]
        if ":" not in values:
            return Varied(name, tuple(numbers))
        low, high, *count = numbers
        if "," in values or len(count) > 1 or not low < high:
            raise ValueError(f"{text} is none of the forms")
        if not count:
            return Varied(name, span=(low, high))
        if count[0] != int(count[0]) or count[0] < 2:
            raise ValueError(f"{text} is none of the forms")
        steps = int(count[0]) - 1
        return Varied(name, tuple(low + (high - low) * k / steps for k in range(steps + 1)))
    except ValueError:
        raise DesignError(
            f"--vary {text} is not of the form NAME=A,B,C, NAME=LOW:HIGH:N or, with --samples, NAME=LOW:HIGH"
        ) from None


def crossed(columns: Sequence[Varied], samples: int | None = None, seed: int = 0) -> Design:
    """All combinations of the lists of values. With `samples`, each of them with a Latin hypercube over the ranges."""
    lists = [column for column in columns if column.span is None]
    ranges = [column for column in columns if column.span is not None]
    if ranges and samples is None:
        raise DesignError(f"{ranges[0].name} has a range: add a number of values, LOW:HIGH:N, or --samples")
    if samples is not None and not ranges:
        raise DesignError("--samples requires --vary NAME=LOW:HIGH")
    sampled: Sequence[tuple[float, ...]] = [()] if samples is None else _hypercube(ranges, samples, seed)
    if len(sampled) * math.prod(len(column.values) for column in lists) > MOST_POINTS:
        raise DesignError(f"the design has more than {MOST_POINTS} points")
    rows = tuple(
        (*combination, *sample)
        for combination in itertools.product(*(column.values for column in lists))
        for sample in sampled
    )
    kind = "grid" if samples is None else "Latin hypercube"
    return Design(kind, tuple(column.name for column in [*lists, *ranges]), rows)


def _hypercube(ranges: Sequence[Varied], samples: int, seed: int) -> list[tuple[float, ...]]:
    """A Latin hypercube: each of `samples` equal intervals of each range has one point."""
    from scipy.stats import qmc

    if samples < 2:
        raise DesignError("a Latin hypercube needs at least 2 samples")
    unit = qmc.LatinHypercube(len(ranges), rng=seed).random(samples)
    low, high = zip(*(column.span for column in ranges if column.span), strict=True)
    return [tuple(float(value) for value in row) for row in qmc.scale(unit, low, high)]


def listed(path: Path, variables: Mapping[str, Any]) -> Design:
    """A list of points from a CSV file with the FMU's names in its header; a unit may follow: `primary.speed [rpm]`. Default: SI."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        lines = [line for line in csv.reader(file) if any(cell.strip() for cell in line)]
    if len(lines) < 2:
        raise DesignError(f"{path} needs a header and at least one point")
    columns, scales = zip(*(_header(path, cell, variables) for cell in lines[0]), strict=True)
    rows = []
    for number, line in enumerate(lines[1:], 2):
        try:
            rows.append(tuple(scale * float(cell) for scale, cell in zip(scales, line, strict=True)))
        except ValueError:
            raise DesignError(f"{path}, line {number}: {','.join(line)} is not {len(columns)} numbers") from None
    return Design("list", columns, tuple(rows))


def _header(path: Path, cell: str, variables: Mapping[str, Any]) -> tuple[str, float]:
    name, _, unit = cell.strip().rstrip("]").partition("[")
    name, unit = name.strip(), unit.strip()
    name = AXIS_OF.get(name, name)
    own = variables[name].unit if name in variables else "1"
    if unit in ("", own) or (unit in ("1", "-") and own in (None, "1")):
        return name, 1.0
    if unit not in UNITS:
        raise DesignError(f"{path}: the unit {unit} of {name} is unknown; known are {own}, {', '.join(UNITS)}")
    return name, UNITS[unit]
