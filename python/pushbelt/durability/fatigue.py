"""Fatigue strength of the ring's steel, and the cycles of a revolution by rainflow counting."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
import rainflow
from numpy.typing import ArrayLike

from pushbelt.fmu.geometry import Array

from .table import AMPLITUDE, FIELD, MEAN, PULLEYS, Table


@dataclass(frozen=True)
class Material:
    """Haigh line and S-N curve. The defaults are engineering values for maraging steel rings (docs/durability.md)."""

    strength: float = 2.0e9
    """Tensile strength R_m, Pa."""
    limit: float = 6.0e8
    """Fatigue limit: amplitude without mean stress that half of the specimens bear, Pa."""
    knee: float = 1.0e7
    """Cycles to failure at the fatigue limit."""
    slope: float = 10.0
    """Exponent k of the S-N curve above the limit: cycles to failure are proportional to amplitude^-k."""
    safety: float = 1.5
    """Factor by which the limit is reduced, for scatter, the size of a ring, and what the stress leaves out."""

    def __post_init__(self) -> None:
        for name, low in (("strength", 1e6), ("limit", 1e6), ("knee", 1.0), ("slope", 1.0), ("safety", 0.1)):
            if not low <= getattr(self, name) <= 1e13:
                raise ValueError(f"{name} {getattr(self, name):g} is not within {low:g} to 1e13")
        if self.limit >= self.strength:
            raise ValueError(f"limit {self.limit:g} Pa is not below the strength, {self.strength:g} Pa")

    @property
    def allowed(self) -> float:
        """Fatigue limit with the safety factor, Pa."""
        return self.limit / self.safety

    def equivalent(self, amplitude: ArrayLike, mean: ArrayLike) -> Array:
        """Amplitude without mean stress that does the same damage (Goodman), Pa. Mean compression counts as no mean stress."""
        return np.asarray(amplitude) / (1.0 - np.maximum(mean, 0.0) / self.strength)

    def damage(self, equivalent: ArrayLike, limited: bool = True) -> Array:
        """Damage of a cycle: 1/cycles to failure. Below the limit it is 0, or with `limited` false the S-N curve continues."""
        share = np.asarray(equivalent) / self.allowed
        return np.where((share < 1.0) & limited, 0.0, share**self.slope / self.knee)


@dataclass(frozen=True)
class Cycles:
    """Cycles of each revolution, arrays of shape (rows, cycles)."""

    amplitude: Array
    mean: Array
    count: Array
    column: str
    """Column of the mean stress."""


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
        return {
            f"{pulley} pulley": Cycles(
                table[AMPLITUDE.format(pulley)][:, None],
                table[MEAN.format(pulley)][:, None],
                np.ones((len(table.lines), 1)),
                MEAN.format(pulley),
            )
            for pulley in PULLEYS
        }
    counted = [count_loop(row) for row in table.field]
    most = max(2, *(len(row) for row in counted))
    padded = np.array([row + [(0.0, 0.0, 0.0)] * (most - len(row)) for row in counted])
    parts = {"largest cycle": padded[:, :1], "other cycles": padded[:, 1:]}
    return {name: Cycles(part[..., 0], part[..., 1], part[..., 2], f"{FIELD}[…]") for name, part in parts.items()}
