"""Figures of the report."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from pushbelt.fmu.data import load_cases, parameter_set
from pushbelt.fmu.geometry import Array
from pushbelt.fmu.results import LoadCase
from pushbelt.report.charts import Chart, Level, Panel, Series, Shade, Tick, around
from pushbelt.report.style import BLUE, GREEN, INK, MUTED, ORANGE, RED, VIOLET

from . import profiles, times
from .results import MODELS, OTHERS, PULLEYS, REFERENCE, CaseRun, PaperResults
from .rings import Motion, Rings
from .statements import REFERENCE_DIRECTIONS

EVEN = "ALE, evenly spaced mesh"

FORWARD = f"ALE0{times.FORWARD}", f"ALE{times.FORWARD}"
COLOURS = {FORWARD[0]: RED, FORWARD[1]: GREEN, "RCM": INK, "ANCF": VIOLET, "ALE0": ORANGE, "ALE": BLUE, REFERENCE_DIRECTIONS: GREEN, EVEN: RED}
SHORT_NAMES = {REFERENCE_DIRECTIONS: "ALE, [t, n]", EVEN: "ALE, even mesh"}
LINES = {"RCM": {"width": 3.2, "opacity": 0.5}, "ANCF": {"dash": "dash"}}
"""Drawing order: the reference model is below the others."""
BELT_RING = "ring of bench168"
"""The ring of a belt in the tables of rings alone."""
TIME = "time (ms)"


def _of(model: str, x: Array, y: Array, **look: object) -> Series:
    """A line of a model."""
    return Series(SHORT_NAMES.get(model, model), x, y, COLOURS.get(model, MUTED), **{**LINES.get(model, {}), **look})  # type: ignore[arg-type]


def _lines(motions: Mapping[str, Motion], field: str, factor: float = 1.0) -> list[Series]:
    """A quantity of several models over time in ms."""
    return [_of(name, 1e3 * motion.time, factor * getattr(motion, field)) for name, motion in motions.items()]


def reference_oscillation(rings: Rings) -> Chart:
    """Fig. 6: outlines at four times; the two coordinates and the energies over time."""
    motion, shapes = rings.motions["6", "ALE0"], rings.shapes["6", "ALE0"]
    time = 1e3 * motion.time
    energies = (
        ("kinetic", motion.kinetic, BLUE, ""),
        ("bending, above its minimum", motion.bending - motion.bending.min(), ORANGE, "dash"),
        ("sum", motion.total - motion.total[0] + np.ptp(motion.bending), INK, ""),
    )
    coordinates = [Series("Θ", time, motion.theta, BLUE), Series("s (m)", time, motion.drift, ORANGE, dash="dash")]
    sums = [Series(name, time, 1e-3 * values, colour, dash=dash) for name, values, colour, dash in energies]
    return Chart(
        [
            _stages(motion, shapes),
            Panel("Ratio coordinate and drift", coordinates, TIME, height=280),
            Panel("Energy (kJ)", sums, TIME, height=280),
        ],
        "Outlines, coordinates and energies of the reference oscillation",
        columns=3,
    )


def mesh_energy(rings: Rings) -> Chart:
    """Energy error of fig. 6 and 7 on the two meshes."""
    panels = []
    for title, number, names in (
        ("Reference motion", "6", ("ALE0, 24 elements", "ALE0, evenly spaced mesh")),
        ("Deformable ring", "7", ("ALE", EVEN)),
    ):
        series = []
        for model, name, colour in zip(names, ("borders on the arcs", "evenly spaced"), (BLUE, RED), strict=True):
            motion = rings.motions[number, model]
            error = np.abs(motion.total - motion.total[0])[1:] / np.ptp(motion.kinetic)
            series.append(Series(name, 1e3 * motion.time[1:], np.maximum(error, 1e-9), colour))
        title = f"{title}: energy error / largest kinetic energy"
        panels.append(Panel(title, series, TIME, scale="log", y_range=(1e-7, 3e1), height=250))
    return Chart(panels, "Energy errors on both meshes over time", columns=2, common_legend=True)


def _stages_of(ale: Motion, rcm: Motion) -> tuple[float, float]:
    """Times of the largest Θ of ALE, and of the oval of RCM, s."""
    return float(ale.time[ale.theta.argmax()]), float(rcm.time[rcm.ovality.argmin()])


def deformable_ring(rings: Rings) -> tuple[Chart, Chart]:
    """Fig. 7: outlines at four times; Θ, ovality and energies over time."""
    models = ("RCM", "ANCF", "ALE", REFERENCE_DIRECTIONS)
    motions = {name: rings.motions["7", name] for name in models if ("7", name) in rings.motions}
    moments = (0.0, 2e-4, *_stages_of(motions["ALE"], rcm := motions["RCM"]))
    outlines = [_outlines(rings, list(motions), k, moment) for k, moment in enumerate(moments)]
    lines = [one for panel in outlines for one in panel.series]
    x_range, y_range = (around([getattr(one, axis) for one in lines]) for axis in "xy")
    outlines = [replace(panel, x_range=x_range, y_range=y_range) for panel in outlines]
    eulerian = {name: motion for name, motion in motions.items() if name.startswith("ALE")}
    energies = (("kinetic", BLUE), ("bending", ORANGE), ("membrane", GREEN), ("total", INK))
    sums = [
        Series(name.replace("total", "sum"), 1e3 * rcm.time, 1e-6 * getattr(rcm, name), colour) for name, colour in energies
    ]
    over_time = [
        Panel("Ratio coordinate Θ of the Eulerian rings", _lines(eulerian, "theta"), TIME),
        Panel("Ovality ∮(x² − y²)/L about the centre (cm²)", _lines(motions, "ovality", 1e4), TIME),
        Panel("Energies of RCM (MJ)", sums, TIME),
    ]
    said = "Outlines of the deformable ring for all models"
    return (
        Chart(outlines, said, columns=4, common_legend=True, least_width=230),
        Chart(over_time, "Θ, ovality and energies of the deformable ring over time", columns=3, linked=True),
    )


def _at(shapes: Mapping[float, Array], moment: float) -> Array | None:
    """The outline in mm near a time, as two rows; none if the run had ended before."""
    nearest = min(shapes, key=lambda t: abs(t - moment))
    return 1e3 * shapes[nearest].T if abs(nearest - moment) <= 0.6 * sorted(shapes)[1] else None


def _outlines(rings: Rings, names: Sequence[str], number: int, moment: float) -> Panel:
    series = []
    for name in names:
        outline = _at(rings.shapes["7", name], moment)
        if outline is not None:
            series.append(_of(name, *outline))
            if name == "ALE":
                x, y = outline[:, 0]
                series.append(Series("locked node of ALE", [x], [y], BLUE, "points", size=7))
    return Panel(f"t{number} = {1e3 * moment:.2f} ms", series, "x (mm)", equal=True, height=250)


def belt_ring(rings: Rings) -> tuple[Chart, Chart]:
    """Fig. 6 and 7 on the ring of a belt: outlines at the paper's four stages, and Θ over time."""
    reference = rings.motions["6 belt", BELT_RING]
    moving = {name: motion for (figure, name), motion in rings.motions.items() if figure == "7 belt"}
    coarse, fine, rcm = (next(name for name in moving if word in name) for word in (", 8 el", ", 40 el", "RCM"))
    kinked, oval = _stages_of(moving[coarse], moving[rcm])
    looks: dict[str, tuple[str, str, dict[str, Any]]] = {
        rcm: ("RCM", INK, LINES["RCM"]), coarse: ("ALE, 8 elements", BLUE, {}), fine: ("ALE, 40 elements", GREEN, {"dash": "dash"}),
    }  # fmt: skip
    panels = [_stages(reference, rings.shapes["6 belt", BELT_RING])]
    for number, moment in enumerate((0.2 * kinked, kinked, oval), start=1):
        outlines = {name: _at(rings.shapes["7 belt", name], moment) for name in looks}
        series = [
            Series(looks[name][0], *outline, looks[name][1], **looks[name][2])
            for name, outline in outlines.items()
            if outline is not None
        ]
        panels.append(Panel(f"7: t{number} = {1e3 * moment:.1f} ms", series, "x (mm)", equal=True, height=250))
    thetas, stretches = [], []
    for name, (said, colour, look) in looks.items():
        motion = moving[name]
        stretches.append(Series(said, 1e3 * motion.time, motion.membrane / motion.total[0], colour, **look))
        if name != rcm:
            thetas.append(Series(said, 1e3 * motion.time, motion.theta, colour))
    over_time = [
        Panel("6: ratio coordinate Θ", [Series("Θ", 1e3 * reference.time, reference.theta, BLUE)], TIME),
        Panel("7: ratio coordinate Θ", thetas, TIME),
        Panel("7: energy of stretch / energy at the start", stretches, TIME),
    ]
    return (
        Chart(panels, "Outlines of the ring of a belt", columns=4, least_width=230),
        Chart(over_time, "Θ and energy of stretch over time", columns=3),
    )


