"""Colours of all figures, and the units of their values."""

import math
from collections.abc import Sequence

import numpy as np

INK, MUTED, GRID = "#1d2733", "#6b7785", "#e3e7ec"
BLUE, ORANGE, GREEN, RED, VIOLET = "#1874dc", "#be840b", "#05a75d", "#8e0c1a", "#830196"
"""Any two of these, `INK` and `MUTED` are distinguishable for colour-blind readers. A test simulates their colour vision."""
COLOUR_SCALE = ("#dbe5ee", "#8fbfe0", "#2f7fc1", "#5b2d91", "#2b0a3d")
"""Colours from small to large values. They become darker, so that the scale also works in grey."""
DIVERGING = ("#08305c", "#2f7fc1", "#a9cfe8", "#f6f6f4", "#f0c489", "#c06f14", "#5e2c02")
"""Colours from large negative values over zero to large positive ones. They become darker on both sides."""
RPM = 30.0 / math.pi  # rpm of a speed of 1 rad/s
SHOWN = {"rad/s": (RPM, "rpm"), "N": (1e-3, "kN"), "Pa": (1e-6, "MPa")}


def in_figures(unit: str) -> tuple[float, str]:
    """Factor and unit in which figures show values of an SI unit: speeds in rpm, forces in kN, stress in MPa."""
    return SHOWN.get(unit, (1.0, unit))


def colour_stops(middle: float | None = None) -> list[tuple[float, str]]:
    """Places from 0 to 1 on a colour scale, and their colours. They diverge from the place of zero, `middle`, if there is one."""
    if middle is None:
        return [(k / (len(COLOUR_SCALE) - 1), colour) for k, colour in enumerate(COLOUR_SCALE)]
    far, half = max(middle, 1.0 - middle), len(DIVERGING) // 2
    places = [middle + far * (k - half) / half for k in range(len(DIVERGING))]
    inside = sorted({0.0, 1.0, *(place for place in places if 0.0 < place < 1.0)})
    return list(zip(inside, mixed(DIVERGING, inside, places), strict=True))


def mixed(colours: Sequence[str], at: Sequence[float], places: Sequence[float] | None = None) -> list[str]:
    """Colours at places between others, which are evenly spaced from 0 to 1 by default."""
    between = np.linspace(0.0, 1.0, len(colours)) if places is None else places
    channels = [np.interp(at, between, [int(colour[k : k + 2], 16) for colour in colours]) for k in (1, 3, 5)]
    return ["#" + "".join(f"{round(value):02x}" for value in colour) for colour in zip(*channels, strict=True)]
