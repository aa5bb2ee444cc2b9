"""What a rig's table measures: steady points, or recorded shifts. Errors are reported by line and column, all at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..fmu.data import pitch_radius
from . import plausible, series, units
from . import sheet as sheets
from .columns import (
    CHANNELS, COLUMNS, CONDITIONS, EXAMPLES, HIGHEST, MEASURED, NAME, PARTS, POWER, QUANTITIES, RECORDED, REQUIRED, SERIES, TIME, template,
)  # fmt: skip
from .faults import Fault, TableError, grouped
from .measured import SAMPLED, SHIFTS, Measured, Point, Record
from .sheet import Reading, Sheet
from .titles import DEVIATION

__all__ = [
    "CONDITIONS", "EXAMPLES", "MEASURED", "QUANTITIES", "Measured", "Oil", "Point", "Reading", "Record", "Rig", "TableError", "read", "template",
]  # fmt: skip

AGREE = 0.05
"""Relative difference below which a geometric ratio and n_P/n_S are the same ratio."""
UNLIKELY = 0.5
"""Share of values with a fault above which the whole column has it."""


@dataclass(frozen=True)
class Oil:
    """Forces of the cylinders of a parameter set from oil pressures, F = p A + F₀ − k z + c ω², as in the FMU without its seals."""

    parameters: Mapping[str, float] = field(default_factory=dict)
    """Values by name: those of `primary.cylinder` and `secondary.cylinder`, and with a stiff spring the geometry."""

    def of(self, pulley: str, name: str) -> float:
        """A parameter of the cylinder of a pulley, 0 if it is not given."""
        return self.parameters.get(f"{pulley}.cylinder.{name}", 0.0)

    def forces(self, pulley: str, pressures: np.ndarray, speeds: np.ndarray, ratios: np.ndarray) -> np.ndarray:
        """Forces of a cylinder, N, at pressures in Pa, speeds in rad/s and geometric ratios. What does not act is not needed."""
        found = pressures * self.of(pulley, "area") + self.of(pulley, "springForce")
        if self.of(pulley, "centrifugal"):
            found = found + self.of(pulley, "centrifugal") * speeds**2
        if self.of(pulley, "springStiffness"):
            found = found - self.of(pulley, "springStiffness") * np.array([self._position(pulley, ratio) for ratio in ratios])
        return found

    def _position(self, pulley: str, ratio: float) -> float:
        """Position of a movable sheave, 2 tanβ (r − r(1)), m."""
        if not ratio > 0.0:
            return math.nan
        radius = pitch_radius(self.parameters, ratio) * (ratio if pulley == "secondary" else 1.0)
        return 2.0 * math.tan(self.parameters["geometry.wedgeAngle"]) * (radius - pitch_radius(self.parameters, 1.0))


@dataclass(frozen=True)
class Rig:
    """A table with what it measures."""

    sheet: Sheet
    points: list[Point]
    remarks: list[str]
    """What was computed from other columns, and warnings."""

    @property
    def recorded(self) -> bool:
        """Whether the table has recorded shifts."""
        return any(isinstance(point, Record) for point in self.points)


def read(path: Path, reading: Reading | None = None, oil: Oil | None = None) -> Rig:
    """Points or recorded shifts of a file; a time series gives a point for each plateau.

    Raises TableError with all faults of the file, or with what cannot be on a variator, and the errors of the file system.
    """
    reading, oil = reading or Reading(), oil or Oil()
    try:
        sheet = sheets.read(path, COLUMNS, reading)
    except OSError as error:
        raise TableError(f"{path}: {error.strerror or error}") from error
    if SERIES not in sheet.taken and not sheet.faults:
        sheet = series.averaged(sheet, TIME, CHANNELS, NAME)
    points = _Points(sheet, oil)
    rig = points.rig()
    found = plausible.doubts(points.checked, len(sheet))
    if found:
        _doubt(sheet, oil, points.checked, found, rig, reading.as_written)
    rig.remarks.extend(plausible.single_rows(points.checked, sheet.lines))
    return rig


def _doubt(sheet: Sheet, oil: Oil, values: Mapping[str, np.ndarray], found: Mapping[str, str], rig: Rig, as_written: bool) -> None:
    """Raises TableError with what is not plausible, and how else the columns could be read."""
    others = plausible.plausible(sheet, lambda changed: _Points(changed, oil).computed(), values, found)
    certain = [text for kind, text in found.items() if kind not in plausible.UNCERTAIN]
    if not certain and not others:
        return
    texts = certain or list(found.values())
    if as_written:
        rig.remarks.extend(f"warning: {text}" for text in texts)
        return
    fault = f"not plausible: {'; '.join(texts)}. "
    fault += f"Plausible is: {', or '.join(map(str, others))}. " if others else "No other unit, sign or exchange of a column explains it. "
    raise TableError([Fault(fault + "--as-written takes the table as it is"), *sheet.faults], sheet.path, sheet)


class _Points:
    """Points of a sheet."""

    def __init__(self, sheet: Sheet, oil: Oil) -> None:
        self.sheet, self.oil = sheet, oil
        self.remarks: list[str] = []
        self.values: dict[str, np.ndarray] = dict(sheet.values)
        self.lost: set[int] = set()
        """Rows that are left out because of a computed value."""
        self.checked: dict[str, np.ndarray] = {}

    def computed(self) -> dict[str, np.ndarray]:
        """Columns with those that follow from others, as they are checked: a recorded shift has no thrust ratio."""
        self._forces()
        self._ratios()
        if self._series:
            return {name: values for name, values in self.values.items() if name != "primary.clampingForce"}
        self._computed()
        return self.values

    @property
    def _series(self) -> bool:
        return SERIES in self.sheet.taken and TIME in self.sheet.taken

    def rig(self) -> Rig:
        sheet = self.sheet
        self.checked = self.computed()
        missing = self._missing(RECORDED if self._series else REQUIRED)
        points: list[Point] = []
        if not missing and not sheet.faults:
            points = self._records() if self._series else self._steady()
        if not points and not sheet.faults:
            reasons = "; ".join(grouped(sheet.left_out)[:5])
            what = "nothing is measured: no line has a value of " + ", ".join(QUANTITIES)
            sheet.faults.append(Fault(f"no row can be used: {reasons}" if sheet.left_out else what))
            sheet.left_out.clear()
        sheet.check()
        return Rig(sheet, points, self.remarks)

    # Columns that follow from others

    def _has(self, name: str) -> bool:
        return name in self.values and bool(np.isfinite(self.values[name]).any())

    def _get(self, name: str) -> np.ndarray:
        return self.values.get(name, np.full(len(self.sheet), np.nan))

    def _ratios(self) -> None:
        """The speed ratio from both speeds; agreement of the ratios with each other."""
        if self._has("primary.speed") and self._has("secondary.speed"):
            found = self.values["primary.speed"] / self.values["secondary.speed"]
            if self._has("ratio.speed"):
                self._compared("ratio.speed", found)
            else:
                self.values["ratio.speed"] = found
                self.remarks.append(f"ratio.speed is {self.sheet.title('primary.speed')}/{self.sheet.title('secondary.speed')}")
        if self._has("ratio.geometric") and self._has("ratio.speed"):
            self._compared("ratio.geometric", self.values["ratio.speed"])

    def _compared(self, name: str, speed_ratio: np.ndarray) -> None:
        """Rows whose ratio contradicts the speeds."""
        values = self.values[name]
        # The ratio 1 distinguishes nothing.
        there = np.isfinite(values) & np.isfinite(speed_ratio) & (np.abs(np.log(speed_ratio)) > 2 * AGREE)
        off = np.abs(values / speed_ratio - 1.0)
        bad = there & (off > (AGREE if name == "ratio.speed" else 0.5))
        if not bad.any() or (off[there] > 2 * AGREE).mean() > UNLIKELY:
            return
        for row in np.flatnonzero(bad):
            fault = f"{values[row]:.4g}, but the speeds give {speed_ratio[row]:.4g}"
            self.sheet.faults.append(Fault(fault, int(self.sheet.lines[row]), self.sheet.title(name)))

    def _dropped(self, name: str, bad: np.ndarray, text: Callable[[int], str], title: str) -> None:
        """Rows with a wrong value of a computed column: left out, or a fault of the column if most are wrong."""
        rows, known = np.flatnonzero(bad), np.isfinite(self.values[name])
        if len(rows) > UNLIKELY * known.sum():
            more = f" (and {len(rows) - 1} more rows)" if len(rows) > 1 else ""
            self.sheet.faults.append(Fault(text(int(rows[0])) + more, int(self.sheet.lines[rows[0]]), title))
        else:
            self.sheet.left_out += [Fault(text(int(row)), int(self.sheet.lines[row]), title) for row in rows]
            self.lost.update(rows.tolist())

    def _forces(self) -> None:
        """Clamping forces from oil pressures."""
        for pulley, other in (("secondary", "primary"), ("primary", "secondary")):
            pressure, force = f"{pulley}.pressure", f"{pulley}.clampingForce"
            if not self._has(pressure) or self._has(force):
                continue
            if not self.oil.of(pulley, "area"):
                self.sheet.failed.add(force)
                text = f"a pressure gives no force without the area of the piston: {pulley}.cylinder.area in the parameter set or by --set"
                self.sheet.faults.append(Fault(text, None, self.sheet.title(pressure)))
                continue
            speed = self._get(f"{pulley}.speed")
            turns = self._get("ratio.speed") if self._has("ratio.speed") else self._get("ratio.geometric")
            factor = turns if pulley == "primary" else 1.0 / turns
            speed = np.where(np.isfinite(speed), speed, self._get(f"{other}.speed") * factor)
            ratio = self._get("ratio.geometric")
            found = self.oil.forces(pulley, self.values[pressure], speed, np.where(np.isfinite(ratio), ratio, turns))
            self.values[force], column = found, CONDITIONS[force]
            text = f"the force is {{:.4g}} N, not within {column.low:g} to {column.high:g} N"
            self._dropped(force, (found < column.low) | (found > column.high), lambda row, f=found, t=text: t.format(f[row]), self.sheet.title(pressure))
            self.remarks.append(f"{force} is the force of {pulley}.cylinder at {self.sheet.title(pressure)}")
            if not self.oil.of(pulley, "centrifugal"):
                self.remarks.append(f"warning: {force} is without the centrifugal force of the oil; {pulley}.cylinder.centrifugal adds it")

    def _computed(self) -> None:
        """Slip and efficiency from speeds and torques; efficiency of the overrun."""
        if self._has("ratio.geometric") and self._has("ratio.speed") and not self._has("slip"):
            self.values["slip"] = 1.0 - self.values["ratio.geometric"] / self.values["ratio.speed"]
            self.remarks.append("slip is 1 - ratio.geometric/ratio.speed")
        torque = self._get("primary.torque")
        if self._has("efficiency"):
            found, title = self.values["efficiency"], self.sheet.title("efficiency")
            turned = (found > HIGHEST) & (torque < 0.0)
            if turned.any():
                self.remarks.append(f"{title} above 1 in overrun is inverted in {int(turned.sum())} rows")
            self.values["efficiency"] = found = np.where(turned, 1.0 / found, found)
            factor = self.sheet.taken["efficiency"].scale.factor
            limits = f"is not within {0.01 / factor:g} to {HIGHEST / factor:g}, unless the primary torque has the other sign"
            self._dropped("efficiency", found > HIGHEST, lambda row: f"{found[row] / factor:g} {limits}", title)
            self.values[POWER] = found
        elif self._has("secondary.torque") and self._has("primary.torque"):
            self._efficiency(torque)

    def _efficiency(self, torque: np.ndarray) -> None:
        turns = self._get("ratio.speed")
        turns = np.where(np.isfinite(turns), turns, self._get("ratio.geometric") / (1.0 - self._get("slip")))
        with np.errstate(divide="ignore", invalid="ignore"):
            found = np.abs(self._get("secondary.torque")) / np.abs(torque) / turns
            found = np.where(torque < 0.0, 1.0 / found, found)
        known = np.isfinite(found) & (torque != 0.0)
        if not known.any():
            return
        self.values[POWER] = np.where(known, found, np.nan)
        inside = known & (found > 0.01) & (found <= HIGHEST)
        title = self.sheet.title("secondary.torque")
        self.values["efficiency"] = np.where(inside, found, np.nan)
        self.remarks.append(f"efficiency is |{title}| ω_S/(|{self.sheet.title('primary.torque')}| ω_P), its inverse in overrun")
        if (known & ~inside).any():
            lines = ", ".join(str(line) for line in self.sheet.lines[known & ~inside])
            self.remarks.append(f"warning: the efficiency of lines {lines} would be above 1 and is not used")

    def _missing(self, required: Sequence[str]) -> bool:
        there = set(self.values) | self.sheet.failed
        missing = [name for name in required if name not in there]
        if not self._series and not there & {"ratio.geometric", "ratio.speed"}:
            missing.insert(0, "ratio.geometric or ratio.speed")
        if missing:
            unknown = f"; unknown are {', '.join(self.sheet.ignored)}" if self.sheet.ignored else ""
            self.sheet.faults.append(Fault(f"there is no column {', '.join(missing)}{unknown}"))
        for name in self.sheet.taken:
            base = name.removesuffix(DEVIATION)
            if base != name and base not in self.sheet.taken and base not in self.values:
                self.sheet.faults.append(Fault(f"there is no column {base}", None, self.sheet.title(name)))
        return bool(missing)

    # Steady points

    def _steady(self) -> list[Point]:
        points, empty = [], 0
        for row, line in enumerate(self.sheet.lines):
            if row in self.lost:
                continue
            values = {name: float(column[row]) for name, column in self.values.items() if np.isfinite(column[row])}
            point = self._point(row, int(line), values)
            if isinstance(point, Point):
                points.append(point)
            empty += point is None
        if empty:
            self.remarks.append(f"{empty} rows without a measured value are not used")
        return points

    def _left_out(self, text: str, line: int, name: str | None = None) -> Fault:
        fault = Fault(text, line, self.sheet.title(name) if name is not None else None)
        self.sheet.left_out.append(fault)
        return fault

    def _point(self, row: int, line: int, values: Mapping[str, float]) -> Point | Fault | None:
        """The point of a row; None if nothing is measured in it."""
        measured = {quantity: values[quantity] for quantity in QUANTITIES if quantity in values}
        force, primary_force = values.get("secondary.clampingForce"), values.get("primary.clampingForce")
        shifting = [quantity for quantity in SHIFTS if quantity in measured]
        if primary_force is not None and force is not None and not shifting and "thrustRatio" not in measured:
            measured = {"thrustRatio": primary_force / force, **measured}
            if not QUANTITIES["thrustRatio"].low <= measured["thrustRatio"] <= QUANTITIES["thrustRatio"].high:
                text = f"primary force/secondary force is {measured['thrustRatio']:.4g}, not within 0.05 to 20"
                return self._left_out(text, line, "primary.clampingForce")
        if not measured:
            return None
        ratio, speed_ratio = values.get("ratio.geometric"), values.get("ratio.speed")
        for name in REQUIRED:
            if name not in values:
                return self._left_out("the cell is empty", line, name)
        if ratio is None and speed_ratio is None:
            return self._left_out("neither ratio.geometric nor ratio.speed has a value", line)
        if shifting:
            if len(measured) > 1:
                text = f"with {shifting[0]} the ratio moves, so no other quantity is allowed"
                self.sheet.faults.append(Fault(text, line))
                return self.sheet.faults[-1]
            for name in ("primary.clampingForce", "ratio.geometric"):
                if name not in values:
                    return self._left_out(f"{shifting[0]} requires a value, but the cell is empty", line, name)
        names = self.sheet.texts.get(NAME)
        found = tuple(
            Measured(
                quantity,
                value,
                values.get(quantity + DEVIATION, math.hypot(QUANTITIES[quantity].assumed(value), self._noise(quantity, row, value))),
                quantity + DEVIATION in values,
            )
            for quantity, value in measured.items()
        )
        return Point(
            line,
            (names[row] if names else "") or f"line {line}",
            ratio,
            speed_ratio if ratio is None else None,
            values["primary.speed"],
            values["primary.torque"],
            values["secondary.clampingForce"],
            primary_force if shifting else None,
            found,
        )

    def _noise(self, quantity: str, row: int, value: float) -> float:
        """Standard error of a value that is averaged, or computed from averages."""
        errors = self.sheet.errors
        parts = (quantity,) if quantity in self.sheet.taken else PARTS.get(quantity, ())
        shares = [errors[name][row] / self.sheet.values[name][row] for name in parts if name in errors]
        size = abs(1.0 - value) if quantity == "slip" and quantity not in self.sheet.taken else abs(value)
        return size * math.sqrt(sum(share**2 for share in shares if math.isfinite(share)))

    # Recorded shifts

    def _records(self) -> list[Point]:
        rows: dict[str, list[int]] = {}
        for row, name in enumerate(self.sheet.texts[SERIES]):
            lost = next((column for column in (TIME, *RECORDED) if not np.isfinite(self._get(column)[row])), None)
            if lost is not None and lost not in self.sheet.failed and lost in self.values:
                self._left_out("the cell is empty", int(self.sheet.lines[row]), lost)
            elif lost is None:
                rows.setdefault(name, []).append(row)
        return [point for name, own in rows.items() if (point := self._record(name, own)) is not None]

    def _record(self, name: str, rows: Sequence[int]) -> Record | None:
        times, lines = self._get(TIME)[rows], self.sheet.lines[rows]
        back = np.flatnonzero(np.diff(times) <= 0.0)
        if back.size:
            row = int(back[0]) + 1
            text = f"{times[row]:g} s is not after {times[row - 1]:g} s of the same series"
            self.sheet.faults.append(Fault(text, int(lines[row]), self.sheet.title(TIME)))
            return None
        if len(rows) < 2:
            self._left_out(f"series {name} has one sample, and a shift has at least two", int(lines[0]))
            return None
        columns = [self._get(column)[rows] for column in RECORDED]
        samples = tuple(tuple(float(v) for v in values) for values in zip(times - times[0], *columns, strict=True))
        deviations = self._get(SAMPLED + DEVIATION)[rows]
        measured = tuple(
            Measured(
                SAMPLED,
                sample[5],
                float(deviation) if np.isfinite(deviation) else MEASURED[SAMPLED].assumed(sample[5]),
                bool(np.isfinite(deviation)),
                f"{SAMPLED}@{k}",
                sample[0],
            )
            for k, (sample, deviation) in enumerate(zip(samples, deviations, strict=True))
            if k
        )
        _, speed, torque, primary_force, force, ratio = samples[0]
        title = f"series {name}" if name else f"line {lines[0]}"
        return Record(int(lines[0]), title, ratio, None, speed, torque, force, primary_force, measured, samples=samples)


# Description of a table

SOLUTION = 0.03
"""Processor time of a steady state, s."""
SHIFT_COST, SPEED_RATIO_COST, SAMPLE_COST = 5.0, 2.0, 1.0
"""Cost of a shift rate, of the search for a speed ratio, and of a sample of a recorded shift, in steady states."""


def solving_time(rig: Rig) -> float:
    """Processor time of a solution of all points, s."""
    costs = (
        SAMPLE_COST * len(point.measured) if isinstance(point, Record)
        else SHIFT_COST if point.shifting else SPEED_RATIO_COST if point.ratio is None else 1.0
        for point in rig.points
    )  # fmt: skip
    return SOLUTION * sum(costs)


def understood(rig: Rig) -> list[str]:
    """Lines that describe what a table contains."""
    return [*described(rig.sheet), *(f"  {remark}" for remark in rig.remarks), *_counted(rig)]


def described(sheet: Sheet) -> list[str]:
    """Lines that describe columns, units, and rows that are left out."""
    lines = [f"{sheet.path}: {sheet.source}, decimal {sheet.decimal}"]
    for name, one in sheet.taken.items():
        unit = f" [{one.unit}]" if one.unit else ""
        if name not in sheet.values:
            lines.append(f"  {one.title}: {name}")
            continue
        values = sheet.values[name][np.isfinite(sheet.values[name])]
        preferred = units.PREFERRED.get(one.column.dimension, ("1",))[0]
        extent = f"{values.min():.5g} to {values.max():.5g} {preferred}" if values.size else "no values"
        lines.append(f"  {one.title}: {one.turned}{name}{unit}, {values.size} values, {extent}")
    if sheet.ignored:
        lines.append(f"  ignored: {', '.join(sheet.ignored)}")
    lines += [f"  {remark}" for remark in sheet.remarks]
    lines += [f"  left out: {text}" for text in grouped(sheet.left_out)]
    return lines


def _counted(rig: Rig) -> list[str]:
    if rig.recorded:
        samples = sum(len(point.measured) for point in rig.points)
        return [f"  {len(rig.points)} shifts with {samples} samples after the first ones"]
    found = {quantity: sum(m.quantity == quantity for p in rig.points for m in p.measured) for quantity in QUANTITIES}
    counts = ", ".join(f"{count} {quantity}" for quantity, count in found.items() if count)
    return [f"  {len(rig.points)} points: {counts}"]
