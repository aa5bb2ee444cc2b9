"""Figures of the drive report, each as a string of SVG."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

from pushbelt.fmu.geometry import Array
from pushbelt.fmu.intervals import intervals
from pushbelt.style import BLUE, GREEN, INK, MUTED, ORANGE, RED, STYLE, VIOLET, svg

from .hydraulics import PressureCircuit
from .simulate import LOSSES, STEP, Run
from .thrust_map import ThrustMap

TIME = "time in the cycle (s)"
LOSS_COLOURS = (BLUE, ORANGE, GREEN, VIOLET, MUTED)
"""Of `LOSSES` over time."""
SHARE_COLOURS = (ORANGE, RED, "#e0b23c", INK, MUTED)
"""Of `LOSSES` beside where else the engine's work went."""
MOST_POINTS = 3000
"""Points of a curve in a figure at most."""


def thinned(run: Run) -> slice:
    """A slice that leaves few enough points to draw."""
    return slice(None, None, max(len(run.time) // MOST_POINTS, 1))


def envelope(values: Array, step: int) -> tuple[Array, Array]:
    """Least and largest value of each `step` values: a thinned curve that loses no peak."""
    count = len(values) // step
    blocks = values[: count * step].reshape(count, step)
    return blocks.min(axis=1), blocks.max(axis=1)


def drive(run: Run) -> str:
    """Speed, ratio, engine, pressures, slip and loss over time."""
    some = thinned(run)
    time = run.time[some]
    area = PressureCircuit(0.0).area
    with plt.rc_context(STYLE):
        figure, rows = plt.subplots(6, 1, figsize=(11.2, 12.6), sharex=True, layout="constrained")
        speed, ratio, engine, pressure, slip, loss = rows
        speed.plot(time, 3.6 * run["speed.target"][some], color=ORANGE, label="cycle")
        speed.plot(time, 3.6 * run["speed.car"][some], color=BLUE, linewidth=0.9, label="car")
        speed.set_title("Speed (km/h)")
        ratio.plot(time, run["ratio.target"][some], color=ORANGE, label="target")
        ratio.plot(time, run["ratio.geometric"][some], color=BLUE, linewidth=0.9, label="ratio.geometric")
        ratio.set_yscale("log")
        ratio.set_yticks([0.5, 1.0, 2.0], ["0.5", "1", "2"])
        ratio.minorticks_off()
        ratio.set_title("Ratio $r_S/r_P$")
        engine.plot(time, run["engine.speed"][some] * 30.0 / np.pi, color=ORANGE, label="engine")
        engine.plot(time, run["primary.speed"][some] * 30.0 / np.pi, color=BLUE, linewidth=0.9, label="primary pulley")
        engine.set_title("Speeds (rpm)")
        for pulley, colour in (("primary", BLUE), ("secondary", ORANGE)):
            pressure.plot(time, 1e-5 * run[f"{pulley}.clampingForce"][some] / area, color=colour, label=pulley)
        pressure.set_title("Pressures (bar)")
        step = some.step
        low, high = envelope(100.0 * run["slip"], step)
        slip.fill_between(run.time[: len(low) * step : step], low, high, color=BLUE, linewidth=0.5)
        slip.set_ylim(-3.0, 4.0)
        slip.set_title("Slip (%)")
        for part, colour in zip(LOSSES, LOSS_COLOURS, strict=True):
            loss.plot(time, run[f"loss.{part}"][some], color=colour, linewidth=0.9, label=part)
        loss.set_title("Loss of the variator (W)")
        loss.set_xlabel(TIME)
        for axes in rows:
            for start, stop in intervals(run.time, run["macroSlip"], gap=0.2):
                axes.axvspan(start, stop + STEP, color=RED, alpha=0.25, linewidth=0)
            if axes.get_legend_handles_labels()[0]:
                axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=5, borderaxespad=0.0)
        rows[0].set_xlim(run.time[0], run.time[-1])
    return svg(figure)


def savings(fixed: Run, slip: Run) -> str:
    """Variator loss of the two clamping strategies as it adds up, and utilisation as a share of time."""
    with plt.rc_context(STYLE):
        figure, (loss, share) = plt.subplots(1, 2, figsize=(11.2, 3.4), layout="constrained")
        for run, colour in ((fixed, ORANGE), (slip, BLUE)):
            some = thinned(run)
            loss.plot(run.time[some], 1e-3 * STEP * np.cumsum(run.loss)[some], color=colour, label=run.setup.name)
            driving = run["primary.power"] > 1000.0
            share.hist(
                run["utilisation.signed"][driving],
                bins=np.arange(0.0, 1.15, 0.025),
                weights=np.full(int(driving.sum()), STEP),
                color=colour,
                histtype="step",
                linewidth=1.4,
                label=run.setup.name,
            )
        loss.set(title="Variator loss, added up (kJ)", xlabel=TIME)
        loss.legend(loc="upper left")
        share.set(title="Time (s) at a torque utilisation, above 1 kW", xlabel="torque utilisation")
        share.legend(loc="upper left")
    return svg(figure)


def energy_shares(fixed: Run, slip: Run) -> str:
    """Where the engine's work went."""
    parts = (
        ("road load", BLUE),
        ("brakes", VIOLET),
        ("launch clutch", GREEN),
        *((f"variator, {part}", colour) for part, colour in zip(LOSSES, SHARE_COLOURS, strict=True)),
    )
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(11.2, 2.3), layout="constrained")
        for place, run in enumerate((slip, fixed)):
            energies, left = run.energies(), 0.0
            for part, colour in parts:
                axes.barh(place, 1e-3 * energies[part], left=left, color=colour, height=0.62)
                left += 1e-3 * energies[part]
        axes.set_yticks([0, 1], [slip.setup.name, fixed.setup.name])
        axes.grid(axis="y", visible=False)
        axes.set_title("Energy (kJ)")
        for part, colour in parts:
            axes.barh(0, 0.0, color=colour, label=part)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=4)
    return svg(figure)


