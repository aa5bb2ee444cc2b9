"""The report: Bode and step plots, and a table of the points, in one self-contained HTML file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pushbelt import page
from pushbelt.charts import Chart, Panel, Series
from pushbelt.linear import Array, LinearModel
from pushbelt.linear_grid import LinearGrid
from pushbelt.style import BLUE, GREEN, INK, MUTED, ORANGE, RED, VIOLET, in_figures

OUTPUTS = ("ratio.geometric", "primary.speed", "slip")
"""Default outputs of the figures."""
COLOURS = (BLUE, ORANGE, GREEN, RED, VIOLET, INK, MUTED)
LOWEST = 0.01
"""Lowest frequency of the Bode plots, Hz."""
UNITS = {"ratio": "", "torque": "N·m", "speed": "rad/s", "force": "N"}
SHOWN_POLES = 4

Drawn = Sequence[tuple[str, str, LinearModel]]
"""Name, colour and model of the points in the figures."""


def write(grid: LinearGrid, folder: Path, outputs: Sequence[str], time: float) -> Path:
    """Writes the report and returns its path. Raises KeyError for an output that the models do not have."""
    found = list(grid.points())
    drawn = chosen(grid)
    drawn[0][2].select(outputs)
    first = found[0][1]
    charts = [(output, bode(drawn, output, first.frequency), steps(drawn, output, time)) for output in outputs]
    path = folder / "report.html"
    context = {
        "grid": grid,
        "points": [(title(grid, point), model, _poles(model)) for point, model in found],
        "refused": [(title(grid, point), reason) for point, reason in grid.refused()],
        "inputs": first.inputs,
        "units": first.units,
        "outputs": first.outputs,
        "frequency": first.frequency,
        "charts": charts,
        "drawn": len(drawn),
    }
    page.write_html("linearize/linearize.html.j2", context, path, short=short)
    return path


def chosen(grid: LinearGrid) -> Drawn:
    """Evenly spaced points of the grid, at most one per colour, including the first and the last."""
    found = list(grid.points())
    places = np.unique(np.linspace(0, len(found) - 1, min(len(found), len(COLOURS))).round().astype(int))
    return [(title(grid, found[k][0]), COLOURS[n], found[k][1]) for n, k in enumerate(places)]


def title(grid: LinearGrid, point: dict[str, float]) -> str:
    """Label of a point: the values in which it differs from the others."""
    several = {name: value for name, value in point.items() if len(grid.axes[name]) > 1} or point
    shown = {name: in_figures(UNITS.get(name, "")) for name in several}
    return ", ".join(f"{name} {shown[name][0] * value:.4g} {shown[name][1]}".rstrip() for name, value in several.items())


def bode(drawn: Drawn, output: str, highest: float) -> Chart:
    """Magnitude and phase from each input to an output, over Hz."""
    frequencies = np.geomspace(LOWEST, highest, 300)
    first, panels = drawn[0][2], []
    for load in first.inputs:
        responses = [
            (name, colour, model.select([output], [load]).response(2.0 * np.pi * frequencies)[:, 0, 0])
            for name, colour, model in drawn
        ]
        scale, unit = per(first.units[output], first.units[load])
        size = [Series(name, frequencies, scale * np.abs(values), colour) for name, colour, values in responses]
        phase = [
            Series(name, frequencies, values, colour)
            for (name, colour, _), values in zip(responses, phases([one for *_, one in responses]), strict=True)
        ]
        log = {"x_label": "frequency (Hz)", "x_scale": "log", "x_range": (LOWEST, highest)}
        panels += [
            Panel(f"{load} → {output}: magnitude ({unit})", size, scale="log", **log),
            Panel(f"{load} → {output}: phase (°)", phase, **log),
        ]
    return Chart(panels, f"Bode plots of {output}", columns=2, common_legend=True, least_width=330)


def phases(responses: Sequence[NDArray[np.complex128]]) -> list[Array]:
    """Phases over frequency without jumps, °. At the lowest frequency they differ by at most 180° from that of the first response."""
    found: list[Array] = []
    for values in responses:
        phase = np.degrees(np.unwrap(np.angle(values)))
        nearest = found[0][0] if found else 0.0
        found.append(phase - 360.0 * np.round((phase[0] - nearest) / 360.0))
    return found


def steps(drawn: Drawn, output: str, end: float) -> Chart:
    """Responses of an output to a unit step of each input, over time."""
    times, first, panels = np.linspace(0.0, end, 400), drawn[0][2], []
    for load in first.inputs:
        scale, unit = per(first.units[output], first.units[load])
        series = [
            Series(name, times, scale * model.select([output], [load]).step(times)[:, 0, 0], colour)
            for name, colour, model in drawn
        ]
        panels.append(Panel(f"{load} → {output} ({unit})", series, "time (s)", x_range=(0.0, end)))
    return Chart(panels, f"Step responses of {output}", columns=2, linked=True, common_legend=True, least_width=330)


def per(output: str, load: str) -> tuple[float, str]:
    """Factor from SI and unit of an output per unit of an input, as figures show it."""
    (above, output), (below, load) = in_figures(output), in_figures(load)
    load = f"({load})" if "." in load or "/" in load else load
    return above / below, f"{output}/{load}"


def _poles(model: LinearModel) -> str:
    upper = [one for one in model.poles if one.imag >= 0.0]
    return ", ".join(pole(one) for one in upper[:SHOWN_POLES])


def pole(value: complex) -> str:
    """An eigenvalue with three digits."""
    turn = f"{'+' if value.imag > 0 else '-'}{abs(value.imag):.3g}i" if value.imag else ""
    return f"{value.real:.3g}{turn}".replace("-", page.MINUS)


def short(value: Any) -> str:
    """A number with four digits, a large one without decimals."""
    return (f"{value:.0f}" if abs(value) >= 9999.5 else f"{value:.4g}").replace("-", page.MINUS)
