"""Figures of the drive report."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pushbelt.fmu.geometry import Array
from pushbelt.fmu.results import intervals
from pushbelt.report.belt_view import SPEEDS, Motion, over_time
from pushbelt.report.charts import Chart, Field, Panel, Series, Shade, Tick, stack
from pushbelt.report.style import BLUE, GREEN, INK, MUTED, ORANGE, RED, RPM, VIOLET

from .simulate import LOSSES, STEP, Run
from .thrust_map import ThrustMap

TIME = "time in the cycle (s)"
LOSS_COLOURS = dict(zip(LOSSES, (BLUE, ORANGE, GREEN, GREEN, RED, VIOLET, MUTED, MUTED), strict=True))
DARK_LOSS_COLOURS = (ORANGE, RED, "#e8c15a", RED, "#c98bd6", INK, INK, MUTED)
"""Colours of `LOSSES` in the distribution of the engine's work."""
RATIO_TICKS: tuple[Tick, ...] = ((0.5, "0.5"), (1.0, "1"), (2.0, "2"))
GROUP = "drive"  # Group name of charts and belt that share a cursor


def drive(run: Run, group: str = "") -> Chart:
    def line(name: str, values: Array, colour: str, width: float = 1.2) -> Series:
        return Series(name, run.time, values, colour, width=width)

    losses = [line(part, run[f"loss.{part}"], c) for part, c in LOSS_COLOURS.items() if run[f"loss.{part}"].any()]
    rows = [
        ("Speed (km/h)", [line("cycle", 3.6 * run["speed.target"], ORANGE, 1.8), line("car", 3.6 * run["speed.car"], BLUE)], {}),
        (
            "Ratio r_S/r_P",
            [line("target", run["ratio.target"], ORANGE, 1.8), line("ratio.geometric", run["ratio.geometric"], BLUE)],
            {"scale": "log", "y_ticks": RATIO_TICKS},
        ),
        ("Speeds (rpm)", [line("engine", RPM * run["engine.speed"], ORANGE), line("primary pulley", RPM * run["primary.speed"], BLUE)], {}),
        ("Pressures (bar)", [line(p, 1e-5 * run[f"{p}.pressure"], c) for p, c in (("primary", BLUE), ("secondary", ORANGE))], {}),
        ("Slip (%)", [line("slip", 100.0 * run["slip"], BLUE)], {"y_range": (-3.0, 4.0)}),
        ("Loss of the variator (W)", losses, {}),
    ]
    macro = intervals(run.time, run["macroSlip"], gap=0.2)
    shades = [Shade(start, stop + STEP, RED, opacity=0.25) for start, stop in macro]
    panels = stack(rows, TIME, shades=shades, x_range=(float(run.time[0]), float(run.time[-1])), height=200)
    return Chart(panels, "Speed, ratio, engine speed, pressures, slip and losses over time", linked=True, group=group)


def belt_over_time(run: Run, parameters: dict[str, float]) -> Motion:
    moments = np.array(sorted(run.snapshots))
    columns = {name: np.array([run.snapshots[moment][name] for moment in moments]) for name in SPEEDS}
    return over_time(moments, columns, run.snapshots, parameters)


LOOKS = ({"colour": ORANGE, "dash": "dash"}, {"colour": BLUE})  # Looks of the fixed safety factor and of slip control


def savings(fixed: Run, slip: Run) -> Chart:
    """Accumulated variator loss of the two clamping strategies, and the distribution of utilisation over time."""
    edges = np.arange(0.0, 1.15, 0.025)
    loss, share = [], []
    for run, look in zip((fixed, slip), LOOKS, strict=True):
        loss.append(Series(run.setup.name, run.time, 1e-3 * STEP * np.cumsum(run.loss), **look))
        counts = STEP * np.histogram(run["utilisation.signed"][run["primary.power"] > 1000.0], edges)[0]
        share.append(Series(run.setup.name, np.repeat(edges, 2)[1:-1], np.repeat(counts, 2), **look))
    panels = [
        Panel("Variator loss, added up (kJ)", loss, TIME, height=270),
        Panel("Time (s) at a torque utilisation, above 1 kW", share, "torque utilisation", height=270),
    ]
    label = "Variator loss of both strategies added up over time, and torque utilisation"
    return Chart(panels, label, columns=2, common_legend=True)


def energy_shares(fixed: Run, slip: Run) -> Chart:
    losses = {f"variator, {part}": colour for part, colour in zip(LOSSES, DARK_LOSS_COLOURS, strict=True)}
    colours = {"road load": BLUE, "brakes": VIOLET, "launch clutch": GREEN, **losses}
    energies = [run.energies() for run in (slip, fixed)]
    series = [
        Series(part, [1e-3 * e[part] for e in energies], (0.0, 1.0), colour, "rows")
        for part, colour in colours.items()
        if any(e[part] for e in energies)
    ]
    ticks = ((0.0, slip.setup.name), (1.0, fixed.setup.name))
    return Chart([Panel("Energy (kJ)", series, y_ticks=ticks, stacked=True, height=170)], "Shares of energy")


def low_friction(fixed: Run, slip: Run) -> Chart:
    """Slip, secondary force and loss of both strategies on a belt with less friction than they assume."""
    runs = list(zip((fixed, slip), LOOKS, strict=True))
    rows: dict[str, Callable[[Run], Array]] = {
        "Slip (%)": lambda run: 100.0 * run["slip"],
        "Secondary clamping force (kN)": lambda run: 1e-3 * run["secondary.clampingForceTotal"],
        "Variator loss, added up (kJ)": lambda run: 1e-3 * STEP * np.cumsum(run.loss),
    }
    panels = [
        Panel(title, [Series(run.setup.strategy, run.time, of(run), **look) for run, look in runs], TIME) for title, of in rows.items()
    ]
    return Chart(panels, "Slip, secondary force and loss of both strategies with low friction", columns=3, linked=True)


def operating_points(table: ThrustMap, run: Run) -> Chart:
    """The thrust-ratio map and the operating points of the car on it."""
    some = np.arange(0, len(run.time), 50)
    some = some[run["primary.speed"][some] > 60.0]
    ratio, utilisation, thrust = (run[name][some] for name in ("ratio.geometric", "utilisation.signed", "thrustRatio"))
    expected = [table.thrust_ratio(i, u) for i, u in zip(ratio, utilisation, strict=True)]
    ends = [float(table.thrust.min()), float(table.thrust.max())]
    points = {"colour": BLUE, "kind": "points", "size": 4, "opacity": 0.6, "labels": [f"{time:.1f} s" for time in run.time[some]]}
    lines = Field("map", table.ratios, table.utilisations, table.thrust.T, lines_only=True)
    panels = [
        Panel(
            "Thrust ratio of the map, and operating points", [Series("worked at", ratio, utilisation, **points)], "ratio",
            "torque utilisation", fields=[lines], x_scale="log", x_ticks=RATIO_TICKS, height=350,
        ),
        Panel(
            "Thrust ratio while driving",
            [Series("belt", expected, thrust, **points), Series("as in the map", ends, ends, INK, width=0.9)],
            "of the map (steady)", "of the belt", y_range=(ends[0] - 0.5, ends[1] + 0.5), height=350,
        ),
    ]  # fmt: skip
    return Chart(panels, "Contours of the thrust ratio with operating points", columns=2)
