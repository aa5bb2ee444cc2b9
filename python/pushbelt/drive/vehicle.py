"""The vehicle around the variator: driver, engine, launch clutch, brakes and road load. SI units.

The vehicle is an inertia on the secondary shaft of the FMU, so its speed is the FMU's secondary speed. The engine with its
clutch has states here. They are integrated with steps of 1 ms and the primary speed of the last communication point. The FMU
gets the mean clutch torque over the communication step, which conserves momentum.
"""

import math
from dataclasses import dataclass, replace

from pushbelt.fmu.data import published_data
from pushbelt.steel import check_ranges

from .cycle import Cycle
from .piecewise import clip, interpolate

GRAVITY = 9.81
AIR_DENSITY = 1.2
SIGNALS = {
    "clutch.torque": "N.m", "secondary.torque": "N.m", "torque.estimated": "N.m", "power.demand": "W", "speed.target": "m/s",
    "speed.car": "m/s", "engine.speed": "rad/s", "engine.torque": "N.m", "clutch.locked": "1", "force.brake": "N", "force.road": "N",
    "work.engine": "J", "loss.clutch": "J",
}  # fmt: skip
"""Signals of a vehicle with their units. The torques are means over a communication step: that of the clutch on the primary shaft, and
that of road load and brakes on the secondary. The estimated torque is what the engine control sends to the transmission: the larger of
the present and the demanded primary torque, with the sign of the present one. Work and loss are energies of the step."""


@dataclass(frozen=True)
class Car:
    """The values of `demoCar` in `resources/variators.json`, and typical values for the rest."""

    mass: float  # kg
    drag_area: float  # c_d A, m²
    rolling_resistance: float  # 1
    wheel_radius: float  # m
    final_drive: float  # Secondary speed divided by wheel speed
    engine_inertia: float  # kg·m²
    max_torque: float  # Largest torque of the engine, N·m
    max_power: float  # Largest power of the engine, W
    idle_speed: float = 84.0  # 800 rpm, rad/s
    max_speed: float = 630.0  # 6000 rpm, rad/s
    max_brake: float = 9000.0  # Largest force of the wheel brakes, N

    @property
    def lever(self) -> float:
        """Torque at the secondary shaft per force at the road, m; v = lever · ω_S."""
        return self.wheel_radius / self.final_drive

    @property
    def inertia(self) -> float:
        """The vehicle as an inertia on the secondary shaft, kg·m²."""
        return self.mass * self.lever**2

    def road_load(self, speed: float) -> float:
        """Air drag and rolling resistance at a speed in m/s, N. The rolling resistance tends to 0 below 0.1 m/s."""
        air = 0.5 * AIR_DENSITY * self.drag_area * speed * abs(speed)
        return air + self.mass * GRAVITY * self.rolling_resistance * math.tanh(speed / 0.1)

    def brake_force(self, demand: float, speed: float, step: float) -> float:
        """Force of the brakes, N, for a demand in N. Near standstill it is proportional to speed, so that it holds the car. The
        slope is at most half of the limit at which the communication step would cause oscillation."""
        width = max(0.05, 2.0 * demand * step / self.mass)
        return min(demand, self.max_brake) * clip(speed / width, -1.0, 1.0)

    def full_load(self, speed: float) -> float:
        """Largest torque of the engine at a speed in rad/s, N·m."""
        if speed >= self.max_speed:
            return self.drag_torque(speed)
        low_end = self.max_torque * interpolate(speed, (0.5 * self.idle_speed, 2.2 * self.idle_speed), (0.5, 1.0))
        return min(low_end, self.max_power / max(speed, 1.0))

    def drag_torque(self, speed: float) -> float:
        """Torque of the engine without fuel, N·m; negative."""
        return -(8.0 + 0.02 * speed) * clip(speed / 20.0, 0.0, 1.0)

    def engine_speed_for(self, power: float) -> float:
        """Engine speed of low consumption at a power in W, rad/s: the torque is about 110 N·m, the speed at least 1250 rpm."""
        return clip(power / 110.0, 131.0, 0.9 * self.max_speed)


