"""The report: Bode and step plots, and a table of the points, in one self-contained HTML file."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pushbelt.linear.grid import LinearGrid
from pushbelt.linear.model import Array, LinearModel
from pushbelt.report import page
from pushbelt.report.charts import Chart, Panel, Series
from pushbelt.report.style import BLUE, GREEN, INK, MUTED, ORANGE, RED, VIOLET, in_figures

COLOURS = (BLUE, ORANGE, GREEN, RED, VIOLET, INK, MUTED)
DASHES = ("", "dash", "dot")
LOWEST = 0.01  # Lowest frequency of the Bode plots, Hz
UNITS = {"ratio": "", "torque": "N·m", "speed": "rad/s", "force": "N"}
SHOWN_POLES = 4
MOST_DASHED = 4  # Largest number of values of the axis with colours, if another one has dashes
Drawn = tuple[dict[str, Any], LinearModel]  # A point in the figures: name, colour and dash of its lines, and its model


def write(grid: LinearGrid, folder: Path, outputs: Sequence[str], time: float) -> Path:
    """Writes the report and returns its path. Raises KeyError for an output that the models do not have."""
    found = list(grid.points())
    drawn = [(look, model.select(outputs)) for look, model in chosen(grid)]
    context = {
        "points": [(title(grid, point), model, ", ".join(map(pole, model.poles[model.poles.imag >= 0.0][:SHOWN_POLES]))) for point, model in found],
        "refused": [(title(grid, point), reason) for point, reason in grid.refused()],
        "charts": list(charts(drawn, time)),
        "first": found[0][1], "drawn": len(drawn),
    }  # fmt: skip
    return page.write_html("linearize/linearize.html.j2", context, folder / "report.html")


def chosen(grid: LinearGrid) -> list[Drawn]:
    """Points for the figures. The first axis with several values, such as the ratio, has colours, and a second one dashes. Values are spread
    evenly over an axis, with the first and the last; further axes are at a middle value."""
    found = list(grid.points())
    values = {axis: sorted({point[axis] for point, _ in found}) for axis in grid.axes}
    several = [axis for axis in values if len(values[axis]) > 1]
    kept = {axis: [every[len(every) // 2]] for axis, every in values.items()}
    for axis, most in zip(several, (MOST_DASHED if len(several) > 1 else len(COLOURS), len(DASHES)), strict=False):
        places = np.linspace(0, len(values[axis]) - 1, min(len(values[axis]), most)).round().astype(int)
        kept[axis] = [values[axis][k] for k in np.unique(places)]
    drawn: list[Drawn] = []
    for point, model in found:
        if all(point[axis] in kept[axis] for axis in kept):
            colour, dash = [*(kept[axis].index(point[axis]) for axis in several), 0, 0][:2]
            drawn.append(({"name": title(grid, point), "colour": COLOURS[colour], "dash": DASHES[dash]}, model))
    return drawn or [({"name": title(grid, found[0][0]), "colour": COLOURS[0]}, found[0][1])]


def title(grid: LinearGrid, point: dict[str, float]) -> str:
    """Label of a point: the values in which it differs from the others."""
    several = {name: value for name, value in point.items() if len(grid.axes[name]) > 1} or point
    shown = {name: in_figures(UNITS.get(name, "")) for name in several}
    return ", ".join(f"{name} {shown[name][0] * value:.4g} {shown[name][1]}".rstrip() for name, value in several.items())


def charts(drawn: Sequence[Drawn], end: float) -> Iterator[tuple[str, Chart, Chart]]:
    """For each output, from each input: magnitude and phase over Hz, and the response to a unit step over time."""
    first, times = drawn[0][1], np.linspace(0.0, end, 400)
    frequencies = np.geomspace(LOWEST, first.frequency, 300)
    responses = np.array([model.response(2.0 * np.pi * frequencies) for _, model in drawn])
    stepped = np.array([model.step(times) for _, model in drawn])
    log: dict[str, Any] = {"x_label": "frequency (Hz)", "x_scale": "log", "x_range": (LOWEST, first.frequency)}
    common: dict[str, Any] = {"columns": 2, "common_legend": True, "least_width": 330}

    def lines(x: Array, values: Iterable[Array]) -> list[Series]:
        return [Series(x=x, y=y, **look) for (look, _), y in zip(drawn, values, strict=True)]

    for k, output in enumerate(first.outputs):
        bode, steps = [], []
        for m, load in enumerate(first.inputs):
            scale, unit = per(first.units[output], first.units[load])
            found = responses[:, :, k, m]
            bode.append(Panel(f"{load} → {output}: magnitude ({unit})", lines(frequencies, scale * np.abs(found)), scale="log", **log))
            bode.append(Panel(f"{load} → {output}: phase (°)", lines(frequencies, phases(found)), **log))
            steps.append(Panel(f"{load} → {output} ({unit})", lines(times, scale * stepped[:, :, k, m]), "time (s)", x_range=(0.0, end)))
        yield output, Chart(bode, f"Bode plots of {output}", **common), Chart(steps, f"Step responses of {output}", linked=True, **common)


def phases(responses: Iterable[Array]) -> list[Array]:
    """Phases over frequency without jumps, °. Their means over the frequencies are within half a turn of the mean direction of all."""
    found = [np.degrees(np.unwrap(np.angle(values))) for values in responses]
    means = np.array([phase.mean() for phase in found])
    centre = np.degrees(np.angle(np.exp(1j * np.radians(means)).sum()))
    return [phase - 360.0 * turn for phase, turn in zip(found, np.round((means - centre) / 360.0), strict=True)]


def per(output: str, load: str) -> tuple[float, str]:
    """Factor from SI and unit of an output per unit of an input, as figures show it."""
    (above, output), (below, load) = in_figures(output), in_figures(load)
    load = f"({load})" if "." in load or "/" in load else load
    return above / below, f"{output}/{load}"


def pole(value: complex) -> str:
    """An eigenvalue with three digits."""
    turn = f"{'+' if value.imag > 0 else '-'}{abs(value.imag):.3g}i" if value.imag else ""
    return f"{value.real:.3g}{turn}".replace("-", page.MINUS)
