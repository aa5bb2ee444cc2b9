"""The user's table: CSV with a unit in each header and one point per line. Errors are reported by line and column."""

from __future__ import annotations

import csv
import difflib
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

RPM = math.pi / 30.0


class TableError(ValueError):
    """The table cannot be used. The message contains line, column and value."""


@dataclass(frozen=True)
class Column:
    """A column that a table may have."""

    units: Mapping[str, float]
    """Factor to SI by unit name."""
    low: float
    """Least plausible value, SI."""
    high: float
    """Largest, SI."""
    meaning: str


@dataclass(frozen=True)
class Quantity(Column):
    """A column that is measured and compared with the model."""

    absolute: float
    """Default standard deviation, SI: the root of the sum of squares of this value …"""
    relative: float
    """… and this share of the measured value."""

    def assumed(self, value: float) -> float:
        """Default standard deviation, SI."""
        return math.hypot(self.absolute, self.relative * value)


ONE, SHARE, RATE = {"1": 1.0}, {"1": 1.0, "%": 0.01}, {"1/s": 1.0}
FORCE, SPEED = {"N": 1.0, "kN": 1e3}, {"rad/s": 1.0, "rpm": RPM}

CONDITIONS: Mapping[str, Column] = {
    "ratio.geometric": Column(ONE, 0.1, 10.0, "r_S/r_P, above 1 is underdrive"),
    "ratio.speed": Column(ONE, 0.1, 10.0, "primary speed/secondary speed, in place of ratio.geometric"),
    "primary.speed": Column(SPEED, 1.0, 2000.0, "speed of the primary pulley"),
    "primary.torque": Column({"N.m": 1.0}, -5000.0, 5000.0, "torque on the primary shaft, negative in overrun"),
    "secondary.clampingForce": Column(FORCE, 100.0, 1e6, "clamping force of the secondary pulley"),
    "primary.clampingForce": Column(
        FORCE,
        100.0,
        1e6,
        "clamping force of the primary pulley; needed for a shift rate, else it gives the thrust ratio",
    ),
}
QUANTITIES: Mapping[str, Quantity] = {
    "thrustRatio": Quantity(ONE, 0.05, 20.0, "primary force/secondary force that holds the ratio", 0.0, 0.01),
    "slip": Quantity(SHARE, -0.5, 0.5, "1 - secondary speed/primary speed * ratio.geometric", 5e-4, 0.05),
    "efficiency": Quantity(SHARE, 0.01, 1.0, "driven power/driving power", 3e-3, 0.0),
    "di/dt": Quantity(RATE, -100.0, 100.0, "shift rate, i = ratio.geometric", 0.01, 0.05),
    "ds/dt": Quantity(RATE, -100.0, 100.0, "shift rate, s = 1/ratio.geometric", 0.01, 0.05),
}
SHIFTS = ("di/dt", "ds/dt")
"""Quantities of a point whose ratio changes."""
REQUIRED = ("primary.speed", "primary.torque", "secondary.clampingForce")
NAME, DEVIATION = "name", ".sd"
"""Name of the column with names of points, and suffix of a column with standard deviations."""


@dataclass(frozen=True)
class Measured:
    """A measured value."""

    quantity: str
    value: float
    """SI."""
    deviation: float
    """Standard deviation, SI."""
    given: bool
    """Whether the standard deviation is from the table."""


@dataclass(frozen=True)
class Point:
    """A line of the table in SI units."""

    line: int
    name: str
    ratio: float | None
    """Geometric ratio r_S/r_P."""
    speed_ratio: float | None
    """Speed ratio; exactly one of the two ratios is specified."""
    speed: float
    """Primary speed, rad/s."""
    torque: float
    """Torque on the primary shaft, N·m."""
    force: float
    """Secondary clamping force, N."""
    primary_force: float | None
    """Primary clamping force, N; only where a shift rate was measured."""
    measured: tuple[Measured, ...]

    @property
    def shifting(self) -> bool:
        """Whether a shift rate was measured, so that the ratio changes."""
        return self.primary_force is not None


