"""The cycles of a revolution by rainflow counting."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
import rainflow

from pushbelt.fmu.geometry import Array

from .table import AMPLITUDE, FIELD, MEAN, PULLEYS, Table

OTHERS = "other cycles"  # Part of a stress along the ring, besides its largest cycle


@dataclass(frozen=True)
class Cycles:
    """Cycles of each revolution, arrays of shape (rows, cycles)."""

    amplitude: Array
    mean: Array
    count: Array
    column: str  # Column of the mean stress.


def count_loop(stress: Array) -> list[tuple[float, float, float]]:
    """Amplitude, mean and number of the cycles of a closed loop, largest first, by rainflow counting from its largest value around to it."""
    start = int(np.argmax(stress))
    loop = np.concatenate([stress[start:], stress[: start + 1]])
    found: Counter[tuple[float, float]] = Counter()
    for span, mean, count, _, _ in rainflow.extract_cycles(loop.tolist()):
        if span > 0.0:
            found[(0.5 * span, mean)] += count
    return [(*cycle, found[cycle]) for cycle in sorted(found, reverse=True)]


def cycles(table: Table) -> dict[str, Cycles]:
    """The cycles of a revolution at each row, by name of the part: from the outputs of each pulley, or counted on the stress along the ring.

    No cycle spans several revolutions.
    """
    if table.field is None:
        columns = {p: (AMPLITUDE.format(p), MEAN.format(p)) for p in PULLEYS}
        once = np.ones((len(table.lines), 1))
        return {f"{p} pulley": Cycles(table[a][:, None], table[m][:, None], once, m) for p, (a, m) in columns.items()}
    counted = [count_loop(row) for row in table.field]
    most = max(2, *(len(row) for row in counted))
    padded = np.array([row + [(0.0, 0.0, 0.0)] * (most - len(row)) for row in counted])
    parts = {"largest cycle": padded[:, :1], OTHERS: padded[:, 1:]}
    return {name: Cycles(part[..., 0], part[..., 1], part[..., 2], f"{FIELD}[…]") for name, part in parts.items()}
