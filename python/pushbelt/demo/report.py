"""The report: one self-contained HTML file."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pushbelt import tables
from pushbelt.fmu.data import curve_of, is_chain, load_case_speed
from pushbelt.fmu.geometry import Array, TwoPulleyCurve
from pushbelt.fmu.results import LoadCaseResult, Profile, Trace, intervals
from pushbelt.report import page
from pushbelt.report.belt_view import STEADY_TIME, belt_view, of_run
from pushbelt.report.charts import Chart, Mark, Panel, Series, Shade, stack
from pushbelt.report.style import BLUE, GREEN, INK, MUTED, ORANGE, RED, RPM, VIOLET

from . import events
from .events import Event, energy_bound
from .simulate import START_VALUES, STEP, DemoResults

RATIO_COLOURS = {"underdrive": BLUE, "medium": GREEN, "overdrive": ORANGE}
LOSSES = (
    ("loss.sheaves", "sheave friction", BLUE), ("loss.ring", "ring friction", ORANGE), ("loss.layers", "ring layers", GREEN),
    ("loss.joints", "joints of the chain", GREEN), ("loss.spin", "turning elements", RED), ("loss.shafts", "shafts", VIOLET),
    ("loss.other", "rest", MUTED),
)  # fmt: skip
"""Output, name and colour of each loss. Those that a belt does not have are not shown."""
STANDSTILL = 1.0  # Least secondary speed for quotients of speeds, rad/s
TIME = "time (s)"
GROUP = "manoeuvre"  # Group name of charts and belt that share a cursor
CHOSEN_CASE = "overdrive-100"  # The load case whose fields along the belt are shown
SHOWN_TIME = 4.0  # Initial time of the belt animation in the manoeuvre, s


def load_cases(results: Sequence[LoadCaseResult]) -> Chart:
    torques = sorted({result.case.torque for result in results})
    thrust, efficiency = [], []
    for name, colour in RATIO_COLOURS.items():
        line = sorted((r for r in results if r.case.ratio_name == name), key=lambda r: r.case.torque)
        marked: dict[str, Any] = {"colour": colour, "marker": "circle"}
        thrust.append(Series(name, torques, [r.steady["thrustRatio"] for r in line], **marked))
        efficiency.append(Series(name, torques, [100 * r.steady["efficiency"] for r in line], **marked))
    lines = {"Thrust ratio": thrust, "Efficiency of the shafts (%)": efficiency}
    panels = [*(Panel(title, series, "primary torque (N·m)") for title, series in lines.items()), _loss_shares(results, torques)]
    return Chart(panels, "Thrust ratio, efficiency and losses of the load cases", columns=3)


def _loss_shares(results: Sequence[LoadCaseResult], torques: Sequence[float]) -> Panel:
    ordered = sorted(results, key=lambda r: (list(RATIO_COLOURS).index(r.case.ratio_name), r.case.torque))
    places = np.array([k + 0.8 * (k // len(torques)) for k in range(len(ordered))])
    names = [f"{r.case.ratio_name}, {r.case.torque:g} N·m" for r in ordered]
    ticks = tuple((float(place), f"{r.case.torque:g}") for place, r in zip(places, ordered, strict=True))
    groups = zip(places.reshape(len(RATIO_COLOURS), -1), RATIO_COLOURS, strict=True)
    series = [
        Series(label, places, [r.steady[part] for r in ordered], colour, "bars", labels=names, bar_width=0.82)
        for part, label, colour in LOSSES
        if any(r.steady[part] for r in ordered)
    ]
    shades = [Shade(group[0] - 0.5, group[-1] + 0.5, "#ffffff", name, 0.0) for group, name in groups]
    return Panel("Losses (W) by ratio and torque (N·m)", series, x_ticks=ticks, stacked=True, shades=shades)


def manoeuvre(trace: Trace, events: Sequence[Event]) -> Chart:
    moving = np.abs(trace["secondary.speed"]) > STANDSTILL

    def line(name: str, values: Array, colour: str, dash: str = "") -> Series:
        return Series(name, trace.time, values, colour, dash=dash)

    of_speeds, slip = np.where(moving, trace["ratio.speed"], np.nan), np.where(moving, 100 * trace["slip"], np.nan)
    bound = energy_bound(trace)
    torques = [
        line("P, external", trace["primary.externalTorque"], MUTED, "dash"),
        line("P, carried by the belt", -trace["primary.shaftTorque"], BLUE),
        line("S, of the belt", trace["secondary.shaftTorque"], ORANGE),
    ]
    forces = [
        line(f"{pulley[0].upper()}, {what}", 1e-3 * trace[f"{pulley}.{name}"], colour, dash)
        for pulley, colour in (("primary", BLUE), ("secondary", ORANGE))
        for what, name, dash in (("of the belt", "axialForce", ""), ("clamping", "clampingForce", "dash"))
    ]
    ratios = [line("geometric, r_S/r_P", trace["ratio.geometric"], GREEN), line("of speeds, ω_P/ω_S", of_speeds, MUTED, "dash")]
    bounds = [line("bound", bound, MUTED, "dash"), line("−bound", -bound, MUTED, "dash")]
    residual = [line("residual", trace["energy.residual"], VIOLET), *bounds]
    losses = [line(name, 1e-3 * trace[part], colour) for part, name, colour in LOSSES if np.any(trace[part])]
    marks = [Mark(event.start, str(k)) for k, event in enumerate((e for e in events if e.occurred), start=1)]
    rows: list[tuple[str, list[Series], dict[str, Any]]] = [
        ("Torques (N·m)", torques, {"marks": marks}),
        ("Axial forces (kN)", forces, {}),
        ("Speeds (rpm)", [line("P", RPM * trace["primary.speed"], BLUE), line("S", RPM * trace["secondary.speed"], ORANGE)], {}),
        ("Ratio", ratios, {"y_range": (0.0, 1.25 * float(trace["ratio.geometric"].max()))}),
        ("Slip (%)", [line("slip", slip, RED)], {"y_range": (-1.0, 5.0)}),
        ("Losses (kW)", losses, {"scale": "log", "y_range": (1e-3, 1e3)}),
        ("Energy residual: supplied minus lost minus stored (J)", residual, {}),
    ]
    shades = [Shade(start, max(end, start + 0.01), RED) for start, end in intervals(trace.time, trace["macroSlip"], gap=0.02)]
    common: dict[str, Any] = {"x_range": (float(trace.time[0]), float(trace.time[-1])), "height": 190, "marks": [Mark(mark.x) for mark in marks]}
    panels = stack(rows, TIME, shades=shades, **common)
    label = "Torques, axial forces, speeds, ratio, slip, losses and energy residual over time"
    return Chart(panels, label, linked=True, group=GROUP)


def fields(profile: Profile, curve: TwoPulleyCurve) -> Chart:
    """Fields along the belt, with shaded arcs. A chain has neither push force nor gaps."""
    order = np.append(np.arange(len(profile.position)), 0)
    xi = 1e3 * np.append(profile.position, curve.length)
    rows: tuple[tuple[str, Array, str], ...] = (
        ("Push force (kN)", 1e-3 * profile.push_force, BLUE),
        ("Ring tension (kN)", 1e-3 * profile.ring_tension, ORANGE),
        ("Normal force per flank (kN/m)", 1e-3 * profile.normal_force, GREEN),
        ("Radial deviation (mm)", 1e3 * profile.radial_deviation, VIOLET),
        ("Sliding speed of the flanks (mm/s)", 1e3 * profile.sliding_speed, RED),
        ("Gap between elements (µm)", 1e6 * profile.gap, MUTED),
    )
    if not profile.push_force.any():
        rows = rows[1:-1]
    names = [title.split(" (")[0] for title, _, _ in rows]
    lines = [
        (title, [Series(name, xi, values[order], colour, marker="circle", size=4)], {"shades": shaded_arcs(curve, named=name == names[0])})
        for name, (title, values, colour) in zip(names, rows, strict=True)
    ]
    panels = stack(lines, "place ξ along the belt (mm)", x_range=(0.0, 1e3 * curve.length), height=170)
    return Chart(panels, f"{', '.join(names)} along the belt", linked=True)


def shaded_arcs(curve: TwoPulleyCurve, named: bool = False) -> list[Shade]:
    """Segments of the belt, with the arcs in the colour of their pulley."""
    borders = 1e3 * np.array(curve.borders)
    labels = ("S arc", "upper strand", "P arc", "push strand", "S arc")
    colours = (ORANGE, INK, BLUE, INK, ORANGE)
    return [
        Shade(start, end, colour, label if named else "", 0.0 if colour == INK else 0.08)
        for start, end, label, colour in zip(borders[:-1], borders[1:], labels, colours, strict=True)
    ]


def write_html(results: DemoResults, path: Path) -> Path:
    chosen = next(result for result in results.cases if result.case.name == CHOSEN_CASE)
    curve = curve_of(results.parameters, chosen.steady["reference.theta"])
    trace = results.manoeuvre.trace
    found = events.detect(trace)
    slips_through = results.manoeuvre.snapshots.get(8.6)
    pictures = {
        "cases": load_cases(results.cases), "manoeuvre": manoeuvre(trace, found),
        "moving_belt": belt_view(
            of_run(trace, results.manoeuvre.snapshots), results.parameters,
            "The belt on its pulleys during the manoeuvre", GROUP, min(SHOWN_TIME, float(trace.time[-1])), trace,
        ),
        "fields": fields(chosen.steady.profile, curve),
        "belt": belt_view(dict.fromkeys((0.0, STEADY_TIME), chosen.steady), results.parameters, "The belt on its pulleys"),
    }  # fmt: skip
    if slips_through is not None:
        theta = float(trace["reference.theta"][np.argmin(np.abs(trace.time - 8.6))])
        pictures["overload_fields"] = fields(slips_through, curve_of(results.parameters, theta))
    context = {
        "version": results.fmu_version, "variator": results.variator,
        "parameters": results.parameters, "chain": is_chain(results.parameters),
        "rows": [{"result": result, "imbalance": events.power_imbalance(result)} for result in results.cases],
        "events": found, "checks": events.evaluate(results), "manoeuvre": results.manoeuvre,
        "step": STEP, "duration": float(trace.time[-1]), "standstill": STANDSTILL, "start_values": START_VALUES,
        "residual": float(np.abs(trace["energy.residual"]).max()),
        "energy_in": float(np.sum(np.maximum(trace["primary.power"], 0.0)) * STEP),
        "energy_lost": float(np.sum(trace["loss.total"]) * STEP),
        "chosen": chosen, "speed": load_case_speed(), "pictures": pictures,
    }  # fmt: skip
    return page.write_html("demo/report.html.j2", context, path)


def write_trace(results: DemoResults, path: Path) -> None:
    """Writes the manoeuvre's outputs over time, one column per FMU variable."""
    trace = results.manoeuvre.trace
    table = np.column_stack([trace.time, *trace.columns.values()])
    tables.write(path, ["time [s]", *tables.titles(trace.columns, results.units)], table.tolist())


def write_cases(results: DemoResults, path: Path) -> None:
    """Writes the outputs of the load cases, one row per case."""
    states = [(result.case.name, result.steady) for result in results.cases]
    names = list(states[0][1].outputs)
    rows = ([name, state.load_torque, *(state[output] for output in names)] for name, state in states)
    tables.write(path, ["case", *tables.titles(["secondary.torque", *names], results.units)], rows)
