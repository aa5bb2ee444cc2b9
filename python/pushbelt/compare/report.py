"""The report: one HTML file that needs nothing else, and the differences as CSV."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pushbelt import page
from pushbelt.charts import Chart, Panel, Series
from pushbelt.style import BLUE, ORANGE

from .runs import Pair

MOST = 24
"""Columns that are drawn of a pair; the table has all."""


def write(pairs: Sequence[Pair], units: Mapping[str, str], folder: Path, wanted: Sequence[str] = ()) -> Path:
    """Writes report and differences; returns where the report is."""
    folder.mkdir(parents=True, exist_ok=True)
    page.write_table(
        folder / "differences.csv",
        ["run", "column", "unit", "range", "rootMeanSquare", "largest", "time", "largestShare"],
        (
            [pair.name, d.name, units.get(d.name, ""), d.span, d.root_mean_square, d.largest, d.when, d.share]
            for pair in pairs
            for d in pair.differences
        ),
    )
    path = folder / "report.html"
    page.write_html("compare/compare.html.j2", _context(pairs, units, wanted), path, plain=_plain)
    return path


def _context(pairs: Sequence[Pair], units: Mapping[str, str], wanted: Sequence[str]) -> dict[str, Any]:
    return {
        "pairs": [(f"run-{k}", pair, overlay(pair, units, wanted)) for k, pair in enumerate(pairs, start=1)],
        "units": units,
        "most": MOST,
        "chosen": bool(wanted),
    }


def overlay(pair: Pair, units: Mapping[str, str], wanted: Sequence[str] = ()) -> Chart:
    """Both runs in each column; those that are apart most come first, unless some are wanted."""
    names = [name for name in wanted if name in pair.names] or [d.name for d in pair.differences[:MOST]]
    looks = (("A", BLUE, ""), ("B", ORANGE, "dash"))
    start = min(float(run.time[0]) for run in pair.runs)
    end = max(float(run.time[-1]) for run in pair.runs)
    return Chart(
        [
            Panel(
                f"{name} ({units[name]})" if name in units else name,
                [
                    Series(who, run.time, run[name], colour, dash=dash)
                    for (who, colour, dash), run in zip(looks, pair.runs, strict=True)
                ],
                "time (s)" if name == names[-1] else "",
                x_range=(start, end),
                height=170,
            )
            for name in names
        ],
        f"Both runs of {pair.name} over time",
        columns=2,
        linked=True,
        least_width=330,
    )


def _plain(value: float) -> str:
    """A number with four significant digits."""
    return f"{value:.4g}".replace("-", page.MINUS)
