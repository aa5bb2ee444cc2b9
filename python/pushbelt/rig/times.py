"""Times of a table: numbers, times of the day, or dates; seconds."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from . import numerals
from .units import Unit

EPOCHS = ((1e17, 1e-9), (1e14, 1e-6), (1e11, 1e-3))
"""Numbers without a unit that are above the first value are a time since 1970 in this unit."""

SAMPLE = 50
"""Cells that decide whether times are numbers."""


def seconds(column: Sequence[Any], scale: Unit, decimal: str) -> np.ndarray[Any, Any]:
    """Seconds, of dates those since the first; NaN for a cell that is no time."""
    filled = np.array([cell != "" for cell in column])
    first = [column[row] for row in np.flatnonzero(filled)[:SAMPLE]]
    if sum(_number(cell, decimal) is not None for cell in first) >= 0.5 * len(first):
        return _scaled(np.array([_number(cell, decimal) for cell in column], dtype=float), scale)
    import pandas as pd

    texts = pd.Series([str(cell).strip().replace(",", ".") for cell in column], dtype=object)
    clock = texts.str.fullmatch(r"(?:\d+ days?,? )?\d{1,3}:\d{2}(?::\d{2}(?:\.\d*)?)?")
    if clock[filled].mean() > 0.5:
        whole = texts.where(texts.str.count(":") == 2, texts + ":00")
        times = pd.to_timedelta(whole.where(clock), errors="coerce").dt.total_seconds().to_numpy(dtype=float)
        # A clock starts again at midnight.
        return times + 86400.0 * np.cumsum(np.diff(times, prepend=times[:1]) < -43200.0)
    day_first = not texts.str.match(r"\d{4}-").any() and not texts.str.contains("/").any()
    if texts.str.match(r"\d{4}-").mean() > 0.5:
        dates = pd.to_datetime(texts, errors="coerce", format="ISO8601", utc=True)
    else:
        with warnings.catch_warnings():
            # pandas warns if it finds no common format.
            warnings.simplefilter("ignore", UserWarning)
            dates = pd.to_datetime(texts, errors="coerce", dayfirst=day_first, utc=True)
            if dates[filled].isna().mean() > 0.1:
                dates = pd.to_datetime(texts, errors="coerce", format="mixed", dayfirst=day_first, utc=True)
    return (dates - dates.min()).dt.total_seconds().to_numpy(dtype=float)


def _number(cell: Any, decimal: str) -> float | None:
    return numerals.number(cell, decimal) if isinstance(cell, str) else float(cell)


def _scaled(numbers: np.ndarray[Any, Any], scale: Unit) -> np.ndarray[Any, Any]:
    largest = np.nanmax(np.abs(numbers), initial=0.0)
    factor = next((factor for above, factor in EPOCHS if largest > above), 1.0) if scale.factor == 1.0 else scale.factor
    return factor * numbers
