"""Model over measurement, and residuals over torque and ratio, of one or more parameter sets.

The axes fit the bulk of the values of the leading set. Its outliers are at the border, with their values.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from pushbelt.report.charts import Chart, Panel, Series, around
from pushbelt.fmu.geometry import Array
from pushbelt.report.style import BLUE, MUTED, ORANGE

from .model import plain

SURE = 2.0  # Half-width of the shaded band, in standard deviations
LEAST_REACH = 3.0  # Least reach of the axis of residuals, in standard deviations
FAR = 6.0
"""Residual of an outlier, in medians of the absolute residuals. That is four standard deviations of a normal distribution."""
INSET = 0.02  # Distance of the marks of outliers from the border, as a share of the axis
LOOKS = ({"colour": BLUE, "size": 7}, {"colour": MUTED, "marker": "circle-open", "size": 6, "opacity": 0.8})
"""Looks of the leading set and of the other one."""
ARROWS = {(0, 1): "triangle-up", (0, -1): "triangle-down", (1, 0): "triangle-right", (-1, 0): "triangle-left"}
Range = tuple[float, float]
Sets = Mapping[str, pd.DataFrame]
Text = Callable[[Any], str]
_brief = partial(plain, digits=3)


def reach(rows: pd.DataFrame) -> float:
    """Largest residual of the bulk, in standard deviations."""
    sizes = rows["relative"].abs()
    far = max(LEAST_REACH, FAR * sizes.median())
    return max(LEAST_REACH, sizes[sizes <= far].max())


def chart(quantity: str, sets: Sets) -> Chart:
    """The figures of a quantity. The first set leads; it must have values."""
    sets = {name: rows.assign(at=rows["ratio"].fillna(rows["speed_ratio"])) for name, rows in sets.items()}
    leading = next(iter(sets.values()))
    most = reach(leading)
    bulk = leading[leading["relative"].abs() <= most]
    x_range, y_range = around([bulk["measured"]]), around([bulk[["measured", "found"]].to_numpy().ravel()])
    ends = [max(x_range[0], y_range[0]), min(x_range[1], y_range[1])]
    line = Series("model as measured", ends, ends, ORANGE, width=1.0)
    series, note = _inside(sets, "measured", "found", x_range, y_range, lambda row: f"{_brief(row.measured)}, model {_brief(row.found)}")
    title = f"{quantity}: model over measurement"
    compared = Panel(title, [line, *series], "measured", "model", x_range=x_range, y_range=y_range, height=270, note=note)
    over = [_over(sets, label, across, 1.15 * most) for label, across in (("torque, N·m", "torque"), ("ratio", "at"))]
    return Chart([compared, *over], f"Residuals of {quantity}", columns=3, common_legend=True)


def _over(sets: Sets, label: str, across: str, most: float) -> Panel:
    places = pd.concat([rows[across] for rows in sets.values()])
    span = around([(places.min() - 1e-3, places.max() + 1e-3)])
    series, note = _inside(sets, across, "relative", span, (-most, most), lambda row: _brief(row.relative))
    sure = Series(f"within {SURE:g}", span, (-SURE, -SURE), BLUE, "band", upper=(SURE, SURE), opacity=0.1)
    title = "Residual, standard deviations"
    return Panel(title, [sure, *series], label, x_range=span, y_range=(-most, most), height=270, note=note)


def _inside(sets: Sets, x: str, y: str, x_range: Range, y_range: Range, text: Text) -> tuple[list[Series], str]:
    """The points within the axes; beyond them those of the leading set at the border, with their values, and a count of the others."""
    series: list[Series] = []
    notes = []
    low, high = np.array([x_range, y_range]).T[:, :, None]
    for k, (name, rows) in reversed(list(enumerate(sets.items()))):
        at = rows[[x, y]].to_numpy(dtype=float).T
        sides = np.sign(at - np.clip(at, low, high)).astype(int)
        beyond = sides.any(axis=0)
        series.append(Series(name, *at[:, ~beyond], kind="points", labels=_labels(rows[~beyond]), **LOOKS[k]))
        if k == 0:
            inset = INSET * (high - low)
            series += _marked(name, rows, np.clip(at, low + inset, high - inset), sides, sum(x_range) / 2, text)
        elif beyond.any():
            notes.append(f"{beyond.sum()} values of {name} are outside the figure.")
    return series, " ".join(notes)


def _labels(rows: pd.DataFrame) -> list[str]:
    return [row.name or f"line {row.line}" for row in rows.itertuples()]


def _marked(name: str, rows: pd.DataFrame, border: Array, sides: Array, middle: float, text: Text) -> Iterator[Series]:
    """Arrows at the border, with values beside them, every other one further inside."""
    for (right, up), marker in ARROWS.items():
        chosen = np.flatnonzero((sides[1] == up) & ((sides[0] == right) | (up != 0)))
        chosen = chosen[np.argsort(border[0, chosen])]
        if chosen.size:
            inside = {0: "", 1: "bottom center", -1: "top center"}[up]
            beside = ["middle right" if x < middle else "middle left" for x in border[0, chosen]]
            texts = [text(row) for row in rows.iloc[chosen].itertuples()]
            yield Series(
                name, *border[:, chosen], **LOOKS[0] | {"kind": "points", "marker": marker, "size": 10},  # type: ignore[arg-type]
                labels=[": ".join(pair) for pair in zip(_labels(rows.iloc[chosen]), texts, strict=True)], texts=texts,
                text_sides=[inside if inside and k % 2 else side for k, side in enumerate(beside)],
            )  # fmt: skip
