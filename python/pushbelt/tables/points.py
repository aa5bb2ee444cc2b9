"""What a rig's table measures: steady points, or recorded shifts. Errors are reported by line and column, all at once."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ..fmu.closing import closing_force, sheave_position
from ..fmu.geometry import Array
from . import plausible, units
from . import sheet as sheets
from .columns import COLUMNS, CONDITIONS, HIGHEST, MEASURED, NAME, PARTS, POWER, QUANTITIES, RECORDED, REQUIRED, SAMPLED, SERIES, SHIFTS, STEP, SURE, TIME
from .names import DEVIATION, same
from .sheet import MEANT, MOST, Fault, Reading, Sheet, TableError, grouped


@dataclass(frozen=True)
class Measured:
    quantity: str
    value: float  # SI
    deviation: float  # Standard deviation, SI
    given: bool  # Whether the standard deviation is from the table
    key: str = ""  # Name of the model's value; empty if it is the quantity
    time: float | None = None  # Time of a sample, s


@dataclass(frozen=True)
class Point:
    """A working point with measured values, or a recorded shift: its first sample, and the ratios of the later ones as measured values.
    Exactly one of `ratio` and `speed_ratio` is given."""

    line: int
    name: str
    ratio: float | None  # Geometric ratio r_S/r_P
    speed_ratio: float | None  # Primary speed/secondary speed
    speed: float  # Primary speed, rad/s
    torque: float  # Torque on the primary shaft, N·m
    force: float  # Secondary clamping force, N
    primary_force: float | None  # Primary clamping force, N; only in a shift
    measured: tuple[Measured, ...]
    slip: float = 0.0  # Estimate of the model's slip, from which the search for a speed ratio starts
    near: bytes = field(default=b"", repr=False)  # Stored steady state of the model, near which others of this point are sought first
    by_ratio: tuple[float, ...] = ()  # Derivatives of the model's thrust ratio, slip and efficiency with respect to the geometric ratio there
    samples: tuple[tuple[float, float, float, float, float, float], ...] = ()
    """Of a recorded shift: time from the first one in s, primary speed, primary torque, primary force, secondary force, ratio; SI."""

    @property
    def shifting(self) -> bool:
        return self.measured[0].quantity in SHIFTS


@dataclass(frozen=True)
class Rig:
    sheet: Sheet
    points: list[Point]
    values: Mapping[str, Array] = field(default_factory=dict)  # Columns of the sheet and computed ones, SI
    parameters: Mapping[str, float] = field(default_factory=dict)  # Those that give forces from oil pressures

    @property
    def recorded(self) -> bool:
        return any(point.samples for point in self.points)

    @property
    def rows(self) -> list[int]:
        """Rows of the sheet that are the points."""
        places = {int(line): row for row, line in enumerate(self.sheet.lines)}
        return [places[point.line] for point in self.points]

    def changed(self, values: Mapping[str, Array]) -> list[Point]:
        """The steady points with other values of columns, by known name. No row is left out because of them."""
        sheet = replace(self.sheet, values={**self.sheet.values, **values}, faults=[], left_out=[], remarks=[])
        return _Points(sheet, self.parameters, highest=math.inf)._steady()


def read(path: Path, reading: Reading | None = None, parameters: Mapping[str, float] | None = None) -> Rig:
    """Points or recorded shifts of a file; a time series gives a point for each plateau. `parameters` are values by name of
    those that give forces from oil pressures: the cylinders, and with a stiff spring the geometry. Raises TableError with all
    faults of the file, or with what cannot be on a variator, and the errors of the file system."""
    reading, parameters = reading or Reading(), parameters or {}
    try:
        sheet = sheets.read(path, COLUMNS, reading)
    except OSError as error:
        raise TableError(f"{path}: {error.strerror or error}") from error
    if SERIES not in sheet.taken and not sheet.faults:
        from . import series

        sheet = series.averaged(sheet, TIME, STEP, tuple(CONDITIONS), NAME, reading.as_written)
    _add_accuracy(sheet, reading.accuracy)
    points = _Points(sheet, parameters)
    rig = points.rig()
    sheet.remarks += plausible.check(sheet, points.checked, lambda changed: _Points(changed, parameters).checked, reading.as_written)
    return rig


def _add_accuracy(sheet: Sheet, accuracy: Mapping[str, str]) -> None:
    """Standard deviations of columns, where the table has none."""
    for title, text in accuracy.items():
        name = next((name for name, one in sheet.taken.items() if name == title or same(one.title, title)), None)
        if name not in sheet.values or name.endswith(DEVIATION):
            sheet.faults.append(Fault(f"--accuracy {title}={text}: there is no such column of numbers"))
            continue
        size = float(text.removesuffix("%"))
        found = 0.01 * size * np.abs(sheet.values[name]) if text.endswith("%") else np.full(len(sheet), size * sheet.taken[name].scale.factor)
        own = sheet.values.get(name + DEVIATION, np.nan)
        sheet.values[name + DEVIATION] = np.where(np.isfinite(own), own, found)


class _Points:
    def __init__(self, sheet: Sheet, parameters: Mapping[str, float], highest: float = HIGHEST) -> None:
        """`highest` is the largest efficiency, apart from its deviation."""
        self.sheet, self.parameters, self.highest = sheet, parameters, highest
        self.values: dict[str, Array] = dict(sheet.values)
        self.recorded = SERIES in sheet.taken and TIME in sheet.taken
        for pulley, other in (("secondary", "primary"), ("primary", "secondary")):
            if self._has(f"{pulley}.pressure") and not self._has(f"{pulley}.clampingForce"):
                self._force(pulley, other)
        self._ratios()
        self.checked = self.values  # Columns with those that follow from others: a recorded shift has no thrust ratio
        if self.recorded:
            self.checked = {name: values for name, values in self.values.items() if name != "primary.clampingForce"}
        else:
            self._efficiency()

    def rig(self) -> Rig:
        """What is measured. Raises TableError with all faults."""
        sheet = self.sheet
        self._require(RECORDED if self.recorded else REQUIRED)
        points = [] if sheet.faults else self._records() if self.recorded else self._steady()
        if not points and not sheet.faults:
            nothing = "nothing is measured: no line has a value of " + ", ".join(QUANTITIES)
            sheet.faults.append(Fault(f"no row can be used: {'; '.join(grouped(sheet.left_out)[:5])}" if sheet.left_out else nothing))
            sheet.left_out.clear()
        sheet.check()
        return Rig(sheet, points, self.values, self.parameters)

    def _require(self, required: Sequence[str]) -> None:
        there = set(self.values) | self.sheet.failed
        missing = [name for name in required if name not in there]
        if not self.recorded and not there & {"ratio.geometric", "ratio.speed"}:
            missing.insert(0, "ratio.geometric or ratio.speed")
        if missing:
            unknown = f"; unknown are {', '.join(self.sheet.ignored)}" if self.sheet.ignored else ""
            meant = [f"; {remark}" for remark in self.sheet.remarks if remark.startswith(MEANT)]
            self._fault(f"there is no column {', '.join(missing)}{unknown}{''.join(meant)}")
        for name in self.sheet.taken:
            base = name.removesuffix(DEVIATION)
            if base not in self.sheet.taken and base not in self.values:
                self._fault(f"there is no column {base}", None, name)

    def _place(self, text: str, row: int | None, name: str | None) -> Fault:
        """A fault of a row, or of all, in the column of a known name, or in all."""
        return Fault(text, None if row is None else int(self.sheet.lines[row]), None if name is None else self.sheet.title(name))

    def _fault(self, text: str, row: int | None = None, name: str | None = None) -> None:
        self.sheet.faults.append(self._place(text, row, name))

    def _leave_out(self, text: str, row: int, name: str | None = None) -> None:
        self.sheet.left_out.append(self._place(text, row, name))

    def _has(self, *names: str) -> bool:
        return all(bool(np.isfinite(self._get(name)).any()) for name in names)

    def _get(self, name: str, other: Array | float = np.nan) -> Array:
        """A column, and another one where it has no value."""
        found = self.values.get(name)
        return np.full(len(self.sheet), other) if found is None else np.where(np.isfinite(found), found, other)

    def _force(self, pulley: str, other: str) -> None:
        """The clamping force from the oil pressure, F = p A + F₀ − k z + c ω², as in the FMU at rest."""
        pressure, force = f"{pulley}.pressure", f"{pulley}.clampingForce"
        known = self.parameters
        speed: float | Array = 0.0
        place: float | Array = 0.0
        centrifugal = known.get(f"{pulley}.cylinder.centrifugal", 0.0)
        if not known.get(f"{pulley}.cylinder.area", 0.0):
            self.sheet.failed.add(force)
            text = f"a pressure gives no force without the area of the piston: {pulley}.cylinder.area in the parameter set or by --set"
            return self._fault(text, None, pressure)
        turns = self._get("ratio.speed" if self._has("ratio.speed") else "ratio.geometric")
        if centrifugal:
            speed = self._get(f"{pulley}.speed", self._get(f"{other}.speed") * turns ** (1 if pulley == "primary" else -1))
        if known.get(f"{pulley}.cylinder.springStiffness", 0.0):
            place = np.array([sheave_position(known, pulley, ratio) for ratio in self._get("ratio.geometric", turns)])
        found = closing_force({**known, force: 0.0, pressure: self.values[pressure]}, pulley, place, speed)
        limits = CONDITIONS[force]
        self.values[force] = np.where((found >= limits.low) & (found <= limits.high), found, np.nan)
        if (own := self.values.get(pressure + DEVIATION)) is not None:
            self.values.setdefault(force + DEVIATION, known[f"{pulley}.cylinder.area"] * own)
        self.sheet.remarks.append(f"{force} is the force of {pulley}.cylinder at {self.sheet.title(pressure)}")
        if not centrifugal:
            self.sheet.remarks.append(f"warning: {force} is without the centrifugal force of the oil; {pulley}.cylinder.centrifugal adds it")

    def _ratios(self) -> None:
        """The speed ratio from both speeds, and the slip from both ratios."""
        if self._has("primary.speed", "secondary.speed") and not self._has("ratio.speed"):
            self.values["ratio.speed"] = self.values["primary.speed"] / self.values["secondary.speed"]
            self.sheet.remarks.append(f"ratio.speed is {self.sheet.title('primary.speed')}/{self.sheet.title('secondary.speed')}")
        if self._has("ratio.geometric", "ratio.speed") and not self.recorded and not self._has("slip"):
            self.values["slip"] = 1.0 - self.values["ratio.geometric"] / self.values["ratio.speed"]
            self.sheet.remarks.append("slip is 1 - ratio.geometric/ratio.speed")

    def _efficiency(self) -> None:
        """The efficiency of the driving direction, as it is given or from speeds and torques."""
        torque = self._get("primary.torque")
        if self._has("efficiency"):
            found, title = self.values["efficiency"], self.sheet.title("efficiency")
            # Scatter about 1 is not the inverse, unless most of the overrun has it.
            overrun, limit = (torque < 0.0) & np.isfinite(found), HIGHEST + SURE * self._deviations("efficiency", found)
            turned = overrun & (found > (HIGHEST if (found[overrun] > HIGHEST).mean() > MOST else limit)) if overrun.any() else overrun
            if turned.any():
                self.sheet.remarks.append(f"{title} above 1 in overrun is inverted in {int(turned.sum())} rows")
            self.values["efficiency"] = self.values[POWER] = found = np.where(turned, 1.0 / found, found)
            factor = self.sheet.taken["efficiency"].scale.factor
            text = f"is not within {0.01 / factor:g} to {HIGHEST / factor:g} and its deviation, unless the primary torque has the other sign"
            for row in np.flatnonzero(found > limit - HIGHEST + self.highest).tolist():
                self._leave_out(f"{found[row] / factor:g} {text}", row, "efficiency")
            return
        turns = self._get("ratio.speed", self._get("ratio.geometric") / (1.0 - self._get("slip")))
        with np.errstate(divide="ignore", invalid="ignore"):
            found = np.abs(self._get("secondary.torque") / torque) / turns
            found = np.where(torque < 0.0, 1.0 / found, found)
        known = np.isfinite(found) & (torque != 0.0)
        if not known.any():
            return
        inside = known & (found > 0.01) & (found <= self.highest + SURE * self._deviations("efficiency", found))
        self.values[POWER], self.values["efficiency"] = np.where(known, found, np.nan), np.where(inside, found, np.nan)
        one, other = self.sheet.title("secondary.torque"), self.sheet.title("primary.torque")
        self.sheet.remarks.append(f"efficiency is |{one}| ω_S/(|{other}| ω_P), its inverse in overrun")
        if (known & ~inside).any():
            lines = ", ".join(str(line) for line in self.sheet.lines[known & ~inside])
            self.sheet.remarks.append(f"warning: the efficiency of lines {lines} would be above 1 by more than its deviation and is not used")

    def _steady(self) -> list[Point]:
        lost = {fault.line for fault in self.sheet.left_out}
        rows = [row for row, line in enumerate(self.sheet.lines.tolist()) if line not in lost]
        before = len(self.sheet.left_out) + len(self.sheet.faults)
        points = [point for row in rows if (point := self._point(row)) is not None]
        if empty := len(rows) - len(points) - (len(self.sheet.left_out) + len(self.sheet.faults) - before):
            self.sheet.remarks.append(f"{empty} rows without a measured value are not used")
        return points

    def _point(self, row: int) -> Point | None:
        """The point of a row; None if nothing is measured in it, or if it is left out."""
        values = {name: float(column[row]) for name, column in self.values.items() if np.isfinite(column[row])}
        measured = {quantity: values[quantity] for quantity in QUANTITIES if quantity in values}
        shift = next((quantity for quantity in SHIFTS if quantity in measured), None)
        if {"primary.clampingForce", "secondary.clampingForce"} <= values.keys() and shift is None and "thrustRatio" not in measured:
            thrust, limits = values["primary.clampingForce"] / values["secondary.clampingForce"], QUANTITIES["thrustRatio"]
            if not limits.low <= thrust <= limits.high:
                text = f"primary force/secondary force is {thrust:.4g}, not within {limits.low:g} to {limits.high:g}"
                return self._leave_out(text, row, "primary.clampingForce")
            measured = {"thrustRatio": thrust, **measured}
        if not measured:
            return None
        if absent := [name for name in REQUIRED if name not in values]:
            return self._leave_out("the cell is empty", row, absent[0])
        if not values.keys() & {"ratio.geometric", "ratio.speed"}:
            return self._leave_out("neither ratio.geometric nor ratio.speed has a value", row)
        if shift and len(measured) > 1:
            return self._fault(f"with {shift} the ratio moves, so no other quantity is allowed", row)
        if shift and (absent := [name for name in ("primary.clampingForce", "ratio.geometric") if name not in values]):
            return self._leave_out(f"{shift} requires a value, but the cell is empty", row, absent[0])
        line, ratio = int(self.sheet.lines[row]), values.get("ratio.geometric")
        speed, torque, force = (values[name] for name in REQUIRED)
        return Point(
            line, self.sheet.texts.get(NAME, {row: ""})[row] or f"line {line}", ratio, values.get("ratio.speed") if ratio is None else None,
            speed, torque, force, values["primary.clampingForce"] if shift else None,
            tuple(Measured(quantity, value, *self._deviation(quantity, row, value)) for quantity, value in measured.items()),
        )  # fmt: skip

    def _deviations(self, quantity: str, values: Array) -> Array:
        return np.array([self._deviation(quantity, row, value)[0] for row, value in enumerate(values.tolist())])

    def _deviation(self, quantity: str, row: int, value: float) -> tuple[float, bool]:
        """Standard deviation of a value, and whether it follows from the table: its own one, or to first order those of the columns from which it is
        computed; else the assumed one with the standard error of averaged values."""
        known = {name: float(column[row]) for name, column in self.values.items() if name.endswith(DEVIATION) and column[row] > 0.0}
        if quantity + DEVIATION in known:
            return known[quantity + DEVIATION], True
        sheet, parts = self.sheet, self._parts(quantity)
        size = abs(1.0 - value) if quantity == "slip" and parts != [quantity] else abs(value)
        values = {name: abs(float(sheet.values.get(name, self.values[name])[row])) for name in parts}
        slopes = {name: 1.0 if name == quantity else size / one for name, one in values.items() if one or name == quantity}
        errors = [slope * float(sheet.errors[name][row]) for name, slope in slopes.items() if name in sheet.errors]
        own = [slope * known[name + DEVIATION] for name, slope in slopes.items() if name + DEVIATION in known]
        return math.hypot(0.0 if own else MEASURED[quantity].assumed(value), *own, *filter(math.isfinite, errors)), bool(own)

    def _parts(self, quantity: str) -> list[str]:
        """Columns of which a column is a product or quotient, or the column itself."""
        if quantity == "ratio.speed" and quantity not in self.values:
            quantity = "ratio.geometric"
        if quantity in self.sheet.taken or quantity not in PARTS:
            return [quantity] * (quantity in self.values)
        return [part for name in PARTS[quantity] for part in self._parts(name)]

    def _records(self) -> list[Point]:
        rows: dict[str, list[int]] = {}
        for row, name in enumerate(self.sheet.texts[SERIES]):
            lost = next((column for column in (TIME, *RECORDED) if not np.isfinite(self.values[column][row])), None)
            if lost is None:
                rows.setdefault(name, []).append(row)
            else:
                self._leave_out("the cell is empty", row, lost)
        return [point for name, own in rows.items() if (point := self._record(name, own)) is not None]

    def _record(self, name: str, rows: Sequence[int]) -> Point | None:
        times, line = self._get(TIME)[rows], int(self.sheet.lines[rows[0]])
        back = np.flatnonzero(np.diff(times) <= 0.0)
        if back.size:
            text = f"{times[back[0] + 1]:g} s is not after {times[back[0]]:g} s of the same series"
            return self._fault(text, rows[back[0] + 1], TIME)
        if len(rows) < 2:
            return self._leave_out(f"series {name} has one sample, and a shift has at least two", rows[0])
        samples = tuple(map(tuple, np.column_stack([times - times[0], *(self._get(column)[rows] for column in RECORDED)]).tolist()))
        deviations = [self._deviation(SAMPLED, row, one[5]) for row, one in zip(rows, samples, strict=True)]
        measured = tuple(Measured(SAMPLED, one[5], *deviations[k], f"{SAMPLED}@{k}", one[0]) for k, one in enumerate(samples) if k)
        _, speed, torque, primary_force, force, ratio = samples[0]
        title = f"series {name}" if name else f"line {line}"
        return Point(line, title, ratio, None, speed, torque, force, primary_force, measured, samples=samples)


def understood(rig: Rig) -> list[str]:
    """Lines that describe what a table contains."""
    if rig.recorded:
        counted = f"{len(rig.points)} shifts with {sum(len(point.measured) for point in rig.points)} samples after the first ones"
    else:
        found = [measured.quantity for point in rig.points for measured in point.measured]
        counts = ", ".join(f"{found.count(quantity)} {quantity}" for quantity in QUANTITIES if quantity in found)
        counted = f"{len(rig.points)} points: {counts}"
    return [*described(rig.sheet), f"  {counted}"]


def described(sheet: Sheet) -> list[str]:
    """Lines that describe columns, units, and rows that are left out."""
    lines = [f"{sheet.path}: {sheet.source}, decimal {sheet.decimal}"]
    for name, one in sheet.taken.items():
        if name not in sheet.values:
            lines.append(f"  {one.title}: {name}")
            continue
        values = sheet.values[name][np.isfinite(sheet.values[name])]
        extent = f"{values.min():.5g} to {values.max():.5g} {units.usual(one.column.dimension)[0]}" if values.size else "no values"
        unit = f" [{one.unit}]" if one.unit else ""
        lines.append(f"  {one.title}: {one.turned}{name}{unit}, {values.size} values, {extent}")
    return [*lines, *(f"  {note}" for note in notes(sheet))]


def notes(sheet: Sheet) -> list[str]:
    """What is ignored, assumed and left out of a table."""
    ignored = [f"ignored: {', '.join(sheet.ignored)}"] * bool(sheet.ignored)
    return [*ignored, *sheet.remarks, *(f"left out: {text}" for text in grouped(sheet.left_out))]
