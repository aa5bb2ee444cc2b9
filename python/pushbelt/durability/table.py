"""The table of outputs: CSV in SI units with the names of the FMU's outputs. Errors are reported by line and column."""

from __future__ import annotations

import csv
import hashlib
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pushbelt.fmu.geometry import Array

PULLEYS = ("primary", "secondary")
AMPLITUDE, MEAN = "ring.stressAmplitude.{}", "ring.stressMean.{}"
FIELD = "profile.ringStress"
BACK = 1.0
"""Largest decrease of the distance in a step, m: a car that rolls back at a standstill."""
GAP = 10.0
"""A step longer than this multiple of the median step is a gap."""


class DurabilityError(ValueError):
    """The table cannot be used. The message has line, column and value."""


@dataclass(frozen=True)
class Column:
    """A column that is read."""

    low: float
    high: float
    unit: str
    meaning: str


STRESS = Column(-1e11, 1e11, "Pa", "stress along the ring")
STRESSES: Mapping[str, Column] = {
    **{AMPLITUDE.format(p): Column(0.0, 1e11, "Pa", f"stress amplitude on the {p} pulley") for p in PULLEYS},
    **{MEAN.format(p): Column(-1e11, 1e11, "Pa", f"mean stress on the {p} pulley") for p in PULLEYS},
}
TIME, SPEED = Column(-1e9, 1e9, "s", "time"), Column(-500.0, 500.0, "m/s", "speed of the ring")
DISTANCE = Column(0.0, 1e10, "m", "distance driven since the start")
OPTIONAL: Mapping[str, Column] = {
    "ratio.geometric": Column(0.01, 100.0, "1", "ratio r_S/r_P"),
    "primary.shaftTorque": Column(-1e6, 1e6, "N.m", "torque of the belt on the primary pulley"),
    "primary.torque": Column(-1e6, 1e6, "N.m", "torque on the primary shaft"),
    **{f"{p}.radius": Column(0.001, 10.0, "m", f"running radius on the {p} pulley") for p in PULLEYS},
}


@dataclass(frozen=True)
class Table:
    """A run, in SI units."""

    path: Path
    columns: Mapping[str, Array]
    lines: Array
    """Line of each row in the file."""
    field: Array | None
    """Stress along the ring, shape (rows, places), if it is counted; otherwise the outputs of both pulleys are used."""
    identity: str
    """SHA-256 of the file."""

    def __getitem__(self, name: str) -> Array:
        return self.columns[name]

    @property
    def name(self) -> str:
        """Name of the run."""
        return f"{self.path.parent.name}/{self.path.stem}" if self.path.parent.name else self.path.stem

    @property
    def duration(self) -> float:
        """s."""
        return float(self["time"][-1] - self["time"][0])

    @property
    def distance(self) -> float | None:
        """Distance driven, m; None without that column."""
        return float(self["distance"][-1] - self["distance"][0]) if "distance" in self.columns else None

    @property
    def torque(self) -> Array | None:
        """Torque with which the primary shaft drives the belt, N·m; None if the table has none."""
        if "primary.shaftTorque" in self.columns:
            return -self["primary.shaftTorque"]
        return self.columns.get("primary.torque")

    def error(self, row: int, column: str, text: str) -> DurabilityError:
        """An error in a cell."""
        return DurabilityError(f"{self.path}, line {self.lines[row]:.0f}, column {column}: {text}")


