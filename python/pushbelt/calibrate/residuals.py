"""Measured values beside the model's, and their scores."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pushbelt.tables.columns import MEASURED
from pushbelt.tables.points import Measured, Point

from .model import Value
from .worker import Found


@dataclass(frozen=True)
class Residual:
    """A measured value, SI, with the model's."""

    point: Point
    measured: Measured
    found: float | None  # Value of the model; None without a steady state
    reason: str | None = None  # Why there is no steady state
    kept: bool = True  # Whether the fit contains it; it does not contain outliers

    @property
    def value(self) -> float | None:
        """Model minus measurement."""
        return None if self.found is None else self.found - self.measured.value

    @property
    def relative(self) -> float | None:
        """Model minus measurement, in standard deviations."""
        return None if self.value is None else self.value / self.measured.deviation

    @property
    def label(self) -> str:
        """Name of the point."""
        return self.point.name or f"line {self.point.line}"

    @property
    def ratio(self) -> float | None:
        """Geometric ratio of the point, or its speed ratio."""
        return self.point.ratio or self.point.speed_ratio


def residuals(points: Sequence[Point], values: Sequence[Value], states: Sequence[Found], kept: Sequence[bool] = ()) -> list[Residual]:
    """All measured values, in the order of the table."""
    return [
        Residual(points[one.point], one.measured, one.of(states[one.point]), states[one.point].reason, own)
        for one, own in zip(values, kept or [True] * len(values), strict=True)
    ]


def quantities(rows: Sequence[Residual]) -> list[str]:
    """Measured quantities, in the order of the table of quantities."""
    return [quantity for quantity in MEASURED if any(row.measured.quantity == quantity for row in rows)]


def of(rows: Sequence[Residual], quantity: str) -> list[Residual]:
    """Those of a quantity that have a model value."""
    return [row for row in rows if row.measured.quantity == quantity and row.found is not None]


@dataclass(frozen=True)
class Score:
    """Residuals of a quantity with a parameter set, SI; NaN without any."""

    quantity: str
    variator: str
    count: int  # Values at points with a steady state
    lost: int  # Values at points without one
    rms: float
    bias: float  # Mean of model minus measurement
    relative: float  # Root mean square in standard deviations
    explained: float
    """1 minus the residual sum of squares over that about the measured mean; NaN for a constant quantity."""


def score(rows: Sequence[Residual], quantity: str, variator: str = "") -> Score:
    """The score of a quantity."""
    known = of(rows, quantity)
    lost = sum(row.measured.quantity == quantity for row in rows) - len(known)
    if not known:
        return Score(quantity, variator, 0, lost, *[float("nan")] * 4)
    errors, measured = np.array([(row.value, row.measured.value) for row in known], dtype=float).T
    relative = np.array([row.relative for row in known], dtype=float)
    spread = float(np.sum((measured - measured.mean()) ** 2))
    explained = 1.0 - float(np.sum(errors**2)) / spread if spread else float("nan")
    rms, sd = (float(np.sqrt(np.mean(some**2))) for some in (errors, relative))
    return Score(quantity, variator, len(known), lost, rms, float(errors.mean()), sd, explained)
