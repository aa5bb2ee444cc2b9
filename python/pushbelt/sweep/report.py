"""The report of a study: one self-contained HTML file, and the maps as image files."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pyarrow as pa

from pushbelt.report.page import write_html
from pushbelt.study.run import Effort

from . import checks, figures, maps
from .maps import Results
from .results import METADATA, schema
from .study import AXES, Study

PICTURE_DPI = 160
FEW = 12
"""Largest number of failed points that are listed individually."""


def write(study: Study, table: pa.Table, folder: Path, effort: Effort) -> Path:
    """Writes report and maps; returns the path of the report."""
    results = Results(study.grid, table)
    pictures = folder / "maps"
    pictures.mkdir(parents=True, exist_ok=True)
    for old in pictures.glob("*.png"):
        old.unlink()
    for name, figure in maps.sheets(results).items():
        figure.savefig(pictures / f"{name}.png", dpi=PICTURE_DPI)
        plt.close(figure)
    path = folder / "report.html"
    write_html("sweep/sweep.html.j2", _context(study, results, effort), path)
    return path


def _context(study: Study, results: Results, effort: Effort) -> dict[str, Any]:
    grid, table = study.grid, results.table
    nearest = {
        "friction": int(np.argmin(np.abs(np.array(grid.friction) - 0.09))),
        "speed": int(np.argmin(np.abs(np.array(grid.speed) - 209.44))),
        "force": len(grid.force) // 2,
    }
    reasons = Counter(reason for reason in table["reason"].to_pylist() if reason is not None)
    failed = np.argwhere(~results.steady)
    steady = {column: results[column][results.steady] for column in ("thrustRatio", "efficiency", "slip", "macroSlip")}
    return {
        "version": study.description.version or "",
        "identity": study.identity,
        "axes": [(axis, getattr(grid, name)) for name, axis in AXES.items()],
        "points": len(grid),
        "steady": steady,
        "effort": effort,
        "processor_time": effort.processor_time,
        "reasons": reasons.most_common(),
        "failed": [checks.name_of(results, place) for place in failed[:FEW]],
        "failed_count": len(failed),
        "checks": checks.evaluate(results) if results.steady.any() else [],
        "spots": checks.spots(results) if results.steady.any() else [],
        "cut": {
            "picture": figures.cuts(results, **nearest),
            "friction": grid.friction[nearest["friction"]],
            "rpm": maps.in_rpm(grid.speed[nearest["speed"]]),
            "force": grid.force[nearest["force"]],
        },
        "maps": figures.maps(results),
        "columns": [
            (field.name, {key.decode(): text.decode() for key, text in field.metadata.items()})
            for field in schema(study)
        ],
        "metadata_key": METADATA.decode(),
        "parameters": shown_parameters(study),
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
