"""A gain-scheduled ratio controller from linear models, tried on the nonlinear variator.

The loop's bandwidth is the same at every ratio, although the shift rate per newton is 26 times as large at 2.2 as at 0.5. Prints
the differences between nonlinear steps and the linear loop, and draws a shift through the whole range in linear-control.png.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.signal import cont2discrete

import pushbelt

# A vehicle that keeps its speed, an engine at constant torque, a force on S that carries it at every ratio.
SPEED, TORQUE, FORCE, STEP = 150.0, 60.0, 16e3, 0.005
BELT = {
    "secondary.drive": "Speed",
    "secondary.speedSetpoint": SPEED,
    "primary.torque": TORQUE,
    "secondary.clampingForce": FORCE,
}
OUTPUT, LOAD = "ratio.geometric", "primary.clampingForce"

# The controller
with pushbelt.Variator("bench168", BELT) as variator:
    ratios, crossover = np.geomspace(0.5, 2.2, 8), 2.0 * np.pi * 1.0
    models = [variator.linearize(ratio, TORQUE, speed=ratio * SPEED, force=FORCE) for ratio in ratios]
gains = [1.0 / abs(model.gain(OUTPUT, LOAD, crossover)) for model in models]
holding = [model.held[LOAD] for model in models]


def primary_force(wanted, ratio, integral):
    error = ratio - wanted  # More force on P lowers the ratio r_S/r_P.
    integral += 0.2 * crossover * error * STEP
    return np.interp(ratio, ratios, holding) + np.interp(ratio, ratios, gains) * (error + integral), integral


# The end of the controller


def run(ratio, wanted, control=primary_force):
    """Ratio over time in the nonlinear variator, from a steady state at a ratio; `wanted` is the set point at each step."""
    start = {"initial.ratio": ratio, LOAD: np.interp(ratio, ratios, holding)}
    with pushbelt.Variator("bench168", {**BELT, **start}) as belt:
        state, integral, found = belt.start(), 0.0, []
        for target in wanted:
            found.append(state[OUTPUT])
            force, integral = control(target, state[OUTPUT], integral)
            state = belt.step(STEP, {LOAD: max(force, 0.0)})
    return np.array(found)


def predicted(model, gain, size, count):
    """The same loop with a linear model, as deviations; the set point is `size` from the start."""
    a, b, c, d, _ = cont2discrete((model.a, model.b, model.c, model.d), STEP)
    state, force, integral, found = np.zeros(len(a)), 0.0, 0.0, []
    for _ in range(count):
        found.append(c[0] @ state + d[0, 0] * force)
        integral += 0.2 * crossover * (found[-1] - size) * STEP
        force = gain * (found[-1] - size + integral)
        state = a @ state + b[:, 0] * force
    return np.array(found)


def compare(k, size, count=200):
    """A step at a point of the grid: nonlinear and linear, both as shares of the step."""
    belt = run(ratios[k], np.full(count, ratios[k] * (1.0 + size))) / ratios[k] - 1.0
    linear = predicted(models[k].select([OUTPUT], [LOAD]), gains[k], ratios[k] * size, count) / ratios[k]
    return belt / size, linear / size


def reached(response):
    """Time until 63 % of a step, s."""
    return STEP * float(np.argmax(response > 0.63))


def fixed(gain):
    """The same controller with one gain at all ratios."""

    def control(wanted, ratio, integral):
        error = ratio - wanted
        integral += 0.2 * crossover * error * STEP
        return np.interp(ratio, ratios, holding) + gain * (error + integral), integral

    return control


def main():
    """Prints the comparison, and draws a shift through the whole range."""
    for k in (1, 3, 5):
        for size in (0.002, 0.02):
            belt, linear = compare(k, size)
            apart = np.abs(belt - linear).max()
            print(f"ratio {ratios[k]:.2f}, step {100 * size:g} %: 63 % after {reached(belt):.3f} s, linear loop {reached(linear):.3f} s; "
                  f"at most {100 * apart:.0f} % of the step apart")  # fmt: skip
    k = 1
    slow = run(ratios[k], np.full(400, 1.02 * ratios[k]), fixed(gains[-1])) / ratios[k] - 1.0
    print(
        f"ratio {ratios[k]:.2f}, step 2 % with the gain of ratio {ratios[-1]:.1f}: 63 % after {reached(slow / 0.02):.3f} s"
    )
    time = STEP * np.arange(2400)
    wanted = np.interp(time, [1.0, 3.0, 6.0, 8.0], [2.0, 0.6, 0.6, 1.8])
    scheduled = run(2.0, wanted)
    print(
        f"shift from 2 to 0.6 and back to 1.8: at most {np.abs(scheduled - wanted).max():.3f} off, {abs(scheduled[-1] - 1.8):.4f} at the end"
    )
    figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
    axes.plot(time, wanted, "k--", label="wanted")
    axes.plot(time, scheduled, label="scheduled gain")
    axes.set(xlabel="time (s)", ylabel="ratio")
    axes.legend()
    figure.savefig("linear-control.png", dpi=120)
    return scheduled, wanted


if __name__ == "__main__":
    main()
