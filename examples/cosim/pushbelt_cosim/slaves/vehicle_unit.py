"""The FMU `VehicleUnit`: driver, engine, launch clutch, brakes and road of `pushbelt.drive.vehicle`."""

from __future__ import annotations

from pushbelt.drive.cycle import wltc_class_3b
from pushbelt.drive.transmission import RATIO_LIMITS
from pushbelt.drive.vehicle import Vehicle, demo_car
from pushbelt_cosim.unit import INPUT, OUTPUT, PARAMETER, Unit

OUTPUTS = {
    "primary.torque": ("clutch.torque", "Mean clutch torque over the last step, N.m"),
    "secondary.torque": ("secondary.torque", "Torque of road load and brakes, N.m"),
    "torque.estimated": ("torque.estimated", "Primary torque as the engine control estimates it, N.m"),
    "power.demand": ("power.demand", "Power demanded by the driver, W"),
    "car.speed": ("speed.car", "m/s"),
    "cycle.speed": ("speed.target", "m/s"),
    "engine.speed": ("engine.speed", "rad/s"),
    "clutch.locked": ("clutch.locked", "Whether the launch clutch is locked"),
}
"""Signals of the vehicle, and descriptions."""


class VehicleUnit(Unit):
    """Computes torques from speeds. The car's inertia is part of the variator's secondary shaft."""

    description = "Driver, engine, launch clutch, brakes and road load on the WLTC"

    def __init__(self, **keywords: object) -> None:
        super().__init__(**keywords)
        self.declare(
            PARAMETER,
            {
                "cycle.start": (0.0, "Start of the section of the WLTC class 3b, s"),
                "cycle.stop": (1800.0, "End of the section, s"),
            },
        )
        self.declare(
            INPUT,
            {
                "primary.speed": (0.0, "rad/s"),
                "secondary.speed": (0.0, "rad/s"),
                "ratio.geometric": (RATIO_LIMITS[1], "Ratio of the variator, r_S/r_P"),
            },
        )
        self.declare(OUTPUT, {name: (False if name == "clutch.locked" else 0.0, text) for name, (_, text) in OUTPUTS.items()})
        self._vehicle: Vehicle | None = None

    def exit_initialization_mode(self) -> None:
        """Applies the parameters."""
        cycle = wltc_class_3b().section(self.values["cycle.start"], self.values["cycle.stop"])
        self._vehicle = Vehicle(demo_car(), cycle)

    def advance(self, time: float, step: float) -> None:
        """Advances by a communication step."""
        values = self.values
        signals = self._vehicle.advance(
            time, values["primary.speed"], values["secondary.speed"], values["ratio.geometric"], step
        )
        values.update({name: signals[signal] for name, (signal, _) in OUTPUTS.items()})
