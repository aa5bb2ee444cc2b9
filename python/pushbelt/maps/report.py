"""The report of the maps: one self-contained HTML file."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from pushbelt.maps.data import AXES, TABLES, Maps
from pushbelt.report.page import write_html
from pushbelt.study.run import Effort

from . import figures, files


def write(maps: Maps, folder: Path, effort: Effort, beside: Maps | None = None) -> Path:
    """Writes the report and returns its path. `beside` are the maps of another variator, side by side with these."""
    path = folder / "report.html"
    write_html("maps/maps.html.j2", _context(maps, effort, beside), path)
    return path


def _context(maps: Maps, effort: Effort, beside: Maps | None) -> dict[str, Any]:
    named = [("", maps)] if beside is None else [("A", maps), ("B", beside)]
    efficiency = maps.masked("efficiency")
    others = beside.parameters if beside else {}
    return {
        "source": maps.source,
        "identity": maps.identity,
        "effort": effort,
        "lines_count": maps.valid[..., 0].size,
        "points": maps.valid.size,
        "gaps": int((~maps.valid).sum()),
        "best": float(np.nanmax(efficiency)),
        "thrust": (float(np.nanmin(maps.masked("thrustRatio"))), float(np.nanmax(maps.masked("thrustRatio")))),
        "contours": [(shown.heading, figures.contours(named, shown)) for shown in figures.QUANTITIES],
        "lines": figures.lines(maps),
        # Without the numbers after the first comma.
        "reasons": Counter(reason.split(",")[0] for reason in maps.reasons.values()).most_common(),
        "axes": [(name, AXES[name], maps.axes[name]) for name in AXES],
        "tables": TABLES,
        "files": (*files.OWN, *files.WRITERS),
        "differing": [(name, value, others.get(name)) for name, value in maps.parameters.items() if beside and others.get(name) != value],
        "beside": beside.source if beside else None,
        "parameters": list(maps.parameters.items()),
    }