@dataclass(frozen=True)
class _Head:
    """A column of a table as its header describes it."""

    title: str
    name: str
    deviation: bool
    factor: float

    def number(self, line: int, text: str) -> float:
        """The number of a cell, SI."""
        try:
            value = float(text)
        except ValueError:
            hint = "; a number has a decimal point" if "," in text else ""
            raise TableError(f"line {line}, column {self.title}: '{text}' is not a number{hint}") from None
        column = {**CONDITIONS, **QUANTITIES}[self.name]
        low, high = (0.0, column.high - column.low) if self.deviation else (column.low, column.high)
        found = value * self.factor
        if not low <= found <= high or (self.deviation and found == 0.0):
            allowed = f"{low / self.factor:.6g} to {high / self.factor:.6g}"
            above = "above " if self.deviation else ""
            raise TableError(f"line {line}, column {self.title}: {text} is not within {above}{allowed}")
        return found


def _head(title: str) -> _Head | None:
    """Parses a header. Returns None for the column of names and for remarks."""
    match = re.fullmatch(r"([^\[\]]*?)\s*(?:\[\s*([^\]]*?)\s*\])?", title)
    if match is None:
        raise TableError(f"line 1, column {title}: a header is a name and a unit, like primary.speed [rpm]")
    written, unit = match.groups()
    if written == NAME or written.startswith("#"):
        return None
    name = written.removesuffix(DEVIATION)
    deviation = name != written
    columns = {**CONDITIONS, **QUANTITIES} if not deviation else QUANTITIES
    if name not in columns:
        known = [NAME, *CONDITIONS, *QUANTITIES, *(name + DEVIATION for name in QUANTITIES)]
        near = difflib.get_close_matches(written, known, 1, 0.5)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise TableError(
            f"column {title}: no such column{hint} There are {', '.join(known)}; a column whose header starts with # is "
            "left out"
        )
    units = columns[name].units
    if unit is None:
        if "1" not in units:
            raise TableError(f"column {title}: no unit; write {' or '.join(f'{name} [{unit}]' for unit in units)}")
        unit = "1"
    if unit not in units:
        raise TableError(f"column {title}: the unit is one of {', '.join(units)}")
    return _Head(title, name, deviation, units[unit])


def _heads(titles: list[str]) -> list[_Head | None]:
    heads = [_head(title.strip()) for title in titles]
    keys = [(head.name, head.deviation) for head in heads if head is not None]
    for key in keys:
        if keys.count(key) > 1:
            raise TableError(f"column {key[0]}{DEVIATION if key[1] else ''} appears twice")
    names = {name for name, deviation in keys if not deviation}
    missing = [name for name in REQUIRED if name not in names]
    if not names & {"ratio.geometric", "ratio.speed"}:
        missing.insert(0, "ratio.geometric or ratio.speed")
    if missing:
        raise TableError(f"there is no column {', '.join(missing)}")
    for name, deviation in keys:
        if deviation and name not in names:
            raise TableError(f"column {name}{DEVIATION}: there is no column {name}")
    return heads


def _point(line: int, name: str, values: Mapping[tuple[str, bool], float]) -> Point | None:
    """The point of a line; None if the line has no measured value."""

    def given(column: str) -> float | None:
        return values.get((column, False))

    measured = {quantity: given(quantity) for quantity in QUANTITIES}
    force, primary_force = given("secondary.clampingForce"), given("primary.clampingForce")
    shifting = [quantity for quantity in SHIFTS if measured[quantity] is not None]
    if primary_force is not None and force is not None and not shifting and measured["thrustRatio"] is None:
        measured["thrustRatio"] = primary_force / force
    found = {quantity: value for quantity, value in measured.items() if value is not None}
    if not found:
        return None
    for column in REQUIRED:
        if given(column) is None:
            raise TableError(f"line {line}, column {column}: the cell is empty")
    if (given("ratio.geometric") is None) == (given("ratio.speed") is None):
        raise TableError(f"line {line}: exactly one of ratio.geometric and ratio.speed is required")
    if shifting:
        if len(found) > 1:
            raise TableError(f"line {line}: with {shifting[0]} the ratio moves, so no other quantity is allowed")
        for column in ("primary.clampingForce", "ratio.geometric"):
            if given(column) is None:
                raise TableError(f"line {line}, column {column}: {shifting[0]} requires a value, but the cell is empty")
    return Point(
        line,
        name or f"line {line}",
        given("ratio.geometric"),
        given("ratio.speed"),
        *(values[column, False] for column in REQUIRED),
        primary_force if shifting else None,
        tuple(
            Measured(
                quantity,
                value,
                values.get((quantity, True), QUANTITIES[quantity].assumed(value)),
                (quantity, True) in values,
            )
            for quantity, value in found.items()
        ),
    )