def _stages(motion: Motion, shapes: Mapping[float, Array]) -> Panel:
    """Outlines of the reference oscillation at four times of its first half."""
    falling = np.nonzero(motion.theta < 0.0)[0]
    half = motion.time[motion.theta[: 2 * falling[0] + 1].argmin()]
    outlines = []
    for k, (share, colour) in enumerate(zip((0.0, 0.3, 0.5, 1.0), (INK, BLUE, GREEN, ORANGE), strict=True)):
        moment = min(shapes, key=lambda t, share=share: abs(t - share * half))
        outlines.append(Series(f"t{k} = {1e3 * moment:.1f} ms", *(1e3 * shapes[moment]).T, colour))
    return Panel("6: outline (mm)", outlines, equal=True, height=280)


def convergence(rings: Rings) -> Chart:
    """Frequency of the free ring compared with the analytic one for a series of meshes, and the orders in time."""
    space, time = [], []
    for name in ("RCM", "ANCF", "ALE", REFERENCE_DIRECTIONS):
        space.append((name, [(f.elements, abs(f.error)) for f in rings.frequencies if f.model == name and "small" in f.case]))
        steps = [(o.resolution, 1e6 * o.error) for o in rings.orders if o.model == name and "shape in time" in o.quantity]
        time.append((name, steps))
    panels = []
    for title, ladders, said in (
        ("Free ring: error of the first frequency against the thin ring", space, "elements"),
        ("Free ring: error of the shape after 1.2 periods (µm)", time, "steps a period"),
    ):
        series = [_of(name, *np.array(ladder, dtype=float).T, marker="circle") for name, ladder in ladders if ladder]
        ticks = tuple((place, f"{place:g}") for place in sorted({place for _, ladder in ladders for place, _ in ladder}))
        if series:
            panels.append(Panel(title, series, said, scale="log", x_scale="log", x_ticks=ticks, height=280))
    return Chart(panels, "Errors of the frequency over elements, of the shape over steps", columns=2)


