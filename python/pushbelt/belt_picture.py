"""The belt on its pulleys, coloured by push force."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.patches import Circle, FancyArrowPatch

from pushbelt.fmu.geometry import Array, TwoPulleyCurve
from pushbelt.fmu.results import BeltState
from pushbelt.style import INK, MUTED, STYLE, svg

PUSH_COLOURS = LinearSegmentedColormap.from_list("push", ["#c9d3dd", "#7fb0d6", "#2f6fb0", "#6a2f8f", "#c4423f"])


def belt_offset(state: BeltState, curve: TwoPulleyCurve, pitch_offset: float) -> Array:
    """Distance of the belt from its reference curve at the points of the profile, outward positive, m.

    On an arc the profile counts from the arc's mean radius, which is not quite that of the reference curve.
    """
    offset = state.profile.radial_deviation
    for pulley in ("primary", "secondary"):
        on_arc = np.abs(curve.from_middle(pulley, state.profile.position)) < 0.5 * curve.arc_length(pulley)
        mean = state[f"{pulley}.radius"] + pitch_offset - curve.radius(pulley)
        offset = offset + np.where(on_arc, mean, 0.0)
    return offset


def belt_picture(state: BeltState, curve: TwoPulleyCurve, pitch_offset: float) -> str:
    """The belt on its pulleys, coloured by push force, its distance from the reference curve magnified."""
    profile, offset = state.profile, belt_offset(state, curve, pitch_offset)
    magnification = magnification_for(offset, curve)
    fine = np.linspace(0.0, curve.length, 721)
    wrapped = np.append(profile.position, curve.length)

    def along(values: Array) -> Array:
        return np.interp(fine, wrapped, np.append(values, values[0]))

    line = 1e3 * curve.outline(fine, magnification * along(offset))
    reference = 1e3 * curve.outline(fine, np.zeros_like(fine))
    segments = np.stack([line[:-1], line[1:]], axis=1)
    push = along(profile.push_force)
    with plt.rc_context({**STYLE, "axes.grid": False}):
        figure, axes = plt.subplots(figsize=(11.2, 5.4), layout="constrained")
        centres = (np.zeros(2), np.array([1e3 * curve.center_distance, 0.0]))
        radii = (curve.secondary_radius, curve.primary_radius)
        for centre, radius, label in zip(centres, radii, ("S", "P"), strict=True):
            pitch = 1e3 * (radius - pitch_offset)
            axes.add_patch(Circle(tuple(centre), pitch, facecolor="#f1f4f7", edgecolor="#cfd6de", linewidth=0.8))
            axes.add_patch(Circle(tuple(centre), 12.0, facecolor="#dde3ea", edgecolor="#b8c2cd", linewidth=0.8))
            axes.text(*centre, label, ha="center", va="center", fontsize=12, fontweight="bold", color=INK)
            _turning(axes, centre, 0.62 * pitch)
            axes.annotate(f"{pitch:.1f} mm", (centre[0], centre[1] - 19.0), ha="center", color=MUTED, fontsize=8.5)
        axes.plot(*reference.T, color=MUTED, linewidth=0.7, linestyle=(0, (4, 3)))
        collection = LineCollection(segments, cmap=PUSH_COLOURS, linewidths=6.0, capstyle="round")
        collection.set_array(0.5 * (push[:-1] + push[1:]))
        collection.set_clim(0.0, max(float(push.max()), 1.0))
        axes.add_collection(collection)
        bar = figure.colorbar(collection, ax=axes, shrink=0.7, pad=0.015, aspect=26)
        bar.set_label("push force (N)")
        bar.outline.set_visible(False)
        axes.set_aspect("equal")
        axes.autoscale_view()
        axes.margins(0.04)
        axes.axis("off")
        gap = 0.5e3 * (curve.center_distance + curve.secondary_radius - curve.primary_radius)
        axes.text(
            gap,
            0.0,
            f"radial\ndeviation\nmagnified\n{magnification:.0f} times",
            ha="center",
            va="center",
            color=MUTED,
            fontsize=8.5,
            linespacing=1.5,
        )
    return svg(figure)


def _turning(axes: Axes, centre: Array, radius: float) -> None:
    """An arrow in the sense of rotation, clockwise."""
    start, end = np.deg2rad(150.0), np.deg2rad(60.0)
    points = [centre + radius * np.array([np.cos(angle), np.sin(angle)]) for angle in (start, end)]
    axes.add_patch(
        FancyArrowPatch(
            tuple(points[0]),
            tuple(points[1]),
            connectionstyle="arc3,rad=-0.4",
            arrowstyle="-|>",
            mutation_scale=12,
            color=MUTED,
            linewidth=1.2,
        )
    )


def magnification_for(offset: Array, curve: TwoPulleyCurve) -> float:
    """A round magnification that shows the largest offset at about a quarter of the smaller radius."""
    largest = float(np.abs(offset).max())
    if largest == 0.0:
        return 1.0
    wanted = 0.3 * min(curve.primary_radius, curve.secondary_radius) / largest
    return float(max(step for step in (1, 2, 5, 10, 20, 50, 100, 200, 500) if step <= max(wanted, 1.0)))
