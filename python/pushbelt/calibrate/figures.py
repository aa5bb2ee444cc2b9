"""Residuals over the working points, and model over measurement."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pushbelt.style import BLUE, MUTED, ORANGE, STYLE

from .results import Results, Row

ACROSS = (
    ("torque, N·m", lambda row: row.point.torque),
    ("ratio", lambda row: row.point.ratio or row.point.speed_ratio),
)
"""What residuals are drawn over."""


def residuals(results: Results, quantity: str) -> Figure:
    """Model over measurement, and residuals in standard deviations over torque and ratio, before and after."""
    rows = results.of(quantity)
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 3, figsize=(11.2, 2.9), layout="constrained")
        _compared(axes[0], rows, quantity)
        for axis, (label, across) in zip(axes[1:], ACROSS, strict=True):
            _over(axis, rows, label, across)
        axes[1].set_title("Residual, standard deviations")
        axes[1].legend(loc="best")
    return figure


def _compared(axis, rows: list[Row], quantity: str) -> None:
    measured = np.array([row.measured.value for row in rows])
    for side, colour, size in (("before", MUTED, 9), ("after", BLUE, 16)):
        found = np.array([np.nan if getattr(row, side) is None else getattr(row, side) for row in rows])
        axis.scatter(measured, found, s=size, color=colour, alpha=0.8, linewidths=0)
    ends = [measured.min(), measured.max()]
    axis.plot(ends, ends, color=ORANGE, linewidth=1.0, zorder=0)
    axis.set_title(f"{quantity}: model over measurement")
    axis.set_xlabel("measured")
    axis.set_ylabel("model")


def _over(axis, rows: list[Row], label: str, across) -> None:
    places = np.array([across(row) for row in rows])
    after = np.array([row.relative for row in rows], dtype=float)
    before = np.array([np.nan if row.relative_before is None else row.relative_before for row in rows])
    axis.axhspan(-2.0, 2.0, color=BLUE, alpha=0.08, linewidth=0)
    axis.scatter(places, before, s=9, color=MUTED, alpha=0.7, linewidths=0, label="start values")
    axis.scatter(places, after, s=16, color=BLUE, linewidths=0, label="fitted")
    # The start may be far off: what is left after the fit decides the scale.
    reach = 1.3 * max(3.0, float(np.abs(after).max()))
    axis.set_ylim(-reach, reach)
    axis.set_xlabel(label)
    beyond = int(np.sum(np.abs(before) > reach))
    if beyond:
        axis.text(
            0.99,
            0.02,
            f"{beyond} of the start values beyond",
            transform=axis.transAxes,
            ha="right",
            color=MUTED,
            fontsize=7.5,
        )
