"""A car around the variator: launch, shift, tip-out, tip-in, braking to standstill.

It needs `pushbelt`, numpy and matplotlib, and writes car.png. With `--naive` it drives 6 s with a clutch whose law is too
steep for the step, so that it chatters.
"""

import sys
from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np

import pushbelt

STEP, SUBSTEPS, END = 0.01, 20, 24.0  # s, parts of a step for engine and clutch, s
MASS, LEVER = 1300.0, 0.3 / 5.4  # kg; wheel radius over final drive: metres on the road a radian of the secondary shaft
ENGINE_INERTIA, IDLE, LAG = 0.15, 84.0, 0.12  # kg·m², rad/s, τ of the clutch in s
RATIOS, SHARES = (
    np.array([0.46, 0.7, 1.0, 1.5, 2.2]),
    np.array([-0.4, 0.0, 0.4, 0.75]),
)  # the map: ratio, torque utilisation
START = {"secondary.inertia": MASS * LEVER**2, "initial.ratio": 2.2, "initial.primarySpeed": 0.0, "primary.torque": 0.0,
         "secondary.torque": 0.0, "primary.clampingForce": 4e3, "secondary.clampingForce": 7e3}  # fmt: skip


def pedals(time: float) -> tuple[float, float]:
    """Accelerator as a share of full load, and brake force at the road, N."""
    throttle = np.interp(time, [0.5, 1.0, 8.0, 8.1, 11.0, 11.1, 14.0, 14.1], [0.0, 0.6, 0.6, 0.0, 0.0, 0.4, 0.4, 0.0])
    return throttle, np.interp(time, [14.5, 15.0], [0.0, 3000.0])


@dataclass
class Engine:
    """Engine and launch clutch, in small steps within a communication step."""

    speed: float = IDLE
    torque: float = 0.0
    pulley: float = 0.0  # speed of the primary pulley at the last step, and its acceleration, low-passed
    acceleration: float = 0.0

    def clutch(self, pulley: float) -> float:
        """A centrifugal clutch. Up to its capacity its torque is the predicted one that keeps both speeds equal.

        The law's slope over speed is d = J/τ. It is stable while d h is well below the inertia of the pulley: here they are
        0.0125 and 0.03 kg·m².
        """
        together = self.torque - ENGINE_INERTIA * self.acceleration + ENGINE_INERTIA / LAG * (self.speed - pulley)
        return np.clip(together, -self.capacity(pulley), self.capacity(pulley))

    def capacity(self, pulley: float) -> float:
        """Capacity, which grows with the square of the speed above idle, N·m."""
        return min(0.02 * max(max(self.speed, pulley) - IDLE - 5.0, 0.0) ** 2, 200.0)

    def advance(self, throttle: float, pulley: float, naive: bool) -> float:
        """Mean clutch torque over the next step, N·m."""
        self.acceleration += STEP / (LAG + STEP) * ((pulley - self.pulley) / STEP - self.acceleration)
        self.pulley, impulse, dt = pulley, 0.0, STEP / SUBSTEPS
        dry = self.capacity(pulley) * np.tanh((self.speed - pulley) / 3.0)
        for _ in range(SUBSTEPS):
            clutch = dry if naive else self.clutch(pulley)
            drag = -(8.0 + 0.02 * self.speed)
            wanted = max(drag + throttle * (150.0 - drag), 2.0 * (IDLE - self.speed))
            self.torque += dt / 0.1 * (min(wanted, 150.0) - self.torque)
            self.speed += dt / ENGINE_INERTIA * (self.torque - clutch)
            impulse += dt * clutch
        return impulse / STEP


