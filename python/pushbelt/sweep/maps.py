"""Results as arrays over the grid, and image files of maps."""

from __future__ import annotations

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pyarrow as pa
import xarray
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, Colormap, LinearSegmentedColormap
from matplotlib.figure import Figure

from pushbelt.fmu.geometry import Array
from pushbelt.maps.panels import Quantity, levels_of, middle_of
from pushbelt.report.style import INK, RED, STYLE, colour_stops

from .study import AXES, Grid

RATIO_TICKS = (0.5, 0.7, 1.0, 1.4, 2.0)


def gridded(grid: Grid, table: pa.Table) -> xarray.Dataset:
    """The numbers of the results over the axes of the grid, NaN where there is no steady state, and the mask `steady`."""
    numbers = table.drop_columns(["remarks", "reason", *AXES.keys() & set(table.column_names)])
    values = {
        name: numbers[name].to_numpy(zero_copy_only=False).astype(float).reshape(grid.shape)
        for name in numbers.column_names
    }
    axes = {name: list(getattr(grid, name)) for name in AXES}
    found = xarray.Dataset({name: (tuple(AXES), one) for name, one in values.items()}, axes)
    return found.assign(steady=found.thrustRatio.notnull())


SLIPS = (0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0)
QUANTITIES = (
    Quantity("thrust ratio", "thrustRatio"),
    Quantity("efficiency", "efficiency", 100.0, "%", (50, 60, 70, 80, 85, 90, 92, 94, 95, 96, 96.5, 97, 97.5, 98, 98.5, 99)),
    Quantity("slip", "slip", 100.0, "%", (*(-level for level in reversed(SLIPS)), 0.0, *SLIPS)),
)


def in_rpm(speed: float) -> float:
    """Revolutions per minute of a speed in rad/s."""
    return speed * 30.0 / np.pi


def maps(results: xarray.Dataset, quantity: Quantity) -> Figure:
    """Maps of a quantity at a clamping force, one per friction and speed."""
    values = quantity.scale * results[quantity.column].values
    slipping = results.macroSlip.values > 0.0
    down, across = [f"μ = {one:g}" for one in results.friction.values], [f"{in_rpm(w):.0f} rpm" for w in results.speed.values]
    if len(down) > len(across):
        values, slipping = np.swapaxes(values, 0, 1), np.swapaxes(slipping, 0, 1)
        down, across = across, down
    levels = levels_of(values, quantity.levels)
    middle = middle_of(levels)
    # Beyond the first and the last level there is one more colour.
    stops = None if middle is None else colour_stops((middle + 1) / (len(levels) + 1))
    colours = plt.get_cmap("viridis") if stops is None else LinearSegmentedColormap.from_list("diverging", stops)
    rows, columns = len(down), len(across)
    with plt.rc_context(STYLE):
        size = (2.45 * columns + 1.4, 2.15 * rows + 0.5)
        figure, panels = plt.subplots(
            rows, columns, figsize=size, sharex=True, sharey=True, squeeze=False, layout="constrained"
        )
        for m, n in np.ndindex(rows, columns):
            _panel(panels[m, n], results, values[m, n], slipping[m, n], levels, colours)
            panels[m, n].set_title(f"{down[m]}, {across[n]}" if rows > 1 or columns > 1 else "")
        for axes in panels[-1]:
            axes.set_xlabel("ratio $r_S/r_P$")
        for axes in panels[:, 0]:
            axes.set_ylabel("torque utilisation")
        shown = plt.cm.ScalarMappable(BoundaryNorm(levels, colours.N, extend="both"), colours)
        bar = figure.colorbar(shown, ax=panels, shrink=min(1.0, 1.6 / rows), aspect=32, pad=0.015, ticks=levels)
        bar.ax.set_yticklabels([f"{level:g}" for level in levels])
        bar.set_label(f"{quantity.name} ({quantity.unit})" if quantity.unit else quantity.name)
        bar.outline.set_visible(False)
    return figure


def carried(utilisation: Array, holds: np.ndarray) -> Array:
    """Least and greatest utilisation that is carried at each ratio: between the last point that holds and the next one.

    `holds` is over ratio × utilisation. NaN where all points hold, or none.
    """
    between = 0.5 * (utilisation[1:] + utilisation[:-1])
    border = np.full((2, len(holds)), np.nan)
    for k, line in enumerate(holds):
        places = np.flatnonzero(line)
        if places.size and places[0] > 0:
            border[0, k] = between[places[0] - 1]
        if places.size and places[-1] < len(utilisation) - 1:
            border[1, k] = between[places[-1]]
    return border


def _panel(
    axes: Axes, results: xarray.Dataset, values: Array, slipping: np.ndarray, levels: Array, colours: Colormap
) -> None:
    """One map; `values` over ratio × utilisation."""
    ratio, utilisation = results.ratio.values, results.utilisation.values
    field = np.ma.masked_invalid(values.T)
    axes.set_facecolor("#f1f3f5")
    if min(values.shape) > 1 and field.count() > 3:
        norm = BoundaryNorm(levels, colours.N, extend="both")
        axes.contourf(ratio, utilisation, field, levels, cmap=colours, norm=norm, extend="both")
        axes.contour(ratio, utilisation, field, levels, colors="white", linewidths=0.4, alpha=0.6)
        for side in carried(utilisation, np.isfinite(values) & ~slipping):
            axes.plot(ratio, side, color=INK, linewidth=1.4)
    places = np.array(np.meshgrid(ratio, utilisation, indexing="ij"))
    missing = ~np.isfinite(values)
    marks = (
        (~missing & ~slipping, {"marker": ".", "color": "white", "markersize": 1.2, "alpha": 0.8}),
        (~missing & slipping, {"marker": "o", "color": INK, "fillstyle": "none", "markersize": 2.8}),
        (missing, {"marker": "x", "color": RED, "markersize": 3.2}),
    )
    for where, mark in marks:
        if where.any():
            # Markers are not clipped, because many are on the border.
            axes.plot(*places[:, where], linestyle="", markeredgewidth=0.7, clip_on=False, **mark)
    axes.set_xscale("log")
    axes.set_xticks(RATIO_TICKS, [f"{tick:g}" for tick in RATIO_TICKS])
    axes.minorticks_off()
    axes.grid(visible=False)
    for axis, limits in ((ratio, axes.set_xlim), (utilisation, axes.set_ylim)):
        if len(axis) > 1:
            limits(axis[0], axis[-1])


def sheets(results: xarray.Dataset) -> dict[str, Figure]:
    """Figures of all maps, by file name."""
    several = results.sizes["force"] > 1
    return {
        quantity.name.replace(" ", "-") + (f"-{force:.0f}N" if several else ""): maps(results.sel(force=force), quantity)
        for force in results.force.values
        for quantity in QUANTITIES
    }
