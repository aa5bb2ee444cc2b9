"""The report: one self-contained HTML file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from pushbelt import tables
from pushbelt.fmu.data import curve_at, curve_of, is_chain, load_case_speed
from pushbelt.report import page
from pushbelt.report.belt_view import belt_view, of_run, steady

from . import events, figures
from .simulate import START_VALUES, STEP, DemoResults

CHOSEN_CASE = "overdrive-100"  # The load case whose fields along the belt are shown
SHOWN_TIME = 4.0  # Initial time of the belt animation in the manoeuvre, s


def write_html(results: DemoResults, path: Path) -> None:
    page.write_html("demo/report.html.j2", _context(results), path)


def _context(results: DemoResults) -> dict[str, Any]:
    chosen = next(result for result in results.cases if result.case.name == CHOSEN_CASE)
    curve = curve_at(results.parameters, chosen.steady)
    trace = results.manoeuvre.trace
    found = events.detect(trace)
    overload = results.manoeuvre.snapshots.get(8.6)
    slipping = next((event for event in found if event.name == events.OVERLOAD and event.occurred), None)
    pictures = {
        "cases": figures.load_cases(results.cases),
        "manoeuvre": figures.manoeuvre(trace, found),
        "moving_belt": belt_view(
            of_run(trace, results.manoeuvre.snapshots, results.parameters),
            results.parameters,
            "The belt on its pulleys during the manoeuvre",
            group=figures.GROUP,
            start=min(SHOWN_TIME, float(trace.time[-1])),
        ),
        "fields": figures.fields(chosen.steady.profile, curve),
        "belt": belt_view(steady(chosen.steady, results.parameters), results.parameters, "The belt on its pulleys"),
    }
    if slipping is not None:
        pictures["overload"] = figures.overload(trace, slipping.start - 0.1, slipping.end + 0.2)
    if overload is not None:
        moment = int(np.argmin(np.abs(trace.time - 8.6)))
        theta = float(trace["reference.theta"][moment])
        pictures["overload_fields"] = figures.fields(overload, curve_of(results.parameters, theta))
    return {
        "version": results.fmu_version,
        "rows": [{"result": result, "imbalance": events.power_imbalance(result)} for result in results.cases],
        "events": found,
        "checks": events.evaluate(results),
        "manoeuvre": results.manoeuvre,
        "step": STEP,
        "duration": float(trace.time[-1]),
        "standstill": figures.STANDSTILL,
        "start_values": START_VALUES,
        "residual": float(np.abs(trace["energy.residual"]).max()),
        "energy_in": float(np.sum(np.maximum(trace["primary.power"], 0.0)) * STEP),
        "energy_lost": float(np.sum(trace["loss.total"]) * STEP),
        "chosen": chosen,
        "speed": load_case_speed(),
        "parameters": results.parameters,
        "variator": results.variator,
        "chain": is_chain(results.parameters),
        "pictures": pictures,
    }


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
