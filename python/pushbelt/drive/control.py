"""Controllers of the variator: clamping, slip, ratio. They are discrete and called once per control step; SI units.

Their inputs are the measured values of a transmission: speeds, the ratio (from a sheave position), and the torque that the
engine control estimates. Their model of the variator consists of friction, geometry and the thrust-ratio map.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from pushbelt.fmu.data import clamping_force

from .piecewise import clip
from .thrust_map import ThrustMap


class Measured(NamedTuple):
    primary_speed: float  # rad/s
    ratio: float  # Geometric ratio r_S/r_P
    slip: float  # 1
    macro_slip: bool
    pitch_radius: float  # Primary running radius, m
    torque: float  # Larger of the present and the demanded primary torque, with the sign of the present one, N·m

    @classmethod
    def from_signals(cls, signals: Mapping[str, float], torque: float) -> Measured:
        """Measured values from signals by the names of FMU variables and the estimated torque, N·m."""
        speed, ratio, slip, radius = (signals[name] for name in ("primary.speed", "ratio.geometric", "slip", "primary.radius"))
        return cls(speed, ratio, slip, bool(signals["macroSlip"]), radius, torque)


class Friction(NamedTuple):
    """Parameters of the belt in the clamping law."""

    coefficient: float  # μ
    wedge_angle: float  # β, rad
    reserve: float = 8.0
    """Torque added for effects that the estimate neglects (inertia of the pulley, drag of the shaft, errors), N·m."""

    def clamping_force(self, measured: Measured, safety: float) -> float:
        """Secondary clamping force for the estimated torque, N."""
        return self.carrying(abs(measured.torque) + self.reserve, measured, safety)

    def carrying(self, torque: float, measured: Measured, safety: float = 1.0) -> float:
        """Clamping force that carries a torque in N·m, N."""
        return clamping_force(torque, measured.pitch_radius, self.coefficient, self.wedge_angle, safety)


class SafetyFactor:
    """Fixed safety factor: the force follows the estimated torque and does not depend on slip."""

    intervening = False
    interventions = 0

    def __init__(self, friction: Friction, safety: float = 1.3) -> None:
        self.friction, self.safety = friction, safety

    def force(self, measured: Measured, step: float, overruled: bool = False) -> float:
        """Secondary clamping force, N."""
        return self.friction.clamping_force(measured, self.safety)


class SlipControl:
    """PI controller of the slip by the secondary force, with intervention against macro-slip.

    The set point is the slip of the map at a torque utilisation u. The feed-forward is the force of that utilisation, and the
    PI controller scales it within limits:

        F_S = F_ff · clip(1 + k_p e + k_i ∫e dt, low, high),   e = |slip| − set point

    u is `utilisation`, or less where there is no steady state or where the flywheel would make the ratio unstable. A shift
    accelerates the engine and so loads the belt by J ω_P λ. Where the thrust ratio falls with torque, this load increases the
    shift by the share

        Γ = −dκ/du · J g ω_P² cosβ/(2 μ r_P)

    of the force that caused it. u is the largest value at which Γ is below 1. It also bounds the factor: the force is never
    below that of this utilisation, whatever the slip is.

    The integrator stops while the factor is at a limit in its direction, and while the ratio control applies a larger force.
    Slip beyond twice its set point plus 1 %, or macro-slip, sets the factor to `rescue` at once. The factor is held for a
    while, and then falls only as fast as the integrator reduces it. At low speeds, where slip cannot be measured well, the
    fixed safety factor is used.
    """

    PROPORTIONAL = 10.0  # Gain of the relative force over slip
    INTEGRAL = 25.0  # Integral gain of the relative force over slip, 1/s
    LOW, HIGH, RESCUE = 0.9, 1.6, 1.5
    HOLD = 0.3  # Least duration of an intervention, s
    LEAST_SPEED = 60.0  # Least speed of the primary pulley for slip control, rad/s
    utilisation = 0.9  # Torque utilisation of the set point

    def __init__(self, friction: Friction, thrust_map: ThrustMap, flywheel: float) -> None:
        """`flywheel` is the inertia that the engine adds to the primary pulley, kg·m²."""
        self.friction, self.map, self.flywheel = friction, thrust_map, flywheel
        self.fallback, self.interventions = SafetyFactor(friction), 0
        self._integral = self._rescue_left = 0.0

    @property
    def intervening(self) -> bool:
        """Whether an intervention is in progress."""
        return self._rescue_left > 0.0

    def stable_utilisation(self, measured: Measured) -> float:
        """Torque utilisation beyond which the flywheel makes the ratio unstable."""
        secondary = self.friction.clamping_force(measured, 1.0 / self.utilisation)
        gain = self.map.shift_gain(measured.ratio, self.utilisation, secondary=secondary)
        torque_per_force = self.flywheel * gain * measured.primary_speed**2
        return self.map.stable_utilisation(measured.ratio, torque_per_force * self.friction.carrying(1.0, measured))

    def set_point(self, ratio: float, utilisation: float) -> float:
        """Set point of the magnitude of slip, 1."""
        return abs(self.map.slip(ratio, utilisation))

    def force(self, measured: Measured, step: float, overruled: bool = False) -> float:
        """Secondary clamping force for the next `step` seconds, N. `overruled`: the ratio control used a larger one before."""
        if measured.primary_speed < self.LEAST_SPEED:
            self._integral = self._rescue_left = 0.0
            return self.fallback.force(measured, step)
        stable, slip = self.stable_utilisation(measured), abs(measured.slip)
        utilisation = min(self.utilisation, stable)
        wanted = self.set_point(measured.ratio, math.copysign(utilisation, measured.torque))
        if measured.macro_slip or slip > 2.0 * wanted + 0.01:
            self.interventions += not self.intervening
            self._rescue_left = self.HOLD
        error = slip - wanted
        feed_forward = self.friction.clamping_force(measured, 1.0 / utilisation)
        if self.intervening:
            self._rescue_left -= step
            self._integral = self.RESCUE - 1.0
            return self.RESCUE * feed_forward
        factor = 1.0 + self.PROPORTIONAL * error + self._integral
        low = max(self.LOW, utilisation / stable)
        if not overruled and (factor > low or error > 0.0) and (factor < self.HIGH or error < 0.0):
            self._integral += step * self.INTEGRAL * error
        return clip(factor, low, self.HIGH) * feed_forward


class RatioControl:
    """Primary clamping force from the thrust-ratio map and a PI controller on the shift speed.

    The ratio error determines a demanded shift speed, λ* = clip(k (ln i* − ln i), ±λ_max) with λ = d(ln i)/dt. The belt shifts
    according to the excess ε = ln(F_P/(κ F_S)) of the thrust ratio over the one that holds the ratio, λ = −ω_P F R(ε), so

        F_P = κ(i, u) F_S exp(R⁻¹(−λ*/(ω_P F))) − C (k_p e + k_i ∫e dt),   e = λ* − λ

    κ is the thrust ratio of the map at the ratio and the torque utilisation u, and R are the map's shift rates. With R
    proportional to ε this is the law of Carbone, Mangialardi and Mantriota (J. Mech. Des. 127, 2005). F is the acting force of the map.
    C = 1/(g ω_P) gives the loop its design bandwidth. g is the largest gain near the demanded excess, because the slope of R may change
    sharply: a belt that shifts by creep hardly moves until its elements slide radially. Where g is small, C is limited to `MOST_FORCE`.

    k_p and a short filter damp the effect of the flywheel when a shift changes its speed (docs/controllers.md). The integral
    is stored as a force and is constant while F_P is at a limit in its direction. The primary force is never below the one
    that carries the torque: for a faster shift down the secondary force rises instead. A standing belt is held the same way.
    """

    APPROACH = 3.0  # k, 1/s
    FASTEST = 1.0  # λ_max, 1/s
    PROPORTIONAL, INTEGRAL = 0.8, 3.0  # k_p, 1, and k_i, 1/s
    MOST_FORCE = 20e3  # Largest C, N·s
    RESERVE = 1.1  # Safety of the primary force against slip
    LEAST_SPEED = 40.0  # Below this speed, rad/s, the belt hardly shifts and only the map is used
    FILTER = 0.01  # Time constant of the measured shift speed, s

    def __init__(self, friction: Friction, thrust_map: ThrustMap, limits: tuple[float, float]) -> None:
        self.friction, self.map, self.limits = friction, thrust_map, limits
        self._integral = self._shift_speed = 0.0
        self._last: float | None = None

    def forces(self, target: float, measured: Measured, secondary: float, step: float) -> tuple[float, float]:
        """Primary and secondary clamping force, N, for a target ratio and a secondary force that carries the torque."""
        low, high = self.limits
        secondary = clip(secondary, low, high)
        ratio_log = math.log(measured.ratio)
        last = ratio_log if self._last is None else self._last
        self._shift_speed += step / (self.FILTER + step) * ((ratio_log - last) / step - self._shift_speed)
        self._last = ratio_log
        if measured.primary_speed < self.LEAST_SPEED:
            self._integral = 0.0
            primary = self._shifting(0.0, measured, secondary)
            if primary < low:
                primary, secondary = low, self._secondary_for(low, 0.0, measured, secondary)
            return min(primary, high), secondary
        wanted = clip(self.APPROACH * (math.log(target) - ratio_log), -self.FASTEST, self.FASTEST)
        error = wanted - self._shift_speed
        gain = self.map.shift_gain(measured.ratio, self._utilisation(measured, secondary), self._excess(wanted, measured, secondary), secondary)
        per_speed = min(1.0 / (gain * measured.primary_speed), self.MOST_FORCE)  # C of the control law, N·s
        correction = per_speed * self.PROPORTIONAL * error + self._integral
        primary = self._shifting(wanted, measured, secondary) - correction
        least = max(self.friction.clamping_force(measured, self.RESERVE), low)
        saturated_down = False
        if primary < least:
            secondary = self._secondary_for(least + correction, wanted, measured, secondary)
            primary, saturated_down = least, secondary >= high
        if not (primary > high and error < 0.0) and not (saturated_down and error > 0.0):
            self._integral += step * per_speed * self.INTEGRAL * error
        return min(primary, high), secondary

    def _utilisation(self, measured: Measured, secondary: float) -> float:
        """Torque utilisation under a secondary force in N, with the sign of the torque."""
        return math.copysign(min(self.friction.carrying(measured.torque, measured) / secondary, 1.0), measured.torque)

    def _excess(self, wanted: float, measured: Measured, secondary: float) -> float:
        """ε for a shift speed λ, 1/s, at a secondary force, N."""
        rate = -wanted / (max(measured.primary_speed, self.LEAST_SPEED) * self.map.acting_force(secondary))
        return self.map.excess(measured.ratio, self._utilisation(measured, secondary), rate)

    def _shifting(self, wanted: float, measured: Measured, secondary: float) -> float:
        """Primary force for a shift speed λ, 1/s, at a secondary force, N."""
        held = self.map.thrust_ratio(measured.ratio, self._utilisation(measured, secondary)) * secondary
        return held * math.exp(self._excess(wanted, measured, secondary))

    def _secondary_for(self, primary: float, wanted: float, measured: Measured, secondary: float) -> float:
        """Secondary force between the given one and the limit that gives the shift speed at a primary force, N; by bisection."""
        below, above = secondary, self.limits[1]
        for _ in range(12):
            middle = 0.5 * (below + above)
            below, above = (middle, above) if self._shifting(wanted, measured, middle) < primary else (below, middle)
        return above
