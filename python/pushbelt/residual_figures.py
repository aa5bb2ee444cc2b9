"""Model over measurement, and residuals over torque and ratio, of one or more parameter sets.

The axes fit the bulk of the values of the leading set. Its outliers are at the border, with their values.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from .fmu.geometry import Array
from .report.charts import Chart, Panel, Series, around
from .report.page import MINUS
from .report.style import BLUE, MUTED, ORANGE

SURE = 2.0
"""Half-width of the shaded band, in standard deviations."""
LEAST_REACH = 3.0
"""Least reach of the axis of residuals, in standard deviations."""
FAR = 6.0
"""Residual of an outlier, in medians of the absolute residuals. That is four standard deviations of a normal distribution."""
INSET = 0.02
"""Distance of the marks of outliers from the border, as a share of the axis."""
LOOKS = ({"colour": BLUE, "size": 7}, {"colour": MUTED, "marker": "circle-open", "size": 6, "opacity": 0.8})
"""Looks of the leading set and of the other one."""
ARROWS = {(0, 1): "triangle-up", (0, -1): "triangle-down", (1, 0): "triangle-right", (-1, 0): "triangle-left"}


class Residual(NamedTuple):
    """A measured value, SI, with the model's."""

    label: str
    torque: float
    ratio: float
    measured: float
    found: float
    deviation: float

    @property
    def relative(self) -> float:
        """Model minus measurement, in standard deviations."""
        return (self.found - self.measured) / self.deviation


def reach(residuals: Sequence[Residual]) -> float:
    """Largest residual of the bulk, in standard deviations."""
    sizes = np.abs([one.relative for one in residuals])
    far = max(LEAST_REACH, FAR * float(np.median(sizes)))
    return max(LEAST_REACH, float(sizes[sizes <= far].max(initial=0.0)))


def residuals(quantity: str, sets: Mapping[str, Sequence[Residual]]) -> Chart:
    """The figures of a quantity. The first set leads; it must have values."""
    panels = [
        _compared(quantity, sets),
        _over(sets, "torque, N·m", lambda one: one.torque),
        _over(sets, "ratio", lambda one: one.ratio),
    ]
    return Chart(panels, f"Residuals of {quantity}", columns=3, common_legend=True)


def _compared(quantity: str, sets: Mapping[str, Sequence[Residual]]) -> Panel:
    leading = next(iter(sets.values()))
    most = reach(leading)
    bulk = [one for one in leading if abs(one.relative) <= most]
    x_range, y_range = (
        around([[one.measured for one in bulk]]),
        around([[v for one in bulk for v in (one.measured, one.found)]]),
    )
    ends = [max(x_range[0], y_range[0]), min(x_range[1], y_range[1])]
    line = Series("model as measured", ends, ends, ORANGE, width=1.0)
    points = {name: (of, [one.measured for one in of], [one.found for one in of]) for name, of in sets.items()}
    series, note = _inside(points, x_range, y_range, lambda one: f"{_brief(one.measured)}, model {_brief(one.found)}")
    title = f"{quantity}: model over measurement"
    return Panel(title, [line, *series], "measured", "model", x_range=x_range, y_range=y_range, height=270, note=note)


def _over(sets: Mapping[str, Sequence[Residual]], label: str, across: Any) -> Panel:
    leading = next(iter(sets.values()))
    most = 1.15 * reach(leading)
    places = [across(one) for of in sets.values() for one in of]
    span = min(places) - 1e-3, max(places) + 1e-3
    span = around([span])
    points = {name: (of, [across(one) for one in of], [one.relative for one in of]) for name, of in sets.items()}
    series, note = _inside(points, span, (-most, most), lambda one: _brief(one.relative))
    sure = Series(f"within {SURE:g}", span, (-SURE, -SURE), BLUE, "band", upper=(SURE, SURE), opacity=0.1)
    title = "Residual, standard deviations"
    return Panel(title, [sure, *series], label, x_range=span, y_range=(-most, most), height=270, note=note)


def _inside(
    points: Mapping[str, tuple[Sequence[Residual], Sequence[float], Sequence[float]]],
    x_range: tuple[float, float],
    y_range: tuple[float, float],
    value: Any,
) -> tuple[list[Series], str]:
    """The points within the axes; beyond them those of the leading set at the border, with their values, and a count of the others."""
    series: list[Series] = []
    notes = []
    for k, (name, (of, x, y)) in reversed(list(enumerate(points.items()))):
        look: dict[str, Any] = {"kind": "points", **LOOKS[k]}
        at = np.array([x, y], dtype=float)
        low, high = np.array([x_range, y_range]).T[:, :, None]
        sides = np.sign(at - np.clip(at, low, high)).astype(int)
        beyond = sides.any(axis=0)
        series.append(
            Series(
                name,
                *at[:, ~beyond],
                labels=[one.label for one, out in zip(of, beyond, strict=True) if not out],
                **look,
            )
        )
        if k > 0:
            if beyond.any():
                notes.append(f"{beyond.sum()} values of {name} are outside the figure.")
            continue
        inset = INSET * (high - low)
        series += _marked(name, of, np.clip(at, low + inset, high - inset), sides, sum(x_range) / 2, value)
    return series, " ".join(notes)


def _marked(
    name: str, of: Sequence[Residual], border: Array, sides: Array, middle: float, value: Any
) -> Iterator[Series]:
    """Arrows at the border, with values beside them, every other one further inside."""
    for (right, up), marker in ARROWS.items():
        chosen = np.flatnonzero((sides[1] == up) & ((sides[0] == right) | (up != 0)))
        chosen = chosen[np.argsort(border[0, chosen])]
        if not chosen.size:
            continue
        inside = {0: "", 1: "bottom center", -1: "top center"}[up]
        beside = ["middle right" if x < middle else "middle left" for x in border[0, chosen]]
        texts = [value(of[n]) for n in chosen]
        yield Series(
            name,
            *border[:, chosen],
            **LOOKS[0] | {"kind": "points", "marker": marker, "size": 10},  # type: ignore[arg-type]
            labels=[f"{of[n].label}: {text}" for n, text in zip(chosen, texts, strict=True)],
            texts=texts,
            text_sides=[inside if inside and k % 2 else side for k, side in enumerate(beside)],
        )


def _brief(value: float) -> str:
    return f"{value:.3g}".replace("-", MINUS)