def low_friction(fixed: Run, slip: Run) -> str:
    """Slip, secondary force and loss of both strategies on a belt with less friction than they believe in."""
    with plt.rc_context(STYLE):
        figure, rows = plt.subplots(1, 3, figsize=(11.2, 3.2), layout="constrained")
        slipping, force, loss = rows
        for run, colour in ((fixed, ORANGE), (slip, BLUE)):
            label = run.setup.strategy
            slipping.plot(run.time, 100.0 * run["slip"], color=colour, label=label)
            force.plot(run.time, 1e-3 * run["secondary.clampingForce"], color=colour, label=label)
            loss.plot(run.time, 1e-3 * STEP * np.cumsum(run.loss), color=colour, label=label)
        slipping.set_title("Slip (%)")
        force.set_title("Secondary clamping force (kN)")
        loss.set_title("Variator loss, added up (kJ)")
        for axes in rows:
            axes.set_xlabel(TIME)
        slipping.legend(loc="upper left")
    return svg(figure)


def operating_points(table: ThrustMap, run: Run) -> str:
    """The thrust-ratio map, and where the car worked on it."""
    some = slice(None, None, 50)
    moving = run["primary.speed"][some] > 60.0
    ratio, utilisation, thrust = (
        run[name][some][moving] for name in ("ratio.geometric", "utilisation.signed", "thrustRatio")
    )
    with plt.rc_context(STYLE):
        figure, (where, values) = plt.subplots(1, 2, figsize=(11.2, 4.4), layout="constrained")
        lines = where.contour(table.ratios, table.utilisations, table.thrust.T, 14, colors=MUTED, linewidths=0.8)
        where.clabel(lines, fontsize=7.5)
        where.scatter(ratio, utilisation, s=5, color=BLUE, alpha=0.5, linewidths=0)
        where.set_xscale("log")
        where.set_xticks([0.5, 1.0, 2.0], ["0.5", "1", "2"])
        where.minorticks_off()
        where.set(
            title="Thrust ratio of the map, and the points worked at", xlabel="ratio", ylabel="torque utilisation"
        )
        expected = [table.thrust_ratio(i, u) for i, u in zip(ratio, utilisation, strict=True)]
        values.scatter(expected, thrust, s=5, color=BLUE, alpha=0.5, linewidths=0)
        low, high = float(table.thrust.min()), float(table.thrust.max())
        values.plot([low, high], [low, high], color=INK, linewidth=0.8)
        values.set_ylim(low - 0.5, high + 0.5)
        values.set(title="Thrust ratio while driving", xlabel="of the map (steady)", ylabel="of the belt")
    return svg(figure)
