"""The drive report: one self-contained HTML file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from pushbelt import tables
from pushbelt.fmu.data import parameter_set
from pushbelt.report import page
from pushbelt.report.belt_view import belt_view

from . import figures
from .merit import Pump, merit
from .runs import LOW_FRICTION, Results
from .simulate import LOSSES, OF_STEPS, STEP, Run
from .thrust_map import FORCE
from .vehicle import demo_car

CSV_STEP = 0.1  # Time between the rows of the results, s


def speed_error(run: Run) -> tuple[float, float]:
    """Root mean square and largest deviation from the cycle, km/h."""
    error = 3.6 * (run["speed.car"] - run["speed.target"])
    return float(np.sqrt(np.mean(error**2))), float(np.abs(error).max())


def ratio_error(run: Run) -> float:
    """Root mean square of ln(ratio/target) while the primary pulley turns fast enough to shift."""
    turning = run["primary.speed"] > 60.0
    if not turning.any():
        return 0.0
    return float(np.sqrt(np.mean(np.log(run["ratio.geometric"] / run["ratio.target"])[turning] ** 2)))


def balance_gap(run: Run) -> float:
    """Net work of the engine minus all losses and the change of stored energy, J.

    The FMU's stored energy includes the car; the engine's flywheel is added. The work of the clamping forces is small and not
    subtracted.
    """
    energies, inertia = run.energies(), demo_car().engine_inertia
    stored = run["stored.energy"] + 0.5 * inertia * run["engine.speed"] ** 2
    spent = sum(energies[part] for part in ("variator", "launch clutch", "road load", "brakes"))
    return energies["engine, driving"] - energies["engine, braking"] - spent - float(stored[-1] - stored[0])


def write_trace(run: Run, units: Mapping[str, str], path: Path) -> None:
    """Writes a run as CSV over the time of the cycle, one row every 0.1 s, in SI units and with the names of the FMU variables.

    Energies are those since the start of the run.
    """
    every = round(CSV_STEP / STEP)
    energies = {name: np.cumsum(run[name]) - run[name] for name in OF_STEPS}
    table = np.column_stack([run.time, *{**run.columns, **energies}.values()])[::every]
    tables.write(path, ["time [s]", *tables.titles(run.columns, units)], table.tolist(), digits=7)


def write_html(results: Results, path: Path) -> None:
    parameters = parameter_set(results.plan.variator)
    fixed, slip, close_up, *slippery = results.runs
    motion, title = figures.belt_over_time(slip, parameters), "The belt on its pulleys during the drive"
    belt = belt_view(motion, parameters, title, group=figures.GROUP, start=0.5 * sum(results.plan.cycle))
    context = {
        "version": results.version,
        "plan": results.plan,
        "car": demo_car(),
        "rows": [
            {
                "run": run, "energies": run.energies(), "speed": speed_error(run), "ratio": ratio_error(run),
                "macro": STEP * float(run["macroSlip"].sum()), "gap": balance_gap(run), "merit": merit(run),
            }
            for run in results.runs
        ],
        "saved": fixed.variator_loss - slip.variator_loss,
        "saved_share": 1.0 - slip.variator_loss / fixed.variator_loss,
        "losses": [part for part in LOSSES if any(run[f"loss.{part}"].any() for run in results.runs)],
        "pump": Pump(),
        "map_force": FORCE,
        "shift_gains": [results.thrust_map.shift_gain(ratio, 0.3) for ratio in (0.5, 1.0, 2.0)],
        "step": STEP,
        "low_friction": LOW_FRICTION,
        "pictures": {
            "belt": belt,
            "drive": figures.drive(slip, figures.GROUP),
            "close_up": figures.drive(close_up),
            "savings": figures.savings(fixed, slip),
            "energy": figures.energy_shares(fixed, slip),
            "low_friction": figures.low_friction(*slippery),
            "map": figures.operating_points(results.thrust_map, slip),
        },
    }  # fmt: skip
    page.write_html("drive/drive.html.j2", context, path)
