"""Parts of a section of the report as plain data: checks with their sources, tables, figures."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum

from pushbelt.page import MINUS, number
from pushbelt.tables import title

Value = float | str | None

NOTHING = "no point was solved"
FEW = 3
"""Largest number of listed values outside a goal."""


class Verdict(Enum):
    """Result of the comparison of a value of the model with its goal."""

    MEETS = "meets"
    MISSES = "misses"
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

    statement: str
    source: Source
    goal: str
    found: str
    verdict: Verdict
    by: str = ""
    """Deviation from the goal if it is missed."""
    used: float | None = None
    """Distance of the worst value from the goal, over the tolerance: above 1 the goal is missed. None without a tolerance."""


def signed(value: float) -> str:
    """A number with its sign, for names."""
    return f"{value:+g}".replace("-", MINUS)


def reported(statement: str, source: Source, goal: str, found: str) -> Check:
    """A value that is reported for comparison, without a goal."""
    return Check(statement, source, goal, found, Verdict.REPORTED)


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
PLAIN = Unit()


def within(
    statement: str,
    source: Source,
    values: Iterable[tuple[str, float | None]],
    low: float | None,
    high: float | None,
    unit: Unit = PLAIN,
    goal: str | None = None,
) -> Check:
    """Check that all named values are within the limits, if there are any. Values outside are listed, worst first.

    The value None is from a point without a steady state and misses the goal.
    """
    pairs = list(values)
    solved = [(name, value) for name, value in pairs if value is not None and not math.isnan(value)]
    missing = [name for name, value in pairs if value is None or math.isnan(value)]
    found = unit.text(*(value for _, value in solved)) + (f", {len(solved)} values" if len(solved) > 2 else "")

    def beyond(value: float) -> float:
        return max(low - value if low is not None else -1.0, value - high if high is not None else -1.0)

    outside = sorted((pair for pair in solved if beyond(pair[1]) > 0.0), key=lambda pair: -beyond(pair[1]))
    by = []
    if outside:
        named = "; ".join(f"{name}: {unit.text(value)}" for name, value in outside[:FEW])
        by.append(f"{len(outside)} of {len(pairs)} outside, by up to {unit.text(beyond(outside[0][1]))}: {named}")
    if missing:
        by.append(f"{len(missing)} of {len(pairs)} without a steady state: {'; '.join(missing[:FEW])}")
    verdict = Verdict.MEETS if solved and not by else Verdict.MISSES
    used = max((_used(value, low, high) for _, value in solved), default=None) if _tolerance(low, high) else None
    return Check(statement, source, goal or _limits(low, high, unit), found, verdict, ". ".join(by), used)


def _tolerance(low: float | None, high: float | None) -> float:
    """Half the width between the limits, or the size of a single one; 0 if there is none."""
    return 0.5 * (high - low) if low is not None and high is not None else abs(low or high or 0.0)


def _used(value: float, low: float | None, high: float | None) -> float:
    """Share of the tolerance that a value uses, 1 at a limit."""
    beyond = max(low - value if low is not None else -math.inf, value - high if high is not None else -math.inf)
    return max(1.0 + beyond / _tolerance(low, high), 0.0)


def _limits(low: float | None, high: float | None, unit: Unit) -> str:
    if low is None or high is None:
        sign, limit = ("≤", high) if low is None else ("≥", low)
        return f"{sign} {unit.text(limit)}" if limit is not None else ""
    if low == -high:
        return f"±{unit.text(high)}"
    return unit.text(low, high)


SPELLED = {"N·m": "N.m", "points": "1", "of 4": "1", "1e-6": "1"}
"""Spelling in files of the units of columns whose values are in that unit."""
UNSCALED = {
    "": "1", "%": "1", "points": "1", "1e-6": "1", "kN": "N", "MPa": "Pa", "mm": "m", "mrad": "rad", "°": "rad",
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
        return [
            title(column.name, column.written) if number else column.name
            for column, number in zip(self.columns, numeric, strict=True)
        ]

    def shown(self) -> list[list[str]]:
        """All rows as text."""
        return [[column.show(value) for column, value in zip(self.columns, row, strict=True)] for row in self.rows]


def table(key: str, title: str, columns: Sequence[Column], rows: Iterable[Sequence[Value]], note: str = "") -> Table:
    """Creates a table from any sequences."""
    return Table(key, title, tuple(columns), tuple(tuple(row) for row in rows), note)


@dataclass(frozen=True)
class Curve:
    """A line or points of a panel."""

    x: tuple[float, ...]
    y: tuple[float, ...]
    label: str
    """Label in the legend. Curves with the same label are shown and hidden together."""
    colour: int = 0
    """Index of the colour. Related curves have the same one."""
    style: str = "-"
    """`-`, `--` or `:` for a line, `o`, `.`, `x` or `_` for points, `o-` for both."""


@dataclass(frozen=True)
class Panel:
    """A panel of a figure."""

    title: str
    x_label: str
    curves: tuple[Curve, ...]
    log_y: bool = False
    names: tuple[str, ...] = ()
    """Names of rows at y = 0, −1, −2 and so on, for panels with named rows."""
    places: tuple[str, ...] = ()
    """Names of x = 0, 1, 2 and so on, for panels with named columns."""


@dataclass(frozen=True)
class Picture:
    """A figure of several panels."""

    panels: tuple[Panel, ...]
    caption: str


@dataclass(frozen=True)
class Section:
    """A section of the report."""

    key: str
    title: str
    lead: str
    checks: tuple[Check, ...] = ()
    tables: tuple[Table, ...] = ()
    pictures: tuple[Picture, ...] = ()
    notes: tuple[str, ...] = ()
    failures: tuple[str, ...] = ()
    """Points without a steady state, with the FMU's reasons."""
