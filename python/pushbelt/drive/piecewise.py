"""Limits and linear interpolation of plain numbers: controllers need one at a time, where arrays are slow."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence


def clip(value: float, low: float, high: float) -> float:
    """The nearest number from `low` to `high`."""
    return min(max(value, low), high)


def interpolate(value: float, places: Sequence[float], values: Sequence[float]) -> float:
    """Linear between points at ascending places, constant beyond them: `numpy.interp`, to the last bit."""
    if value >= places[-1]:
        return values[-1]
    k = bisect_right(places, value) - 1
    if k < 0:
        return values[0]
    slope = (values[k + 1] - values[k]) / (places[k + 1] - places[k])
    return slope * (value - places[k]) + values[k]


def interval(grid: Sequence[float], value: float) -> tuple[int, float]:
    """Interval of an ascending grid that holds a value, and the share of the way through it, 0 to 1."""
    index = min(max(bisect_left(grid, value) - 1, 0), len(grid) - 2)
    return index, clip((value - grid[index]) / (grid[index + 1] - grid[index]), 0.0, 1.0)
