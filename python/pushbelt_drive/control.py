"""Controllers of the variator: clamping, slip, ratio. Discrete, one call a control step; SI units.

They read what a transmission measures: speeds, the ratio (from a sheave position), the torque that the engine control
estimates. Friction, geometry and the thrust-ratio map are what they know of the variator.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .thrust_map import ThrustMap


def clamping_force(torque: float, pitch_radius: float, friction: float, wedge_angle: float, safety: float) -> float:
    """Clamping force that carries a torque with a safety factor: F_S = S_f |T_P| cosβ/(2 μ r_P), N.

    Torque in N·m, pitch radius on the primary pulley in m (positive), wedge angle β in rad, safety 1 or more.
    """
    return safety * abs(torque) * math.cos(wedge_angle) / (2.0 * friction * pitch_radius)


@dataclass(frozen=True)
class Measured:
    """What the controllers see at a control step."""

    primary_speed: float
    """rad/s."""
    ratio: float
    """Geometric ratio r_S/r_P."""
    slip: float
    """1."""
    macro_slip: bool
    pitch_radius: float
    """Primary running radius, m."""
    torque: float
    """Larger of the primary torques now and as demanded, with the sign of the torque now, N·m."""


@dataclass(frozen=True)
class Friction:
    """What the clamping law needs to know of the belt."""

    coefficient: float
    """μ."""
    wedge_angle: float
    """β, rad."""
    reserve: float = 8.0
    """Torque added for what the estimate leaves out (inertia of the pulley, errors), N·m."""

    def clamping_force(self, measured: Measured, safety: float) -> float:
        """Secondary clamping force for the estimated torque, N."""
        torque = abs(measured.torque) + self.reserve
        return clamping_force(torque, measured.pitch_radius, self.coefficient, self.wedge_angle, safety)


class ClampingStrategy(Protocol):
    """Gives the secondary clamping force."""

    def force(self, measured: Measured, step: float) -> float:
        """Secondary clamping force for the next step of `step` seconds, N."""
        ...

    @property
    def intervening(self) -> bool:
        """Whether it acts against macro-slip."""
        ...


class SafetyFactor:
    """Fixed safety factor: the force follows the estimated torque, blind to slip."""

    intervening = False

    def __init__(self, friction: Friction, safety: float = 1.3) -> None:
        self.friction, self.safety = friction, safety

    def force(self, measured: Measured, step: float) -> float:  # noqa: ARG002
        """Secondary clamping force, N."""
        return self.friction.clamping_force(measured, self.safety)


class SlipControl:
    """PI on the secondary force to a slip set point, with intervention when macro-slip threatens.

    The set point is the slip that the map has at a torque utilisation of `utilisation`; the feed-forward is the force
    of that utilisation, and the PI scales it within limits:

        F_S = F_ff · clip(1 + k_p e + k_i ∫e dt, low, high),   e = |slip| − set point

    The integral stands still while the factor is at a limit in its direction. Slip beyond twice its set point and 1 %
    more, or macro-slip, makes the factor `rescue` at once; it is held for a while, then comes down no faster than the
    integral brings it. Below a speed at which slip can't be measured well the fixed safety factor holds.
    """

    PROPORTIONAL = 10.0
    """Force per slip, relative."""
    INTEGRAL = 25.0
    """The same per second."""
    LOW, HIGH, RESCUE = 0.9, 1.6, 1.5
    HOLD = 0.3
    """How long an intervention lasts at least, s."""
    LEAST_SPEED = 60.0
    """Of the primary pulley, rad/s."""

    def __init__(
        self, friction: Friction, thrust_map: ThrustMap, utilisation: float = 0.9, safety: float = 1.3
    ) -> None:
        self.friction, self.map, self.utilisation = friction, thrust_map, utilisation
        self.fallback = SafetyFactor(friction, safety)
        self.interventions = 0
        self._integral = 0.0
        self._rescue_left = 0.0

    @property
    def intervening(self) -> bool:
        """Whether an intervention is on."""
        return self._rescue_left > 0.0

    def set_point(self, measured: Measured) -> float:
        """Magnitude of slip to hold, 1."""
        return abs(self.map.slip(measured.ratio, math.copysign(self.utilisation, measured.torque)))

    def force(self, measured: Measured, step: float) -> float:
        """Secondary clamping force, N."""
        if measured.primary_speed < self.LEAST_SPEED:
            self._integral = self._rescue_left = 0.0
            return self.fallback.force(measured, step)
        wanted = self.set_point(measured)
        slip = abs(measured.slip)
        if measured.macro_slip or slip > 2.0 * wanted + 0.01:
            if not self.intervening:
                self.interventions += 1
            self._rescue_left = self.HOLD
        error = slip - wanted
        feed_forward = self.friction.clamping_force(measured, 1.0 / self.utilisation)
        if self.intervening:
            self._rescue_left -= step
            self._integral = self.RESCUE - 1.0
            return self.RESCUE * feed_forward
        factor = 1.0 + self.PROPORTIONAL * error + self._integral
        if (factor > self.LOW or error > 0.0) and (factor < self.HIGH or error < 0.0):
            self._integral += step * self.INTEGRAL * error
        return float(np.clip(factor, self.LOW, self.HIGH)) * feed_forward


class RatioControl:
    """Primary clamping force from the thrust-ratio map and a PI controller on the shift speed.

    The ratio error asks for a shift speed, λ* = clip(k (ln i* − ln i), ±λ_max) with λ = d(ln i)/dt. To first order the
    belt shifts with the excess of the primary force over equilibrium, λ = −g ω_P (F_P − κ(i, u) F_S), so

        F_P = κ(i, u) F_S − (λ* + k_p e + k_i ∫e dt)/(g ω_P),   e = λ* − λ

    κ is the thrust ratio of the map at the ratio and the torque utilisation u, g the shift gain at the ratio. k_p and a short
    filter damp what the flywheel does when a shift changes its speed (docs/drivetrain.md). The integral stands
    still while F_P is at a limit in its direction. A primary force below what carries the torque is not allowed:
    to shift down faster the secondary force rises instead.
    """

    APPROACH = 3.0
    """k, 1/s."""
    FASTEST = 1.0
    """λ_max, 1/s."""
    PROPORTIONAL, INTEGRAL = 1.0, 3.0
    """k_p, 1, and k_i, 1/s."""
    LEAST_SPEED = 40.0
    """Below it the belt hardly shifts: only the map acts, rad/s."""
    FILTER = 0.01
    """Time constant of the measured shift speed, s."""

    def __init__(self, friction: Friction, thrust_map: ThrustMap, limits: tuple[float, float]) -> None:
        self.friction, self.map, self.limits = friction, thrust_map, limits
        self._integral = 0.0
        self._shift_speed = 0.0
        self._last: float | None = None

    def forces(self, target: float, measured: Measured, secondary: float, step: float) -> tuple[float, float]:
        """Primary and secondary clamping force, N, for a target ratio and a secondary force that carries the torque."""
        low, high = self.limits
        secondary = float(np.clip(secondary, low, high))
        ratio_log = math.log(measured.ratio)
        last = ratio_log if self._last is None else self._last
        self._shift_speed += step / (self.FILTER + step) * ((ratio_log - last) / step - self._shift_speed)
        self._last = ratio_log
        carried = clamping_force(
            measured.torque, measured.pitch_radius, self.friction.coefficient, self.friction.wedge_angle, 1.0
        )
        kappa = self.map.thrust_ratio(measured.ratio, math.copysign(min(carried / secondary, 1.0), measured.torque))
        if measured.primary_speed < self.LEAST_SPEED:
            self._integral = 0.0
            return float(np.clip(kappa * secondary, low, high)), secondary
        wanted = self.APPROACH * (math.log(target) - ratio_log)
        wanted = float(np.clip(wanted, -self.FASTEST, self.FASTEST))
        error = wanted - self._shift_speed
        per_speed = 1.0 / (self.map.shift_gain(measured.ratio) * measured.primary_speed)
        primary = kappa * secondary - per_speed * (wanted + self.PROPORTIONAL * error + self._integral)
        least = max(self.friction.clamping_force(measured, 1.1), low)
        if primary < least:
            raised = min(secondary + (least - primary) / kappa, high)
            saturated_down = raised >= high
            secondary, primary = raised, least
        else:
            saturated_down = False
        saturated_up = primary > high
        if not (saturated_up and error < 0.0) and not (saturated_down and error > 0.0):
            self._integral += step * self.INTEGRAL * error
        return min(primary, high), secondary
