"""Maps over ratio and torque utilisation: coloured levels, marks of the points, and the capacity as border."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.ticker import MaxNLocator

from ..fmu.geometry import Array
from ..report.charts import Field, Panel, Series, around
from ..report.page import MINUS
from ..report.style import COLOUR_SCALE, INK, MUTED, RED, mixed

TICKS = tuple((tick, f"{tick:g}") for tick in (0.4, 0.5, 0.7, 1.0, 1.4, 2.0, 2.5))
_LEVELS = (0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0)
ROWS = 61  # Number of values over the utilisation in a map with a border
MOST_TICKS = 9  # Largest number of ticks of a colour bar
COVER = "#f1f4f7"
"""Colour of what is beyond the capacity."""
MARKS: dict[str, dict[str, Any]] = {
    "solved": {"colour": MUTED, "marker": "circle", "size": 2.5},
    "slips through": {"colour": INK, "marker": "circle-open", "size": 6.0},
    "no steady state": {"colour": RED, "marker": "x-thin-open", "size": 7.0},
}
"""Kinds of points with their look."""


@dataclass(frozen=True)
class Quantity:
    """A quantity of figures: a column or table, and how it is shown."""

    name: str
    column: str
    scale: float = 1.0
    unit: str = ""
    levels: Sequence[float] | None = None  # Levels of the colours; by default they are evenly spaced

    @property
    def heading(self) -> str:
        """Name with the unit, if it has one."""
        text = f"{self.name} ({self.unit})" if self.unit not in ("", "1") else self.name
        return text[0].upper() + text[1:]


QUANTITIES = (
    Quantity("thrust ratio", "thrustRatio"),
    Quantity("efficiency", "efficiency", 100.0, "%", (50, 60, 70, 80, 85, 90, 92, 94, 95, 96, 96.5, 97, 97.5, 98, 98.5, 99)),
    Quantity("slip", "slip", 100.0, "%", (*(-level for level in reversed(_LEVELS)), 0.0, *_LEVELS)),
)
"""What all maps show."""


def levels_of(values: Array, preferred: Sequence[float] | None = None) -> Array:
    """Levels of the colours for the range of the values, from the preferred ones if at least two of these are inside."""
    found = values[np.isfinite(values)]
    if found.size == 0:
        return np.array([0.0, 1.0])
    low, high = float(np.percentile(found, 1)), float(np.percentile(found, 99))
    if preferred is not None:
        levels = np.array(preferred, dtype=float)
        inside = np.flatnonzero((levels >= low) & (levels <= high))
        if inside.size >= 2:
            return levels[max(inside[0] - 1, 0) : inside[-1] + 2]
    return np.asarray(MaxNLocator(12).tick_values(low, max(high, low + 1e-6 * (abs(low) or 1.0))))


def middle_of(levels: Array) -> int | None:
    """Index of the level 0, from which the colours diverge, if there are levels on both sides."""
    zero = np.flatnonzero(np.abs(levels) < 1e-9 * np.abs(levels).max())
    return int(zero[0]) if zero.size and 0 < zero[0] < len(levels) - 1 else None


def panel(
    title: str, quantity: Quantity, axes: tuple[Array, Array], values: Array, levels: Array, kinds: Mapping[str, np.ndarray],
    border: Array, at_border: Array | None = None,
) -> Panel:  # fmt: skip
    """A map of a quantity; `values` and the masks of `kinds` over ratio × utilisation. The colours end at the border: the least and the
    greatest utilisation that is carried, shape (2, ratios), NaN where unknown; `at_border` are the values there, where known."""
    unit = "" if quantity.unit == "1" else quantity.unit
    ratio, utilisation = (np.asarray(axis, dtype=float) for axis in axes)
    places = np.array(np.meshgrid(ratio, utilisation, indexing="ij"))
    series = []
    for kind, where in kinds.items():
        shown = [f"{value:.4g} {unit}" if np.isfinite(value) else kind for value in values[where]]
        series.append(Series(kind, *places[:, where], **{"kind": "points", "labels": shown, **MARKS[kind]}))
    fields: list[Field] = []
    rows = _rows(utilisation, border)
    ends = around([rows], 0.04)
    if min(values.shape) > 1 and np.count_nonzero(np.isfinite(values)) > 3:
        series = [*_beyond(ratio, ends, border), *series]
        values = _up_to(border, at_border, rows, utilisation, values)
        # All intervals between levels have the same width on the colour scale.
        steps = np.where(np.isfinite(values), np.interp(values, levels, np.arange(len(levels))), np.nan)
        middle, every = middle_of(levels), -(-len(levels) // MOST_TICKS)
        ticks = tuple((float(k), f"{level:g}".replace("-", MINUS)) for k, level in enumerate(levels))
        span = (0.0, float(len(levels) - 1), 1.0)
        named = ticks[(middle or 0) % every :: every]
        fields = [Field(quantity.name, ratio, rows, steps.T, span, named, middle=middle, unit=unit)]
    labels = "ratio r_S/r_P", "torque utilisation"
    return Panel(title, series, *labels, fields=fields, x_scale="log", x_ticks=TICKS, y_range=ends, height=250)


def _rows(utilisation: Array, border: Array) -> Array:
    """Closer values over the utilisation with those of the border, up to it if that is less than a step away."""
    low, high = (np.append(side[np.isfinite(side)], end) for side, end in zip(border, utilisation[[0, -1]], strict=True))
    step = np.diff(utilisation)[[0, -1]] if len(utilisation) > 1 else np.zeros(2)
    first, last = max(low.min(), utilisation[0] - step[0]), min(high.max(), utilisation[-1] + step[1])
    rows = np.concatenate([utilisation, np.linspace(min(first, utilisation[0]), max(last, utilisation[-1]), ROWS), low, high])
    return np.unique(rows[(rows >= first) & (rows <= last)])


def _beyond(ratio: Array, ends: tuple[float, float], border: Array) -> list[Series]:
    """The capacity as a line, and what is beyond it as areas without a name, so that the legend does not hide them."""
    known = [np.where(np.isfinite(side), np.clip(side, *ends), end) for side, end in zip(border, ends, strict=True)]
    wide = ratio * np.interp(np.arange(len(ratio)), [0, len(ratio) - 1], [0.995, 1.005])
    return [
        *(Series("", wide, side, COVER, "band", upper=np.full_like(side, end), opacity=1.0)
          for side, end in zip(known, ends, strict=True)),
        *(Series("capacity", ratio, side, INK, width=2.0) for side in border),
    ]  # fmt: skip


def _up_to(border: Array, at_border: Array | None, rows: Array, utilisation: Array, values: Array) -> Array:
    """Values at closer rows, which continue up to the border and under the areas beyond it. Gaps inside the border remain."""
    nearest = np.abs(rows[:, None] - utilisation).argmin(axis=1)
    found = np.full((len(values), len(rows)), np.nan)
    for k, line in enumerate(values):
        low, high = border[:, k]
        carried = ~((utilisation < low) | (utilisation > high))
        x, y = utilisation[carried & np.isfinite(line)], line[carried & np.isfinite(line)]
        if at_border is not None:
            at = np.isfinite(at_border[:, k]) & np.isfinite(border[:, k])
            x, y = np.append(x, border[at, k]), np.append(y, at_border[at, k])
        if len(x) > 1:
            gap = carried & ~np.isfinite(line)
            found[k] = np.where(gap[nearest], np.nan, np.interp(rows, np.sort(x), y[np.argsort(x)]))
    return found


def shades(count: int) -> list[str]:
    """Colours from light to dark, without the lightest."""
    return mixed(COLOUR_SCALE[1:], np.linspace(0.0, 1.0, count).tolist())
