"""The driver model: follows a speed trace with accelerator and brake."""

from __future__ import annotations

from dataclasses import dataclass

from .car import Car
from .cycle import Cycle
from .piecewise import clip


@dataclass(frozen=True)
class Demand:
    """The driver's demands."""

    force: float
    """Force at the road, N: positive for driving, negative for braking."""
    power: float
    """The force times the speed of the trace, W, at least 0."""
    waiting: bool
    """Whether the trace demands standstill."""


class Driver:
    """Feed-forward from the road load and the future speed of the trace, plus a PI controller.

    F = m a_ref + F_road(v_ref) + m (k_p e + k_i ∫e dt), e = v_ref − v, with a_ref over the next half second. The
    integrator is stopped while the force is at a limit, and at standstill.
    """

    PREVIEW = 0.5
    """s."""
    PROPORTIONAL, INTEGRAL = 1.2, 0.3
    """1/s and 1/s²."""
    HOLD = 1500.0
    """Brake force that holds the standing car, N."""

    def __init__(self, car: Car, cycle: Cycle) -> None:
        self.car, self.cycle = car, cycle
        self._integral = 0.0

    def demand(self, time: float, speed: float, step: float) -> Demand:
        """Demand at a time, s, and a speed, m/s."""
        car, wanted = self.car, self.cycle.at(time)
        ahead = self.cycle.at(time + self.PREVIEW)
        if wanted == 0.0 and ahead == 0.0 and speed < 0.3:
            self._integral = 0.0
            return Demand(-self.HOLD, 0.0, True)
        error = wanted - speed
        acceleration = (ahead - wanted) / self.PREVIEW
        force = car.mass * (acceleration + self.PROPORTIONAL * error + self._integral) + car.road_load(wanted)
        limit = car.mass * 4.0
        if abs(force) < limit and wanted > 0.0:
            self._integral += step * self.INTEGRAL * error
        force = clip(force, -limit, limit)
        return Demand(force, max(force, 0.0) * max(wanted, speed, 1.0), False)
