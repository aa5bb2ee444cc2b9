"""The drive report, one self-contained HTML file: figures of merit of the runs, and their figures."""

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pushbelt import tables
from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.geometry import Array
from pushbelt.fmu.results import intervals
from pushbelt.report import page
from pushbelt.report.belt_view import belt_view
from pushbelt.report.charts import Chart, Field, Panel, Series, Shade, Tick, stack
from pushbelt.report.style import BLUE, GREEN, INK, MUTED, ORANGE, RED, RPM, VIOLET

from .runs import LOW_FRICTION, Results
from .simulate import LOSSES, OF_STEPS, STEP, Run
from .thrust_map import FORCE, ThrustMap

PULLEYS = ("primary", "secondary")
TIME = "time in the cycle (s)"
LOSS_COLOURS = dict(zip(LOSSES, (BLUE, ORANGE, GREEN, GREEN, RED, VIOLET, MUTED, MUTED), strict=True))
RATIO_TICKS: tuple[Tick, ...] = ((0.5, "0.5"), (1.0, "1"), (2.0, "2"))
GROUP = "drive"  # Group name of charts and belt that share a cursor
LOOKS: tuple[dict[str, Any], ...] = ({"colour": ORANGE, "dash": "dash"}, {"colour": BLUE})  # Looks of the fixed safety factor and of slip control
CSV_STEP = 0.1  # Time between the rows of the results, s
DISPLACEMENT, PUMP_EFFICIENCY = 12e-6, 0.85  # Of a pump of fixed displacement on the engine, m³ per revolution
PUMP_MARGIN = 2e5  # Pressure above the higher of the two circuits that it maintains, Pa. These values are typical; they are not from a source.


class Merit(NamedTuple):
    supplied: float  # Energy that the shafts carry into the variator, at the primary in drive and at the secondary in overrun, J
    lost: float  # Energy lost in the variator, J
    pump: float  # Energy that the pump takes from the engine, J
    distance: float  # m
    pressure: float  # Mean pressure in the secondary circuit, Pa
    efficiency: float  # Of the variator over the cycle: 1 − lost/supplied; NaN if nothing was supplied
    with_pump: float  # The same if the pump counts as a loss, and its energy as supplied
    lost_per_km: float  # Energy lost in variator and pump, J/km; NaN at a standstill


def pump_power(run: Run) -> Array:
    """Power that the pump takes from the engine over time, W: (max(p_P, p_S) + margin) V n/η. What the circuits do not take flows back."""
    pressure = np.max([run[f"{pulley}.pressure"] for pulley in PULLEYS], axis=0) + PUMP_MARGIN
    revolutions = np.maximum(run["engine.speed"], 0.0) / (2.0 * math.pi)
    return pressure * DISPLACEMENT * revolutions / PUMP_EFFICIENCY


def merit(run: Run) -> Merit:
    """Figures of merit of a run, by sums over the communication steps."""
    # Powers are those of the belt, without the drag of the shafts.
    into_the_belt = sum(np.maximum(run[f"{pulley}.power"], 0.0).sum() for pulley in PULLEYS)
    sums = (into_the_belt + run["loss.shafts"].sum(), pump_power(run).sum(), np.abs(run["speed.car"]).sum())
    supplied, pumped, distance = (run.setup.step * float(one) for one in sums)
    lost = run.variator_loss

    def over(part: float, whole: float) -> float:
        return part / whole if whole > 0.0 else math.nan

    return Merit(
        supplied, lost, pumped, distance, float(run["secondary.pressure"].mean()), 1.0 - over(lost, supplied),
        1.0 - over(lost + pumped, supplied + pumped), 1e3 * over(lost + pumped, distance),
    )  # fmt: skip


