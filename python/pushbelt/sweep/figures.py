"""Figures of the report: maps over ratio and torque utilisation, and cuts through them."""

from __future__ import annotations

import numpy as np
import xarray

from pushbelt.maps.panels import QUANTITIES, Border, Quantity, levels_of, panel, shades
from pushbelt.report.charts import Chart, Panel, Series
from pushbelt.report.style import RPM

from .maps import carried

ACROSS = 4  # Largest number of maps per row


def maps(results: xarray.Dataset) -> dict[str, Chart]:
    """Charts of all quantities by heading: one chart per clamping force, with one map per friction and speed."""
    several = results.sizes["force"] > 1
    return {
        quantity.heading + (f" at {1e-3 * force:.1f} kN" if several else ""): _maps(results.sel(force=force), quantity)
        for force in results.force.values
        for quantity in QUANTITIES
    }


def _maps(results: xarray.Dataset, quantity: Quantity) -> Chart:
    axes = results.ratio.values, results.utilisation.values
    levels = levels_of(quantity.scale * results[quantity.column].values, quantity.levels)
    panels = []
    for friction in results.friction.values:
        for speed in results.speed.values:
            one = results.sel(friction=friction, speed=speed)
            values, slips = quantity.scale * one[quantity.column].values, one.macroSlip.values > 0.0
            there = np.isfinite(values)
            kinds = {"solved": there & ~slips, "slips through": there & slips, "no steady state": ~there}
            border = Border(carried(axes[1], there & ~slips))
            title = f"μ = {friction:g}, {RPM * speed:.0f} rpm"
            panels.append(panel(title, quantity, axes, values, levels, kinds, border))
    columns = min(len(panels), ACROSS)
    return Chart(panels, f"Maps of {quantity.name}", columns=columns, common_legend=True, least_width=240)


def cuts(results: xarray.Dataset) -> Chart:
    """The quantities over the utilisation at a force, a friction and a speed, one line per ratio."""
    panels = []
    for quantity in QUANTITIES:
        values = quantity.scale * results[quantity.column]
        series = [
            Series(f"ratio {ratio:.3g}", results.utilisation, values.sel(ratio=ratio), colour, marker="circle", size=4)
            for ratio, colour in zip(results.ratio.values, shades(results.sizes["ratio"]), strict=True)
        ]
        # Values in macro-slip would make the scale too large for the others.
        held = values.where(results.macroSlip == 0.0)
        low, high = float(held.min()), float(held.max())
        margin = 0.08 * (high - low) + 0.01
        span = (low - margin, high + margin) if np.isfinite(low) else None
        panels.append(Panel(quantity.heading, series, "torque utilisation", y_range=span, height=300))
    label = "Thrust ratio, efficiency and slip over torque utilisation"
    return Chart(panels, label, columns=len(panels), common_legend=True)
