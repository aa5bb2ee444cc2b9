"""Figures of the report, each as a string of SVG."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from pushbelt.fmu.geometry import Array, TwoPulleyCurve
from pushbelt.fmu.intervals import intervals
from pushbelt.fmu.results import LoadCaseResult, Profile, Trace
from pushbelt.style import BLUE, GREEN, INK, MUTED, ORANGE, RED, STYLE, VIOLET, svg

from .checks import energy_bound
from .events import Event
from .results import MeasuredPoint

RATIO_COLOURS = {"underdrive": BLUE, "medium": GREEN, "overdrive": ORANGE}

LOSSES = (
    ("loss.sheaves", "sheave friction", BLUE),
    ("loss.ring", "ring friction", ORANGE),
    ("loss.layers", "ring layers", GREEN),
    ("loss.shafts", "shafts", VIOLET),
    ("loss.other", "rest", MUTED),
)
"""Output, name and colour of each loss."""

STANDSTILL = 1.0
"""Below this secondary speed quotients of speeds are left out, rad/s."""


def load_case_bars(results: Sequence[LoadCaseResult], measured: Sequence[MeasuredPoint]) -> str:
    """Thrust ratio, efficiency with the measured transmission beside it, and shares of the loss."""
    names = ["underdrive", "medium", "overdrive"]
    torques = sorted({result.case.torque for result in results})
    with plt.rc_context(STYLE):
        figure, (thrust, efficiency, losses) = plt.subplots(1, 3, figsize=(11.2, 3.1), layout="constrained")
        for name in names:
            line = sorted((r for r in results if r.case.ratio_name == name), key=lambda r: r.case.torque)
            colour = RATIO_COLOURS[name]
            ratios = [r.steady["thrustRatio"] for r in line]
            thrust.plot(torques, ratios, "o-", color=colour)
            thrust.annotate(
                name, (torques[-1], ratios[-1]), (-2, 6), textcoords="offset points", ha="right", color=colour
            )
            efficiency.plot(torques, [100 * r.steady["efficiency"] for r in line], "o-", color=colour)
            for point in (point for point in measured if nearest_case(point, results) == name):
                place = [point.measured.torque] * 2
                values = [100 * point.efficiency, 100 * point.measured.efficiency]
                efficiency.plot(place, values, ":", color=colour, linewidth=0.9)
                efficiency.plot(place[0], values[0], "o", color=colour, fillstyle="none")
                efficiency.plot(place[0], values[1], "x", color=colour)
        thrust.set(title="Thrust ratio", xlabel="primary torque (N·m)")
        thrust.margins(y=0.16)
        efficiency.set(title="Efficiency of the shafts (%)", xlabel="primary torque (N·m)")
        efficiency.plot([], [], "o-", color=MUTED, label="load cases")
        efficiency.plot([], [], "o", color=MUTED, fillstyle="none", label="at the measured points")
        efficiency.plot([], [], "x", color=MUTED, label="measured transmission")
        efficiency.legend(loc="lower right")
        _loss_shares(losses, results, names, torques)
    return svg(figure)


def nearest_case(point: MeasuredPoint, results: Sequence[LoadCaseResult]) -> str:
    """Which of the load cases' ratios a measured point is nearest to."""

    def distance(result: LoadCaseResult) -> float:
        return abs(np.log(point.measured.ratio / result.steady["ratio.geometric"]))

    return min(results, key=distance).case.ratio_name


def _loss_shares(axes: Axes, results: Sequence[LoadCaseResult], names: Sequence[str], torques: Sequence[float]) -> None:
    by_case = {(r.case.ratio_name, r.case.torque): r.steady for r in results}
    places, labels = [], []
    for group, name in enumerate(names):
        for k, torque in enumerate(torques):
            place, bottom = group * (len(torques) + 0.8) + k, 0.0
            for part, _, colour in LOSSES:
                height = by_case[name, torque][part]
                axes.bar(place, height, 0.82, bottom=bottom, color=colour)
                bottom += height
            places.append(place)
            labels.append(f"{torque:g}")
        axes.annotate(
            name,
            (group * (len(torques) + 0.8) + (len(torques) - 1) / 2, 0),
            (0, -24),
            textcoords="offset points",
            ha="center",
            va="top",
            color=RATIO_COLOURS[name],
            fontsize=8.5,
        )
    axes.set_xticks(places, labels)
    axes.grid(axis="x", visible=False)
    axes.set_title("Losses (W) by ratio and torque (N·m)")
    axes.set_xlabel(" ", labelpad=12)
    for _, label, colour in LOSSES:
        axes.bar(0, 0, color=colour, label=label)
    axes.set_ylim(top=1.35 * axes.get_ylim()[1])
    axes.legend(loc="upper center", ncols=3, columnspacing=1.0, handlelength=1.2)