def drive(run: Run, group: str = "") -> Chart:
    def line(name: str, values: Array, colour: str, width: float = 1.2) -> Series:
        return Series(name, run.time, values, colour, width=width)

    losses = [line(part, run[f"loss.{part}"], c) for part, c in LOSS_COLOURS.items() if run[f"loss.{part}"].any()]
    ratios = [line("target", run["ratio.target"], ORANGE, 1.8), line("ratio.geometric", run["ratio.geometric"], BLUE)]
    rows: list[tuple[str, list[Series], dict[str, Any]]] = [
        ("Speed (km/h)", [line("cycle", 3.6 * run["speed.target"], ORANGE, 1.8), line("car", 3.6 * run["speed.car"], BLUE)], {}),
        ("Ratio r_S/r_P", ratios, {"scale": "log", "y_ticks": RATIO_TICKS}),
        ("Speeds (rpm)", [line("engine", RPM * run["engine.speed"], ORANGE), line("primary pulley", RPM * run["primary.speed"], BLUE)], {}),
        ("Pressures (bar)", [line(p, 1e-5 * run[f"{p}.pressure"], c) for p, c in (("primary", BLUE), ("secondary", ORANGE))], {}),
        ("Slip (%)", [line("slip", 100.0 * run["slip"], BLUE)], {"y_range": (-3.0, 4.0)}),
        ("Loss of the variator (W)", losses, {}),
    ]
    macro = intervals(run.time, run["macroSlip"], gap=0.2)
    shades = [Shade(start, stop + STEP, RED, opacity=0.25) for start, stop in macro]
    panels = stack(rows, TIME, shades=shades, x_range=(float(run.time[0]), float(run.time[-1])), height=200)
    return Chart(panels, "Speed, ratio, engine speed, pressures, slip and losses over time", linked=True, group=group)


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
    return Chart(panels, "Variator loss of both strategies added up over time, and torque utilisation", columns=2, common_legend=True)


def low_friction(fixed: Run, slip: Run) -> Chart:
    """Slip, secondary force and loss of both strategies on a belt with less friction than they assume."""
    runs = list(zip((fixed, slip), LOOKS, strict=True))
    rows: dict[str, Callable[[Run], Array]] = {
        "Slip (%)": lambda run: 100.0 * run["slip"],
        "Secondary clamping force (kN)": lambda run: 1e-3 * run["secondary.clampingForceTotal"],
        "Variator loss, added up (kJ)": lambda run: 1e-3 * STEP * np.cumsum(run.loss),
    }
    lines = {title: [Series(run.setup.strategy, run.time, of(run), **look) for run, look in runs] for title, of in rows.items()}
    panels = [Panel(title, series, TIME) for title, series in lines.items()]
    return Chart(panels, "Slip, secondary force and loss of both strategies with low friction", columns=3, linked=True)


def operating_points(table: ThrustMap, run: Run) -> Chart:
    """The thrust-ratio map and the operating points of the car on it."""
    some = np.arange(0, len(run.time), 50)
    some = some[run["primary.speed"][some] > 60.0]
    ratio, utilisation, thrust = (run[name][some] for name in ("ratio.geometric", "utilisation.signed", "thrustRatio"))
    expected = [table.thrust_ratio(i, u) for i, u in zip(ratio, utilisation, strict=True)]
    ends = [float(table.thrust.min()), float(table.thrust.max())]
    points: dict[str, Any] = {"colour": BLUE, "kind": "points", "size": 4, "opacity": 0.6, "labels": [f"{time:.1f} s" for time in run.time[some]]}
    lines = Field("map", table.ratios, table.utilisations, table.thrust.T, lines_only=True)
    worked, same = Series("worked at", ratio, utilisation, **points), Series("as in the map", ends, ends, INK, width=0.9)
    axes: dict[str, Any] = {"x_label": "ratio", "y_label": "torque utilisation", "x_scale": "log", "x_ticks": RATIO_TICKS, "height": 350}
    compared: dict[str, Any] = {"x_label": "of the map (steady)", "y_label": "of the belt", "y_range": (ends[0] - 0.5, ends[1] + 0.5), "height": 350}
    panels = [
        Panel("Thrust ratio of the map, and operating points", [worked], fields=[lines], **axes),
        Panel("Thrust ratio while driving", [Series("belt", expected, thrust, **points), same], **compared),
    ]
    return Chart(panels, "Contours of the thrust ratio with operating points", columns=2)


