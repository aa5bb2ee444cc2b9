"""The report of a design of experiments: rank correlations, scatter over each varied column, points without a steady state."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from scipy.stats import rankdata

from pushbelt.fmu.geometry import Array
from pushbelt.report.charts import Chart, Panel, Series
from pushbelt.report.page import Check, write_html
from pushbelt.report.style import BLUE, RED, in_figures
from pushbelt.study.run import Effort

from .checks import of_all
from .maps import Quantity
from .report import FEW, shown_parameters
from .results import METADATA, schema
from .study import Study

QUANTITIES = (
    Quantity("thrust ratio", "thrustRatio", 1.0, ""),
    Quantity("efficiency", "efficiency", 100.0, "%"),
    Quantity("slip", "slip", 100.0, "%"),
    Quantity("losses", "loss.total", 1.0, "W"),
    Quantity("largest stress of the ring", "ring.stressMax", 1e-6, "MPa"),
)
LENGTHS = {"m": (1e3, "mm"), "rad": (1e3, "mrad")}
"""Scale and unit of lengths and angles."""
LARGE = 1e5
"""Stiffnesses in N and other values above this are shown in SI units."""
MOST_COLUMNS = 12
"""Largest number of columns with figures: those of the largest correlations."""


def write(study: Study, table: pa.Table, folder: Path, effort: Effort) -> Path:
    """Writes the report; returns its path."""
    path = folder / "report.html"
    write_html("sweep/design.html.j2", _context(study, table, effort), path)
    return path


def column(table: pa.Table, name: str) -> Array:
    """A column as numbers; NaN where there is no value."""
    return table[name].to_numpy(zero_copy_only=False).astype(float)


def correlation(x: Array, y: Array) -> float:
    """Rank correlation (Spearman): 1 where y rises with x at all points, NaN where either is constant."""
    there = np.isfinite(x) & np.isfinite(y)
    if there.sum() < 3 or np.ptp(x[there]) == 0.0 or np.ptp(y[there]) == 0.0:
        return float("nan")
    return float(np.corrcoef(rankdata(x[there]), rankdata(y[there]))[0, 1])


def checks(table: pa.Table) -> list[Check]:
    """Checks of all steady states."""
    steady, found = np.isfinite(column(table, "thrustRatio")), []
    for statement, values, limit in of_all(lambda name: column(table, name), steady):
        values = values[steady]
        wrong, worst = int((values > limit).sum()), float(values.max(initial=0.0))
        found.append(Check(statement, not wrong, f"{values.size - wrong} of {values.size} points, at most {worst:.2g} %"))
    return found


def _context(study: Study, table: pa.Table, effort: Effort) -> dict[str, Any]:
    names = study.grid.columns
    correlations = {
        name: [correlation(column(table, name), column(table, quantity.column)) for quantity in QUANTITIES]
        for name in names
    }

    def weight(name: str) -> float:
        return float(np.max(np.abs(np.nan_to_num(correlations[name]))))

    strongest = sorted(names, key=weight, reverse=True)
    reasons = Counter(reason for reason in table["reason"].to_pylist() if reason is not None)
    failed = [row for row in table.select(["point", *names, "reason"]).to_pylist() if row["reason"] is not None]
    fields = [(field.name, {key.decode(): text.decode() for key, text in field.metadata.items()}) for field in schema(study)]
    units = {name: metadata["unit"] for name, metadata in fields}
    return {
        "version": study.description.version or "",
        "identity": study.identity,
        "design": study.grid,
        "points": len(table),
        "failed_count": len(failed),
        "failed": [{"point": row["point"], "values": [row[name] for name in names], "reason": row["reason"]} for row in failed[:FEW]],
        "reasons": reasons.most_common(),
        "effort": effort,
        "processor_time": effort.processor_time,
        "quantities": [
            (quantity, _range(quantity.scale * column(table, quantity.column))) for quantity in QUANTITIES
        ],
        "ranges": [(name, units[name], _range(column(table, name))) for name in names],
        "correlations": [(name, correlations[name]) for name in strongest],
        "charts": [(name, _scatter(table, name, units[name])) for name in strongest[:MOST_COLUMNS]],
        "checks": checks(table),
        "columns": fields,
        "metadata_key": METADATA.decode(),
        "parameters": shown_parameters(study),
    }


def _range(values: Array) -> tuple[float, float] | None:
    values = values[np.isfinite(values)]
    return (float(values.min()), float(values.max())) if values.size else None


def _scatter(table: pa.Table, name: str, unit: str) -> Chart:
    """The quantities over a column. Points at which the belt slips through have another colour."""
    x = column(table, name)
    scale, unit = LENGTHS.get(unit, in_figures(unit)) if np.nanmax(np.abs(x)) < LARGE or unit == "Pa" else (1.0, unit)
    slipping = column(table, "macroSlip") == 1.0
    panels = []
    for quantity in QUANTITIES[:3]:
        y = quantity.scale * column(table, quantity.column)
        kinds = (("steady", np.isfinite(y) & ~slipping, BLUE), ("slips through", np.isfinite(y) & slipping, RED))
        series = [
            Series(kind, scale * x[where], y[where], colour, "points", marker="circle", size=5, opacity=0.7)
            for kind, where, colour in kinds
            if where.any()
        ]
        title = f"{quantity.name} ({quantity.unit})" if quantity.unit else quantity.name
        label = name if unit in ("", "1") else f"{name} ({unit})"
        panels.append(Panel(title[0].upper() + title[1:], series, label, height=260))
    return Chart(panels, f"Thrust ratio, efficiency and slip over {name}", columns=len(panels), common_legend=True)
