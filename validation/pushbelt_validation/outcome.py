"""Parts of a section as plain data: checks with their sources, tables, charts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from pushbelt.report.charts import Chart, Series
from pushbelt.report.page import MINUS, number
from pushbelt.report.style import BLUE, GREEN, INK, MUTED, ORANGE, RED, VIOLET
from pushbelt.tables import title

Value = float | str | None

NOTHING = "no point was solved"
FEW = 3
"""Largest number of listed values outside a goal."""
COLOURS = (BLUE, ORANGE, GREEN, RED, VIOLET, INK, MUTED)
DASHES = {"-": "", "--": "dash", ":": "dot"}
MARKERS = {"o": ("circle", 6.0), ".": ("circle", 7.0), "x": ("x-thin-open", 7.0), "_": ("line-ew-open", 14.0)}


class Part(Enum):
    """Part of the report."""

    VERIFICATION = "verification"
    ELEMENTS = "single elements"
    MEASUREMENTS = "measurements"
    STEPS = "steps"


class Verdict(Enum):
    """Result of the comparison of values of the model with their goal."""

    MET = "met"
    MISSED = "missed"
    REPORTED = "reported"


@dataclass(frozen=True)
class Source:
    """Source of a goal."""

    text: str
    certainty: str
    """Certainty: measured, fitted, read in an abstract, or an engineering value."""


@dataclass(frozen=True)
class Check:
    """A statement, its goal, the result of the model, and the verdict."""

    key: str
    """Name in the pinned results."""
    statement: str
    source: Source
    goal: str
    found: str
    verdict: Verdict
    by: str = ""
    """Deviation from the goal if it is missed."""
    used: float | None = None
    """Distance of the worst value from the goal, over the tolerance: above 1 the goal is missed. None without a tolerance."""

    @property
    def miss(self) -> float:
        """Distance of the worst value beyond the goal, in tolerances; at least 1 for a point without a steady state; 0 if the goal is met."""
        return 0.0 if self.verdict is not Verdict.MISSED else self.used - 1.0 if self.used is not None and self.used > 1.0 else 1.0


def signed(value: float) -> str:
    """A number with its sign, for names."""
    return f"{value:+g}".replace("-", MINUS)


def reported(key: str, statement: str, source: Source, goal: str, found: str) -> Check:
    """A value that is reported for comparison, without a goal."""
    return Check(key, statement, source, goal, found, Verdict.REPORTED)


@dataclass(frozen=True)
class Unit:
    """Format of the numbers of a check."""

    name: str = ""
    digits: int = 2
    scale: float = 1.0
    """Factor from the value to the shown number."""

    def show(self, value: float) -> str:
        """The value as text, without the unit's name."""
        return number(self.scale * value, self.digits)

    def text(self, *values: float) -> str:
        """One value, or the least and the greatest of several, with the unit's name."""
        if not values:
            return NOTHING
        shown = list(dict.fromkeys(self.show(value) for value in (min(values), max(values))))
        return " to ".join(shown) + (f"\N{NO-BREAK SPACE}{self.name}" if self.name else "")


PERCENT = Unit("%", 1, 100.0)
POINTS = Unit("points", 2, 100.0)
PLAIN = Unit()


def within(
    key: str,
    statement: str,
    source: Source,
    values: Iterable[tuple[str, float | None]],
    low: float | None,
    high: float | None,
    unit: Unit = PLAIN,
    goal: str | None = None,
    tolerance: float | None = None,
) -> Check:
    """Check that all named values are within the limits, if there are any. Values outside are listed, worst first. The
    value None is from a point without a steady state and misses the goal. `tolerance` measures misses: by default half the width between
    the limits, or the size of a single one."""
    pairs = list(values)
    solved = [(name, value) for name, value in pairs if value is not None and not math.isnan(value)]
    missing = [name for name, value in pairs if value is None or math.isnan(value)]
    found = unit.text(*(value for _, value in solved)) + (f", {len(solved)} values" if len(solved) > 2 else "")

    def beyond(value: float) -> float:
        return max(low - value if low is not None else -math.inf, value - high if high is not None else -math.inf)

    outside = sorted((pair for pair in solved if beyond(pair[1]) > 0.0), key=lambda pair: -beyond(pair[1]))
    by = []
    if outside:
        named = "; ".join(f"{name}: {unit.text(value)}" for name, value in outside[:FEW])
        by.append(f"{len(outside)} of {len(pairs)} outside, by up to {unit.text(beyond(outside[0][1]))}: {named}")
    if missing:
        by.append(f"{len(missing)} of {len(pairs)} without a steady state: {'; '.join(missing[:FEW])}")
    verdict = Verdict.MET if solved and not by else Verdict.MISSED
    tolerance = tolerance or (0.5 * (high - low) if low is not None and high is not None else abs(low or high or 0.0))
    used = max((max(1.0 + beyond(value) / tolerance, 0.0) for _, value in solved), default=None) if tolerance else None
    return Check(key, statement, source, goal or _limits(low, high, unit), found, verdict, ". ".join(by), used)


