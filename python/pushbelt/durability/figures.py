"""Figures of the report."""

from __future__ import annotations

import numpy as np

from pushbelt.report.charts import Chart, Level, Panel, Series, stack
from pushbelt.report.style import BLUE, COLOUR_SCALE, GREEN, MUTED, ORANGE, RED

from .damage import Damage

COLOURS = (BLUE, ORANGE)
MEGA = 1e-6
MOST_POINTS = 1500
"""Largest number of points of a cloud. The largest amplitudes are among them."""


def over_time(result: Damage) -> Chart:
    """Speed of the ring, equivalent amplitude of each part, and accumulated damage."""
    time = result.table["time"]
    parts = result.rows(result.limited)
    scale = result.total if result.limited else result.total_without_limit
    limit = result.material.allowed
    most = max(limit, *(float(one.max()) for one in result.equivalent.values()))
    amplitudes = [Series(name, time, MEGA * one, c) for (name, one), c in zip(result.equivalent.items(), COLOURS)]
    damage = [
        Series(name, time, 100.0 * np.cumsum(one) / (scale or 1.0), c) for (name, one), c in zip(parts.items(), COLOURS)
    ]
    rows = [
        ("Speed of the ring (m/s)", [Series("ring.speed", time, result.table["ring.speed"], GREEN)], {}),
        (
            "Largest equivalent amplitude (MPa)",
            amplitudes,
            {"levels": [Level(MEGA * limit, "fatigue limit with safety factor", RED)], "y_range": (0.0, 1.1 * MEGA * most)},
        ),
        (f"Accumulated damage, % of the run's{'' if result.limited else ', without fatigue limit'}", damage, {}),
    ]
    panels = stack(rows, "time (s)", x_range=(float(time[0]), float(time[-1])), height=190)
    return Chart(panels, "Stress and damage over time", linked=True)


def haigh(result: Damage) -> Chart:
    """Amplitude over mean stress of all cycles, with the Haigh lines."""
    material = result.material
    series = []
    for (name, part), colour in zip(result.parts.items(), COLOURS):
        large = part.amplitude[:, 0] > 0.0
        rows = np.flatnonzero(large & (result.turns > 0.0))
        order = rows[np.argsort(-result.equivalent[name][rows])]
        chosen = order[:: -(-len(order) // MOST_POINTS) or 1]
        cycles = MEGA * part.mean[chosen, 0], MEGA * part.amplitude[chosen, 0]
        series.append(Series(name, *cycles, colour, "points", size=4, opacity=0.5))
    for text, limit, dash in (
        ("fatigue limit with safety factor", material.allowed, ""),
        ("fatigue limit", material.limit, "dash"),
    ):
        line = [MEGA * limit, MEGA * limit, 0.0]
        series.append(Series(text, [-200.0, 0.0, MEGA * material.strength], line, RED, dash=dash))
    panel = Panel("", series, "mean stress (MPa)", "amplitude (MPa)", height=320)
    return Chart([panel], "Haigh diagram: amplitude over mean stress")


def ratio_torque(result: Damage) -> Chart | None:
    """Ratio and torque of the rows, coloured by damage per revolution. None if the table lacks them."""
    torque = result.table.torque
    if torque is None or "ratio.geometric" not in result.table.columns:
        return None
    turning = result.turns > 0.0
    each = np.zeros_like(result.turns)
    each[turning] = sum(result.rows(result.limited).values())[turning] / result.turns[turning]
    share = each / (each.max() or 1.0)
    bands = (
        ("none", -1.0, 0.0, MUTED),
        ("below 1 %", 0.0, 0.01, COLOUR_SCALE[1]),
        ("1 to 10 %", 0.01, 0.1, COLOUR_SCALE[2]),
        ("10 to 50 %", 0.1, 0.5, COLOUR_SCALE[3]),
        ("above 50 %", 0.5, 1.0, RED),
    )
    series = []
    for name, low, high, colour in bands:
        rows = np.flatnonzero(turning & (share > low) & (share <= high))
        rows = rows[:: -(-len(rows) // MOST_POINTS) or 1]
        if len(rows):
            ratio = result.table["ratio.geometric"][rows]
            series.append(Series(name, ratio, torque[rows], colour, "points", size=5, opacity=0.7))
    panel = Panel("Damage per revolution, of the largest one", series, "ratio r_S/r_P", "primary torque (N·m)", height=340)
    return Chart([panel], "Damage over ratio and torque")


def clamping(found: list[tuple[float, float, float, float]]) -> Chart:
    """Damage over the factor on the clamping forces: factor, damage with and without fatigue limit, utilisation."""
    factors, with_limit, without, utilisation = (np.array(column) for column in zip(*found))
    base = without[list(factors).index(1.0)]
    rows = [
        ("Damage", with_limit, GREEN),
        ("Damage without fatigue limit, relative to the run", without / (base or 1.0), BLUE),
        ("Utilisation of the fatigue limit (%)", 100.0 * utilisation, ORANGE),
    ]
    panels = [
        Panel(
            title,
            [Series(title.split(" ")[0].lower(), factors, values, colour, "bars", bar_width=0.05)],
            "factor on the clamping forces",
            height=220,
        )
        for title, values, colour in (rows if with_limit.any() else rows[1:])
    ]
    return Chart(panels, "Effect of the clamping forces", columns=3)
