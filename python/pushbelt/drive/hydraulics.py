"""Pressure circuits of the two pulleys."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .piecewise import clip


@dataclass
class PressureCircuit:
    """A valve and a piston: first-order lag with limits of pressure and of its rate, in steps of 1 ms.

        dp/dt = clip((p_demand − p)/τ, −rate, rate),   p_min ≤ p_demand ≤ p_max,   F = A p

    Values are typical; they are not from a source.
    """

    pressure: float
    """Pa."""
    area: float = 0.01
    """m²."""
    lag: float = 0.05
    """s."""
    lowest: float = 2e5
    """Pa."""
    highest: float = 6e6
    """Pa."""
    rate: float = 4e7
    """Pa/s."""
    substep: float = 1e-3
    """s."""

    @property
    def force(self) -> float:
        """Clamping force now, N."""
        return self.area * self.pressure

    @property
    def limits(self) -> tuple[float, float]:
        """Least and largest clamping force, N."""
        return self.area * self.lowest, self.area * self.highest

    def advance(self, demand: float, step: float) -> float:
        """Advances by a communication step towards a demanded clamping force, N; returns the mean pressure over the step, Pa."""
        wanted = clip(demand / self.area, self.lowest, self.highest)
        count = max(round(step / self.substep), 1)
        dt = step / count
        # Exact for a constant demand, so that the solution does not oscillate for any time constant.
        share, most = -math.expm1(-dt / self.lag), self.rate * dt
        impulse = 0.0
        for _ in range(count):
            before = self.pressure
            self.pressure += clip((wanted - before) * share, -most, most)
            impulse += 0.5 * dt * (before + self.pressure)
        return impulse / step
