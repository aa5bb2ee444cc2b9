"""Figures of the report, each as a string of SVG."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from pushbelt.style import BLUE, GREEN, INK, MUTED, ORANGE, RED, STYLE, VIOLET, svg

from . import profiles
from .results import MODELS, OTHERS, REFERENCE, CaseRun, PaperResults
from .rings import Rings
from .statements_rings import REFERENCE_DIRECTIONS

EVEN = "ALE, evenly spaced mesh"

COLOURS = {"RCM": INK, "ANCF": VIOLET, "ALE0": ORANGE, "ALE": BLUE, REFERENCE_DIRECTIONS: GREEN, EVEN: RED}
SHORT_NAMES = {REFERENCE_DIRECTIONS: "ALE, [t, n]", EVEN: "ALE, even mesh"}
LINES = {"RCM": {"linewidth": 2.2, "alpha": 0.55}}
"""The reference lies under the others."""


def label(model: str) -> str:
    """A model's name in a legend."""
    return SHORT_NAMES.get(model, model)


def reference_oscillation(rings: Rings) -> str:
    """Fig. 6: outlines at four times, the two coordinates and the energies over time."""
    motion, shapes = rings.motions["6", "ALE0"], rings.shapes["6", "ALE0"]
    falling = np.nonzero(motion.theta < 0.0)[0]
    half = motion.time[int(np.argmin(motion.theta[: 2 * falling[0] + 1]))]
    with plt.rc_context(STYLE):
        figure, (outline, coordinates, energy) = plt.subplots(
            1, 3, figsize=(11.2, 3.2), layout="constrained", width_ratios=(1.25, 1, 1)
        )
        shades = (INK, BLUE, GREEN, ORANGE)
        for k, (share, colour) in enumerate(zip((0.0, 0.3, 0.5, 1.0), shades, strict=True)):
            moment = min(shapes, key=lambda t, share=share: abs(t - share * half))
            points = 1e3 * shapes[moment]
            outline.plot(*points.T, color=colour, label=f"$t_{k}$ = {1e3 * moment:.1f} ms")
        _square(outline, "Outline (mm)")
        outline.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2)
        coordinates.plot(1e3 * motion.time, motion.theta, color=BLUE, label="Θ")
        coordinates.plot(1e3 * motion.time, motion.drift, color=ORANGE, label="s (m)")
        coordinates.set(title="Ratio coordinate and drift", xlabel="time (ms)")
        coordinates.legend(loc="upper right", ncols=2)
        coordinates.set_ylim(-0.5, 0.62)
        start = motion.total[0]
        for values, name, colour in (
            (motion.kinetic, "kinetic", BLUE),
            (motion.bending - motion.bending.min(), "bending, above its least", ORANGE),
            (motion.total - start + np.ptp(motion.bending), "sum", INK),
        ):
            energy.plot(1e3 * motion.time, 1e-3 * values, color=colour, label=name)
        energy.set(title="Energy (kJ)", xlabel="time (ms)")
        energy.set_ylim(top=1.45 * energy.get_ylim()[1])
        energy.legend(loc="upper right", ncols=2)
    return svg(figure)


def _square(axes: Axes, title: str) -> None:
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title(title)
    axes.grid(visible=False)


def mesh_energy(rings: Rings) -> str:
    """Energy error of fig. 6 and 7 on the two meshes."""
    panels = (
        ("6", {"ALE0, 24 elements": ("borders on the arcs", BLUE), "ALE0, evenly spaced mesh": ("evenly spaced", RED)}),
        ("7", {"ALE": ("borders on the arcs", BLUE), EVEN: ("evenly spaced", RED)}),
    )
    with plt.rc_context(STYLE):
        figure, both = plt.subplots(1, 2, figsize=(11.2, 2.9), layout="constrained")
        for axes, (number, models) in zip(both, panels, strict=True):
            for model, (name, colour) in models.items():
                motion = rings.motions[number, model]
                size = np.ptp(motion.kinetic)
                error = np.abs(motion.total - motion.total[0])[1:] / size
                axes.semilogy(1e3 * motion.time[1:], np.maximum(error, 1e-9), color=colour, label=name)
            axes.set_xlabel("time (ms)")
            axes.set_ylim(1e-7, 3e1)
            axes.legend(loc="upper right", ncols=2)
        both[0].set_title("Reference motion: energy error / largest kinetic energy")
        both[1].set_title("Deformable ring: energy error / largest kinetic energy")
    return svg(figure)


