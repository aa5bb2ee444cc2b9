"""Time intervals in which a flag is true."""

from __future__ import annotations

import numpy as np

from .geometry import Array


def intervals(time: Array, flag: Array, gap: float = 0.0) -> list[tuple[float, float]]:
    """Time intervals in which a flag is true. Intervals less than `gap` seconds apart are merged."""
    up = np.concatenate([[False], np.asarray(flag) > 0.5, [False]])
    edges = np.flatnonzero(up[1:] != up[:-1])
    found: list[tuple[float, float]] = []
    for first, after in edges.reshape(-1, 2):
        start, end = float(time[first]), float(time[after - 1])
        if found and start - found[-1][1] <= gap:
            found[-1] = (found[-1][0], end)
        else:
            found.append((start, end))
    return found
