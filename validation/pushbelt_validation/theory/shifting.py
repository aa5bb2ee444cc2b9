"""Speed of ratio change by the continuum theory of `cmm` with A not 0.

Sources
-------
G. Carbone, L. Mangialardi, G. Mantriota: "The Influence of Pulley Deformations on the Shifting Mechanism of Metal Belt
CVT", J. Mech. Des. 127 (2005) 103-113: the equations of an arc.
G. Carbone, L. Mangialardi, B. Bonsen, C. Tursi, P. A. Veenhuizen: "CVT dynamics: theory and experiments", Mechanism and
Machine Theory 42 (2007) 409-428: the law in this form, and measurements.

Law
---
    ds/dt = omega_P a Delta g(s) [ln(F_P/F_S) - ln(F_P/F_S)_eq],   a = (1 + cos^2 beta)/sin 2 beta

s = R_P/R_S is the speed ratio, Delta the sheaves' deformation, rad, that of P where the pulleys' differ. The torque of each
pulley determines its strand forces, which are equal without load, and with them the creep B of an arc for each A. The creep is
small beside the speed of the belt, which does not stretch:

    dR_P/dt = A_P omega_P R_P a Delta_P,   alpha_P dR_P/dt + alpha_S dR_S/dt = 0,   omega_P R_P = omega_S R_S
    hence  A_S = -A_P (alpha_P/alpha_S) Delta_P/Delta_S  and  ds/dt = omega_P a Delta s (1 + s alpha_P/alpha_S) A_P

The axial forces of both arcs follow from A_P and A_S, and with them ln(F_P/F_S). It is nearly linear in A_P: at
A_P = 0.2, a thrust ratio 1.2 times that of equilibrium, the slope is within 2 % of that at rest.

Validity: that of `cmm`. Inertia, sheave damping and forces of the axial motion are neglected.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import atanh, exp, inf, log

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from . import cmm
from .cmm import Arc, Array

WIDEST = 3.0
"""Creep is searched between -1 - sinh 3 and -1 + sinh 3, which is full slip for |A| up to 2."""

SMALL = 0.1
"""|A_P| of the difference quotient of g about rest."""


@lru_cache(maxsize=10_000)
def shifting_arc(wrap: float, beta: float, mu: float, shift: float, traction: float = 0.0) -> Arc:
    """Arc with this traction while its radius changes at A = `shift`; angles in rad."""

    def excess(u: float) -> float:
        return cmm.log_ratio(wrap, beta, mu, cmm.creep_of(u), shift) - 2.0 * atanh(traction)

    u = float(brentq(excess, -WIDEST, WIDEST, xtol=1.0e-12))
    return cmm.arc_at_creep(wrap, beta, mu, cmm.creep_of(u), shift)


@dataclass(frozen=True)
class Shift:
    """Solution for a belt whose ratio changes."""

    primary: Arc
    secondary: Arc
    rate: float
    """ds/dt in units of omega_P a Delta."""

    @property
    def log_thrust_ratio(self) -> float:
        """ln(S_P/S_S)."""
        return log(self.primary.thrust / self.secondary.thrust)


@dataclass(frozen=True)
class Belt:
    """A belt on two pulleys, described by its pitch line."""

    beta: float
    """Half wedge angle, rad."""
    mu: float
    """Friction coefficient between element and sheave."""
    center_distance: float
    """m."""
    pitch_length: float
    """m."""

    def shift(self, speed_ratio: float, primary_shift: float, openings: float = 1.0, torque: float = 0.0) -> Shift:
        """Solution at s = R_P/R_S with A_P on the primary pulley; `openings` is Delta_P/Delta_S, `torque` T_P/(S_S R_P)."""
        wrap_p, wrap_s, _, _ = cmm.wrap_angles(1.0 / speed_ratio, self.center_distance, self.pitch_length)

        def secondary_at(traction: float) -> Arc:
            return shifting_arc(wrap_s, self.beta, self.mu, -primary_shift * openings * wrap_p / wrap_s, traction)

        secondary, traction = secondary_at(0.0), inf
        while abs((following := 0.5 * torque * secondary.thrust) - traction) > 1.0e-10:
            traction, secondary = following, secondary_at(following)
        primary = shifting_arc(wrap_p, self.beta, self.mu, primary_shift, -traction)
        return Shift(primary, secondary, speed_ratio * (1.0 + speed_ratio * wrap_p / wrap_s) * primary_shift)

    def equilibrium(self, speed_ratio: float) -> float:
        """ln(F_P/F_S) that holds a speed ratio without load."""
        return self.shift(speed_ratio, 0.0).log_thrust_ratio

    def gain(self, speed_ratio: float, openings: float = 1.0, torque: float = 0.0) -> float:
        """g(s): ds/dt in units of omega_P a Delta_P per unit of ln(F_P/F_S), about equilibrium at T_P/(S_S R_P)."""
        up, down = (self.shift(speed_ratio, sign * SMALL, openings, torque) for sign in (1.0, -1.0))
        return (up.rate - down.rate) / (up.log_thrust_ratio - down.log_thrust_ratio)


@dataclass(frozen=True)
class ShiftLaw:
    """The law over the speed ratio: splines of ln g and of the equilibrium through the places at which the theory was solved."""

    belt: Belt
    speed_ratios: tuple[float, ...]
    """Places, ascending; at least four."""

    @cached_property
    def _splines(self) -> tuple[CubicSpline, CubicSpline]:
        places = np.log(self.speed_ratios)
        gains = [log(self.belt.gain(s)) for s in self.speed_ratios]
        return CubicSpline(places, gains), CubicSpline(places, [self.belt.equilibrium(s) for s in self.speed_ratios])

    def gain(self, speed_ratio: float) -> float:
        """g(s)."""
        return exp(float(self._splines[0](log(speed_ratio))))

    def equilibrium(self, speed_ratio: float) -> float:
        """ln(F_P/F_S) that holds a speed ratio."""
        return float(self._splines[1](log(speed_ratio)))

    def run(self, start: float, log_step: float, speed: float, opening: float, times: Array) -> Array:
        """Speed ratio at times from 0 on, s, after ln(F_P/F_S) has risen by `log_step` above equilibrium at `start`.
        Primary speed in rad/s, opening Delta in rad. One step of the classical Runge-Kutta scheme per time."""
        force = self.equilibrium(start) + log_step
        factor = speed * cmm.deformation_factor(self.belt.beta) * opening

        def slope(s: float) -> float:
            return factor * self.gain(s) * (force - self.equilibrium(s))

        found, s, before = [], start, 0.0
        for time in times:
            h, before = float(time) - before, float(time)
            first = slope(s)
            second = slope(s + 0.5 * h * first)
            third = slope(s + 0.5 * h * second)
            fourth = slope(s + h * third)
            s += h * (first + 2.0 * second + 2.0 * third + fourth) / 6.0
            found.append(s)
        return np.array(found)
