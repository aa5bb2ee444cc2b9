"""Figures of the report, from plain data."""

from __future__ import annotations

from pushbelt.charts import Chart, Mark, Series
from pushbelt.charts import Panel as ChartPanel
from pushbelt.style import BLUE, GREEN, INK, MUTED, ORANGE, RED, VIOLET

from .outcome import Curve, Panel, Picture

COLOURS = (BLUE, ORANGE, GREEN, RED, VIOLET, INK, MUTED)
MOST_IN_A_ROW = 3
REACH = 50.0
"""Largest change in a panel of named rows, per cent."""
MARKERS = {"o": "circle", ".": "circle", "x": "x-thin-open", "_": "line-ew-open"}
SIZES = {"o": 6.0, ".": 7.0, "x": 7.0, "_": 14.0}
DASHES = {"--": "dash", ":": "dot", "-": ""}


def draw(picture: Picture) -> Chart:
    """A picture as a chart."""
    named = any(panel.names for panel in picture.panels)
    names = [{curve.label for curve in panel.curves} for panel in picture.panels]
    return Chart(
        [_panel(panel) for panel in picture.panels],
        picture.caption,
        columns=2 if named else min(len(picture.panels), MOST_IN_A_ROW),
        common_legend=len(names) > 1 and all(found == names[0] for found in names),
        least_width=330 if named else 260,
    )


def _panel(panel: Panel) -> ChartPanel:
    reach = None
    if panel.names:
        farthest = max((abs(x) for curve in panel.curves for x in curve.x if x == x), default=1.0)
        reach = min(REACH, 1.1 * farthest)
    return ChartPanel(
        panel.title,
        [_series(curve, panel) for curve in panel.curves],
        panel.x_label,
        scale="log" if panel.log_y else "linear",
        x_ticks=tuple((float(k), name) for k, name in enumerate(panel.places)),
        y_ticks=tuple((-float(k), name) for k, name in enumerate(panel.names)),
        x_range=None if reach is None else (-reach, reach),
        y_range=(0.5 - len(panel.names), 0.5) if panel.names else None,
        marks=[Mark(0.0)] if panel.names else [],
        height=70 + 16 * len(panel.names) if panel.names else 300,
    )


def _series(curve: Curve, panel: Panel) -> Series:
    dash, mark = ("--" if "--" in curve.style else curve.style.strip("ox._")), curve.style.strip("-:")
    labels = panel.names or [panel.places[int(x)] for x in curve.x] if panel.names or panel.places else None
    return Series(
        curve.label,
        curve.x,
        curve.y,
        COLOURS[curve.colour % len(COLOURS)],
        "line" if dash else "points",
        dash=DASHES.get(dash, ""),
        marker=MARKERS.get(mark, ""),
        size=SIZES.get(mark, 6.0),
        labels=labels,
    )
