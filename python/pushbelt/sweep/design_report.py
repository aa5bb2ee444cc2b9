"""The report of a design of experiments: rank correlations, scatter over each varied column, points without a steady state."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas
import pyarrow as pa

from pushbelt.maps.panels import Quantity
from pushbelt.report.charts import Chart, Panel, Series
from pushbelt.report.page import Check, write_html
from pushbelt.report.style import BLUE, RED, in_figures
from pushbelt.study.run import Effort

from .checks import of_all
from .report import FEW, common
from .study import Study

QUANTITIES = (
    Quantity("thrust ratio", "thrustRatio"),
    Quantity("efficiency", "efficiency", 100.0, "%"),
    Quantity("slip", "slip", 100.0, "%"),
    Quantity("losses", "loss.total", unit="W"),
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


def checks(numbers: pandas.DataFrame) -> list[Check]:
    """Checks of all steady states."""
    steady, found = numbers.thrustRatio.notna().to_numpy(), []
    for statement, values, limit in of_all(lambda name: numbers[name].to_numpy(), steady):
        values = values[steady]
        wrong, worst = int((values > limit).sum()), float(values.max(initial=0.0))
        found.append(Check(statement, not wrong, f"{values.size - wrong} of {values.size} points, at most {worst:.2g} %"))
    return found


def _context(study: Study, table: pa.Table, effort: Effort) -> dict[str, Any]:
    names = list(study.grid.columns)
    rows = table.to_pandas()
    numbers = rows.drop(columns=["remarks", "reason"]).astype(float)
    columns = [quantity.column for quantity in QUANTITIES]
    # By rank: 1 where a quantity rises with a column at all points, NaN where either is constant.
    correlations = numbers[[*names, *columns]].corr("spearman", min_periods=3).loc[names, columns]
    strongest = correlations.abs().max(axis=1).fillna(0.0).sort_values(ascending=False, kind="stable").index
    failed = rows[rows.reason.notna()]
    given = common(study, table, effort)
    units = {name: metadata["unit"] for name, metadata in given["columns"]}
    return {
        **given,
        "design": study.grid,
        "failed": [
            {"point": row.point, "values": [row[name] for name in names], "reason": row.reason}
            for _, row in failed.head(FEW).iterrows()
        ],
        "quantities": [(quantity, _range(quantity.scale * numbers[quantity.column])) for quantity in QUANTITIES],
        "ranges": [(name, units[name], _range(numbers[name])) for name in names],
        "correlations": [(name, correlations.loc[name].tolist()) for name in strongest],
        "charts": [(name, _scatter(numbers, name, units[name])) for name in strongest[:MOST_COLUMNS]],
        "checks": checks(numbers),
    }


def _range(values: pandas.Series) -> tuple[float, float] | None:
    return (values.min(), values.max()) if values.notna().any() else None


def _scatter(numbers: pandas.DataFrame, name: str, unit: str) -> Chart:
    """The quantities over a column. Points at which the belt slips through have another colour."""
    x = numbers[name]
    scale, unit = LENGTHS.get(unit, in_figures(unit)) if x.abs().max() < LARGE or unit == "Pa" else (1.0, unit)
    slipping = numbers.macroSlip == 1.0
    label = name if unit in ("", "1") else f"{name} ({unit})"
    panels = []
    for quantity in QUANTITIES[:3]:
        y = quantity.scale * numbers[quantity.column]
        kinds = (("steady", y.notna() & ~slipping, BLUE), ("slips through", y.notna() & slipping, RED))
        series = [
            Series(kind, scale * x[where], y[where], colour, "points", marker="circle", size=5, opacity=0.7)
            for kind, where, colour in kinds
            if where.any()
        ]
        panels.append(Panel(quantity.heading, series, label, height=260))
    return Chart(panels, f"Thrust ratio, efficiency and slip over {name}", columns=len(panels), common_legend=True)