def main(naive: bool = False, end: float = END) -> np.ndarray:
    """Drives, writes the picture and returns the outputs of all steps."""
    engine, target, integral, targets = Engine(), 2.2, 0.0, [2.2]
    with pushbelt.Variator("bench168", START) as variator:
        loads = [[share * variator.torque_capacity(ratio, 12e3) for share in SHARES] for ratio in RATIOS]
        table = [
            [variator.steady(ratio, load, force=12e3)["thrustRatio"] for load in row]
            for ratio, row in zip(RATIOS, loads)
        ]
        state = variator.start()
        for k in range(round(end / STEP)):
            throttle, brake = pedals(k * STEP)
            ratio, speed, car = state["ratio.geometric"], state["primary.speed"], LEVER * state["secondary.speed"]
            torque = engine.advance(throttle, speed, naive)
            road = 0.39 * car * abs(car) + 130.0 * np.tanh(car / 0.1)
            # The brake's slope over speed times the step is a quarter of the car's mass: it holds the car without oscillation.
            road += brake * np.clip(car / max(0.05, 4.0 * brake * STEP / MASS), -1.0, 1.0)
            # The least clamping force of each pulley carries the present torque and the demanded one.
            ahead = max(abs(torque), throttle * 150.0)
            least = variator.least_force(ratio, ahead + 8.0, thrust_ratio=1.0)
            share = np.copysign(min(abs(torque) / variator.torque_capacity(ratio, least), 0.75), torque)
            kappa = np.interp(ratio, RATIOS, [np.interp(share, SHARES, row) for row in table])
            secondary = max(least, least / kappa)
            # The engine's set-point speed determines the ratio. PI controller with anti-windup on ln i; κ of the map is the feed-forward.
            wish = 131.0 + 270.0 * throttle
            wanted = np.clip(wish / max(state["secondary.speed"], 1.0), RATIOS[0], RATIOS[-1])
            target *= np.exp(np.clip(np.log(wanted / target), -0.8 * STEP, 0.8 * STEP))
            error = np.log(ratio / target) if speed > 20.0 else 0.0
            force = secondary * (kappa + 2.0 * error + integral)
            primary = np.clip(force, least, 40e3)
            if primary > force:  # faster towards underdrive only with more force on the other pulley
                secondary = min(secondary * primary / max(force, 0.3 * primary), 40e3)
            integral = np.clip(integral + STEP * (3.0 * error + (primary - force) / secondary), -0.3, 0.3) * (
                speed > 20.0
            )
            state = variator.step(STEP, {"primary.torque": torque, "secondary.torque": -LEVER * road,
                                         "primary.clampingForce": primary, "secondary.clampingForce": secondary})  # fmt: skip
            targets.append(target)
        plot(variator.outputs, np.array(targets), "car-naive.png" if naive else "car.png")
        return variator.outputs


def plot(run: np.ndarray, targets: np.ndarray, path: str) -> None:
    """Speed, ratio, torque, forces and slip over time."""
    panels = {"car, km/h": [3.6 * LEVER * run["secondary.speed"]], "ratio and target": [run["ratio.geometric"], targets],
              "clutch torque, N·m": [run["primary.torque"]], "slip, %": [100.0 * run["slip"]],
              "clamping forces, kN": [run["primary.clampingForce"] / 1e3, run["secondary.clampingForce"] / 1e3]}  # fmt: skip
    figure, axes = plt.subplots(len(panels), sharex=True, figsize=(7, 9), layout="constrained")
    for axis, (name, lines) in zip(axes, panels.items(), strict=True):
        for line in lines:
            axis.plot(run["time"], line)
        axis.set(ylabel=name)
    axes[-1].set(xlabel="time, s")
    figure.savefig(path, dpi=100)


if __name__ == "__main__":
    naive = "--naive" in sys.argv[1:]
    run = main(naive, 6.0 if naive else END)
    jumps, slipping = np.abs(np.diff(run["primary.torque"])), run["macroSlip"].sum()
    print(
        f"clutch torque changes by up to {jumps.max():.1f} N·m a step, macro-slip in {slipping:.0f} of {len(jumps)} steps"
    )
    print(
        f"ratio at the end {run['ratio.geometric'][-1]:.3f}, speed {3.6 * LEVER * abs(run['secondary.speed'][-1]):.1f} km/h"
    )
