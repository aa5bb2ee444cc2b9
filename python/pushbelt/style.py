"""Colours of all figures, and the style of figures that are images."""

from __future__ import annotations

import math

INK, MUTED, GRID = "#1d2733", "#6b7785", "#e3e7ec"

BLUE, ORANGE, GREEN, RED, VIOLET = "#1874dc", "#be840b", "#05a75d", "#8e0c1a", "#830196"
"""Any two of these, `INK` and `MUTED` are distinguishable for colour-blind readers. A test simulates their colour vision."""

COLOUR_SCALE = ("#dbe5ee", "#8fbfe0", "#2f7fc1", "#5b2d91", "#2b0a3d")
"""Colours from small to large values. They become darker, so that the scale also works in grey."""

SHOWN = {"rad/s": (30.0 / math.pi, "rpm"), "N": (1e-3, "kN"), "Pa": (1e-6, "MPa")}


def in_figures(unit: str) -> tuple[float, str]:
    """Factor and unit in which figures show values of an SI unit: speeds in rpm, forces in kN, stress in MPa."""
    return SHOWN.get(unit, (1.0, unit))


STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titlecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "axes.grid": True,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "axes.axisbelow": True,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.4,
}
"""Settings of matplotlib."""