def deformable_ring(rings: Rings) -> str:
    """Fig. 7: outlines at four times; Θ, ovality and energies over time."""
    names = [name for name in ("RCM", "ANCF", "ALE", REFERENCE_DIRECTIONS) if ("7", name) in rings.motions]
    ale, rcm = rings.motions["7", "ALE"], rings.motions["7", "RCM"]
    kinked = float(ale.time[int(np.argmax(ale.theta))])
    oval = float(rcm.time[int(np.argmin(rcm.ovality))])
    moments = (0.0, 2e-4, kinked, oval)
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(11.2, 6.0), layout="constrained")
        top, bottom = figure.subfigures(2, 1, height_ratios=(1.15, 1))
        panels = top.subplots(1, 4, sharex=True, sharey=True)
        for k, (axes, moment) in enumerate(zip(panels, moments, strict=True)):
            for name in names:
                shapes = rings.shapes["7", name]
                nearest = min(shapes, key=lambda t, moment=moment: abs(t - moment))
                if abs(nearest - moment) < 6e-5:
                    style = {"color": COLOURS[name], **LINES.get(name, {})}
                    axes.plot(*(1e3 * shapes[nearest]).T, **style, label=label(name))
                    if name == "ALE":
                        axes.plot(*(1e3 * shapes[nearest][0]), "o", color=BLUE, markersize=5)
            axes.set_aspect("equal", adjustable="box")
            axes.set_title(f"$t_{k}$ = {1e3 * moment:.2f} ms")
            axes.grid(visible=False)
            axes.set_xlabel("x (mm)")
        panels[0].set_ylabel("y (mm)")
        handles, labels = panels[0].get_legend_handles_labels()
        top.legend(handles, labels, loc="outside lower center", ncols=len(names))
        ratio, shape, energy = bottom.subplots(1, 3)
        for name in names:
            motion = rings.motions["7", name]
            style = {"color": COLOURS[name], **LINES.get(name, {})}
            if name in ("ALE", REFERENCE_DIRECTIONS):
                ratio.plot(1e3 * motion.time, motion.theta, **style)
            shape.plot(1e3 * motion.time, 1e4 * motion.ovality, **style)
        ratio.set(title="Ratio coordinate Θ of the Eulerian rings", xlabel="time (ms)")
        shape.set(title="Ovality ∮(x² − y²)/L about the centre (cm²)", xlabel="time (ms)")
        for values, name, colour in (
            (rcm.kinetic, "kinetic", BLUE),
            (rcm.bending, "bending", ORANGE),
            (rcm.membrane, "membrane", GREEN),
            (rcm.total, "sum", INK),
        ):
            energy.plot(1e3 * rcm.time, 1e-6 * values, color=colour, label=name)
        energy.set(title="Energies of RCM (MJ)", xlabel="time (ms)")
        energy.set_ylim(top=1.4 * energy.get_ylim()[1])
        energy.legend(loc="upper right", ncols=4, columnspacing=0.9, handlelength=1.1)
    return svg(figure)


