"""Model over measurement, and residuals over torque and ratio, of one or more parameter sets.

The axes fit the bulk of the values of the leading set. Its outliers are at the border, with their values.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from pushbelt.report.charts import Chart, Panel, Series, around
from pushbelt.fmu.geometry import Array
from pushbelt.report.page import MINUS
from pushbelt.report.style import BLUE, MUTED, ORANGE

from .residuals import Residual

SURE = 2.0  # Half-width of the shaded band, in standard deviations
LEAST_REACH = 3.0  # Least reach of the axis of residuals, in standard deviations
FAR = 6.0
"""Residual of an outlier, in medians of the absolute residuals. That is four standard deviations of a normal distribution."""
INSET = 0.02  # Distance of the marks of outliers from the border, as a share of the axis
LOOKS = ({"colour": BLUE, "size": 7}, {"colour": MUTED, "marker": "circle-open", "size": 6, "opacity": 0.8})
"""Looks of the leading set and of the other one."""
ARROWS = {(0, 1): "triangle-up", (0, -1): "triangle-down", (1, 0): "triangle-right", (-1, 0): "triangle-left"}
Range = tuple[float, float]
Sets = Mapping[str, Sequence[Residual]]
Of = Callable[[Residual], Any]


def reach(rows: Sequence[Residual]) -> float:
    """Largest residual of the bulk, in standard deviations."""
    sizes = np.abs([row.relative for row in rows])
    far = max(LEAST_REACH, FAR * float(np.median(sizes)))
    return max(LEAST_REACH, float(sizes[sizes <= far].max(initial=0.0)))


def chart(quantity: str, sets: Sets) -> Chart:
    """The figures of a quantity. The first set leads; it must have values."""
    leading = next(iter(sets.values()))
    most = reach(leading)
    bulk = [row for row in leading if abs(row.relative) <= most]
    x_range, y_range = around([[row.measured.value for row in bulk]]), around([[v for row in bulk for v in (row.measured.value, row.found)]])
    ends = [max(x_range[0], y_range[0]), min(x_range[1], y_range[1])]
    line = Series("model as measured", ends, ends, ORANGE, width=1.0)
    series, note = _inside(
        sets, lambda row: row.measured.value, lambda row: row.found, x_range, y_range,
        lambda row: f"{_brief(row.measured.value)}, model {_brief(row.found)}",
    )  # fmt: skip
    title = f"{quantity}: model over measurement"
    compared = Panel(title, [line, *series], "measured", "model", x_range=x_range, y_range=y_range, height=270, note=note)
    over = [_over(sets, label, across, 1.15 * most) for label, across in
            (("torque, N·m", lambda row: row.point.torque), ("ratio", lambda row: row.ratio))]  # fmt: skip
    return Chart([compared, *over], f"Residuals of {quantity}", columns=3, common_legend=True)


def _over(sets: Sets, label: str, across: Of, most: float) -> Panel:
    places = [across(row) for of in sets.values() for row in of]
    span = around([(min(places) - 1e-3, max(places) + 1e-3)])
    series, note = _inside(sets, across, lambda row: row.relative, span, (-most, most), lambda row: _brief(row.relative))
    sure = Series(f"within {SURE:g}", span, (-SURE, -SURE), BLUE, "band", upper=(SURE, SURE), opacity=0.1)
    title = "Residual, standard deviations"
    return Panel(title, [sure, *series], label, x_range=span, y_range=(-most, most), height=270, note=note)


def _inside(sets: Sets, x: Of, y: Of, x_range: Range, y_range: Range, text: Of) -> tuple[list[Series], str]:
    """The points within the axes; beyond them those of the leading set at the border, with their values, and a count of the others."""
    series: list[Series] = []
    notes = []
    for k, (name, rows) in reversed(list(enumerate(sets.items()))):
        look: dict[str, Any] = {"kind": "points", **LOOKS[k]}
        at = np.array([[one(row) for row in rows] for one in (x, y)], dtype=float)
        low, high = np.array([x_range, y_range]).T[:, :, None]
        sides = np.sign(at - np.clip(at, low, high)).astype(int)
        beyond = sides.any(axis=0)
        labels = [row.label for row, out in zip(rows, beyond, strict=True) if not out]
        series.append(Series(name, *at[:, ~beyond], labels=labels, **look))
        if k == 0:
            inset = INSET * (high - low)
            series += _marked(name, rows, np.clip(at, low + inset, high - inset), sides, sum(x_range) / 2, text)
        elif beyond.any():
            notes.append(f"{beyond.sum()} values of {name} are outside the figure.")
    return series, " ".join(notes)


def _marked(name: str, rows: Sequence[Residual], border: Array, sides: Array, middle: float, text: Of) -> Iterator[Series]:
    """Arrows at the border, with values beside them, every other one further inside."""
    for (right, up), marker in ARROWS.items():
        chosen = np.flatnonzero((sides[1] == up) & ((sides[0] == right) | (up != 0)))
        chosen = chosen[np.argsort(border[0, chosen])]
        if not chosen.size:
            continue
        inside = {0: "", 1: "bottom center", -1: "top center"}[up]
        beside = ["middle right" if x < middle else "middle left" for x in border[0, chosen]]
        texts = [text(rows[n]) for n in chosen]
        yield Series(
            name, *border[:, chosen], **LOOKS[0] | {"kind": "points", "marker": marker, "size": 10},  # type: ignore[arg-type]
            labels=[f"{rows[n].label}: {text}" for n, text in zip(chosen, texts, strict=True)], texts=texts,
            text_sides=[inside if inside and k % 2 else side for k, side in enumerate(beside)],
        )  # fmt: skip


def _brief(value: float) -> str:
    return f"{value:.3g}".replace("-", MINUS)
