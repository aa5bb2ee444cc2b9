"""The theory of the published reference case in closed form.

A continuous belt runs on rigid sheaves with friction along the belt only. On each pulley the net strand force F is constant from
the entry on (idle arc) and changes along a slip arc γ (active arc) at the exit,

    (F_u − σV²)/(F_l − σV²) = exp(μγ/sinβ),

and the axial force of a pulley is the radial balance without friction along the flank,

    S = ∫ (F − σV²) dα / (2 tanβ).

Here F_u and F_l are the net forces (ring tension minus push force) of the upper and lower strand, σ the mass of the belt
per length and V its speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from .results import StrandForces


@dataclass(frozen=True)
class ContinuousBelt:
    """A belt on two pulleys at one working point."""

    wrap_primary: float
    """Wrap angle on P, rad."""
    wrap_secondary: float
    """Wrap angle on S, rad."""
    wedge_angle: float
    """Half wedge angle β, rad."""
    friction: float
    """Friction coefficient μ."""
    centrifugal: float
    """σV², N."""

    def slip_arc(self, strands: StrandForces) -> float:
        """Slip arc γ, rad; the same on both pulleys."""
        upper, lower = strands.upper - self.centrifugal, strands.lower - self.centrifugal
        return float(np.sin(self.wedge_angle) / self.friction * np.log(upper / lower))

    def axial_forces(self, strands: StrandForces) -> tuple[float, float]:
        """Axial forces of P and S, N. The upper strand enters P, the lower one S."""
        upper, lower = strands.upper - self.centrifugal, strands.lower - self.centrifugal
        arc = self.slip_arc(strands)
        mean = (upper - lower) / np.log(upper / lower)
        return tuple(
            float((entry * (wrap - arc) + mean * arc) / (2.0 * np.tan(self.wedge_angle)))
            for entry, wrap in ((upper, self.wrap_primary), (lower, self.wrap_secondary))
        )  # type: ignore[return-value]

    def strand_forces(self, secondary_force: float, difference: float) -> StrandForces:
        """Strand forces for an axial force on S and a difference of the strand forces (torque over radius), N."""

        def excess(lower: float) -> float:
            return self.axial_forces(StrandForces(lower + difference, lower))[1] - secondary_force

        lower = brentq(excess, self.centrifugal + 1.0, self.centrifugal + secondary_force, xtol=1e-9)
        return StrandForces(float(lower) + difference, float(lower))