RANGES = {
    "mass": (200.0, 2e4, "kg"), "drag_area": (0.0, 20.0, "m²"), "rolling_resistance": (0.0, 0.1, "1"), "wheel_radius": (0.1, 1.0, "m"),
    "final_drive": (1.0, 20.0, "1"), "engine_inertia": (0.01, 2.0, "kg·m²"), "max_torque": (10.0, 1e3, "N·m"),
    "max_power": (5e3, 5e5, "W"),
}  # fmt: skip
"""Ranges and units of a car of one's own."""


def demo_car(**changes: float) -> Car:
    """The car of `demoCar`, with other values. Raises ArgumentError for one out of its range."""
    names = "mass dragArea rollingResistance wheelRadius finalDrive engineInertia engineMaxTorque engineMaxPower".split()
    data = published_data()["demoCar"]
    car = replace(Car(*(data[name] for name in names)), **changes)
    check_ranges(car, "the car", RANGES)
    return car


class Powertrain:
    """Engine and launch clutch.

    While the clutch slips, its torque grows with the square of the speed above idle, as in a centrifugal clutch. When it is
    locked, engine and primary pulley have the same speed. The pulley's speed comes from the FMU once per communication
    step, so the torque that keeps both speeds equal is predicted,

        T_c = T_e − J_e α + (J_e/τ)(ω_e − ω_P),

    with the acceleration α of the pulley, low-pass filtered with τ. The last term corrects errors of the prediction. The scheme is
    stable if J_e h/τ is below the inertia of the pulley alone; this matters when the belt slips through.
    """

    SYNCHRONISATION = 0.12  # τ, s
    TORQUE_LAG = 0.1  # Time constant of the engine torque, s
    LOCK_SPEED, OPEN_SPEED = 100.0, 90.0  # The clutch locks above the first speed and opens below the second, rad/s
    CLUTCH_LIMIT = 250.0  # N·m
    SUBSTEP = 1e-3  # s

    def __init__(self, car: Car) -> None:
        self.car, self.locked = car, False
        self.speed, self.torque = car.idle_speed, 0.0  # Of the engine, rad/s and N·m
        self.clutch_loss = self.engine_work = 0.0  # Heat generated in the clutch and work of the engine over the last step, J
        self._last_pulley: float | None = None
        self._acceleration = 0.0

    def advance(self, demand: float, pulley: float, step: float) -> float:
        """Advances by a communication step; returns the mean clutch torque, N·m. `demand` is the demanded engine torque, N·m;
        `pulley` is the primary speed, rad/s, held constant over the step."""
        car = self.car
        self._follow(pulley, step)
        count = max(round(step / self.SUBSTEP), 1)
        dt = step / count
        impulse = self.clutch_loss = self.engine_work = 0.0
        for _ in range(count):
            idle = 2.0 * (car.idle_speed - self.speed)
            wanted = clip(max(demand, idle), car.drag_torque(self.speed), car.full_load(self.speed))
            self.torque += (wanted - self.torque) * dt / self.TORQUE_LAG
            clutch = self._clutch_torque(pulley)
            before = self.speed
            self.speed += dt * (self.torque - clutch) / car.engine_inertia
            mean = 0.5 * (before + self.speed)
            self.engine_work += dt * self.torque * mean
            self.clutch_loss += dt * clutch * (mean - pulley)
            impulse += dt * clutch
        return impulse / step

    def _follow(self, pulley: float, step: float) -> None:
        """Filters the pulley's acceleration and locks or opens the clutch."""
        last = pulley if self._last_pulley is None else self._last_pulley
        share = step / (self.SYNCHRONISATION + step)
        self._acceleration += share * ((pulley - last) / step - self._acceleration)
        self._last_pulley = pulley
        self.locked = pulley > self.OPEN_SPEED if self.locked else pulley > self.LOCK_SPEED and abs(self.speed - pulley) < 5.0

    def _clutch_torque(self, pulley: float) -> float:
        difference, inertia = self.speed - pulley, self.car.engine_inertia
        if self.locked:
            torque = self.torque - inertia * self._acceleration + inertia / self.SYNCHRONISATION * difference
            return clip(torque, -self.CLUTCH_LIMIT, self.CLUTCH_LIMIT)
        above_idle = max(max(self.speed, pulley) - self.car.idle_speed - 5.0, 0.0)
        return min(0.02 * above_idle**2, self.CLUTCH_LIMIT) * math.tanh(difference / 3.0)


