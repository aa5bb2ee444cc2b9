"""The report of a study, one self-contained HTML file: maps of a grid, also as image files; of a design rank correlations, and scatter
over each varied column."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import pandas
import pyarrow as pa
import xarray

from pushbelt.maps.panels import QUANTITIES, Quantity
from pushbelt.report.charts import Chart, Panel, Series
from pushbelt.report.page import write_html
from pushbelt.report.style import BLUE, RED, RPM, in_figures
from pushbelt.study.run import Effort

from . import checks, figures, maps
from .design import Design
from .results import METADATA, schema
from .study import AXES, Study

PICTURE_DPI = 160
FEW = 12  # Largest number of failed points that are listed individually
SHOWN = (
    *QUANTITIES, Quantity("losses", "loss.total", unit="W"), Quantity("largest stress of the ring", "ring.stressMax", 1e-6, "MPa"),
)  # fmt: skip
LENGTHS = {"m": (1e3, "mm"), "rad": (1e3, "mrad")}  # Scale and unit of lengths and angles
LARGE = 1e5  # Stiffnesses in N and other values above this are shown in SI units
MOST_COLUMNS = 12  # Largest number of columns with figures: those of the largest correlations


def write(study: Study, table: pa.Table, folder: Path, effort: Effort) -> Path:
    """Writes the report, and for a grid its maps as image files; returns the path of the report."""
    path = folder / "report.html"
    results = maps.data_set(study.grid, table)
    context = _common(study, table, effort) | {"checks": checks.evaluate(results) if results.steady.any() else []}
    if isinstance(study.grid, Design):
        write_html("sweep/design.html.j2", context | _of_design(study, table), path)
        return path
    pictures = folder / "maps"
    pictures.mkdir(parents=True, exist_ok=True)
    for old in pictures.glob("*.png"):
        old.unlink()
    for name, figure in maps.sheets(results).items():
        figure.savefig(pictures / f"{name}.png", dpi=PICTURE_DPI)
        plt.close(figure)
    write_html("sweep/sweep.html.j2", context | _of_grid(study, results), path)
    return path


def _common(study: Study, table: pa.Table, effort: Effort) -> dict[str, Any]:
    reasons = Counter(reason for reason in table["reason"].to_pylist() if reason is not None)
    return {
        "version": study.description.version or "",
        "identity": study.identity,
        "points": len(table),
        "effort": effort,
        "reasons": reasons.most_common(),
        "failed_count": reasons.total(),
        "columns": [
            (field.name, {key.decode(): text.decode() for key, text in field.metadata.items()})
            for field in schema(study)
        ],
        "metadata_key": METADATA.decode(),
        "parameters": [
            (name, _shown(study.variables[name], value), study.variables[name].unit or "1") for name, value in study.parameters.items()
        ],
    }


def _of_grid(study: Study, results: xarray.Dataset) -> dict[str, Any]:
    grid, steady = study.grid, results.steady
    middle = results.isel(force=results.sizes["force"] // 2).sel(friction=0.09, speed=209.44, method="nearest")
    return {
        "axes": [(axis, getattr(grid, name)) for name, axis in AXES.items()],
        "steady": {name: results[name].values[steady.values] for name in ("thrustRatio", "efficiency", "slip", "macroSlip")},
        "failed": checks.names_of(results, ~steady)[:FEW],
        "cut": {
            "picture": figures.cuts(middle),
            "friction": float(middle.friction),
            "rpm": RPM * float(middle.speed),
            "force": float(middle.force),
        },
        "maps": figures.maps(results),
    }


def _shown(variable: Any, value: float) -> str:
    """Value of a parameter, or the name of an enumeration's value."""
    if variable.type == "Enumeration":
        return next(item.name for item in variable.declaredType.items if int(item.value) == value)
    return f"{value:g}"


def _of_design(study: Study, table: pa.Table) -> dict[str, Any]:
    names = list(study.grid.columns)
    rows = table.to_pandas()
    numbers = rows.drop(columns=["remarks", "reason"]).astype(float)
    columns = [quantity.column for quantity in SHOWN]
    # By rank: 1 where a quantity rises with a column at all points, NaN where either is constant.
    correlations = numbers[[*names, *columns]].corr("spearman", min_periods=3).loc[names, columns]
    strongest = correlations.abs().max(axis=1).fillna(0.0).sort_values(ascending=False, kind="stable").index
    failed = rows[rows.reason.notna()]
    units = {field.name: field.metadata[b"unit"].decode() for field in schema(study)}
    return {
        "design": study.grid,
        "failed": [
            {"point": row.point, "values": [row[name] for name in names], "reason": row.reason}
            for _, row in failed.head(FEW).iterrows()
        ],
        "quantities": [(quantity, _range(quantity.scale * numbers[quantity.column])) for quantity in SHOWN],
        "ranges": [(name, units[name], _range(numbers[name])) for name in names],
        "correlations": [(name, correlations.loc[name].tolist()) for name in strongest],
        "charts": [(name, _scatter(numbers, name, units[name])) for name in strongest[:MOST_COLUMNS]],
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
    for quantity in QUANTITIES:
        y = quantity.scale * numbers[quantity.column]
        kinds = (("steady", y.notna() & ~slipping, BLUE), ("slips through", y.notna() & slipping, RED))
        series = [
            Series(kind, scale * x[where], y[where], colour, "points", marker="circle", size=5, opacity=0.7)
            for kind, where, colour in kinds
            if where.any()
        ]
        panels.append(Panel(quantity.heading, series, label, height=260))
    return Chart(panels, f"Thrust ratio, efficiency and slip over {name}", columns=len(panels), common_legend=True)