def manoeuvre(trace: Trace, events: Sequence[Event]) -> str:
    """The whole manoeuvre over time."""
    panels = (_torques, _forces, _speeds, _ratio, _slip, _losses, _energy)
    with plt.rc_context(STYLE):
        figure, rows = plt.subplots(len(panels), 1, figsize=(11.2, 13.4), sharex=True, layout="constrained")
        for panel, axes in zip(panels, rows, strict=True):
            panel(axes, trace)
        _mark(rows, trace, events)
        for panel, axes in zip(panels, rows, strict=True):
            if panel is not _slip:
                axes.legend(loc="upper left", ncols=4)
                low, high = axes.get_ylim()
                axes.set_ylim(low, 4.0 * high if panel is _losses else high + 0.18 * (high - low))
        rows[-1].set_xlabel("time (s)")
        rows[-1].set_xlim(trace.time[0], trace.time[-1])
    return svg(figure)


DASHED = {"linewidth": 0.9, "linestyle": "--"}


def _torques(axes: Axes, trace: Trace) -> None:
    axes.plot(trace.time, trace["primary.externalTorque"], color=MUTED, label="P, external", **DASHED)
    axes.plot(trace.time, -trace["primary.shaftTorque"], color=BLUE, label="P, carried by the belt")
    axes.plot(trace.time, trace["secondary.shaftTorque"], color=ORANGE, label="S, of the belt")
    axes.set_title("Torques (N·m)")


def _forces(axes: Axes, trace: Trace) -> None:
    for pulley, colour in (("primary", BLUE), ("secondary", ORANGE)):
        label = pulley[0].upper()
        axes.plot(trace.time, 1e-3 * trace[f"{pulley}.axialForce"], color=colour, label=f"{label}, of the belt")
        clamping = 1e-3 * trace[f"{pulley}.clampingForce"]
        axes.plot(trace.time, clamping, color=colour, alpha=0.7, label=f"{label}, clamping", **DASHED)
    axes.set_title("Axial forces (kN)")


def _speeds(axes: Axes, trace: Trace) -> None:
    axes.plot(trace.time, trace["primary.speed"], color=BLUE, label="P")
    axes.plot(trace.time, trace["secondary.speed"], color=ORANGE, label="S")
    axes.set_title("Speeds (rad/s)")


def _moving(trace: Trace) -> Array:
    return np.abs(trace["secondary.speed"]) > STANDSTILL


def _ratio(axes: Axes, trace: Trace) -> None:
    axes.plot(trace.time, trace["ratio.geometric"], color=GREEN, label="geometric, $r_S/r_P$")
    of_speeds = np.where(_moving(trace), trace["ratio.speed"], np.nan)
    axes.plot(trace.time, of_speeds, color=MUTED, label=r"of speeds, $\omega_P/\omega_S$", **DASHED)
    axes.set_ylim(0.0, 1.25 * trace["ratio.geometric"].max())
    axes.set_title("Ratio")


def _slip(axes: Axes, trace: Trace) -> None:
    moving = _moving(trace)
    axes.plot(trace.time, np.where(moving, 100 * trace["slip"], np.nan), color=RED)
    axes.set_yscale("symlog", linthresh=3, linscale=1.5)
    axes.set_yticks([-100, -10, -3, 0, 1, 2, 3, 10, 100], ["−100", "−10", "−3", "0", "1", "2", "3", "10", "100"])
    shown = 100 * trace["slip"][moving]
    axes.set_ylim(min(-1.0, 1.3 * shown.min(initial=0.0)), max(5.0, 1.5 * shown.max(initial=0.0)))
    axes.set_title("Slip (%), linear to 3 %, logarithmic beyond")


def _losses(axes: Axes, trace: Trace) -> None:
    for part, label, colour in LOSSES:
        axes.plot(trace.time, 1e-3 * trace[part], color=colour, label=label)
    axes.set_yscale("symlog", linthresh=1, linscale=1.5)
    axes.set_ylim(bottom=min(0.0, 1e-3 * min(trace[part].min() for part, *_ in LOSSES)))
    axes.set_yticks([0, 0.5, 1, 10, 100], ["0", "0.5", "1", "10", "100"])
    axes.set_title("Losses (kW), linear to 1 kW, logarithmic beyond")


def _energy(axes: Axes, trace: Trace) -> None:
    bound = energy_bound(trace)
    axes.plot(trace.time, trace["energy.residual"], color=VIOLET, label="residual")
    for sign, label in ((1, "bound"), (-1, None)):
        axes.plot(trace.time, sign * bound, color=MUTED, label=label, **DASHED)
    axes.set_title("Energy: supplied less lost less stored (J)")


