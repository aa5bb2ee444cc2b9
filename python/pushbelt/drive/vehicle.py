"""The vehicle around the variator: driver, engine, launch clutch, brakes and road. It is called once per communication step."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .car import Car, Powertrain
from .cycle import Cycle
from .driver import Driver


@dataclass(frozen=True)
class VehicleSignals:
    """Outputs of the vehicle over a communication step. The defaults are those of the standing car."""

    primary_torque: float = 0.0
    """Mean torque of the clutch on the primary shaft, N·m."""
    secondary_torque: float = 0.0
    """Torque of road load and brakes on the secondary shaft, N·m."""
    estimated_torque: float = 0.0
    """Torque that the engine control sends to the transmission: the larger of the present and the demanded primary torque, with
    the sign of the present one, N·m."""
    power_demand: float = 0.0
    """Power demanded by the driver, W."""
    target_speed: float = 0.0
    """Speed of the cycle, m/s."""
    speed: float = 0.0
    """Speed of the car, m/s."""
    engine_speed: float = 0.0
    """rad/s."""
    engine_torque: float = 0.0
    """N·m."""
    clutch_locked: bool = False
    brake_force: float = 0.0
    """N."""
    road_load: float = 0.0
    """N."""
    engine_work: float = 0.0
    """Work of the engine over the step, J."""
    clutch_loss: float = 0.0
    """Energy lost in the clutch over the step, J."""


class Vehicle:
    """Driver and car. The car's inertia is a parameter of the variator FMU (secondary shaft)."""

    def __init__(self, car: Car, cycle: Cycle) -> None:
        self.car = car
        self.driver = Driver(car, cycle)
        self.powertrain = Powertrain(car)

    def advance(
        self, time: float, primary_speed: float, secondary_speed: float, ratio: float, step: float
    ) -> VehicleSignals:
        """Advances from a time, s, by a step, s, with the shaft speeds, rad/s, and the ratio at that time."""
        car, powertrain = self.car, self.powertrain
        # Masters sum their steps. Without rounding, the trace would be read slightly before or after its break points.
        time = round(time, 9)
        speed = car.lever * secondary_speed
        demand = self.driver.demand(time, speed, step)
        wanted_torque = demand.force * car.lever / ratio
        clutch = powertrain.advance(wanted_torque, primary_speed, step)
        overrun = car.drag_torque(powertrain.speed) * ratio / car.lever if powertrain.locked else 0.0
        brake = car.brake_force(max(-demand.force + overrun, 0.0), speed, step)
        road = car.road_load(speed)
        expected = min(max(wanted_torque, 0.0), car.full_load(powertrain.speed)) if primary_speed > 20.0 else 0.0
        return VehicleSignals(
            primary_torque=clutch,
            secondary_torque=-car.lever * (road + brake),
            estimated_torque=math.copysign(max(abs(clutch), expected), clutch),
            power_demand=demand.power,
            target_speed=self.driver.cycle.at(time),
            speed=speed,
            engine_speed=powertrain.speed,
            engine_torque=powertrain.torque,
            clutch_locked=powertrain.locked,
            brake_force=brake,
            road_load=road,
            engine_work=powertrain.engine_work,
            clutch_loss=powertrain.clutch_loss,
        )
