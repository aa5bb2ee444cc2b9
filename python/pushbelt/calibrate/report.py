"""Reports and files: of a calibration, and of a parameter set on a table that it was not fitted to, beside another set."""

import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pushbelt import tables
from pushbelt.fmu.untrusted import described
from pushbelt.report import page
from pushbelt.report.charts import Chart, Panel, Series, around
from pushbelt.report.style import BLUE, MUTED, ORANGE
from pushbelt.tables import points
from pushbelt.tables.columns import MEASURED
from pushbelt.tables.points import Rig

from . import fit, model, worker
from .fit import Estimate, Fit
from .misfit import Trend
from .model import Model, Score, of, plain, quantities, score

SURE = 2.0  # Half-width of the shaded band, in standard deviations
LEAST_REACH = 3.0  # Least reach of the axis of residuals, in standard deviations
FAR = 6.0
"""Residual of an outlier, in medians of the absolute residuals. That is four standard deviations of a normal distribution."""
INSET = 0.02  # Distance of the marks of outliers from the border, as a share of the axis
LOOKS: tuple[dict[str, Any], ...] = ({"colour": BLUE, "size": 7}, {"colour": MUTED, "marker": "circle-open", "size": 6, "opacity": 0.8})
"""Looks of the leading set and of the other one."""
Range = tuple[float, float]
Sets = Mapping[str, pd.DataFrame]
_brief = partial(plain, digits=3)
WORST = 10  # Number of values with the largest residuals in the list
short = partial(plain, digits=4, none="–")
SCORES = ("quantity", "variator", "values", "lost values", "rms [SI]", "bias [SI]", "rms/sd [1]", "explained share [1]")


def reach(rows: pd.DataFrame) -> float:
    """Largest residual of the bulk, in standard deviations."""
    sizes = rows["relative"].abs()
    far = max(LEAST_REACH, FAR * sizes.median())
    return max(LEAST_REACH, sizes[sizes <= far].max())


def chart(quantity: str, sets: Sets) -> Chart:
    """The figures of a quantity. The first set must have values: the axes fit their bulk, and its outliers are at the border."""
    sets = {name: rows.assign(at=rows["ratio"].fillna(rows["speed_ratio"])) for name, rows in sets.items()}
    leading = next(iter(sets.values()))
    most = reach(leading)
    bulk = leading[leading["relative"].abs() <= most]
    x_range, y_range = around([bulk["measured"]]), around([bulk[["measured", "found"]].to_numpy().ravel()])
    ends = [max(x_range[0], y_range[0]), min(x_range[1], y_range[1])]
    line = Series("model as measured", ends, ends, ORANGE, width=1.0)
    series, note = _inside(sets, "measured", "found", x_range, y_range, lambda row: f"{_brief(row.measured)}, model {_brief(row.found)}")
    title = f"{quantity}: model over measurement"
    panels = [Panel(title, [line, *series], "measured", "model", x_range=x_range, y_range=y_range, height=270, note=note)]
    panels += [_residuals(sets, across, label, "Residual, standard deviations") for label, across in (("torque, N·m", "torque"), ("ratio", "at"))]
    return Chart(panels, f"Residuals of {quantity}", columns=3, common_legend=True)


def _residuals(sets: Sets, across: str, label: str, title: str, note: str = "") -> Panel:
    """Residuals over a column of the rows."""
    most = 1.15 * reach(next(iter(sets.values())))
    places = pd.concat([rows[across] for rows in sets.values()])
    margin = 1e-3 * (places.max() - places.min() or 1.0)
    span = around([(places.min() - margin, places.max() + margin)])
    series, far = _inside(sets, across, "relative", span, (-most, most), lambda row: _brief(row.relative))
    sure = Series(f"within {SURE:g}", span, (-SURE, -SURE), BLUE, "band", upper=(SURE, SURE), opacity=0.1)
    return Panel(title, [sure, *series], label, x_range=span, y_range=(-most, most), height=270, note=" ".join(filter(None, (note, far))))


def over_columns(rows: pd.DataFrame, trends: Sequence[Trend]) -> Chart:
    """Residuals of the fitted set, each of a quantity over a column."""
    panels = []
    for one in trends:
        own = rows.assign(at=one.places)[np.isfinite(one.places)]
        note = f"Change {_brief(one.rise)}, chance {_brief(one.chance)}."
        panels.append(_residuals({"fitted": own}, "at", one.column, f"Residual of {one.quantity}", note))
    return Chart(panels, "Residuals over columns", columns=3, common_legend=True)


