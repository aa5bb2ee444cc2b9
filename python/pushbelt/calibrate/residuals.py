"""Scores of residuals: of the rows of `Model.rows`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from pushbelt.report import page
from pushbelt.tables.columns import MEASURED


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
