"""The report of a study: one self-contained HTML file, and the maps as image files."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import pyarrow as pa
import xarray

from pushbelt.report.page import write_html
from pushbelt.report.style import RPM
from pushbelt.study.run import Effort

from . import checks, figures, maps
from .results import METADATA, schema
from .study import AXES, Study

PICTURE_DPI = 160
FEW = 12
"""Largest number of failed points that are listed individually."""


def write(study: Study, table: pa.Table, folder: Path, effort: Effort) -> Path:
    """Writes report and maps; returns the path of the report."""
    results = maps.gridded(study.grid, table)
    pictures = folder / "maps"
    pictures.mkdir(parents=True, exist_ok=True)
    for old in pictures.glob("*.png"):
        old.unlink()
    for name, figure in maps.sheets(results).items():
        figure.savefig(pictures / f"{name}.png", dpi=PICTURE_DPI)
        plt.close(figure)
    path = folder / "report.html"
    write_html("sweep/sweep.html.j2", _context(study, table, results, effort), path)
    return path


def common(study: Study, table: pa.Table, effort: Effort) -> dict[str, Any]:
    """Values for the template of any study."""
    reasons = Counter(reason for reason in table["reason"].to_pylist() if reason is not None)
    return {
        "version": study.description.version or "",
        "identity": study.identity,
        "points": len(table),
        "effort": effort,
        "processor_time": effort.processor_time,
        "reasons": reasons.most_common(),
        "failed_count": reasons.total(),
        "columns": [
            (field.name, {key.decode(): text.decode() for key, text in field.metadata.items()})
            for field in schema(study)
        ],
        "metadata_key": METADATA.decode(),
        "parameters": shown_parameters(study),
    }


def _context(study: Study, table: pa.Table, results: xarray.Dataset, effort: Effort) -> dict[str, Any]:
    grid, steady = study.grid, results.steady
    middle = results.isel(force=results.sizes["force"] // 2).sel(friction=0.09, speed=209.44, method="nearest")
    return {
        **common(study, table, effort),
        "axes": [(axis, getattr(grid, name)) for name, axis in AXES.items()],
        "steady": {name: results[name].values[steady.values] for name in ("thrustRatio", "efficiency", "slip", "macroSlip")},
        "failed": checks.names_of(results, ~steady)[:FEW],
        "checks": checks.evaluate(results) if steady.any() else [],
        "cut": {
            "picture": figures.cuts(middle),
            "friction": float(middle.friction),
            "rpm": RPM * float(middle.speed),
            "force": float(middle.force),
        },
        "maps": figures.maps(results),
    }


def shown_parameters(study: Study) -> list[tuple[str, str, str]]:
    """Parameters of a study: name, value and unit."""
    return [
        (name, _shown(study.variables[name], value), study.variables[name].unit or "1")
        for name, value in study.parameters.items()
    ]


def _shown(variable: Any, value: float) -> str:
    """Value of a parameter, or the name of an enumeration's value."""
    if variable.type == "Enumeration":
        return next(item.name for item in variable.declaredType.items if int(item.value) == value)
    return f"{value:g}"
