"""Figures of the report: contours over ratio and torque utilisation, capacity, traction and shift rates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.ticker import MaxNLocator

from pushbelt.charts import Chart, Field, Panel, Series
from pushbelt.fmu.geometry import Array
from pushbelt.map_data import Maps
from pushbelt.style import BLUE, COLOUR_SCALE, INK, MUTED, ORANGE, RED

RPM = 30.0 / np.pi
TICKS = tuple((tick, f"{tick:g}") for tick in (0.4, 0.5, 0.7, 1.0, 1.4, 2.0, 2.5))
SLIPS = (0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0)


@dataclass(frozen=True)
class Shown:
    """A quantity of the contours."""

    title: str
    table: str
    scale: float
    unit: str
    levels: tuple[float, ...] | None = None


QUANTITIES = (
    Shown("Thrust ratio", "thrustRatio", 1.0, ""),
    Shown("Slip", "slip", 100.0, "%", (*(-level for level in reversed(SLIPS)), 0.0, *SLIPS)),
    Shown("Efficiency", "efficiency", 100.0, "%", (50, 60, 70, 80, 85, 88, 90, 92, 94, 95, 96, 97, 98)),
    Shown("Torque loss at the primary shaft", "torqueLoss", 1.0, "N·m"),
)


def _levels(shown: Shown, values: Array) -> Array:
    """Levels of the colours for the range of the values."""
    found = values[np.isfinite(values)]
    low, high = float(np.percentile(found, 1)), float(np.percentile(found, 99))
    if shown.levels is None:
        return MaxNLocator(12).tick_values(low, max(high, low + 1e-9))
    levels = np.array(shown.levels, dtype=float)
    inside = np.flatnonzero((levels >= low) & (levels <= high))
    if inside.size < 2:
        return MaxNLocator(10).tick_values(low, max(high, low + 1e-9))
    return levels[max(inside[0] - 1, 0) : inside[-1] + 2]


def contours(named: Sequence[tuple[str, Maps]], shown: Shown) -> Chart:
    """A quantity of one or two variators: a row of panels for each force, a panel for each speed, variators side by side."""
    values = [shown.scale * maps.masked(shown.table) for _, maps in named]
    levels = _levels(shown, np.concatenate([one.ravel() for one in values]))
    panels = []
    first = named[0][1]
    for f, force in enumerate(first.axes["force"]):
        for s, speed in enumerate(first.axes["speed"]):
            for (name, maps), table in zip(named, values, strict=True):
                at = _nearest(maps, "force", force), _nearest(maps, "speed", speed)
                place = (f, s) if maps is first else at
                title = f"{1e-3 * maps.axes['force'][place[0]]:g} kN, {RPM * maps.axes['speed'][place[1]]:.0f} rpm"
                panels.append(_contour(maps, shown, f"{name}: {title}" if name else title, table[place], place, levels))
    columns = len(first.axes["speed"]) if len(named) == 1 else 2
    return Chart(panels, f"Maps of {shown.title.lower()}", columns=columns, common_legend=True, least_width=240)


def _nearest(maps: Maps, axis: str, value: float) -> int:
    return int(np.argmin(np.abs(np.log(maps.axes[axis] / value))))


def _contour(maps: Maps, shown: Shown, title: str, values: Array, place: tuple[int, int], levels: Array) -> Panel:
    """One map; `values` over ratio × utilisation."""
    ratio, utilisation = maps.axes["ratio"], maps.axes["utilisation"]
    places = np.array(np.meshgrid(ratio, utilisation, indexing="ij"))
    state = maps["state"][place]
    kinds = (
        ("solved", state == 0.0, MUTED, "circle", 2.5),
        ("slips through", state == 1.0, INK, "circle-open", 6.0),
        ("beyond the capacity", state == 2.0, INK, "x-thin-open", 5.0),
        ("no steady state", state == 3.0, RED, "x-thin-open", 7.0),
    )
    series = []
    for name, where, colour, marker, size in kinds:
        labels = [f"{value:.4g} {shown.unit}" if np.isfinite(value) else name for value in values[where]]
        series.append(Series(name, *places[:, where], colour, "points", marker=marker, size=size, labels=labels))
    fields = []
    if min(values.shape) > 1 and np.count_nonzero(np.isfinite(values)) > 3:
        # All intervals between levels have the same width on the colour scale.
        steps = np.where(np.isfinite(values), np.interp(values, levels, np.arange(len(levels))), np.nan)
        ticks = tuple((float(k), f"{level:g}") for k, level in enumerate(levels))
        spread = (0.0, float(len(levels) - 1), 1.0)
        fields = [
            Field(shown.title, ratio, utilisation, steps.T, spread, ticks[:: max(len(ticks) // 8, 1)], shown=values.T)
        ]
    return Panel(
        title, series, "ratio r_S/r_P", "torque utilisation", fields=fields, x_scale="log", x_ticks=TICKS, height=240
    )


def _shades(count: int) -> list[str]:
    """Colours from light to dark, without the lightest."""
    scale = np.array([[int(colour[k : k + 2], 16) for k in (1, 3, 5)] for colour in COLOUR_SCALE[1:]])
    places = np.linspace(0.0, len(scale) - 1.0, count)
    mixed = np.stack([np.interp(places, np.arange(len(scale)), channel) for channel in scale.T], axis=1)
    return ["#" + "".join(f"{round(value):02x}" for value in colour) for colour in mixed]


def lines(maps: Maps) -> Chart:
    """Capacity over the ratio, traction over the slip and shift rates over the excess, at the middle force and speed."""
    f, s = len(maps.axes["force"]) // 2, len(maps.axes["speed"]) // 2
    ratio = maps.axes["ratio"]
    shades = _shades(len(ratio))
    capacity = [
        Series(f"{'primary' if k else 'secondary'} drives", ratio, np.abs(maps["capacity"][f, s, :, k]), colour, marker="circle", size=4)
        for k, colour in enumerate((ORANGE, BLUE))
    ]  # fmt: skip
    traction, shifts = [], []
    share = maps.axes["slipShare"]
    for k, (value, colour) in enumerate(zip(ratio, shades, strict=True)):
        low, high = maps["capacitySlip"][f, s, k]
        slips = 100.0 * np.where(share < 0.0, -share * low, share * high)
        name = f"ratio {value:.3g}"
        traction.append(Series(name, slips, maps["traction"][f, s, k], colour, marker="circle", size=4))
        rates = 1e3 * maps["shiftRate"][f, s, k, -1]
        shifts.append(Series(name, maps.axes["excess"], rates, colour, marker="circle", size=4))
    drive = f"utilisation {maps.axes['shiftUtilisation'][-1]:g}"
    panels = [
        Panel("Utilisation at capacity", capacity, "ratio r_S/r_P", x_scale="log", x_ticks=TICKS, height=280),
        Panel("Torque utilisation", traction, "slip (%)", height=280),
        Panel(f"−d(ln i)/dt/ω_P (1/krad), {drive}", shifts, "ln(F_P/(κ F_S))", height=280),
    ]
    return Chart(panels, "Capacity, traction and shift rates", columns=3, common_legend=True, least_width=280)
