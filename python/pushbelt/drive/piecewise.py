"""Limits and linear interpolation of single numbers. Controllers evaluate one value at a time, for which arrays are slow."""

from bisect import bisect_left, bisect_right
from collections.abc import Sequence


def clip(value: float, low: float, high: float) -> float:
    """The nearest number from `low` to `high`."""
    return min(max(value, low), high)


def interpolate(value: float, places: Sequence[float], values: Sequence[float]) -> float:
    """Linear interpolation between points at ascending places, constant beyond them. Results equal those of `numpy.interp` bit for bit."""
    if value >= places[-1]:
        return values[-1]
    k = bisect_right(places, value) - 1
    if k < 0:
        return values[0]
    slope = (values[k + 1] - values[k]) / (places[k + 1] - places[k])
    return slope * (value - places[k]) + values[k]


def interval(grid: Sequence[float], value: float) -> tuple[int, float]:
    """Index of the grid interval that contains a value, and the relative position in it, 0 to 1. The grid is ascending."""
    index = min(max(bisect_left(grid, value) - 1, 0), len(grid) - 2)
    return index, clip((value - grid[index]) / (grid[index + 1] - grid[index]), 0.0, 1.0)
