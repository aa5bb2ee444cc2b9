"""What a calibration gives: the fit with the table it belongs to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from .fit import Fit
from .model import Value
from .table import QUANTITIES, Measured, Point


@dataclass(frozen=True)
class Effort:
    """What it took."""

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
    """At the start values; none without a steady state."""
    after: float | None
    reason: str | None
    """Why there is none after the fit."""

    @property
    def residual(self) -> float | None:
        """Model less measurement after the fit."""
        return None if self.after is None else self.after - self.measured.value

    @property
    def relative(self) -> float | None:
        """The same in standard deviations."""
        return None if self.residual is None else self.residual / self.measured.deviation

    @property
    def relative_before(self) -> float | None:
        """Model less measurement at the start values in standard deviations."""
        return None if self.before is None else (self.before - self.measured.value) / self.measured.deviation


@dataclass(frozen=True)
class Results:
    """All that report and files show."""

    table: str
    """Name of the table's file."""
    version: str
    """Of the FMU."""
    variator: str
    """Parameter set that was started from."""
    base: Mapping[str, float]
    """Its values, with what was set beside."""
    short: bool
    """Whether the mesh was coarse."""
    points: tuple[Point, ...]
    values: tuple[Value, ...]
    fit: Fit
    effort: Effort

    @cached_property
    def rows(self) -> list[Row]:
        """All measured values, in the order of the table."""
        return [
            Row(
                self.points[value.point],
                value.measured,
                self.fit.before[value.point].values.get(value.measured.quantity),
                self.fit.after[value.point].values.get(value.measured.quantity),
                self.fit.after[value.point].reason,
            )
            for value in self.values
        ]

    @property
    def lost(self) -> list[Row]:
        """A row of each point that has no steady state after the fit."""
        return list({row.point.line: row for row in self.rows if row.reason is not None}.values())

    def of(self, quantity: str) -> list[Row]:
        """Rows of a quantity that have a model value."""
        return [row for row in self.rows if row.measured.quantity == quantity and row.after is not None]

    @property
    def quantities(self) -> list[str]:
        """Those that were measured, in the order of the table of quantities."""
        there = {value.measured.quantity for value in self.values}
        return [quantity for quantity in QUANTITIES if quantity in there]