def parse(text: str) -> list[Point]:
    """Points of a table. Empty lines, lines that start with #, and points without a measured value are skipped."""
    lines = [(k, line) for k, line in enumerate(text.splitlines(), 1) if line.strip(" ,;\t") and line.strip()[0] != "#"]
    if not lines:
        raise TableError("the table is empty")
    delimiter = ";" if ";" in lines[0][1] else ","
    rows = [(k, [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter))]) for k, line in lines]
    heads = _heads(rows[0][1])
    titles = [title.strip() for title in rows[0][1]]
    points = []
    for line, cells in rows[1:]:
        if len(cells) > len(heads):
            raise TableError(f"line {line} has {len(cells)} cells, but the header has {len(heads)}")
        values = {
            (head.name, head.deviation): head.number(line, cell)
            for head, cell in zip(heads, cells, strict=False)
            if head is not None and cell
        }
        name = next((cell for title, cell in zip(titles, cells, strict=False) if title == NAME), "")
        point = _point(line, name, values)
        if point is not None:
            points.append(point)
    if not points:
        raise TableError(f"nothing is measured: no line has a value of {', '.join(QUANTITIES)}")
    return points


def read(path: Path) -> list[Point]:
    """Points of a file. Raises TableError, with the file's name."""
    try:
        return parse(path.read_text(encoding="utf-8-sig"))
    except UnicodeDecodeError as error:
        raise TableError(f"{path}: the file is not text in UTF-8") from error
    except (TableError, OSError) as error:
        raise TableError(f"{path}: {error.strerror if isinstance(error, OSError) else error}") from error


EXAMPLES = (
    ("underdrive", 2, 1500, 60, 14, "", 1.05, 0.8, "", "", ""),
    ("ratio 1", 1, 2000, 50, 9, "", 1.37, "", 0.05, 97.1, ""),
    ("overdrive", 0.5, 2000, 40, 10, 18.1, "", 0.3, 0.05, "", ""),
    ("upshift", 1, 1000, 0, 20, 26, "", "", "", "", 0.45),
)
"""Template of a table."""


def template() -> str:
    """Text of the template: every column with its meaning, and example lines."""
    header = (
        "name,ratio.geometric,primary.speed [rpm],primary.torque [N.m],secondary.clampingForce [kN],"
        "primary.clampingForce [kN],thrustRatio,slip [%],slip.sd [%],efficiency [%],ds/dt [1/s]"
    )
    return "\n".join(
        (
            "# Table for `cargo fmu calibrate`: one steady point per line. Replace the lines below the header.",
            "# Empty cells are allowed. Unused columns can be removed, and their order is free.",
            *_described("Conditions", CONDITIONS),
            *_described("Measured quantities, any of", QUANTITIES),
            f"# {' ' * 4}….sd: standard deviation of a measured column; the default is an assumed one",
            header,
            *(",".join(map(str, line)) for line in EXAMPLES),
            "",
        )
    )


def _described(title: str, columns: Mapping[str, Column]) -> Iterable[str]:
    yield f"# {title}:"
    for name, column in columns.items():
        yield f"# {' ' * 4}{name} [{' or '.join(column.units)}]: {column.meaning}".replace(",", ";")
