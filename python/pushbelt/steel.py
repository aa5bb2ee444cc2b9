"""Fatigue strength of the ring's steel."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pushbelt.errors import ArgumentError
from pushbelt.fmu.geometry import Array


def check_ranges(one: object, what: str, ranges: Mapping[str, tuple[float, float, str]]) -> None:
    """Raises ValueError for the first attribute outside its range, which is in SI units or in MPa."""
    for name, (low, high, unit) in ranges.items():
        value, shown = getattr(one, name) * (1e-6 if unit == " MPa" else 1.0), f" {unit.strip()}".rstrip()
        if not low <= value <= high:
            raise ArgumentError(f"{name} of {what}: {value:g}{shown} is not within {low:g} to {high:g}{shown}")


def _of(default: float, low: float, high: float, unit: str, text: str) -> Any:
    """A value with its range, outside of which it is most likely in another unit, and the text of its option."""
    return field(default=default, metadata={"range": (low, high, unit), "help": text})


@dataclass(frozen=True)
class Material:
    """Haigh line and S-N curve: cycles to failure are proportional to amplitude^-slope above the limit. Stresses are in Pa. The defaults are
    engineering values for maraging steel rings (docs/durability.md); the safety is for scatter, the size of a ring and what the stress leaves out."""

    strength: float = _of(2e9, 100.0, 5000.0, " MPa", "tensile strength R_m, MPa or with its unit")
    limit: float = _of(6e8, 10.0, 3e3, " MPa", "fatigue limit: amplitude without mean stress that half of the specimens bear, MPa or with its unit")
    knee: float = _of(1e7, 1e3, 1e12, "", "cycles to failure at the fatigue limit")
    slope: float = _of(10.0, 1.0, 50.0, "", "exponent of the S-N curve above the limit")
    safety: float = _of(1.5, 1.0, 10.0, "", "factor by which strength and limit are reduced")

    def __post_init__(self) -> None:
        check_ranges(self, "the steel", {one.name: one.metadata["range"] for one in fields(self)})
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
