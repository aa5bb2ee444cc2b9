"""Tilt of a loaded sheave: a clearance, then bending.

M(a) = k (s a + (1 − s) ⟨a − c⟩₊) with a = √(ψ² + δ²), s = 0.02, δ = 0.02 c and ⟨x⟩₊ = ½(x + √(x² + (0.05 c)²)); the moment along ψ
is M ψ/a. Without clearance it is k ψ. The law and its derivation are in `src/tilt.rs`.
"""

from __future__ import annotations

from math import hypot

from scipy.optimize import brentq

SOFT, ROUNDING, BEARING = 0.02, 0.02, 0.05
"""s; δ and the width of the transition to bending, relative to the clearance."""


RIGID = 1e12
"""Stiffness above which a sheave is rigid, N·m/rad."""


def moment_of(psi: float, stiffness: float, clearance: float) -> float:
    """Moment under which a sheave tilts by `psi` (rad), N·m."""
    if clearance == 0.0:
        return stiffness * psi
    amplitude = hypot(psi, ROUNDING * clearance)
    beyond = 0.5 * (amplitude - clearance + hypot(amplitude - clearance, BEARING * clearance))
    return stiffness * (SOFT * amplitude + (1.0 - SOFT) * beyond) * psi / amplitude


def tilt_under(moment: float, stiffness: float, clearance: float) -> float:
    """Tilt of a sheave under a moment (N·m), rad. It is at most the sum of clearance and bending."""
    if stiffness >= RIGID or moment <= 0.0:
        return 0.0
    most = clearance + moment / ((1.0 - SOFT) * stiffness)
    return float(brentq(lambda psi: moment_of(psi, stiffness, clearance) - moment, 0.0, most, xtol=1e-16))
