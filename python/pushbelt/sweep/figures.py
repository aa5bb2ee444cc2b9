"""Figures of the report: maps over ratio and torque utilisation, and cuts through them."""

from __future__ import annotations

import numpy as np

from pushbelt.maps.panels import Border, heading, levels_of, panel, shades
from pushbelt.report.charts import Chart, Panel, Series

from .maps import QUANTITIES, Quantity, Results, carried, in_rpm

ACROSS = 4
"""Largest number of maps per row."""


def maps(results: Results) -> dict[str, Chart]:
    """Charts of all quantities by heading: one chart per clamping force, with one map per friction and speed."""
    grid = results.grid
    several = len(grid.force) > 1
    return {
        heading(quantity.name, quantity.unit) + (f" at {1e-3 * force:.1f} kN" if several else ""): _maps(results, quantity, index)
        for index, force in enumerate(grid.force)
        for quantity in QUANTITIES
    }


def _maps(results: Results, quantity: Quantity, force: int) -> Chart:
    grid = results.grid
    values = quantity.scale * results[quantity.column][force]
    slipping = results["macroSlip"][force] > 0.0
    levels = levels_of(values, quantity.levels)
    panels = []
    for m, n in np.ndindex(len(grid.friction), len(grid.speed)):
        missing, slips = ~np.isfinite(values[m, n]), slipping[m, n]
        kinds = {"solved": ~missing & ~slips, "slips through": ~missing & slips, "no steady state": missing}
        title = f"μ = {grid.friction[m]:g}, {in_rpm(grid.speed[n]):.0f} rpm"
        border = Border(carried(np.array(grid.utilisation), ~missing & ~slips))
        axes = np.array(grid.ratio), np.array(grid.utilisation)
        panels.append(panel(title, (quantity.name, quantity.unit), axes, values[m, n], levels, kinds, border))
    return Chart(
        panels, f"Maps of {quantity.name}", columns=min(len(panels), ACROSS), common_legend=True, least_width=240
    )


def cuts(results: Results, force: int, friction: int, speed: int) -> Chart:
    """The quantities over the utilisation, one line per ratio."""
    grid = results.grid
    colours = shades(len(grid.ratio))
    panels = []
    for quantity in QUANTITIES:
        values = quantity.scale * results[quantity.column][force, friction, speed]
        series = [
            Series(f"ratio {ratio:.3g}", grid.utilisation, line, colour, marker="circle", size=4)
            for ratio, colour, line in zip(grid.ratio, colours, values, strict=True)
        ]
        # Values in macro-slip would make the scale too large for the others.
        held = values[results["macroSlip"][force, friction, speed] == 0.0]
        held = held[np.isfinite(held)]
        margin = 0.08 * float(np.ptp(held)) + 0.01 if held.size else 0.0
        span = (float(held.min()) - margin, float(held.max()) + margin) if held.size else None
        panels.append(Panel(heading(quantity.name, quantity.unit), series, "torque utilisation", y_range=span, height=300))
    return Chart(
        panels, "Thrust ratio, efficiency and slip over torque utilisation", columns=len(panels), common_legend=True
    )