def _cases(cases: Sequence[LoadCase]) -> tuple[Tick, ...]:
    names = [f"{case.ratio_name.removesuffix('drive')}<br>{case.torque:g} N·m" for case in cases]
    return tuple((float(place), name) for place, name in enumerate(names))


def _bars(results: PaperResults, models: Sequence[str], value: Callable[[CaseRun], float]) -> list[Series]:
    """Bars for all models, grouped by case."""
    series = []
    for model in models:
        runs = results.of(model)
        slipped = [run.window.slipped for run in runs]
        labels = [run.case.name + (", slips" if run.window.slipped else "") for run in runs]
        values = [value(run) for run in runs]
        series.append(_bar(model, values, hatched=slipped, labels=labels))
    return series


def _bar(model: str, values: Sequence[float], **look: object) -> Series:
    """Bars of a model, one a case."""
    return Series(SHORT_NAMES.get(model, model), np.arange(len(values)), values, COLOURS.get(model, MUTED), "bars", **look)  # type: ignore[arg-type]


def thrust_and_efficiency(results: PaperResults) -> Chart:
    """Fig. 8a and 8b: levels, and differences to the reference model."""
    lowest = 100.0 * min(run.window.efficiency for run in results.runs)
    span = (float(np.floor(lowest - 1.0)), 100.0)
    panels = (
        ("8a  Thrust ratio", MODELS, lambda run: run.window.thrust_ratio, None),
        ("8b  Efficiency (%)", MODELS, lambda run: 100.0 * run.window.efficiency, span),
        (f"Thrust ratio, difference to {REFERENCE} (%)", OTHERS, lambda run: 100.0 * results.thrust_difference(run), None),
        (f"Efficiency, difference to {REFERENCE} (points)", OTHERS, lambda run: 100.0 * results.efficiency_difference(run), None),
    )
    return Chart(
        [
            Panel(title, _bars(results, models, value), x_ticks=_cases(results.cases), y_range=span, height=270)
            for title, models, value, span in panels
        ],
        "Thrust ratio and efficiency of the models, and their differences",
        columns=2,
        common_legend=True,
        least_width=330,
    )