class Driver:
    """Feed-forward from the road load and the future speed of the trace, plus a PI controller:
    F = m a_ref + F_road(v_ref) + m (k_p e + k_i ∫e dt), e = v_ref − v, with a_ref over the next half second.
    The integrator is stopped while the force is at a limit, and at standstill."""

    PREVIEW = 0.5  # s
    PROPORTIONAL, INTEGRAL = 1.2, 0.3  # 1/s and 1/s²
    HOLD = 1500.0  # Brake force that holds the standing car, N

    def __init__(self, car: Car, cycle: Cycle) -> None:
        self.car, self.cycle = car, cycle
        self._integral = 0.0

    def demand(self, time: float, speed: float, step: float) -> tuple[float, float]:
        """At a time, s, and a speed, m/s: force at the road, N, negative for braking; the force times the speed of the trace, W, at least 0."""
        car, wanted = self.car, self.cycle.at(time)
        ahead = self.cycle.at(time + self.PREVIEW)
        if wanted == 0.0 and ahead == 0.0 and speed < 0.3:
            self._integral = 0.0
            return -self.HOLD, 0.0
        error, limit = wanted - speed, car.mass * 4.0
        acceleration = (ahead - wanted) / self.PREVIEW
        force = car.mass * (acceleration + self.PROPORTIONAL * error + self._integral) + car.road_load(wanted)
        if abs(force) < limit and wanted > 0.0:
            self._integral += step * self.INTEGRAL * error
        force = clip(force, -limit, limit)
        return force, max(force, 0.0) * max(wanted, speed, 1.0)


class Vehicle:
    """Driver and car. The car's inertia is a parameter of the variator FMU (secondary shaft)."""

    def __init__(self, car: Car, cycle: Cycle) -> None:
        self.car, self.driver, self.powertrain = car, Driver(car, cycle), Powertrain(car)

    def advance(self, time: float, primary_speed: float, secondary_speed: float, ratio: float, step: float) -> dict[str, float]:
        """`SIGNALS` over a step, s, from a time, s, with the shaft speeds, rad/s, and the ratio at that time."""
        car, powertrain = self.car, self.powertrain
        # Importers sum their steps. Without rounding, the trace would be read slightly before or after its break points.
        time = round(time, 9)
        speed = car.lever * secondary_speed
        force, power = self.driver.demand(time, speed, step)
        wanted_torque = force * car.lever / ratio
        clutch = powertrain.advance(wanted_torque, primary_speed, step)
        overrun = car.drag_torque(powertrain.speed) * ratio / car.lever if powertrain.locked else 0.0
        brake = car.brake_force(max(overrun - force, 0.0), speed, step)
        road = car.road_load(speed)
        expected = min(max(wanted_torque, 0.0), car.full_load(powertrain.speed)) if primary_speed > 20.0 else 0.0
        return {
            "clutch.torque": clutch, "secondary.torque": -car.lever * (road + brake),
            "torque.estimated": math.copysign(max(abs(clutch), expected), clutch), "power.demand": power,
            "speed.target": self.driver.cycle.at(time), "speed.car": speed,
            "engine.speed": powertrain.speed, "engine.torque": powertrain.torque, "clutch.locked": powertrain.locked,
            "force.brake": brake, "force.road": road, "work.engine": powertrain.engine_work, "loss.clutch": powertrain.clutch_loss,
        }  # fmt: skip
