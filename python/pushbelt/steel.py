"""Fatigue strength of the ring's steel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pushbelt.errors import ArgumentError
from pushbelt.fmu.geometry import Array

RANGES = {
    "strength": (100.0, 5000.0, " MPa"), "limit": (10.0, 3000.0, " MPa"), "knee": (1e3, 1e12, ""), "slope": (1.0, 50.0, ""),
    "safety": (1.0, 10.0, ""),
}  # fmt: skip
"""Range of each value. A value outside is most likely in another unit."""


def check_ranges(one: object, what: str, ranges: Mapping[str, tuple[float, float, str]]) -> None:
    """Raises ValueError for the first attribute outside its range, which is in SI units or in MPa."""
    for name, (low, high, unit) in ranges.items():
        value = getattr(one, name) * (1e-6 if unit == " MPa" else 1.0)
        if not low <= value <= high:
            raise ArgumentError(f"{name} of {what}: {value:g}{unit} is not within {low:g} to {high:g}{unit}")


@dataclass(frozen=True)
class Material:
    """Haigh line and S-N curve. The defaults are engineering values for maraging steel rings (docs/durability.md)."""

    strength: float = 2.0e9  # Tensile strength R_m, Pa
    limit: float = 6.0e8  # Fatigue limit: amplitude without mean stress that half of the specimens bear, Pa
    knee: float = 1.0e7  # Cycles to failure at the fatigue limit
    slope: float = 10.0  # Exponent k of the S-N curve above the limit: cycles to failure are proportional to amplitude^-k
    safety: float = 1.5  # Factor by which the limit is reduced, for scatter, the size of a ring, and what the stress leaves out

    def __post_init__(self) -> None:
        check_ranges(self, "the steel", RANGES)
        if self.limit >= self.strength:
            raise ArgumentError(f"limit of the steel: {1e-6 * self.limit:g} MPa is not below its strength, {1e-6 * self.strength:g} MPa")

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
