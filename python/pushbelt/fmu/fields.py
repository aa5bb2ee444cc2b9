"""Evaluation of fields along the belt: means between places, gain of push force over arcs."""

from __future__ import annotations

import numpy as np

from .geometry import Array, TwoPulleyCurve

EDGE = 0.012
"""Least distance from the arcs at which a field on a strand is read, m. Pressure extends some millimetres beyond the arcs."""


def push_force_gains(curve: TwoPulleyCurve, position: Array, push_force: Array) -> tuple[float, float, float]:
    """Change of the push force over the primary arc, the push strand and the secondary arc, N."""
    _, upper_start, upper_end, lower_start, lower_end, _ = curve.borders
    places = [upper_end - EDGE, lower_start + EDGE, lower_end - EDGE, upper_start + EDGE]
    return tuple(np.diff(np.interp(places, position, push_force)).tolist())
