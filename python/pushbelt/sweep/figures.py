"""Figures of the report: maps over ratio and torque utilisation, and cuts through them."""

from __future__ import annotations

import numpy as np

from pushbelt.charts import Chart, Field, Panel, Series
from pushbelt.fmu.geometry import Array
from pushbelt.style import COLOUR_SCALE, INK, MUTED, RED

from .maps import QUANTITIES, RATIO_TICKS, Quantity, Results, in_rpm, levels_of
from .study import Grid

ACROSS = 4
"""Largest number of maps per row."""
TICKS = tuple((tick, f"{tick:g}") for tick in RATIO_TICKS)


def maps(results: Results) -> dict[str, Chart]:
    """Charts of all quantities by name: one chart per clamping force, with one map per friction and speed."""
    grid = results.grid
    several = len(grid.force) > 1
    return {
        quantity.name + (f" at {1e-3 * force:.1f} kN" if several else ""): _maps(results, quantity, index)
        for index, force in enumerate(grid.force)
        for quantity in QUANTITIES
    }


def _maps(results: Results, quantity: Quantity, force: int) -> Chart:
    grid = results.grid
    values = quantity.scale * results[quantity.column][force]
    slipping = results["macroSlip"][force] > 0.0
    levels = levels_of(quantity, values)
    panels = [
        _map(grid, quantity, f"μ = {friction:g}, {in_rpm(speed):.0f} rpm", values[m, n], slipping[m, n], levels)
        for m, friction in enumerate(grid.friction)
        for n, speed in enumerate(grid.speed)
    ]
    return Chart(
        panels, f"Maps of {quantity.name}", columns=min(len(panels), ACROSS), common_legend=True, least_width=240
    )


def _map(grid: Grid, quantity: Quantity, title: str, values: Array, slipping: np.ndarray, levels: Array) -> Panel:
    """One map; `values` over ratio × utilisation."""
    missing = ~np.isfinite(values)
    places = np.array(np.meshgrid(grid.ratio, grid.utilisation, indexing="ij"))
    kinds = (
        ("solved", ~missing & ~slipping, MUTED, "circle", 2.5),
        ("slips through", ~missing & slipping, INK, "circle-open", 6.0),
        ("no steady state", missing, RED, "x-thin-open", 7.0),
    )
    series = []
    for name, where, colour, marker, size in kinds:
        labels = [f"{value:.4g} {quantity.unit}" if np.isfinite(value) else name for value in values[where]]
        series.append(Series(name, *places[:, where], colour, "points", marker=marker, size=size, labels=labels))
    fields = []
    if min(values.shape) > 1 and np.count_nonzero(~missing) > 3:
        # All intervals between levels have the same width on the colour scale.
        steps = np.interp(values, levels, np.arange(len(levels)))
        steps[missing] = np.nan
        ticks = tuple((float(k), f"{level:g}") for k, level in enumerate(levels))
        fields = [
            Field(
                quantity.name, grid.ratio, grid.utilisation, steps.T, levels=(0.0, float(len(levels) - 1), 1.0),
                ticks=ticks[:: max(len(ticks) // 8, 1)], shown=values.T,
            )
        ]  # fmt: skip
    return Panel(
        title, series, "ratio r_S/r_P", "torque utilisation", fields=fields, x_scale="log", x_ticks=TICKS, height=250
    )


def cuts(results: Results, force: int, friction: int, speed: int) -> Chart:
    """The quantities over the utilisation, one line per ratio."""
    grid = results.grid
    shades = _shades(len(grid.ratio))
    panels = []
    for quantity in QUANTITIES:
        values = quantity.scale * results[quantity.column][force, friction, speed]
        series = [
            Series(f"ratio {ratio:.3g}", grid.utilisation, line, colour, marker="circle", size=4)
            for ratio, colour, line in zip(grid.ratio, shades, values, strict=True)
        ]
        # Values in macro-slip would make the scale too large for the others.
        carried = values[results["macroSlip"][force, friction, speed] == 0.0]
        carried = carried[np.isfinite(carried)]
        margin = 0.08 * float(np.ptp(carried)) + 0.01 if carried.size else 0.0
        span = (float(carried.min()) - margin, float(carried.max()) + margin) if carried.size else None
        panels.append(Panel(_title(quantity), series, "torque utilisation", y_range=span, height=300))
    return Chart(
        panels, "Thrust ratio, efficiency and slip over torque utilisation", columns=len(panels), common_legend=True
    )


def _title(quantity: Quantity) -> str:
    name = f"{quantity.name} ({quantity.unit})" if quantity.unit else quantity.name
    return name[0].upper() + name[1:]


def _shades(count: int) -> list[str]:
    """Colours from light to dark, without the lightest."""
    scale = np.array([[int(colour[k : k + 2], 16) for k in (1, 3, 5)] for colour in COLOUR_SCALE[1:]])
    places = np.linspace(0.0, len(scale) - 1.0, count)
    mixed = np.stack([np.interp(places, np.arange(len(scale)), channel) for channel in scale.T], axis=1)
    return ["#" + "".join(f"{round(value):02x}" for value in colour) for colour in mixed]
