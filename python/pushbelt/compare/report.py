"""The report: one self-contained HTML file, and the differences as CSV."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from pushbelt import tables
from pushbelt.fmu.data import is_chain
from pushbelt.fmu.results import BeltState, Profile, Trace
from pushbelt.fmu.unit import PROFILE_FIELDS, PROFILE_POINTS
from pushbelt.report import page
from pushbelt.report.belt_view import OUTPUTS, SPEEDS, belt_view, of_run
from pushbelt.report.charts import Chart, Series, stack
from pushbelt.report.style import BLUE, ORANGE, in_figures

from .runs import Pair
from .sets import Difference, verdict

MOST = 24  # Largest number of columns in the figures of a pair. The table has all columns.
FIELD = "profile."  # Prefix of the names of fields along the belt
MOMENTS = 300  # Largest number of times of a run in the animation


def write(pairs: Sequence[Pair], folder: Path, wanted: Sequence[str], parameters: Mapping[str, float]) -> Path:
    """Writes report and differences; returns the path of the report. It shows both belts, of these parameters, if both have fields."""
    measures = (f"{name} {tables.OF_A_VARIABLE}" for name in ("range", "rootMeanSquare", "largest"))
    found = ((pair, d) for pair in pairs for d in pair.differences)
    rows = ([pair.name, d.name, pair.units.get(d.name, ""), *d[1:], d.share] for pair, d in found)
    tables.write(folder / "differences.csv", ["run", "column", "unit", *measures, "time [s]", "largestShare [1]"], rows)
    keys = [f"run-{k}" for k in range(1, len(pairs) + 1)]
    shown = [(key, pair, overlay(pair, wanted, key), _belts(pair, key, parameters)) for key, pair in zip(keys, pairs, strict=True)]
    return page.write_html("compare/compare.html.j2", {"pairs": shown, "most": MOST, "chosen": bool(wanted)}, folder / "report.html")


def write_sets(rows: Sequence[Difference], paths: Sequence[Path], folder: Path) -> Path:
    """Writes report and differences of two parameter sets; returns the path of the report."""
    header = ["parameter", "unit", *(f"{name} {tables.OF_A_VARIABLE}" for name in ("A", "B", "difference", "deviation")), "difference/deviation [1]"]
    tables.write(folder / "differences.csv", header, rows)
    return page.write_html("compare/sets.html.j2", {"rows": rows, "paths": paths, "verdict": verdict(rows)}, folder / "report.html")


def _belts(pair: Pair, group: str, parameters: Mapping[str, float]) -> list[tuple[str, Markup]]:
    """The belt of each run; empty unless both files have the required columns."""
    if not all(run.columns.keys() >= set(needed(parameters)) for run in pair.runs):
        return []
    runs = zip("AB", pair.runs, strict=True)
    return [(who, belt_view(belt_of(run), parameters, f"Belt of run {who} over time", group, run=run)) for who, run in runs]


def places(field: str) -> list[str]:
    return [f"{FIELD}{field}[{k + 1}]" for k in range(PROFILE_POINTS)]


def needed(parameters: Mapping[str, float]) -> list[str]:
    """Columns that the animation of the belt requires. Other fields are optional."""
    fields = ("position", "ringTension" if is_chain(parameters) else "pushForce", "radialDeviation")
    return [*OUTPUTS, *SPEEDS, *(name for field in fields for name in places(field))]


def belt_of(run: Trace) -> dict[float, BeltState]:
    """The belt over the time of the run, at evenly spaced rows."""
    rows = np.unique(np.linspace(0, len(run.time) - 1, MOMENTS).round().astype(int))
    none = np.zeros((len(run.time), PROFILE_POINTS))
    tables = {
        name: np.column_stack([run[column] for column in places(field)]) if places(field)[0] in run.columns else none
        for name, field in PROFILE_FIELDS.items()
    }
    profiles = {float(run.time[k]): Profile(**{name: of[k] for name, of in tables.items()}) for k in rows}
    return of_run(run, profiles)


def overlay(pair: Pair, wanted: Sequence[str] = (), group: str = "") -> Chart:
    """Both runs in each column. By default the columns with the largest differences come first. Figures of one group share the cursor."""
    most = [d.name for d in pair.differences if not d.name.startswith(FIELD)][:MOST]
    names = [name for name in wanted if name in pair.names] or most
    shown = {name: in_figures(pair.units.get(name, "")) for name in names}
    looks = (("A", BLUE, ""), ("B", ORANGE, "dash"))
    start, end = min(float(run.time[0]) for run in pair.runs), max(float(run.time[-1]) for run in pair.runs)

    def lines(name: str) -> list[Series]:
        runs = zip(looks, pair.runs, strict=True)
        return [Series(who, run.time, shown[name][0] * run[name], colour, dash=dash) for (who, colour, dash), run in runs]

    rows: list[tuple[str, list[Series], dict[str, Any]]] = [(f"{name} ({shown[name][1]})" if name in pair.units else name, lines(name), {}) for name in names]
    panels = stack(rows, "time (s)", x_range=(start, end), height=170)
    return Chart(panels, f"Both runs of {pair.name} over time", columns=2, linked=True, group=group, least_width=330)
