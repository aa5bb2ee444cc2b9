"""Measured values beside the model's, and their scores."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from pushbelt.report import page
from pushbelt.tables.columns import MEASURED
from pushbelt.tables.points import Point

from .model import Value
from .worker import Found

COLUMNS = (
    "line", "name", "time", "ratio", "speed_ratio", "speed", "torque", "force", "primary_force", "quantity", "measured", "sd", "given",
    "found", "reason",
)  # fmt: skip


def residuals(points: Sequence[Point], values: Sequence[Value], states: Sequence[Found], kept: Sequence[bool] | bool = True) -> pd.DataFrame:
    """A row for each measured value, SI, in the order of the table: its point, measured value, standard deviation and whether it is given,
    the model's value or why there is no steady state, and whether the fit contains it. `residual` is model minus measurement, `relative`
    the same in standard deviations."""
    pairs = ((points[one.point], one.measured, one.of(states[one.point]), states[one.point].reason) for one in values)
    rows = [
        (p.line, p.name, m.time, p.ratio, p.speed_ratio, p.speed, p.torque, p.force, p.primary_force, m.quantity, m.value, m.deviation,
         m.given, found, reason)
        for p, m, found, reason in pairs
    ]  # fmt: skip
    numbers = ("time", "ratio", "speed_ratio", "primary_force", "measured", "sd", "found")
    frame = pd.DataFrame(rows, columns=list(COLUMNS)).astype(dict.fromkeys(numbers, float)).assign(kept=kept)
    frame["residual"] = frame["found"] - frame["measured"]
    return frame.assign(relative=frame["residual"] / frame["sd"])


def plain(value: float | None, digits: int = 5, none: str = "") -> str:
    """A number with so many significant digits; `none` for one that is unknown."""
    return none if value is None or value != value else f"{value:.{digits}g}".replace("-", page.MINUS)


def quantities(rows: pd.DataFrame) -> list[str]:
    """Measured quantities, in the order of the table of quantities."""
    return [quantity for quantity in MEASURED if (rows["quantity"] == quantity).any()]


def of(rows: pd.DataFrame, quantity: str) -> pd.DataFrame:
    """Those of a quantity that have a model value."""
    return rows[(rows["quantity"] == quantity) & rows["found"].notna()]


class Score(NamedTuple):
    """Residuals of a quantity with a parameter set, SI; NaN without any."""

    quantity: str
    variator: str
    count: int  # Values at points with a steady state
    lost: int  # Values at points without one
    rms: float
    bias: float  # Mean of model minus measurement
    relative: float  # Root mean square in standard deviations
    explained: float  # 1 minus the residual sum of squares over that about the measured mean; NaN for a constant quantity


def score(rows: pd.DataFrame, quantity: str, variator: str = "") -> Score:
    """The score of a quantity."""
    known = of(rows, quantity)
    squares, spread = known["residual"] ** 2, ((known["measured"] - known["measured"].mean()) ** 2).sum()
    explained = 1.0 - squares.sum() / spread if spread else np.nan
    rms, bias, relative = np.sqrt(squares.mean()), known["residual"].mean(), np.sqrt((known["relative"] ** 2).mean())
    lost = int((rows["quantity"] == quantity).sum()) - len(known)
    return Score(quantity, variator, len(known), lost, *map(float, (rms, bias, relative, explained)))
