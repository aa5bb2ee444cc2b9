"""Growth rates of small oscillations of the ratio: the linear belt with the controllers of `cargo fmu drive`.

The belt is the linear model of `pushbelt.Variator.linearize`; flywheel, clutch, controllers and hydraulics are those of the drive. A small
change of the target ratio excites the oscillation. Prints growth rates (docs/controllers.md): `stability.py coarse`, the mesh of the drive, and
`stability.py default`.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.linalg import expm

import pushbelt
from pushbelt.drive import simulate
from pushbelt.drive.control import Friction, Measured, RatioControl, SlipControl
from pushbelt.drive.measure import measure
from pushbelt.drive.thrust_map import ThrustMap
from pushbelt.drive.transmission import PressureCircuit
from pushbelt.drive.vehicle import Powertrain, demo_car
from pushbelt.fmu.data import torque_capacity
from pushbelt.fmu.files import default_fmu

POINTS = ((0.46, 0.6), (0.46, 0.77), (0.46, 0.9), (0.6, 0.77), (0.6, 0.9), (1.0, 0.9))
"""Ratio and torque utilisation."""
SPEEDS, FORCE, FREQUENCY = (140.0, 210.0, 280.0), 9e3, 100.0
"""Speeds of the primary pulley, rad/s; secondary clamping force, N; frequency below which modes are in the linear model, Hz."""
STEP, DURATION = simulate.STEP, 4.0
INPUTS = ("primary.clampingForce", "secondary.clampingForce", "primary.torque")
OUTPUTS = ("ratio.geometric", "primary.speed", "slip", "primary.radius")
CAR = demo_car()
PARAMETERS = simulate.unit_parameters(CAR, "ALE", "default" if "default" in sys.argv[1:] else "coarse")


class Belt:
    """The linear model with steps of the control, in deviations from the working point. Inputs are linear within a step."""

    def __init__(self, model: pushbelt.LinearModel) -> None:
        model = model.select(OUTPUTS, INPUTS)
        a, b = model.a, model.b
        n, k = b.shape
        held = np.zeros((n + 2 * k, n + 2 * k))
        held[:n, :n], held[:n, n : n + k], held[n : n + k, n + k :] = a, b, np.eye(k) / STEP
        self.step_matrix = expm(STEP * held)[:n]
        self.c, self.d = model.c, model.d
        self.at = np.array([model.values[name] for name in OUTPUTS])
        self.state, self.inputs = np.zeros(n), np.zeros(k)

    def read(self) -> np.ndarray:
        """Present outputs, as deviations."""
        return self.c @ self.state + self.d @ self.inputs

    def advance(self, inputs: np.ndarray) -> None:
        """Advances by a step with inputs that reach these values at its end."""
        self.state = self.step_matrix @ np.concatenate([self.state, self.inputs, inputs - self.inputs])
        self.inputs = inputs


def linear_model(variator: pushbelt.Variator, ratio: float, torque: float, speed: float) -> pushbelt.LinearModel | None:
    """The linear model at a point; None without a steady working point or without a mode below the frequency."""
    try:
        return variator.linearize(ratio, torque, speed=speed, force=FORCE, frequency=FREQUENCY)
    except (pushbelt.SteadyStateError, pushbelt.LinearPointError) as error:
        print(error, file=sys.stderr)
        return None


def growth(belt: Belt, table: ThrustMap, torque: float, steered: bool, lag: float) -> float:
    """Growth rate of the shift speed, 1/s; `steered`: whether the controllers act; `lag`: time constant of the pressures, s."""
    ratio, speed, slip, radius = belt.at
    friction = Friction(PARAMETERS["friction.pulley"], PARAMETERS["geometry.wedgeAngle"])
    clamping = SlipControl(friction, table, CAR.engine_inertia)
    circuits = [PressureCircuit(2e6, wanted_lag=lag) for _ in range(2)]
    shifting = RatioControl(friction, table, circuits[0].limits)
    engine = Powertrain(CAR)
    engine.speed, engine.torque, engine.locked = speed, torque, True
    measured = Measured(speed, ratio, slip, False, radius, torque)
    # Offset of the measured slip with which the integral is constant at the working point.
    at_rest = clamping.set_point(ratio, min(clamping.utilisation, clamping.stable_utilisation(measured))) - slip
    base = np.zeros(2)
    logs = []
    for k in range(round(DURATION / STEP)):
        deviation = belt.read()
        now = belt.at + deviation
        logs.append(deviation[0] / ratio)
        clutch = engine.advance(torque, now[1], STEP)
        measured = Measured(now[1], now[0], now[2] + at_rest, False, now[3], clutch)
        needed = FORCE * clamping.force(measured, STEP) / (base[1] or clamping.force(measured, 0.0))
        target = ratio * (1.00001 if 0.1 < k * STEP < 0.2 else 1.0)
        wanted = np.array(shifting.forces(target, measured, needed, STEP))
        if not base.any():
            base = np.array([wanted[0], clamping.force(measured, 0.0)])
            for circuit, force in zip(circuits, (base[0], FORCE), strict=True):
                circuit.pressure = force / circuit.area
        forces = [c.area * c.advance(c.demand(w), STEP) for c, w in zip(circuits, wanted, strict=True)]
        change = np.array(forces) - (base[0], FORCE) if steered else np.full(2, 0.01 if k == 10 else 0.0)
        belt.advance(np.array([*change, clutch - torque]))
        if abs(logs[-1]) > 0.003:
            break
    speeds = np.abs(np.diff(logs))[25:]
    half = len(speeds) // 2
    return float(np.log(speeds[half:].max() / speeds[:half].max()) / (half * STEP))


def main() -> None:
    """Prints the growth rates."""
    coarse = simulate.unit_parameters(CAR, "ALE", "coarse")
    table = ThrustMap.of_maps(measure(default_fmu(), coarse, Path("target/drive")))
    print("| ratio | utilisation | primary speed rad/s | forces held | pressures at 50 ms | at 12.5 ms |")
    print("|---" * 6 + "|")
    variator = pushbelt.Variator(PARAMETERS)
    for ratio, utilisation in POINTS:
        for speed in SPEEDS:
            torque = utilisation * torque_capacity(PARAMETERS, ratio, FORCE)
            model = linear_model(variator, ratio, torque, speed)
            if model is None:
                continue
            found = [
                growth(Belt(model), table, torque, steered, lag)
                for steered, lag in ((False, 0.05), (True, 0.05), (True, PressureCircuit.wanted_lag))
            ]
            cells = f"{ratio:g}", f"{utilisation:g}", f"{speed:.0f}", *(f"{rate:+.1f}" for rate in found)
            print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