def overload(trace: Trace, start: float, end: float) -> str:
    """Torques, speeds and loss between two times, for a closer look at macro-slip."""
    inside = (trace.time >= start) & (trace.time <= end)
    time = trace.time[inside]
    with plt.rc_context(STYLE):
        figure, (torque, speed, loss) = plt.subplots(1, 3, figsize=(11.2, 2.9), layout="constrained")
        external, carried = trace["primary.externalTorque"][inside], -trace["primary.shaftTorque"][inside]
        torque.plot(time, external, color=MUTED, linewidth=0.9, linestyle="--", label="external")
        torque.plot(time, carried, color=BLUE, label="carried by the belt")
        torque.set_title("Torque on P (N·m)")
        speed.plot(time, trace["primary.speed"][inside], color=BLUE, label="P")
        speed.plot(time, trace["secondary.speed"][inside], color=ORANGE, label="S")
        speed.set_title("Speeds (rad/s)")
        loss.plot(time, 1e-3 * trace["loss.total"][inside], color=RED)
        loss.set_title("Losses (kW)")
        for axes in (torque, speed, loss):
            for first, last in intervals(time, trace["macroSlip"][inside], gap=0.02):
                axes.axvspan(first, last, color=RED, alpha=0.12, linewidth=0)
            axes.set_xlim(time[0], time[-1])
            axes.set_xlabel("time (s)")
        for axes in (torque, speed):
            axes.legend(loc="upper right")
    return svg(figure)


def _mark(rows: Sequence[Axes], trace: Trace, events: Sequence[Event]) -> None:
    """Shades macro-slip and marks the starts of the events on all axes."""
    for start, end in intervals(trace.time, trace["macroSlip"], gap=0.02):
        for axes in rows:
            axes.axvspan(start, max(end, start + 0.01), color=RED, alpha=0.12, linewidth=0)
    rows[0].set_title(rows[0].get_title(loc="left"), pad=20)
    for number, event in enumerate((event for event in events if event.occurred), start=1):
        for axes in rows:
            axes.axvline(event.start, color=INK, alpha=0.25, linewidth=0.8)
        rows[0].annotate(
            str(number),
            (event.start, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 8),
            textcoords="offset points",
            ha="center",
            fontsize=8,
            color="white",
            bbox={"boxstyle": "circle,pad=0.25", "color": INK},
        )


def fields(profile: Profile, curve: TwoPulleyCurve) -> str:
    """Fields along the belt, arcs shaded."""
    order = np.append(np.arange(len(profile.position)), 0)
    xi = 1e3 * np.append(profile.position, curve.length)
    rows = (
        ("Push force (N)", profile.push_force, BLUE),
        ("Ring tension (N)", profile.ring_tension, ORANGE),
        ("Normal force per flank (kN/m)", 1e-3 * profile.normal_force, GREEN),
        ("Radial deviation (mm)", 1e3 * profile.radial_deviation, VIOLET),
        ("Sliding speed of the flanks (mm/s)", 1e3 * profile.sliding_speed, RED),
    )
    with plt.rc_context(STYLE):
        figure, panels = plt.subplots(len(rows), 1, figsize=(11.2, 8.6), sharex=True, layout="constrained")
        for axes, (title, values, colour) in zip(panels, rows, strict=True):
            _shade_arcs(axes, curve)
            axes.plot(xi, values[order], color=colour, marker=".", markersize=3.5)
            axes.set_title(title)
            if values.min() >= 0.0 and title.startswith(("Push", "Normal")):
                axes.set_ylim(bottom=0.0)
        panels[-1].set(xlabel="place ξ along the belt (mm)", xlim=(0.0, 1e3 * curve.length))
        borders = 1e3 * np.array(curve.borders)
        labels = ("S arc", "upper strand", "P arc", "lower (push) strand", "S arc")
        for start, end, label in zip(borders[:-1], borders[1:], labels, strict=True):
            panels[0].annotate(
                label,
                (0.5 * (start + end), 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(0, 3),
                textcoords="offset points",
                ha="center",
                va="bottom",
                color=MUTED,
                fontsize=8.5,
            )
        panels[0].set_title("Push force (N)", pad=16)
    return svg(figure)


def _shade_arcs(axes: Axes, curve: TwoPulleyCurve) -> None:
    start, s_end, p_start, p_end, s_start, end = 1e3 * np.array(curve.borders)
    for left, right, colour in ((start, s_end, ORANGE), (p_start, p_end, BLUE), (s_start, end, ORANGE)):
        axes.axvspan(left, right, color=colour, alpha=0.08, linewidth=0)