def convergence(rings: Rings) -> str:
    """Frequency of the free ring against the analytic one on a ladder of meshes, and the orders in time."""
    with plt.rc_context(STYLE):
        figure, (space, time) = plt.subplots(1, 2, figsize=(11.2, 3.2), layout="constrained")
        for name in ("RCM", "ANCF", "ALE", REFERENCE_DIRECTIONS):
            ladder = sorted(
                (f.elements, abs(f.error)) for f in rings.frequencies if f.model == name and "small" in f.case
            )
            style = {"color": COLOURS[name], **LINES.get(name, {})}
            space.loglog(*np.array(ladder).T, "o-", **style, label=label(name))
            steps = [(o.resolution, o.error) for o in rings.orders if o.model == name and "shape in time" in o.quantity]
            if steps:
                resolution, error = np.array(steps).T
                time.loglog(resolution, 1e6 * error, "o-", **style, label=label(name))
        space.set(title="Free ring: error of the first frequency against the thin ring", xlabel="elements")
        _plain_ticks(space, sorted({f.elements for f in rings.frequencies if "small" in f.case}))
        space.legend(loc="lower left", ncols=2)
        if time.has_data():
            time.set(title="Free ring: error of the shape after 1.2 periods (µm)", xlabel="steps a period")
            _plain_ticks(time, sorted({round(o.resolution) for o in rings.orders if "shape in time" in o.quantity}))
        else:
            time.set_axis_off()
    return svg(figure)


def _plain_ticks(axes: Axes, ticks: Sequence[int]) -> None:
    axes.set_xticks(ticks, [str(tick) for tick in ticks])
    axes.minorticks_off()


def _case_ticks(axes: Axes, results: PaperResults) -> None:
    names = [f"{case.ratio_name.removesuffix('drive')}\n{case.torque:g} N·m" for case in results.cases]
    axes.set_xticks(range(len(names)), names)
    axes.tick_params(axis="x", length=0, labelsize=8)
    axes.grid(axis="x", visible=False)


def _bars(axes: Axes, results: PaperResults, models: Sequence[str], value: Callable[[CaseRun], float]) -> None:
    """Bars of all cases, one a model, grouped by case."""
    width = 0.84 / len(models)
    for k, model in enumerate(models):
        places = np.arange(len(results.cases)) + width * (k - 0.5 * (len(models) - 1))
        values = [value(results.run(case, model)) for case in results.cases]
        slipping = [results.run(case, model).slipped for case in results.cases]
        bars = axes.bar(places, values, 0.94 * width, color=COLOURS.get(model, MUTED), label=label(model))
        for bar, slips in zip(bars, slipping, strict=True):
            if slips:
                bar.set(hatch="////", edgecolor="white", linewidth=0.0)
    _case_ticks(axes, results)
    axes.axhline(0.0, color=MUTED, linewidth=0.8)


def thrust_and_efficiency(results: PaperResults) -> str:
    """Fig. 8a and 8b: levels, and differences to the reference model."""
    with plt.rc_context(STYLE):
        figure, ((thrust, efficiency), (thrust_off, efficiency_off)) = plt.subplots(
            2, 2, figsize=(11.2, 5.8), layout="constrained"
        )
        _bars(thrust, results, MODELS, lambda run: run.window.thrust_ratio)
        thrust.set_title("8a  Thrust ratio")
        _bars(efficiency, results, MODELS, lambda run: 100.0 * run.window.efficiency)
        lowest = 100.0 * min(run.window.efficiency for run in results.runs)
        efficiency.set_ylim(np.floor(lowest - 1.0), 100.0)
        efficiency.set_title("8b  Efficiency (%)")
        _bars(thrust_off, results, OTHERS, lambda run: 100.0 * results.thrust_difference(run.case, run.model))
        thrust_off.set_title(f"Thrust ratio, difference to {REFERENCE} (%)")
        _bars(efficiency_off, results, OTHERS, lambda run: 100.0 * results.efficiency_difference(run.case, run.model))
        efficiency_off.set_title(f"Efficiency, difference to {REFERENCE} (points)")
        handles, labels = thrust.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return svg(figure)


