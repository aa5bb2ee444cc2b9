"""Results as arrays over the grid, and image files of maps."""

from __future__ import annotations

import itertools
from typing import Any

import matplotlib
import numpy as np
import pandas
import pyarrow as pa
import xarray
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, LinearSegmentedColormap
from matplotlib.figure import Figure

from pushbelt.fmu.geometry import Array
from pushbelt.maps.panels import QUANTITIES, Quantity, levels_of, middle_of
from pushbelt.report.style import INK, RED, RPM, STYLE, colour_stops

from .design import Points
from .study import AXES, Grid

RATIO_TICKS = (0.5, 0.7, 1.0, 1.4, 2.0)


def data_set(grid: Points, table: pa.Table) -> xarray.Dataset:
    """The numbers of the results over the axes of a grid, or over the points of a design, NaN where there is no steady state, and
    the mask `steady`."""
    numbers = table.drop_columns(["remarks", "reason"]).to_pandas().astype(float).set_index("point")
    if isinstance(grid, Grid):
        axes = {name: getattr(grid, name) for name in AXES}
        numbers = numbers.drop(columns=axes.keys() & numbers.keys())
        numbers.index = pandas.MultiIndex.from_product(axes.values(), names=axes)
    found = numbers.to_xarray()
    return found.assign(steady=found.thrustRatio.notnull())


def maps(results: xarray.Dataset, quantity: Quantity) -> Figure:
    """Maps of a quantity at a clamping force, one per friction and speed, with the capacity and the points without a steady state."""
    levels = levels_of(quantity.scale * results[quantity.column].values, quantity.levels)
    middle = middle_of(levels)
    # Beyond the first and the last level there is one more colour.
    stops = None if middle is None else colour_stops((middle + 1) / (len(levels) + 1))
    colours = matplotlib.colormaps["viridis"] if stops is None else LinearSegmentedColormap.from_list("diverging", stops)
    norm = BoundaryNorm(levels, colours.N, extend="both")
    rows, columns = results.sizes["friction"], results.sizes["speed"]
    with matplotlib.rc_context(STYLE):
        size = (2.45 * columns + 1.4, 2.15 * rows + 0.5)
        figure = Figure(size, layout="constrained")
        panels: Any = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for m, n in np.ndindex(rows, columns):
            axes, one = panels[m, n], results.isel(friction=m, speed=n).transpose("utilisation", "ratio")
            values = (quantity.scale * one[quantity.column]).to_masked_array()
            there, slipping = ~np.ma.getmaskarray(values), one.pastPeak.values > 0.0
            if min(values.shape) > 1 and values.count() > 3:
                axes.contourf(one.ratio, one.utilisation, values, levels, cmap=colours, norm=norm, extend="both")
                for side in carried(one.utilisation.values, (there & ~slipping).T):
                    axes.plot(one.ratio, side, color=INK, linewidth=1.4)
            x, y = np.meshgrid(one.ratio, one.utilisation)
            for where, marker, colour in ((there & slipping, "o", INK), (~there, "x", RED)):
                if where.any():
                    axes.plot(x[where], y[where], marker, color=colour, fillstyle="none", markersize=2.8, clip_on=False)
            axes.set_title(f"μ = {one.friction:g}, {RPM * one.speed:.0f} rpm")
            axes.set_xscale("log")
            axes.set_xticks(RATIO_TICKS, [f"{tick:g}" for tick in RATIO_TICKS])
            axes.minorticks_off()
            axes.set(facecolor="#f1f3f5", xmargin=0.0, ymargin=0.0)
        figure.supxlabel("ratio $r_S/r_P$", fontsize=9)
        figure.supylabel("torque utilisation", fontsize=9)
        shown, shrink = ScalarMappable(norm, colours), min(1.0, 1.6 / rows)
        bar = figure.colorbar(shown, ax=panels, shrink=shrink, aspect=32, pad=0.015, ticks=levels)
        bar.ax.set_yticklabels([f"{level:g}" for level in levels])
        bar.set_label(quantity.heading)
    return figure


def carried(utilisation: Array, holds: np.ndarray) -> Array:
    """Least and greatest utilisation that is carried at each ratio: between the last point that holds and the next one.
    `holds` is over ratio × utilisation. NaN where all points hold, or none."""
    between = 0.5 * (utilisation[1:] + utilisation[:-1])
    border = np.full((2, len(holds)), np.nan)
    for k, line in enumerate(holds):
        places = np.flatnonzero(line)
        if places.size and places[0] > 0:
            border[0, k] = between[places[0] - 1]
        if places.size and places[-1] < len(utilisation) - 1:
            border[1, k] = between[places[-1]]
    return border


def sheets(results: xarray.Dataset) -> dict[str, Figure]:
    """Figures of all maps, by file name."""
    end = "-{:.0f}N" if results.sizes["force"] > 1 else ""
    places = itertools.product(results.force.values, QUANTITIES)
    return {one.name.replace(" ", "-") + end.format(force): maps(results.sel(force=force), one) for force, one in places}