def _inside(sets: Sets, x: str, y: str, x_range: Range, y_range: Range, text: Callable[[Any], str]) -> tuple[list[Series], str]:
    """The points within the axes; beyond them those of the leading set at the border, with their values, and a count of the others."""
    series: list[Series] = []
    notes = []
    low, high = np.array([x_range, y_range]).T[:, :, None]
    for k, (name, rows) in reversed(list(enumerate(sets.items()))):
        at = rows[[x, y]].to_numpy(dtype=float).T
        beyond = ((at < low) | (at > high)).any(axis=0)
        labels = rows["name"].where(rows["name"] != "", "line " + rows["line"].astype(str))
        series.append(Series(name, *at[:, ~beyond], **{"kind": "points", "labels": list(labels[~beyond]), **LOOKS[k]}))
        if k == 0 and beyond.any():
            inset = INSET * (high - low)
            border = np.clip(at, low + inset, high - inset)[:, beyond]
            texts = [text(row) for row in rows[beyond].itertuples()]
            sides = np.where(border[0] < sum(x_range) / 2, "middle right", "middle left").tolist()
            more = {"labels": list(labels[beyond] + ": " + texts), "texts": texts, "text_sides": sides, "marker": "diamond", "size": 10}
            series.append(Series(name, *border, **{**LOOKS[0], "kind": "points", **more}))
        elif beyond.any():
            notes.append(f"{beyond.sum()} values of {name} are outside the figure.")
    return series, " ".join(notes)


class Results:
    def __init__(
        self, table: str, version: str, variator: str, base: Mapping[str, float], model: Model, found: Fit, seconds: float = 0.0,
        notes: Sequence[str] = (), causes: Sequence[str] = (), trends: Sequence[Trend] = (), laws: Sequence[str] = (),
    ) -> None:  # fmt: skip
        """Name of the table's file, version of the FMU, parameter set of the start values, its values with the additional settings, wall-clock
        time, notes on the table, causes of a misfit, trends of the residuals, and what a fitted law of the friction says."""
        self.table, self.version, self.variator, self.base, self.seconds, self.notes = table, version, variator, base, seconds, notes
        self.causes, self.tests, self.laws = causes, trends, laws
        self.trends = [one for one in trends if one.significant]
        self.fit, self.points, self.solves = found, model.points, model.solves
        # All measured values with the start values and with the fitted parameters, in the order of the table.
        self.before, self.rows = (model.rows(states, found.kept) for states in (found.before, found.after))
        self.lost = _lost(self.rows)
        # For each row or sample of the table that was left out, its value with the largest residual.
        out = self.rows[~self.rows["kept"]].sort_values("relative", key=abs, ascending=False, kind="stable")
        self.outliers = out.drop_duplicates(["line", "time"]).sort_values(["line", "time"])

    @property
    def parameters(self) -> dict[str, float]:
        """Fitted values by name."""
        return {one.parameter.name: one.value for one in self.fit.estimates}


def sentence(estimate: Estimate) -> str:
    """Result for a parameter, in one line."""
    parameter, interval = estimate.parameter, estimate.interval
    value = f"{parameter.name} = {estimate.value:.5g} {parameter.unit}"
    if interval is not None:
        return f"{value} (95 %: {interval[0]:.5g} to {interval[1]:.5g}), was {parameter.start:.5g}"
    if estimate.undetermined is not None:
        return f"{value}: {estimate.undetermined}"
    return f"{value}: held at its bound, so without an interval; was {parameter.start:.5g}"


def outliers(results: Results) -> str:
    """The rows that were left out, in one line; empty without any."""
    found = []
    for row in results.outliers.itertuples():
        place = f"line {row.line}" + (f" at {row.time:g} s" if row.time == row.time else "")
        model = f" ({abs(row.relative):.3g} standard deviations from {row.found:.5g})" if row.found == row.found else ""
        found.append(f"{place}, {row.quantity} {row.measured:.5g}{model}")
    scatter = f"{results.fit.rms[1]:.3g} standard deviations without them and {results.fit.rms_of_all:.3g} with them"
    return f"left out as outliers: {'; '.join(found)}. The root mean square of the residuals is {scatter}" if found else ""


def write_parameters(results: Results, path: Path) -> None:
    """Writes all parameters in the form of `resources/parameters/`, which the other programs read."""
    entries: dict[str, dict[str, Any]] = {name: {"value": value, "origin": "start"} for name, value in results.base.items()}
    for estimate in results.fit.estimates:
        parameter = estimate.parameter
        entry: dict[str, Any] = {"value": estimate.value, "unit": parameter.unit, "origin": "bound" if estimate.at_bound else "calibrated"}
        if estimate.interval is not None:
            entry["interval95"] = list(estimate.interval)
        if parameter.name == "friction.pulley" and results.laws:
            entry["note"] = "; ".join([*results.laws, *(sentence(one) for one in results.fit.estimates if not one.parameter.variables)])
        for name in parameter.variables:
            kept = {"value": results.base.get(name, parameter.start), "origin": "start"}
            entries[name] = entry if estimate.undetermined is None else kept
    document = {
        "id": path.stem, "about": f"{results.variator}, calibrated by {results.table} with PushbeltVariator.fmu {results.version}",
        "fits": results.fit.misfit is None, "note": "SI units. Start values of the FMU by variable name.", "parameters": entries,
    }  # fmt: skip
    path.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")


