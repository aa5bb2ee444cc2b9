"""Stability and error of a shaft that is coupled to the variator from outside: `damping.py`.

A spring k with a damper d connects the primary shaft to a flywheel. The importer computes the shaft's torque from both speeds at a
communication point and holds it until the next one, so the torque acts late by some delay τ. A delayed spring is a negative damper of
−k τ: the coupling is stable if d > k τ. Prints both tables of docs/cosimulation.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.files import default_fmu
from pushbelt.fmu.unit import Archive, Instance

STIFFNESS, INERTIA, TORQUE = 1000.0, 0.03, 50.0
"""Spring, N·m/rad; inertia of the flywheel, kg·m²; torque on it, N·m."""
STEP, DURATION, WINDOW = 1e-3, 0.4, 0.05
"""Communication step, duration, window at both ends in which amplitudes are compared, s."""
KICK, RIPPLE = 2.0, 20.0
"""Step of the flywheel's speed at the start, rad/s, for the amplitudes; ripple of its torque at 10 Hz, N·m, for the errors."""
STABLE = 5.0
"""Damper of the runs whose errors are compared, N·m·s/rad."""
WAYS: dict[str, tuple[float, Callable[[float, float], tuple[float, float | None]]]] = {
    "held, default ramp": (1e-3, lambda torque, change: (torque, None)),
    "held, `inputs.ramp` = 0": (0.0, lambda torque, change: (torque, None)),
    "mean over the step, `inputs.ramp` = 0": (0.0, lambda torque, change: (torque + 0.5 * change, None)),
    "with input derivatives": (1e-3, lambda torque, change: (torque, change)),
}
"""For each way to pass the torque on: the ramp, s, and from the torque at the communication point and its change since the last one
the value that is set, and its change over the step if a derivative is set."""


def run(archive: Archive, way: str, damping: float, step: float, kick: float = 0.0, ripple: float = 0.0) -> np.ndarray:
    """Speeds of the primary shaft at every step of 1 ms."""
    ramp, passed = WAYS[way]
    values = parameter_set("bench168") | {"inputs.ramp": ramp, "primary.torque": TORQUE, "secondary.torque": -0.98 * TORQUE}
    with Instance(archive, values) as variator:
        variator.initialise()
        torque_input, speed_output = variator.reals(["primary.torque"]), variator.reals(["primary.speed"])
        (speed,) = variator.get_reals(speed_output)
        flywheel, twist, last, speeds = speed + kick, TORQUE / STIFFNESS, TORQUE, [speed]
        for k in range(round(DURATION / step)):
            torque = STIFFNESS * twist + damping * (flywheel - speed)
            value, change = passed(torque, torque - last)
            last = torque
            if change is None:
                variator.set({"primary.torque": value})
            else:
                variator.set_ramps(torque_input, [value], [change / step])
            variator.step_to((k + 1) * step)
            (now,) = variator.get_reals(speed_output)
            load = TORQUE + ripple * math.sin(20.0 * math.pi * (k + 0.5) * step)
            # The flywheel has the mean of what the variator has.
            after = flywheel + step * (load - value - 0.5 * (change or 0.0)) / INERTIA
            twist += 0.5 * step * (flywheel + after - speed - now)
            flywheel, speed = after, now
            speeds.append(speed)
    return np.array(speeds)[:: round(STEP / step)]


def amplitude(speeds: np.ndarray) -> float:
    """Half of the range of the speed beside its linear trend."""
    time = np.arange(len(speeds))
    return 0.5 * float(np.ptp(speeds - np.polyval(np.polyfit(time, speeds, 1), time)))


def main() -> None:
    """Prints the tables."""
    with Archive.unpack(default_fmu()) as archive:
        print("| d | way | amplitude at first, rad/s | at the end, rad/s |\n|---|---|---|---|")
        for way in list(WAYS)[:2]:
            for factor in (0.0, 0.6, 1.0, 1.5):
                speeds, count = run(archive, way, factor * STIFFNESS * STEP, STEP, kick=KICK), round(WINDOW / STEP)
                print(f"| {factor:g} k h | {way} | {amplitude(speeds[:count]):.2f} | {amplitude(speeds[-count:]):.2f} |", flush=True)
        exact = run(archive, "with input derivatives", STABLE, STEP / 32.0, ripple=RIPPLE)
        print("\n| way | largest error at 1 ms, rad/s | order |\n|---|---|---|")
        for way in WAYS:
            errors = [float(np.abs(run(archive, way, STABLE, h, ripple=RIPPLE) - exact).max()) for h in (STEP, 0.5 * STEP)]
            print(f"| {way} | {errors[0]:.2g} | {math.log2(errors[0] / errors[1]):.1f} |", flush=True)


if __name__ == "__main__":
    main()