def push_force(results: PaperResults, run_of: Callable[[str], CaseRun]) -> str:
    """Fig. 8c: push force on one element over one revolution."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(11.2, 3.5), layout="constrained")
        for model in MODELS:
            path, force = profiles.element(results.parameters, run_of(model))
            style = {"color": COLOURS.get(model, MUTED), **LINES.get(model, {})}
            axes.plot(1e3 * path.time, force, **style, label=label(model))
        shown = run_of(REFERENCE)
        path, _ = profiles.element(results.parameters, shown)
        shape = profiles.curve(results.parameters, shown.window)
        _, s_end, p_start, p_end, s_start, length = shape.borders
        marks = np.interp([p_start, p_end, s_start, length + s_end, length + p_start], path.xi, 1e3 * path.time)
        names = ("primary arc", "push strand", "secondary arc", "slack strand")
        for name, start, end, colour in zip(names, marks[:-1], marks[1:], (BLUE, None, ORANGE, None), strict=True):
            if colour:
                axes.axvspan(start, end, color=colour, alpha=0.08, linewidth=0)
            axes.annotate(name, (0.5 * (start + end), 1.0), xycoords=("data", "axes fraction"), xytext=(0, 3),
                          textcoords="offset points", ha="center", color=MUTED, fontsize=8.5)  # fmt: skip
        axes.set(xlabel="time since the element enters the primary arc (ms)", xlim=(0.0, float(1e3 * path.time[-1])))
        axes.set_title(f"8c  Push force on one element (N), {shown.case.name} N·m", pad=18)
        axes.legend(loc="upper right")
    return svg(figure)


def spiral_running(results: PaperResults, run_of: Callable[[str], CaseRun]) -> str:
    """Fig. 8d: radius along both arcs."""
    with plt.rc_context(STYLE):
        figure, both = plt.subplots(1, 2, figsize=(11.2, 3.2), sharey=True, layout="constrained")
        for axes, pulley in zip(both, ("primary", "secondary"), strict=True):
            for model in MODELS:
                fraction, deviation = profiles.arc(results.parameters, run_of(model), pulley)
                style = {"color": COLOURS.get(model, MUTED), **LINES.get(model, {})}
                axes.plot(fraction, 1e3 * deviation, ".-", markersize=3.5, **style, label=label(model))
            axes.set(
                title=f"8d  Radius less its mean (mm), {pulley} arc", xlabel="from entry (0) to exit (1)", xlim=(0, 1)
            )
        both[0].legend(loc="best")
    return svg(figure)


def computing_times(results: PaperResults) -> str:
    """Fig. 9: computing times relative to the reference model's."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(11.2, 3.4), layout="constrained")
        width = 0.84 / len(MODELS)
        for k, model in enumerate(MODELS):
            places = np.arange(len(results.cases)) + width * (k - 0.5 * (len(MODELS) - 1))
            ratios = np.array([results.time_ratio(case, model) for case in results.cases])
            base = np.array([results.run(case, REFERENCE).times.median for case in results.cases])
            ends = np.array(
                [[f(results.run(case, model).times.stepping) for case in results.cases] for f in (min, max)]
            )
            errors = np.abs(ends / base - ratios)
            axes.bar(places, ratios, 0.94 * width, color=COLOURS.get(model, MUTED), label=label(model))
            axes.errorbar(places, ratios, errors, fmt="none", ecolor=RED, elinewidth=1.0, capsize=2)
        levels = {"paper: ALE": (0.8, BLUE), "paper: ANCF, ALE0": (0.5, VIOLET), "goal for ALE": (0.1, GREEN)}
        for name, (level, colour) in levels.items():
            axes.axhline(level, color=colour, linewidth=0.9, linestyle="--")
            axes.annotate(name, (1.0, level), xycoords=("axes fraction", "data"), xytext=(-4, 2),
                          textcoords="offset points", ha="right", va="bottom", color=colour, fontsize=8)  # fmt: skip
        axes.set_yscale("log")
        _case_ticks(axes, results)
        axes.set_title(f"9  Computing time relative to {REFERENCE}", pad=22)
        axes.legend(loc="lower left", bbox_to_anchor=(0.35, 1.0), ncols=len(MODELS))
    return svg(figure)
