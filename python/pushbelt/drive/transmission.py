"""The transmission control: target ratio, clamping forces and hydraulics. It is called once per control step."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .car import Car
from .control import ClampingStrategy, Friction, Measured, PressureControl, RatioControl, SafetyFactor, SlipControl
from .hydraulics import PressureCircuit
from .piecewise import clip
from .thrust_map import ThrustMap

RATIO_LIMITS = 0.46, 2.2
"""Range of the target ratio; the car starts at the upper end."""
START_PRESSURE = 8e5
"""Initial pressure of both circuits, Pa."""


@dataclass(frozen=True)
class ClampingSignals:
    """Outputs of the transmission control over a control step."""

    primary_pressure: float
    """Mean pressure in the primary cylinder, Pa."""
    secondary_pressure: float
    """Pa."""
    target_ratio: float
    intervening: bool
    """Whether the slip controller intervenes against macro-slip."""


def ratio_target(engine_speed: float, secondary_speed: float, before: float, step: float) -> float:
    """Target ratio at which the engine runs at its set-point speed. Its rate is limited to 120 % per second."""
    wanted = engine_speed / max(secondary_speed, 1.0)
    change = clip(math.log(clip(wanted, *RATIO_LIMITS) / before), -1.2 * step, 1.2 * step)
    return before * math.exp(change)


def strategy_of(name: str, friction: Friction, thrust_map: ThrustMap, flywheel: float) -> ClampingStrategy:
    """A clamping strategy: `safety` for the fixed safety factor, `slip` for slip control; the engine's inertia in kg·m².

    Raises ValueError for any other name.
    """
    strategies = {
        "safety": lambda: SafetyFactor(friction),
        "slip": lambda: SlipControl(friction, thrust_map, flywheel),
    }
    if name not in strategies:
        raise ValueError(f"{name!r} is not a clamping strategy: use {' or '.join(strategies)}")
    return strategies[name]()


class TransmissionControl:
    """Computes the target ratio from the demanded power, the clamping forces by strategy and ratio control, and the pressures.

    `scale` multiplies the secondary force that the strategy demands.
    """

    POWER_RISE, POWER_FALL = 0.3, 1.5
    """Time constants with which the ratio follows the demanded power, s."""

    def __init__(
        self, car: Car, strategy: str, friction: Friction, thrust_map: ThrustMap, scale: float = 1.0
    ) -> None:
        self.car, self._scale = car, scale
        self.clamping = strategy_of(strategy, friction, thrust_map, car.engine_inertia)
        self.primary, self.secondary = PressureCircuit(START_PRESSURE), PressureCircuit(START_PRESSURE)
        self.pressure = PressureControl(self.primary.lag)
        self.shifting = RatioControl(friction, thrust_map, self.primary.limits)
        self._overruled = False
        self._target, self._power = RATIO_LIMITS[1], 0.0

    @property
    def interventions(self) -> int:
        """Number of interventions of the slip controller so far."""
        return getattr(self.clamping, "interventions", 0)

    @property
    def signals(self) -> ClampingSignals:
        """The present pressures, as they act before the first step."""
        return ClampingSignals(self.primary.pressure, self.secondary.pressure, self._target, self.clamping.intervening)

    def advance(self, power_demand: float, secondary_speed: float, measured: Measured, step: float) -> ClampingSignals:
        """Computes the demands from the measured values and advances the hydraulics by a step, s. Power in W, speed in rad/s."""
        lag = self.POWER_RISE if power_demand > self._power else self.POWER_FALL
        self._power += (power_demand - self._power) * step / lag
        self._target = ratio_target(self.car.engine_speed_for(self._power), secondary_speed, self._target, step)
        needed = self._scale * self.clamping.force(measured, step, self._overruled)
        primary, secondary = self.shifting.forces(self._target, measured, needed, step)
        self._overruled = secondary > needed
        return ClampingSignals(
            self._close(self.primary, primary, step),
            self._close(self.secondary, secondary, step),
            self._target,
            self.clamping.intervening,
        )

    def _close(self, circuit: PressureCircuit, wanted: float, step: float) -> float:
        """Mean pressure of a circuit over a step towards a demanded force, N; Pa."""
        return circuit.advance(self.pressure.demand(wanted, circuit.force), step)