def write_residuals(results: Results, path: Path) -> None:
    """Writes every measured value with the model's, SI."""
    rows = results.rows.assign(before=results.before["found"], unit=results.rows["quantity"].map(_unit).replace("", "1"))
    rows["reason"] = rows["reason"].where(rows["kept"], "outlier")
    titles = {
        "line": "line", "name": "name", "time": "time [s]", "ratio": "ratio.geometric [1]", "speed_ratio": "ratio.speed [1]",
        "speed": "primary.speed [rad/s]", "torque": "primary.torque [N.m]", "force": "secondary.clampingForce [N]",
        "primary_force": "primary.clampingForce [N]", "quantity": "quantity", "unit": "unit", "measured": "measured [SI]", "sd": "sd [SI]",
        "before": "before [SI]", "found": "after [SI]", "residual": "residual [SI]", "relative": "residual/sd [1]", "reason": "reason",
    }  # fmt: skip
    tables.write_frame(path, titles.values(), rows[list(titles)])


def _unit(quantity: str) -> str:
    return "" if MEASURED[quantity].dimension == "ratio" else "1/s"


def write_html(results: Results, path: Path) -> Path:
    found, rows = results.fit, results.rows
    used = rows[rows["found"].notna() & rows["kept"]]
    names, correlations = [estimate.parameter.name for estimate in found.determined], found.spread.correlations
    context = {
        "results": results, "fit": found, "used": len(used), "outliers": outliers(results),
        "lost_values": int(rows["reason"].notna().sum()),
        "quantities": [_quantity(results, q) for q in quantities(rows) if len(of(rows, q))],
        "assumed": list(rows["quantity"][~rows["given"]].unique()),
        "correlated": [
            (names[k], names[m], float(correlations[k, m]))
            for k in range(len(names)) for m in range(k) if abs(correlations[k, m]) >= fit.PARTNER
        ],
        "trends": [
            over_columns(rows, some)
            for some in (results.trends, [one for one in results.tests if not one.significant]) if some
        ],
        "worst": list(used.sort_values("relative", key=abs, ascending=False, kind="stable")[:WORST].itertuples()),
        "priors": [estimate.parameter.name for estimate in found.estimates if estimate.parameter.prior],
        "step": model.STEP, "undetermined": fit.UNDETERMINED, "settling": worker.SETTLING, "window": worker.WINDOW,
    }  # fmt: skip
    return page.write_html("calibrate/calibrate.html.j2", context, path, plain=model.plain)


def _quantity(results: Results, quantity: str) -> dict[str, Any]:
    """Scores and figures of a quantity. The values after the fit determine the axes, since those at the start may be far off."""
    after, before = of(results.rows, quantity), of(results.before, quantity)
    kept = after[after["kept"]] if after["kept"].any() else after
    return {
        "meaning": MEASURED[quantity].meaning, "unit": _unit(quantity), "score": score(kept, quantity),
        "before": score(before[before.index.isin(kept.index)], quantity).rms,
        "picture": chart(quantity, {"fitted": after, "start values": before}),
    }  # fmt: skip


def hold_out(fmu: Path, rig: Rig, parameters: Mapping[str, Mapping[str, float]], workers: int, folder: Path) -> list[Score]:
    """Scores of sets by name on a table, by quantity and set. Writes report.html, holdout.csv, holdout.json and residuals.csv."""
    with model.opened(fmu, {}, rig.points, workers, len(parameters) * len(rig.points)) as opened:
        sets = {name: opened.rows(opened.states(values)) for name, values in parameters.items()}
    first = next(iter(sets.values()))
    scores = [score(own, quantity, name) for quantity in quantities(first) for name, own in sets.items()]
    tables.write(folder / "holdout.csv", SCORES, scores)
    pd.DataFrame(scores).to_json(folder / "holdout.json", orient="records", double_precision=15, indent=2)
    header = ["line", "name", "time [s]", "quantity", "measured [SI]", "sd [SI]", *(f"{name} [SI]" for name in sets)]
    columns = [first[name] for name in ("line", "name", "time", "quantity", "measured", "sd")]
    tables.write_frame(folder / "residuals.csv", header, pd.concat([*columns, *(rows["found"] for rows in sets.values())], axis=1))
    context = {
        "rig": rig, "version": described(fmu).version or "", "scores": scores, "variators": list(sets),
        "notes": points.understood(rig)[1:],
        "figures": [
            (q, MEASURED[q].meaning, chart(q, {name: own for name, rows in sets.items() if len(own := of(rows, q))}))
            for q in dict.fromkeys(one.quantity for one in scores if one.count)
        ],
        "lost": [(name, row) for name, rows in sets.items() for row in _lost(rows).itertuples()],
    }  # fmt: skip
    page.write_html("calibrate/holdout.html.j2", context, folder / "report.html", plain=short)
    return scores


def _lost(rows: pd.DataFrame) -> pd.DataFrame:
    """One row for each point without a steady state."""
    return rows[rows["reason"].notna()].drop_duplicates("line")