def speed_error(run: Run) -> tuple[float, float]:
    """Root mean square and largest deviation from the cycle, km/h."""
    error = 3.6 * (run["speed.car"] - run["speed.target"])
    return float(np.sqrt(np.mean(error**2))), float(np.abs(error).max())


def ratio_error(run: Run) -> float:
    """Root mean square of ln(ratio/target) while the primary pulley turns fast enough to shift."""
    turning = run["primary.speed"] > 60.0
    squares = np.log(run["ratio.geometric"] / run["ratio.target"])[turning] ** 2
    return float(np.sqrt(np.mean(squares))) if squares.size else 0.0


def balance_gap(run: Run, inertia: float) -> float:
    """Net work of the engine minus all losses and the change of stored energy, J. The FMU's stored energy includes the car; the
    engine's flywheel, `inertia`, is added. The work of the clamping forces is small and not subtracted."""
    energies = run.energies()
    stored = run["stored.energy"] + 0.5 * inertia * run["engine.speed"] ** 2
    spent = sum(energies[part] for part in ("variator", "launch clutch", "road load", "brakes"))
    return energies["engine, driving"] - energies["engine, braking"] - spent - float(stored[-1] - stored[0])


def write_trace(run: Run, units: Mapping[str, str], path: Path) -> None:
    """Writes a run as CSV over the time of the cycle, one row every 0.1 s, in SI units. Energies are those since its start."""
    every = round(CSV_STEP / STEP)
    energies = {name: np.cumsum(run[name]) - run[name] for name in OF_STEPS}
    columns = {name: column for name, column in {**run.columns, **energies}.items() if not np.isnan(column).all()}
    table = np.column_stack([run.time, *columns.values()])[::every]
    tables.write(path, ["time [s]", *tables.titles(columns, units)], table.tolist(), digits=7)


def write_html(results: Results, path: Path) -> Path:
    parameters = parameter_set(results.plan.variator)
    named = {run.setup.name: run for run in results.runs}
    fixed, slip, *_, safe, controlled = results.runs
    close_up, belt = named.get("close-up"), ""
    if slip.snapshots:
        title = "The belt on its pulleys during the drive"
        belt = belt_view(slip.snapshots, parameters, title, group=GROUP, start=0.5 * sum(results.plan.cycle))
    context = {
        "version": results.version, "plan": results.plan, "car": results.plan.car,
        "rows": [
            {
                "run": run, "energies": run.energies(), "speed": speed_error(run), "ratio": ratio_error(run),
                "macro": STEP * float(run["macroSlip"].sum()), "gap": balance_gap(run, results.plan.car.engine_inertia), "merit": merit(run),
            }
            for run in results.runs
        ],
        "saved": fixed.variator_loss - slip.variator_loss,
        "saved_share": 1.0 - slip.variator_loss / fixed.variator_loss,
        "losses": [part for part in LOSSES if any(run[f"loss.{part}"].any() for run in results.runs)],
        "pump": {"displacement": DISPLACEMENT, "margin": PUMP_MARGIN, "efficiency": PUMP_EFFICIENCY},
        "map_force": FORCE, "step": STEP, "low_friction": LOW_FRICTION,
        "shift_gains": [results.thrust_map.shift_gain(ratio, 0.3) for ratio in (0.5, 1.0, 2.0)],
        "pictures": {
            "belt": belt, "drive": drive(slip, GROUP), "close_up": drive(close_up) if close_up else "", "savings": savings(fixed, slip),
            "low_friction": low_friction(safe, controlled), "map": operating_points(results.thrust_map, slip),
        },
    }  # fmt: skip
    return page.write_html("drive/drive.html.j2", context, path)
