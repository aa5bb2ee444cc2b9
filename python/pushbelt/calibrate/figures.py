"""Residuals over the working points, and model over measurement."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pushbelt.charts import Chart, Panel, Series
from pushbelt.style import BLUE, MUTED, ORANGE

from .results import Results, Row

ACROSS: tuple[tuple[str, Callable[[Row], float]], ...] = (
    ("torque, N·m", lambda row: row.point.torque),
    ("ratio", lambda row: row.point.ratio or row.point.speed_ratio),
)
"""Abscissas of the residuals."""
NAMES = {"before": "start values", "after": "fitted"}
LOOKS = {
    "before": {"colour": MUTED, "marker": "circle-open", "size": 6, "opacity": 0.8},
    "after": {"colour": BLUE, "size": 7},
}
SURE = 2.0
"""Half-width of the shaded band, in standard deviations."""


def residuals(results: Results, quantity: str) -> Chart:
    """Model over measurement, and residuals in standard deviations over torque and ratio, before and after."""
    rows = results.of(quantity)
    panels = [_compared(rows, quantity), *(_over(rows, label, across) for label, across in ACROSS)]
    return Chart(panels, f"Residuals of {quantity}", columns=3, common_legend=True)


def _points(side: str, rows: list[Row], x: list[float], y: list[float | None]) -> Series:
    values = [np.nan if value is None else value for value in y]
    labels = [f"{row.point.name or 'line ' + str(row.point.line)}" for row in rows]
    return Series(NAMES[side], x, values, kind="points", labels=labels, **LOOKS[side])  # type: ignore[arg-type]


def _compared(rows: list[Row], quantity: str) -> Panel:
    measured = [row.measured.value for row in rows]
    # Outliers do not determine the scales.
    inside = [value for row, value in zip(rows, measured, strict=True) if row.kept] or measured
    ends = [min(inside), max(inside)]
    series = [_points(side, rows, measured, [getattr(row, side) for row in rows]) for side in NAMES]
    series.append(Series("model as measured", ends, ends, ORANGE, width=1.0))
    beyond = len(measured) - len(inside)
    margin = 0.1 * (ends[1] - ends[0]) + 1e-6
    span = (ends[0] - margin, ends[1] + margin) if beyond else None
    note = f"{beyond} outliers may be outside the figure." if beyond else ""
    return Panel(f"{quantity}: model over measurement", series, "measured", "model", x_range=span, height=270, note=note)


def _over(rows: list[Row], label: str, across: Callable[[Row], float]) -> Panel:
    places = [across(row) for row in rows]
    values = {"before": [row.relative_before for row in rows], "after": [row.relative for row in rows]}
    # The residuals after the fit determine the scale, since those at the start and those of outliers may be very large.
    reach = 1.3 * max(3.0, *(abs(row.relative) for row in rows if row.kept))
    before, after = (sum(value is not None and abs(value) > reach for value in values[side]) for side in NAMES)
    margin = 0.04 * (max(places) - min(places)) + 1e-3
    span = (min(places) - margin, max(places) + margin)
    sure = Series(f"within {SURE:g}", span, (-SURE, -SURE), BLUE, "band", upper=(SURE, SURE), opacity=0.1)
    series = [sure, *(_points(side, rows, places, values[side]) for side in NAMES)]
    beyond = [f"{count} residuals {of}" for count, of in ((before, "at the start values"), (after, "of outliers")) if count]
    note = f"{' and '.join(beyond)} are outside the figure." if beyond else ""
    title = "Residual, standard deviations"
    return Panel(title, series, label, x_range=span, y_range=(-reach, reach), height=270, note=note)
