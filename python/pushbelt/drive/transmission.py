"""The transmission control: target ratio, clamping forces and pressure circuits. It is called once per control step."""

import math
from dataclasses import dataclass

from pushbelt.errors import ArgumentError

from .control import Friction, Measured, RatioControl, SafetyFactor, SlipControl
from .piecewise import clip
from .thrust_map import ThrustMap
from .vehicle import Car

RATIO_LIMITS = 0.46, 2.2  # Range of the target ratio; the car starts at the upper end
START_PRESSURE = 8e5  # Initial pressure of both circuits, Pa


@dataclass
class PressureCircuit:
    """A valve and a piston: first-order lag with limits of pressure and of its rate, in steps of 1 ms.

        dp/dt = clip((p_demand − p)/τ, −rate, rate),   p_min ≤ p_demand ≤ p_max,   F = A p

    Pressure feedback changes the time constant τ to τ_c: the valve's demand is F + (τ/τ_c)(F* − F). Values are typical; they are not
    from a source.
    """

    pressure: float  # Pa
    area: float = 0.01  # m²
    lag: float = 0.05  # τ, s
    wanted_lag: float = 0.0125  # τ_c, s
    lowest: float = 2e5  # Pa
    highest: float = 6e6  # Pa
    rate: float = 4e7  # Pa/s
    substep: float = 1e-3  # s

    @property
    def force(self) -> float:
        """Clamping force now, N."""
        return self.area * self.pressure

    @property
    def limits(self) -> tuple[float, float]:
        """Least and largest clamping force, N."""
        return self.area * self.lowest, self.area * self.highest

    def demand(self, wanted: float) -> float:
        """Demand on the valve for a demanded clamping force, N."""
        return self.force + max(self.lag / self.wanted_lag, 1.0) * (wanted - self.force)

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


def ratio_target(engine_speed: float, secondary_speed: float, before: float, step: float) -> float:
    """Target ratio at which the engine runs at its set-point speed. Its rate is limited to 120 % per second."""
    wanted = engine_speed / max(secondary_speed, 1.0)
    change = clip(math.log(clip(wanted, *RATIO_LIMITS) / before), -1.2 * step, 1.2 * step)
    return before * math.exp(change)


class TransmissionControl:
    """Computes the target ratio from the demanded power, the clamping forces by strategy and ratio control, and the pressures.
    `strategy` is `safety` for the fixed safety factor, or `slip` for slip control; `scale` multiplies its secondary force."""

    POWER_RISE, POWER_FALL = 0.3, 1.5  # Time constants with which the ratio follows the demanded power, s

    def __init__(self, car: Car, strategy: str, friction: Friction, thrust_map: ThrustMap, scale: float = 1.0) -> None:
        self.car, self._scale = car, scale
        if strategy not in ("safety", "slip"):
            raise ArgumentError(f"{strategy!r} is not a clamping strategy: use safety or slip")
        slip_control = strategy == "slip"
        self.clamping = SlipControl(friction, thrust_map, car.engine_inertia) if slip_control else SafetyFactor(friction)
        self.primary, self.secondary = PressureCircuit(START_PRESSURE), PressureCircuit(START_PRESSURE)
        self.shifting = RatioControl(friction, thrust_map, self.primary.limits)
        self._overruled = False
        self._target, self._power = RATIO_LIMITS[1], 0.0
        self._pressures = {"primary.pressure": START_PRESSURE, "secondary.pressure": START_PRESSURE}

    @property
    def signals(self) -> dict[str, float]:
        """Mean pressures over the last step, Pa, target ratio, and whether the slip controller intervenes."""
        return {**self._pressures, "ratio.target": self._target, "intervening": self.clamping.intervening}

    def advance(self, power_demand: float, secondary_speed: float, measured: Measured, step: float) -> dict[str, float]:
        """Computes the demands from the measured values and advances the hydraulics by a step, s. Power in W, speed in rad/s."""
        lag = self.POWER_RISE if power_demand > self._power else self.POWER_FALL
        self._power += (power_demand - self._power) * step / lag
        self._target = ratio_target(self.car.engine_speed_for(self._power), secondary_speed, self._target, step)
        needed = self._scale * self.clamping.force(measured, step, self._overruled)
        primary, secondary = self.shifting.forces(self._target, measured, needed, step)
        self._overruled = secondary > needed
        for name, circuit, wanted in (("primary", self.primary, primary), ("secondary", self.secondary, secondary)):
            self._pressures[f"{name}.pressure"] = circuit.advance(circuit.demand(wanted), step)
        return self.signals
