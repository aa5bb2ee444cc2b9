"""Results of the study, as text and as one HTML file."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np

from pushbelt.report import page
from pushbelt.report.charts import Chart, Panel, Series
from pushbelt.report.style import BLUE, GREEN, INK, ORANGE, VIOLET

from . import package
from .study import PACKAGE, SIGNALS, Coupling, orders

COLOURS = (BLUE, ORANGE, GREEN, VIOLET)


def text(result: Coupling) -> str:
    """The tables of the study."""
    steps = [f"{1e3 * step:g} ms" for step in result.plan.steps]
    lines = [f"{'root mean square, shares of the range':>44}  " + "  ".join(f"{name:>21}" for name in SIGNALS)]
    for importer in result.importers:
        refinement, against = result.refinement(importer), result.against_loop(importer)
        rows = [
            *zip([f"{importer}, {a} against {b}" for a, b in pairwise(steps)], refinement, strict=True),
            (f"{importer}, order", orders(refinement)[-1]),
            *zip([f"{importer} against the loop, both {step}" for step in steps], against, strict=True),
            (f"{importer} against the loop, order", orders(against)[-1]),
        ]
        lines += [f"{name:>44}  " + "  ".join(f"{value:21.3g}" for value in values) for name, values in rows]
        largest = result.against_parallel(importer)
        lines.append(f"{importer + ' against the parallel loop':>44}  {largest:.3g} at most")
    return "\n".join(lines)


def write_html(result: Coupling, path: Path) -> None:
    """Writes `coupling.html`."""
    context = {
        "result": result,
        "package": PACKAGE,
        "wires": package.WIRES,
        "signals": SIGNALS,
        "orders": orders,
        "pictures": {"traces": _traces(result), "errors": _errors(result)},
    }
    page.write_html("coupling.html.j2", context, path, Path(__file__).parent)


def _traces(result: Coupling) -> Chart:
    """Signals of an importer and of the loop at the largest step, and their differences."""
    step, importer = result.plan.steps[0], next(iter(result.importers))
    coupled, loop = result.importers[importer][step], result.loop[step]
    time = result.plan.section[0] + step * np.arange(1, len(loop) + 1)
    above = [
        Panel(
            name,
            [
                Series("loop", time, loop[:, k], ORANGE, dash="dash"),
                Series(importer, time, coupled[:, k], BLUE, width=1.0),
            ],
        )
        for k, name in enumerate(SIGNALS)
    ]
    below = [
        Panel(f"{name}, difference", [Series("difference", time, coupled[:, k] - loop[:, k], BLUE)], "time (s)")
        for k, name in enumerate(SIGNALS)
    ]
    label = "Signals of importer and loop, and their difference"
    return Chart([*above, *below], label, columns=len(SIGNALS), linked=True, least_width=230)


def _errors(result: Coupling) -> Chart:
    """Differences over the communication step, with a reference line of slope 1."""
    steps = 1e3 * np.array(result.plan.steps)
    found = (
        ("Importer, against half its step", steps[:-1], result.refinement),
        ("Importer against the loop, same step", steps, result.against_loop),
    )
    panels = []
    for title, where, errors_of in found:
        series = [Series("order 1", steps, 1e-3 * steps, INK, dash="dot", width=1.0)]
        for importer, marker in zip(result.importers, ("circle", "x-thin-open"), strict=False):
            errors = errors_of(importer)
            series += [
                Series(f"{name}, {importer}", where, errors[:, k], COLOURS[k], marker=marker)
                for k, name in enumerate(SIGNALS)
            ]
        ticks = tuple((float(step), f"{step:g}") for step in steps)
        x_label = "communication step (ms)"
        panels.append(Panel(title, series, x_label, scale="log", x_scale="log", x_ticks=ticks, height=300))
    return Chart(panels, "Differences over the communication step", columns=2, common_legend=True)