def push_force(results: PaperResults) -> Chart:
    """Fig. 8c: push force on one element over one revolution."""
    series = []
    for model in MODELS:
        path, force = profiles.element(results.parameters, results.chosen(model))
        series.append(_of(model, 1e3 * path.time, 1e-3 * force))
    shown = results.chosen(REFERENCE)
    path, _ = profiles.element(results.parameters, shown)
    shape = profiles.curve(results.parameters, shown.window)
    _, s_end, p_start, p_end, s_start, length = shape.borders
    marks = np.interp([p_start, p_end, s_start, length + s_end, length + p_start], path.xi, 1e3 * path.time)
    names = ("primary arc", "push strand", "secondary arc", "slack strand")
    shades = [
        Shade(start, end, colour, name, 0.0 if colour == INK else 0.08)
        for name, start, end, colour in zip(names, marks[:-1], marks[1:], (BLUE, INK, ORANGE, INK), strict=True)
    ]
    title = f"8c  Push force on one element (kN), {shown.case.name} N·m"
    entered = "time since the element enters the primary arc (ms)"
    span, heights = around([1e3 * path.time], 0.02), around([one.y for one in series])
    return Chart(
        [Panel(title, series, entered, x_range=span, y_range=heights, shades=shades, height=320)],
        "Push force on one element over one revolution, all models",
        linked=True,
    )


def spiral_running(results: PaperResults) -> Chart:
    """Fig. 8d: radius along both arcs."""
    panels = []
    for pulley in PULLEYS:
        series = []
        for model in MODELS:
            fraction, deviation = profiles.arc(results.parameters, results.chosen(model), pulley)
            series.append(_of(model, fraction, 1e3 * deviation, marker="circle", size=4))
        title, heights = f"8d  Radius minus its mean (mm), {pulley} arc", around([one.y for one in series])
        panels.append(Panel(title, series, "from entry (0) to exit (1)", x_range=around([[0.0, 1.0]], 0.03), y_range=heights, height=290))
    return Chart(panels, "Radius along both arcs, all models", columns=2, common_legend=True)


def computing_times(measured: pd.DataFrame) -> Chart:
    """Fig. 9: computing times of whole simulations relative to the reference model's."""
    ratios = times.ratios(measured)
    ends = [times.ratios(measured, times.whole(measured, end)) for end in ("min", "max")]
    cases = [case for case in load_cases(parameter_set("bench168")) if case.name in set(measured["case"])]
    levels = [Level(0.8, "paper: ALE", BLUE), Level(0.5, "paper: ANCF, ALE0", VIOLET)]
    panels = []
    for load in times.LOADS:
        series = []
        for model in (REFERENCE, "ANCF", *FORWARD, *MODELS[2:]):
            value, low, high = (of[load][model] for of in (ratios, *ends))
            errors = ((value - low).to_numpy(), (high - value).to_numpy())
            series.append(_bar(model, value.to_numpy(), errors=errors, labels=list(value.index)))
        title = f"9  Time of whole simulations / that of {REFERENCE}, {load} load"
        panels.append(Panel(title, series, x_ticks=_cases(cases), scale="log", levels=levels, height=300))
    return Chart(panels, "Computing times relative to the reference model", columns=2, common_legend=True, least_width=330)