def read(path: Path, kilometres: bool = True, profile: bool = False) -> Table:
    """Reads a table. With `kilometres` it must have the column distance. With `profile`, or without the outputs of the cycles, the
    stress along the ring is read.

    Raises DurabilityError for the first problem, and OSError if the file cannot be read.
    """
    data = path.read_bytes()
    try:
        rows = csv.reader(data.decode("utf-8-sig").splitlines())
        header = [name.strip() for name in next(rows, [])]
        cells = [(rows.line_num, row) for row in rows if row]
    except (UnicodeDecodeError, csv.Error) as error:
        raise DurabilityError(f"{path} is not a table in CSV: {error}") from error
    wanted, places = _wanted(path, header, kilometres, profile)
    for line, row in cells:
        if len(row) != len(header):
            raise DurabilityError(f"{path}, line {line}: {len(row)} cells below {len(header)} names")
    if len(cells) < 2:
        raise DurabilityError(f"{path}: {len(cells)} rows below the header; a run has at least 2")
    values = {
        name: np.array([_number(path, line, name, column, row[header.index(name)]) for line, row in cells])
        for name, column in wanted.items()
    }
    field = np.column_stack([values.pop(name) for name in places]) if places else None
    lines = np.array([line for line, _ in cells], dtype=float)
    table = Table(path, values, lines, field, hashlib.sha256(data).hexdigest())
    _check_course(table)
    return table


def _wanted(path: Path, header: list[str], kilometres: bool, profile: bool) -> tuple[dict[str, Column], list[str]]:
    """The columns to read by name, and those of the stress along the ring in their order."""
    for name in header:
        if name and header.count(name) > 1:
            raise DurabilityError(f"{path}, line 1, column {name}: it appears {header.count(name)} times")
    found = [name for name in header if re.fullmatch(re.escape(FIELD) + r"\[\d+\]", name)]
    places = [f"{FIELD}[{k}]" for k in range(1, len(found) + 1)]
    counted = profile or (bool(found) and not any(name in header for name in STRESSES))
    required = {"time": TIME, "ring.speed": SPEED}
    required |= dict.fromkeys(places or [f"{FIELD}[1]"], STRESS) if counted else STRESSES
    missing = [f"{name} ({one.meaning}, {one.unit})" for name, one in required.items() if name not in header]
    if missing:
        raise DurabilityError(f"{path}, line 1: no column {', '.join(missing)}")
    if counted and len(places) < 8:
        raise DurabilityError(f"{path}, line 1: {len(places)} columns {FIELD}[…]; a closed loop has at least 8 places")
    if kilometres and "distance" not in header:
        raise DurabilityError(
            f"{path}, line 1: no column distance ({DISTANCE.meaning}, {DISTANCE.unit}), which a life in kilometres needs; "
            "--hours gives the life in hours"
        )
    optional = {name: column for name, column in {**OPTIONAL, "distance": DISTANCE}.items() if name in header}
    return required | optional, places if counted else []


def _number(path: Path, line: int, name: str, column: Column, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if math.isnan(value):
        raise DurabilityError(f"{path}, line {line}, column {name}: '{text}' is not a number")
    if not column.low <= value <= column.high:
        allowed = f"{column.low:g} to {column.high:g} {column.unit}"
        raise DurabilityError(f"{path}, line {line}, column {name}: {text} is not within {allowed}")
    return value


def _check_course(table: Table) -> None:
    """Times ascend without a gap, and the distance does not jump back."""
    time = table["time"]
    steps = np.diff(time)
    if (steps <= 0.0).any():
        row = int(np.argmax(steps <= 0.0)) + 1
        raise table.error(row, "time", f"{time[row]:g} s is not after {time[row - 1]:g} s")
    longest = GAP * float(np.median(steps))
    if (steps > longest).any():
        row = int(np.argmax(steps > longest)) + 1
        text = f"{time[row]:g} s is {steps[row - 1]:g} s after the row before; a gap is longer than {longest:g} s"
        raise table.error(row, "time", text + f", {GAP:g} times the median step")
    if table.distance is not None:
        back = np.diff(table["distance"]) < -BACK
        if back.any():
            row = int(np.argmax(back)) + 1
            text = f"{table['distance'][row]:g} m is below the {table['distance'][row - 1]:g} m of the row before"
            raise table.error(row, "distance", text)
        if table.distance <= 0.0:
            raise table.error(len(time) - 1, "distance", "no distance is driven, so there is no life in kilometres")