def _limits(low: float | None, high: float | None, unit: Unit) -> str:
    if low is None or high is None:
        sign, limit = ("≤", high) if low is None else ("≥", low)
        return f"{sign} {unit.text(limit)}" if limit is not None else ""
    return f"±{unit.text(high)}" if low == -high else unit.text(low, high)


SPELLED = {"N·m": "N.m", "points": "1", "of 4": "1", "1e-6": "1"}
"""Spelling in files of the units of columns whose values are in that unit."""
UNSCALED = {
    "": "1", "%": "1", "points": "1", "1e-6": "1", "kN": "N", "mm": "m", "mrad": "rad", "°": "rad",
}  # fmt: skip
"""Units of the values of columns that are shown with a factor."""


@dataclass(frozen=True)
class Column:
    """A column of a table."""

    name: str
    unit: str = ""
    digits: int = 3
    scale: float = 1.0
    """Factor from SI to the shown unit; CSV files contain SI values."""
    signed: bool = False

    def show(self, value: Value) -> str:
        """A value as text."""
        if value is None or isinstance(value, str):
            return value or "–"
        if math.isnan(value):
            return "–"
        shown = number(self.scale * value, self.digits)
        return f"+{shown}" if self.signed and not shown.startswith(MINUS) else shown

    @property
    def written(self) -> str:
        """Unit of the values themselves, which CSV files have."""
        return UNSCALED[self.unit] if self.scale != 1.0 else SPELLED.get(self.unit, self.unit)

    @property
    def heading(self) -> str:
        """Name and unit."""
        return f"{self.name} ({self.unit})" if self.unit else self.name


def share(name: str, digits: int = 1, signed: bool = True) -> Column:
    """A column of shares, shown in per cent."""
    return Column(name, "%", digits, 100.0, signed)


@dataclass(frozen=True)
class Table:
    """A table of the report, also written as CSV."""

    key: str
    """Name of its CSV file."""
    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Value, ...], ...]
    note: str = ""

    @property
    def titles(self) -> list[str]:
        """Titles of the columns in the CSV file."""
        numeric = [any(isinstance(row[place], float) for row in self.rows) for place in range(len(self.columns))]
        pairs = zip(self.columns, numeric, strict=True)
        return [title(column.name, column.written) if number else column.name for column, number in pairs]

    def shown(self) -> list[list[str]]:
        """All rows as text."""
        return [[column.show(value) for column, value in zip(self.columns, row, strict=True)] for row in self.rows]


def table(key: str, title: str, columns: Sequence[Column], rows: Iterable[Sequence[Value]], note: str = "") -> Table:
    """Creates a table from any sequences."""
    return Table(key, title, tuple(columns), tuple(tuple(row) for row in rows), note)


def curve(name: str, x: Sequence[float], y: Sequence[float | None], colour: int = 0, style: str = "-", **more: Any) -> Series:
    """A line or points of a panel. `style` is `-`, `--` or `:` for a line, `o`, `.`, `x` or `_` for points, or both together."""
    dash = "--" if "--" in style else style.strip("ox._")
    marker, size = MARKERS.get(style.strip("-:"), ("", 6.0))
    values = np.array(y, dtype=float)
    kind = "line" if dash else "points"
    return Series(name, x, values, COLOURS[colour % len(COLOURS)], kind, dash=DASHES.get(dash, ""), marker=marker, size=size, **more)


@dataclass(frozen=True)
class Section:
    """A section of the report."""

    key: str
    part: Part
    title: str
    lead: str
    checks: tuple[Check, ...] = ()
    tables: tuple[Table, ...] = ()
    charts: tuple[Chart, ...] = ()
    """The label of a chart is its caption."""
    notes: tuple[str, ...] = ()
    failures: tuple[str, ...] = ()
    """Points without a steady state, with the FMU's reasons."""
