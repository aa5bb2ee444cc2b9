"""The calibration's report, parameter file and residuals."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from pushbelt import tables
from pushbelt.page import write_html as write_page
from pushbelt.tables.columns import MEASURED

from . import figures, fit, model, worker
from .fit import Estimate
from .results import Results, Row

WORST = 10
"""Number of values with the largest residuals in the list."""


def sentence(estimate: Estimate) -> str:
    """Result for a parameter, in one line."""
    parameter, interval = estimate.parameter, estimate.interval
    value = f"{parameter.name} = {estimate.value:.5g} {parameter.unit}"
    if interval is not None:
        return f"{value} (95 %: {interval[0]:.5g} to {interval[1]:.5g}), was {parameter.start:.5g}"
    if estimate.undetermined is not None:
        return f"{value}: {why_undetermined(estimate)}"
    return f"{value}: held at its bound, so without an interval; was {parameter.start:.5g}"


def outliers(results: Results) -> str:
    """The rows that were left out, in one line; empty without any."""
    if not results.outliers:
        return ""
    return (
        f"left out as outliers: {'; '.join(map(_outlier, results.outliers))}. The root mean square of the residuals is "
        f"{results.fit.rms[1]:.3g} standard deviations without them and {results.fit.rms_of_all:.3g} with them"
    )


def _outlier(row: Row) -> str:
    place = f"line {row.point.line}" + (f" at {row.measured.time:g} s" if row.measured.time is not None else "")
    text = f"{place}, {row.measured.quantity} {row.measured.value:.5g}"
    return text if row.after is None else f"{text} ({abs(row.relative):.3g} standard deviations from {row.after:.5g})"


def why_undetermined(estimate: Estimate) -> str:
    """Reason why a parameter cannot be identified from the table."""
    reason = estimate.undetermined
    assert reason is not None
    half = "any size" if reason.half > 1e3 else f"±{100.0 * reason.half:.0f} %"
    text = f"cannot be identified from this table (its interval would be {half}), so it remains at its start value"
    if reason.partner is not None:
        text += f"; the table cannot separate it from {reason.partner} (correlation {reason.correlation:.2f})"
    return text


def write_parameters(results: Results, path: Path) -> None:
    """Writes all parameters in the form of `resources/parameters/`, which the other programs read."""
    fitted = {name: estimate for estimate in results.fit.estimates for name in estimate.parameter.variables}
    entries: dict[str, dict[str, Any]] = {}
    for name in [*results.base, *(name for name in fitted if name not in results.base)]:
        estimate = fitted.get(name)
        if estimate is None or estimate.undetermined is not None:
            value = results.base.get(name, estimate.parameter.start if estimate else None)
            entries[name] = {"value": value, "origin": "start"}
        else:
            origin = "bound" if estimate.at_bound else "calibrated"
            entries[name] = {"value": estimate.value, "unit": estimate.parameter.unit, "origin": origin}
            if estimate.interval is not None:
                entries[name]["interval95"] = list(estimate.interval)
    document = {
        "id": path.stem,
        "about": f"{results.variator}, calibrated by {results.table} with PushbeltVariator.fmu {results.version}",
        "fits": results.fit.fits,
        "note": "SI units. Start values of the FMU by variable name.",
        "parameters": entries,
    }
    path.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")


def write_residuals(results: Results, path: Path) -> None:
    """Writes every measured value with the model's, SI."""
    header = [
        "line", "name", "time [s]", "ratio.geometric [1]", "ratio.speed [1]", "primary.speed [rad/s]", "primary.torque [N.m]",
        "secondary.clampingForce [N]", "primary.clampingForce [N]", "quantity", "unit", "measured [SI]", "sd [SI]", "before [SI]",
        "after [SI]", "residual [SI]", "residual/sd [1]", "reason",
    ]  # fmt: skip
    tables.write(path, header, map(_cells, results.rows))


def _cells(row: Row) -> list[Any]:
    point, measured = row.point, row.measured
    return [
        point.line, point.name, measured.time, point.ratio, point.speed_ratio, point.speed, point.torque, point.force,
        point.primary_force, measured.quantity, "1" if MEASURED[measured.quantity].dimension == "ratio" else "1/s",
        measured.value, measured.deviation, row.before, row.after, row.residual, row.relative,
        row.reason if row.kept else "outlier",
    ]  # fmt: skip


def write_html(results: Results, path: Path) -> None:
    """Writes the report."""
    write_page("calibrate/calibrate.html.j2", context(results), path, plain=plain)


def plain(value: float | None) -> str:
    """A number with five significant digits."""
    return "" if value is None else f"{value:.5g}".replace("-", "\N{MINUS SIGN}")


def context(results: Results) -> dict[str, Any]:
    """Values for the template."""
    found = results.fit
    used = [row for row in results.rows if row.relative is not None and row.kept]
    return {
        "results": results,
        "fit": found,
        "used": len(used),
        "outliers": outliers(results),
        "rms": found.rms,
        "lost_values": sum(row.reason is not None for row in results.rows),
        "quantities": [_quantity(results, quantity) for quantity in results.quantities if results.of(quantity)],
        "assumed": [
            q for q in results.quantities if any(not r.measured.given for r in results.rows if r.measured.quantity == q)
        ],
        "correlated": _correlated(results),
        "worst": sorted(used, key=lambda row: -abs(row.relative))[:WORST],
        "priors": [estimate.parameter.name for estimate in found.estimates if estimate.parameter.prior],
        "why": why_undetermined,
        "step": model.STEP,
        "lost_residual": model.LOST,
        "undetermined": fit.UNDETERMINED,
        "settling": worker.SETTLING,
        "window": worker.WINDOW,
    }


def _quantity(results: Results, quantity: str) -> dict[str, Any]:
    rows = [row for row in results.of(quantity) if row.kept] or results.of(quantity)
    after = np.array([row.residual for row in rows])
    before = np.array([row.before - row.measured.value for row in rows if row.before is not None])
    return {
        "name": quantity,
        "meaning": MEASURED[quantity].meaning,
        "unit": "" if MEASURED[quantity].dimension == "ratio" else "1/s",
        "count": len(rows),
        "before": float(np.sqrt(np.mean(before**2))) if before.size else None,
        "after": float(np.sqrt(np.mean(after**2))),
        "bias": float(after.mean()),
        "relative": float(np.sqrt(np.mean([row.relative**2 for row in rows]))),
        "picture": figures.residuals(results, quantity),
    }


def _correlated(results: Results) -> list[tuple[str, str, float]]:
    """Pairs of parameters with a high correlation."""
    names = [estimate.parameter.name for estimate in results.fit.determined]
    matrix = results.fit.correlations
    return [
        (names[k], names[m], float(matrix[k, m]))
        for k in range(len(names))
        for m in range(k)
        if abs(matrix[k, m]) >= fit.PARTNER
    ]
