"""The report of the maps: one self-contained HTML file."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from pushbelt.maps.data import AXES, TABLES, Maps
from pushbelt.report.page import write_html
from pushbelt.study.run import Effort

from . import figures, files


def write(maps: Maps, folder: Path, effort: Effort, beside: Maps | None = None) -> Path:
    """Writes the report and returns its path. `beside` are the maps of another variator, side by side with these."""
    named = [("", maps)] if beside is None else [("A", maps), ("B", beside)]
    others = beside.parameters if beside else maps.parameters
    context = {
        "maps": maps,
        "effort": effort,
        "beside": beside,
        "contours": [(shown.heading, figures.contours(named, shown)) for shown in figures.SHOWN],
        "lines": figures.lines(maps),
        # Without the numbers after the first comma.
        "reasons": Counter(reason.split(",")[0] for reason in maps.reasons.values()).most_common(),
        "axes": [(name, AXES[name], maps.axes[name]) for name in AXES],
        "tables": TABLES,
        "files": (*files.OWN, *files.WRITERS),
        "differing": [(name, value, others.get(name)) for name, value in maps.parameters.items() if others.get(name) != value],
    }
    path = folder / "report.html"
    write_html("maps/maps.html.j2", context, path)
    return path
