"""The FMU `ControlUnit`: strategy, ratio control and hydraulics of `pushbelt.drive.transmission`."""

from __future__ import annotations

from pathlib import Path

from pushbelt.drive.control import Friction, Measured
from pushbelt.drive.thrust_map import ThrustMap
from pushbelt.drive.transmission import RATIO_LIMITS, START_PRESSURE, TransmissionControl
from pushbelt.drive.vehicle import demo_car
from pushbelt.fmu.data import parameter_set
from pushbelt.maps.data import Maps
from pushbelt_cosim.unit import INPUT, MAP_FILE, OUTPUT, PARAMETER, Unit

OUTPUTS = {
    "primary.pressure": (START_PRESSURE, "Mean over the last step, Pa"),
    "secondary.pressure": (START_PRESSURE, "Mean over the last step, Pa"),
    "ratio.target": (RATIO_LIMITS[1], "1"),
    "intervening": (False, "Whether the slip controller intervenes against macro-slip"),
}


class ControlUnit(Unit):
    """Computes clamping pressures from the measured values of a transmission."""

    description = "Transmission control: ratio, clamping pressures, hydraulics"

    def __init__(self, **keywords: object) -> None:
        super().__init__(**keywords)
        assumed = parameter_set("bench168")
        self.declare(
            PARAMETER,
            {
                "slipControl": (True, "Slip control, otherwise a fixed safety factor"),
                "friction.pulley": (assumed["friction.pulley"], "Friction coefficient assumed by the control, 1"),
                "geometry.wedgeAngle": (assumed["geometry.wedgeAngle"], "Half the wedge angle, rad"),
            },
        )
        self.declare(
            INPUT,
            {
                "primary.speed": (0.0, "rad/s"),
                "secondary.speed": (0.0, "rad/s"),
                "ratio.geometric": (RATIO_LIMITS[1], "Ratio of the variator, r_S/r_P"),
                "primary.radius": (0.03, "Primary running radius, m"),
                "slip": (0.0, "1"),
                "macroSlip": (False, "Whether the belt slips through"),
                "torque.estimated": (0.0, "Primary torque as the engine control estimates it, N.m"),
                "power.demand": (0.0, "Power demanded by the driver, W"),
            },
        )
        self.declare(OUTPUT, OUTPUTS)
        self._control: TransmissionControl | None = None

    def exit_initialization_mode(self) -> None:
        """Applies the parameters and reads the map."""
        values = self.values
        path = Path(self.resources) / MAP_FILE
        thrust_map = ThrustMap.of_maps(Maps.read(path))
        friction = Friction(values["friction.pulley"], values["geometry.wedgeAngle"])
        strategy = "slip" if values["slipControl"] else "safety"
        self._control = TransmissionControl(demo_car(), strategy, friction, thrust_map)

    def advance(self, time: float, step: float) -> None:  # noqa: ARG002
        """Computes the demands and advances the hydraulics by a communication step."""
        values = self.values
        measured = Measured.from_signals(values, values["torque.estimated"])
        values.update(self._control.advance(values["power.demand"], values["secondary.speed"], measured, step))
