"""The table of outputs by the FMU's names, or a load collective, whose rows have hours. Errors are reported by line and column."""

import hashlib
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from pushbelt.fmu.geometry import Array
from pushbelt.tables import sheet as sheets
from pushbelt.tables import split
from pushbelt.tables.columns import CONDITIONS
from pushbelt.tables.names import Column
from pushbelt.tables.sheet import Sheet, TableError
from pushbelt.tables.units import usual

PULLEYS = ("primary", "secondary")
AMPLITUDE, MEAN = "ring.stressAmplitude.{}", "ring.stressMean.{}"
FIELD = "profile.ringStress"
HOURS = "hours"
BACK = 1.0  # Largest decrease of the distance in a step, m: a car that rolls back at a standstill.
GAP = 10.0  # A step longer than this multiple of the median step is a gap.
STRESS = Column("stress", -1e11, 1e11, "stress along the ring", (), "Pa")
STRESSES: Mapping[str, Column] = {
    **{AMPLITUDE.format(p): Column("stress", 0.0, 1e11, f"stress amplitude on the {p} pulley", (), "Pa") for p in PULLEYS},
    **{MEAN.format(p): Column("stress", -1e11, 1e11, f"mean stress on the {p} pulley", (), "Pa") for p in PULLEYS},
}
COLUMNS: Mapping[str, Column] = {
    "time": Column("time", -1e9, 1e9, "time", (), "s"),
    "ring.speed": Column("velocity", -500.0, 500.0, "speed of the ring", (), "m/s"),
    **STRESSES,
    "distance": Column("length", 0.0, 1e10, "distance driven since the start", (), "m"),
    "ratio.geometric": Column("ratio", 0.01, 100.0, "ratio r_S/r_P"),
    "primary.shaftTorque": Column("torque", -1e6, 1e6, "torque of the belt on the primary pulley", (), "N.m"),
    "primary.torque": Column("torque", -1e4, 1e4, "torque on the primary shaft", (), "N.m"),
    **{f"{p}.radius": Column("length", 0.001, 10.0, f"running radius on the {p} pulley", (), "m") for p in PULLEYS},
}
"""Columns of runs that are read. Those without a unit are in SI units."""
LASTING = Column("time", 0.0, 1e10, "time in the state of the row", ("duration", "Stunden", "Dauer", "heures", "durée"), "h")
POINT = ("ratio.geometric", "primary.torque", "primary.speed", "secondary.clampingForce")  # Columns of a working point
RATIO = replace(CONDITIONS[POINT[0]], aliases=CONDITIONS[POINT[0]].aliases + CONDITIONS["ratio.speed"].aliases)
OF_POINTS: Mapping[str, Column] = {**{name: CONDITIONS[name] for name in POINT}, POINT[0]: RATIO, HOURS: LASTING}
"""Columns of a collective of working points, with the names and units of a rig. A ratio of speeds counts as the geometric one."""
Solve = Callable[[Mapping[str, Array]], dict[str, Array]]  # Outputs in the steady states at columns of working points


class Table:
    """A run, in SI units."""

    def __init__(self, path: Path, columns: Mapping[str, Array], lines: Array, field: Array | None, identity: str) -> None:
        """`lines` of the rows in the file; `field`: stress along the ring, shape (rows, places), if it is counted, otherwise the outputs
        of both pulleys are used; `identity`: SHA-256 of the file."""
        self.path, self.columns, self.lines, self.field, self.identity = path, columns, lines, field, identity
        self.name = f"{path.parent.name}/{path.stem}" if path.parent.name else path.stem
        self.collective = HOURS in columns
        self.solved = False  # Whether its rows are working points that were solved
        half = 0.5 * np.diff(columns["time"])
        # Time that belongs to each row, s: that of a collective, or by the trapezoidal rule.
        self.times = columns[HOURS] if self.collective else np.append(half, 0.0) + np.append(0.0, half)
        self.duration = float(self.times.sum())
        driven = columns.get("distance")
        self.distance = None if driven is None else float(driven[-1] - driven[0])  # m
        # With which the primary shaft drives the belt, N·m.
        self.torque = -columns["primary.shaftTorque"] if "primary.shaftTorque" in columns else columns.get("primary.torque")

    def __getitem__(self, name: str) -> Array:
        return self.columns[name]

    def refuse(self, bad: Array, column: str, why: Callable[[int], str]) -> None:
        """Raises TableError at the first of the rows that are bad in a column; `why` gives the text of a row."""
        if bad.any():
            row = int(np.argmax(bad))
            raise TableError(f"{self.path}, line {self.lines[row]:.0f}, column {column}: {why(row)}")


