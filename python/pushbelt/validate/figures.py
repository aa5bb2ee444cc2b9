"""Pictures of the report, drawn from plain data."""

from __future__ import annotations

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

from pushbelt.style import BLUE, GREEN, INK, MUTED, ORANGE, RED, STYLE, VIOLET, svg

from .outcome import Panel, Picture

COLOURS = (BLUE, ORANGE, GREEN, RED, VIOLET, INK, MUTED)
WIDTH = 11.2
"""Of a picture, inches."""
MOST_IN_A_ROW = 3
REACH = 50.0
"""Farthest change that a panel of named rows shows, per cent."""


def draw(picture: Picture) -> str:
    """A picture as SVG."""
    named = next((panel.names for panel in picture.panels if panel.names), ())
    across = len(picture.panels) if named else min(len(picture.panels), MOST_IN_A_ROW)
    down = -(-len(picture.panels) // across)
    height = 0.8 + 0.17 * len(named) if named else 3.4 * down
    with plt.rc_context(STYLE):
        figure, all_axes = plt.subplots(
            down, across, figsize=(WIDTH, height), layout="constrained", squeeze=False, sharey=bool(named)
        )
        for axes, panel in zip(all_axes.flat, picture.panels, strict=False):
            _panel(axes, panel)
        for axes in all_axes.flat[len(picture.panels) :]:
            axes.set_visible(False)
    return svg(figure)


def _panel(axes: Axes, panel: Panel) -> None:
    for curve in panel.curves:
        size = {"o": 3.5, ".": 5.0, "x": 4.0, "_": 9.0}.get(curve.style.strip("-:"), 3.5)
        colour = COLOURS[curve.colour % len(COLOURS)]
        axes.plot(curve.x, curve.y, curve.style, color=colour, markersize=size, label=curve.label or None)
    axes.set(title=panel.title, xlabel=panel.x_label)
    if panel.log_y:
        axes.set_yscale("log")
    if panel.names:
        axes.set_yticks([-k for k in range(len(panel.names))], panel.names)
        axes.axvline(0.0, color=MUTED, linewidth=0.8)
        farthest = max((abs(x) for curve in panel.curves for x in curve.x if x == x), default=1.0)
        reach = min(REACH, 1.1 * farthest)
        axes.set_xlim(-reach, reach)
    if panel.places:
        axes.set_xticks(range(len(panel.places)), panel.places, rotation=35, ha="right", fontsize=7.5)
    if any(curve.label for curve in panel.curves):
        axes.legend(fontsize=7.5)
