"""The table of outputs: in SI units or with units in its header, with the names of the FMU's outputs. Errors are reported by line and column."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pushbelt.errors import PushbeltError
from pushbelt.fmu.geometry import Array
from pushbelt.tables import sheet as sheets
from pushbelt.tables import split
from pushbelt.tables.faults import TableError
from pushbelt.tables.names import Column
from pushbelt.tables.sheet import Sheet

PULLEYS = ("primary", "secondary")
AMPLITUDE, MEAN = "ring.stressAmplitude.{}", "ring.stressMean.{}"
FIELD = "profile.ringStress"
BACK = 1.0
"""Largest decrease of the distance in a step, m: a car that rolls back at a standstill."""
GAP = 10.0
"""A step longer than this multiple of the median step is a gap."""


class DurabilityError(PushbeltError, ValueError):
    """The table cannot be used. The message has line, column and value."""


STRESS = Column("stress", -1e11, 1e11, "stress along the ring", (), "Pa")
STRESSES: Mapping[str, Column] = {
    **{AMPLITUDE.format(p): Column("stress", 0.0, 1e11, f"stress amplitude on the {p} pulley", (), "Pa") for p in PULLEYS},
    **{MEAN.format(p): Column("stress", -1e11, 1e11, f"mean stress on the {p} pulley", (), "Pa") for p in PULLEYS},
}
DISTANCE = Column("length", 0.0, 1e10, "distance driven since the start", (), "m")
COLUMNS: Mapping[str, Column] = {
    "time": Column("time", -1e9, 1e9, "time", (), "s"),
    "ring.speed": Column("velocity", -500.0, 500.0, "speed of the ring", (), "m/s"),
    **STRESSES,
    "distance": DISTANCE,
    "ratio.geometric": Column("ratio", 0.01, 100.0, "ratio r_S/r_P"),
    "primary.shaftTorque": Column("torque", -1e6, 1e6, "torque of the belt on the primary pulley", (), "N.m"),
    "primary.torque": Column("torque", -1e4, 1e4, "torque on the primary shaft", (), "N.m"),
    **{f"{p}.radius": Column("length", 0.001, 10.0, f"running radius on the {p} pulley", (), "m") for p in PULLEYS},
}
"""Columns that are read. Those without a unit are in SI units."""


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

    Raises DurabilityError for faults of the file, and OSError if the file cannot be read.
    """
    try:
        sheet = sheets.read(path, COLUMNS, misspelled=False)
        field = [title for title in sheet.ignored if re.fullmatch(re.escape(FIELD) + r"\[\d+\]", split(title)[0])]
        places = [f"{FIELD}[{k}]" for k in range(1, len(field) + 1)]
        counted = profile or (bool(field) and not any(name in sheet.taken for name in STRESSES))
        required = ["time", "ring.speed", *((places or [f"{FIELD}[1]"]) if counted else STRESSES)]
        if counted:
            sheet = sheets.read(path, {**COLUMNS, **dict.fromkeys(places, STRESS)}, misspelled=False)
        sheet.check()
    except TableError as error:
        raise DurabilityError(str(error)) from error
    _complete(path, sheet, required, places if counted else None, kilometres)
    unused = set() if not counted else set(STRESSES)
    values = {name: column for name, column in sheet.values.items() if name not in unused}
    along = np.column_stack([values.pop(name) for name in places]) if counted else None
    identity = hashlib.sha256(path.read_bytes()).hexdigest()
    table = Table(path, values, sheet.lines.astype(float), along, identity)
    _check_course(table)
    return table


def _complete(path: Path, sheet: Sheet, required: list[str], places: list[str] | None, kilometres: bool) -> None:
    """Checks that the required columns are there, and that each row has all values."""
    known = {**COLUMNS, f"{FIELD}[1]": STRESS}
    missing = [
        f"{name} ({known[name].meaning}, {known[name].default or '1'})" for name in required if name not in sheet.taken
    ]
    if missing:
        raise DurabilityError(f"{path}, line 1: no column {', '.join(missing)}")
    if places is not None and len(places) < 8:
        raise DurabilityError(f"{path}, line 1: {len(places)} columns {FIELD}[…]; a closed loop has at least 8 places")
    if kilometres and "distance" not in sheet.taken:
        raise DurabilityError(
            f"{path}, line 1: no column distance ({DISTANCE.meaning}, {DISTANCE.default}), which a life in kilometres needs; "
            "--hours gives the life in hours"
        )
    if sheet.left_out:
        raise DurabilityError(f"{path}, {sheet.left_out[0]}")
    for name, column in sheet.values.items():
        empty = np.isnan(column)
        if empty.any():
            raise DurabilityError(f"{path}, line {sheet.lines[np.argmax(empty)]}, column {name}: the cell is empty")
    if len(sheet) < 2:
        raise DurabilityError(f"{path}: {len(sheet)} rows below the header; a run has at least 2")


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