def read(path: Path, kilometres: bool = True, profile: bool = False, solve: Solve = dict) -> Table:
    """Reads a table. With `kilometres` it must have the column distance, unless it is a collective. With `profile`, or without the outputs of the
    cycles, the stress along the ring is read. A collective without stress is one of working points, which `solve` solves. Raises TableError
    for faults of the file, and OSError if the file cannot be read."""
    known = {**COLUMNS, HOURS: LASTING}
    sheet = sheets.read(path, known, misspelled=False)
    field = [title for title in sheet.ignored if re.fullmatch(re.escape(FIELD) + r"\[\d+\]", split(title)[0])]
    counted = profile or (bool(field) and not any(name in sheet.taken for name in STRESSES))
    places = [f"{FIELD}[{k}]" for k in range(1, len(field) + 1)] if counted else []
    if counted:
        sheet = sheets.read(path, {**known, **dict.fromkeys(places, STRESS)}, misspelled=False)
    points = sheet if counted or sheet.taken.keys() & {"ring.speed", *STRESSES} else sheets.read(path, OF_POINTS, misspelled=False)
    solved = points is not sheet and HOURS in points.taken
    sheet = points if solved else sheet
    sheet.check()
    stresses = (places or [f"{FIELD}[1]"]) if counted else [*STRESSES]
    required = [*POINT] if solved else ["ring.speed", *stresses]
    _complete(sheet, places, counted, [*required, HOURS] if HOURS in sheet.taken else ["time", *required, *["distance"] * kilometres])
    values = {name: column for name, column in sheet.values.items() if not counted or name not in STRESSES}
    along = np.column_stack([values.pop(name) for name in places]) if counted else None
    if HOURS in values:
        values = {**(solve(values) if solved else values), HOURS: values[HOURS], "time": np.cumsum(values[HOURS])}
        values.pop("distance", None)
    table = Table(path, values, sheet.lines.astype(float), along, hashlib.sha256(path.read_bytes()).hexdigest())
    table.solved = solved
    _check_course(table)
    return table


def _complete(sheet: Sheet, places: list[str], counted: bool, required: list[str]) -> None:
    """Checks that the required columns are there, and that each row has all values."""
    text = ""
    if missing := [name for name in required if name not in sheet.taken]:
        known = [(name, {**CONDITIONS, **COLUMNS}.get(name, STRESS)) for name in missing]
        text = ", line 1: no column " + ", ".join(f"{name} ({one.meaning}, {one.default or usual(one.dimension)[0]})" for name, one in known)
        text += "; a life in kilometres needs it, --hours gives the life in hours" * (missing == ["distance"])
    elif counted and len(places) < 8:
        text = f", line 1: {len(places)} columns {FIELD}[…]; a closed loop has at least 8 places"
    elif sheet.left_out:
        text = f", {sheet.left_out[0]}"
    elif empty := next((name for name, column in sheet.values.items() if np.isnan(column).any()), None):
        text = f", line {sheet.lines[np.argmax(np.isnan(sheet.values[empty]))]}, column {empty}: the cell is empty"
    elif len(sheet) < 2 and HOURS not in required:
        text = f": {len(sheet)} rows below the header; a run has at least 2"
    elif HOURS in required and (bad := sheet.values[HOURS] < 0.0).any():
        text = f", line {sheet.lines[np.argmax(bad)]}, column {HOURS}: {sheet.values[HOURS][np.argmax(bad)] / 3600.0:g} h is below 0"
    elif HOURS in required and not sheet.values[HOURS].any():
        text = f", column {HOURS}: the sum is 0"
    if text:
        raise TableError(f"{sheet.path}{text}")


def _check_course(table: Table) -> None:
    """Times ascend without a gap, and the distance does not jump back."""
    if table.collective:
        return
    time = table["time"]
    steps = np.diff(time, prepend=time[0] - 1.0)
    table.refuse(steps <= 0.0, "time", lambda row: f"{time[row]:g} s is not after {time[row - 1]:g} s")
    longest = GAP * float(np.median(steps[1:]))
    text = f"a gap is longer than {longest:g} s, {GAP:g} times the median step"
    gap = np.append(False, steps[1:] > longest)
    table.refuse(gap, "time", lambda row: f"{time[row]:g} s is {steps[row]:g} s after the row before; {text}")
    if table.distance is not None:
        driven = table["distance"]
        back = np.diff(driven, prepend=driven[0]) < -BACK
        table.refuse(back, "distance", lambda row: f"{driven[row]:g} m is below the {driven[row - 1]:g} m of the row before")
        nowhere = (np.arange(len(time)) == len(time) - 1) & (table.distance <= 0.0)
        table.refuse(nowhere, "distance", lambda _: "no distance is driven, so there is no life in kilometres")
