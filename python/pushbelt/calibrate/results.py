"""Results of a calibration: the fit and its table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from pushbelt.tables.columns import MEASURED
from pushbelt.tables.points import Measured, Point

from .fit import Fit
from .model import Value


@dataclass(frozen=True)
class Effort:
    """Computing effort."""

    solves: int
    """Points solved."""
    seconds: float
    """Wall-clock time."""


@dataclass(frozen=True)
class Row:
    """A measured value with the model's, SI."""

    point: Point
    measured: Measured
    before: float | None
    """Model value at the start values; None without a steady state."""
    after: float | None
    reason: str | None
    """Reason for a missing steady state after the fit."""
    kept: bool
    """Whether the fit contains it; it does not contain outliers."""

    @property
    def residual(self) -> float | None:
        """Model minus measurement after the fit."""
        return None if self.after is None else self.after - self.measured.value

    @property
    def relative(self) -> float | None:
        """Model minus measurement after the fit, in standard deviations."""
        return None if self.residual is None else self.residual / self.measured.deviation


@dataclass(frozen=True)
class Results:
    """Data for report and files."""

    table: str
    """Name of the table's file."""
    version: str
    """Version of the FMU."""
    variator: str
    """Parameter set of the start values."""
    base: Mapping[str, float]
    """Values of the parameter set, with the additional settings."""
    points: tuple[Point, ...]
    values: tuple[Value, ...]
    fit: Fit
    effort: Effort
    notes: tuple[str, ...] = ()
    """What was computed, ignored or left out of the table."""

    @cached_property
    def rows(self) -> list[Row]:
        """All measured values, in the order of the table."""
        return [
            Row(
                self.points[value.point],
                value.measured,
                value.of(self.fit.before),
                value.of(self.fit.after),
                self.fit.after[value.point].reason,
                kept,
            )
            for value, kept in zip(self.values, self.fit.kept, strict=True)
        ]

    @property
    def lost(self) -> list[Row]:
        """One row for each point without a steady state after the fit."""
        return list({row.point.line: row for row in self.rows if row.reason is not None}.values())

    @property
    def outliers(self) -> list[Row]:
        """For each row or sample of the table that was left out, its value with the largest residual."""
        found: dict[tuple[int, float | None], Row] = {}
        for row in sorted((row for row in self.rows if not row.kept), key=lambda row: -abs(row.relative or 0.0)):
            found.setdefault((row.point.line, row.measured.time), row)
        return sorted(found.values(), key=lambda row: (row.point.line, row.measured.time or 0.0))

    def of(self, quantity: str) -> list[Row]:
        """Rows of a quantity that have a model value."""
        return [row for row in self.rows if row.measured.quantity == quantity and row.after is not None]

    @property
    def quantities(self) -> list[str]:
        """Measured quantities, in the order of the table of quantities."""
        there = {value.measured.quantity for value in self.values}
        return [quantity for quantity in MEASURED if quantity in there]
