"""Interactive figures: lines, points, bars and maps with hover text, zoom and a legend that shows and hides them.

The input is plain data, the output an HTML fragment. A `Chart` is a group of panels in a responsive grid. `plotly.js`
draws each panel; `charts.js.j2` has the layout that all panels have, and adds the legend, the cursor and the keys. Panels of
a linked chart share cursor and zoom along x.
"""

import base64
import itertools
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import ArrayLike

from ..fmu.geometry import Array
from .page import fragment
from .style import INK, MUTED, colour_stops

BUCKETS = 500  # Number of parts of a long line. In each part only the first, least, greatest and last value remain.
MARGIN = 0.06  # Empty part of the axes on each side of a figure whose axes have the same scale

Tick = tuple[float, str]


@dataclass(frozen=True)
class Series:
    """An item of a panel with a name in the legend."""

    name: str
    x: ArrayLike
    y: ArrayLike
    colour: str = INK
    kind: str = "line"  # `line`, `points`, `bars` or `band` (between `y` and `upper`)
    dash: str = ""
    marker: str = ""  # Marker by its name in plotly: `circle`, `circle-open`, `x-thin-open` and so on; empty for a line
    size: float = 6.0
    width: float = 1.5
    opacity: float = 1.0
    upper: ArrayLike | None = None
    errors: tuple[ArrayLike, ArrayLike] | None = None  # Error bars: lengths below and above
    hatched: Sequence[bool] | None = None  # Which bars are hatched
    labels: Sequence[str] | None = None  # Hover text of each point, before the values
    texts: Sequence[str] | None = None  # Text beside each point
    text_sides: Sequence[str] = ()  # Side of each text: `middle left`, `middle right` and so on
    bar_width: float | None = None


class Field(NamedTuple):
    """Values over a grid, as filled contours or as labelled contour lines."""

    name: str
    x: ArrayLike
    y: ArrayLike
    values: ArrayLike  # Values, shape (len(y), len(x)); NaN leaves a gap
    levels: tuple[float, float, float] | None = None  # First level, last level and spacing of the contours
    ticks: tuple[Tick, ...] = ()  # Ticks of the colour bar
    unit: str = ""  # Unit above the colour bar
    middle: float | None = None  # Value from which the colours diverge
    lines_only: bool = False


class Shade(NamedTuple):
    """A stretch along x."""

    start: float
    end: float
    colour: str
    label: str = ""
    opacity: float = 0.12


class Mark(NamedTuple):
    """A line at one x."""

    x: float
    label: str = ""


class Level(NamedTuple):
    """A line at one y."""

    y: float
    label: str = ""
    colour: str = MUTED


@dataclass(frozen=True)
class Panel:
    """One pair of axes."""

    title: str
    series: Sequence[Series]
    x_label: str = ""
    y_label: str = ""
    fields: Sequence[Field] = ()
    scale: str = "linear"  # Scale of y: `linear` or `log`
    x_scale: str = "linear"
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None
    x_ticks: tuple[Tick, ...] = ()
    y_ticks: tuple[Tick, ...] = ()
    shades: Sequence[Shade] = ()
    marks: Sequence[Mark] = ()
    levels: Sequence[Level] = ()
    equal: bool = False  # Whether x and y have the same scale. Without ranges the axes have a margin around the lines.
    stacked: bool = False
    height: int = 230
    note: str = ""


@dataclass(frozen=True)
class Chart:
    panels: Sequence[Panel]
    label: str  # Description of the chart for screen readers
    columns: int = 1  # Largest number of panels per row
    linked: bool = False  # Whether the panels share cursor and zoom along x
    group: str = ""  # Charts and belts of the same group share the cursor
    common_legend: bool = False  # Whether all panels share one legend
    least_width: int = 260  # Least width of a panel, px. Narrow pages have fewer panels per row.

    def __html__(self) -> Markup:
        of_panels = [panel_data(panel, self.linked) for panel in self.panels]
        specification = {"linked": self.linked, "group": self.group, "commonLegend": self.common_legend, "panels": of_panels}
        text = json.dumps(specification, allow_nan=False, separators=(",", ":"), ensure_ascii=False).replace("</", "<\\/")
        return fragment("chart.html.j2", chart=self, data=text)


def stack(rows: Sequence[tuple[str, Sequence[Series], dict[str, Any]]], x_label: str, **common: Any) -> list[Panel]:
    """Panels above each other over the same x, whose label the last one has. A row has a title, lines, and further settings of its panel."""
    labels = [""] * (len(rows) - 1) + [x_label]
    return [Panel(title, series, label, **{**common, **more}) for (title, series, more), label in zip(rows, labels, strict=True)]


def panel_data(panel: Panel, linked: bool = False) -> dict[str, Any]:
    """Data and layout of a panel for plotly."""
    traces = [_field(panel, one) for one in panel.fields]
    for one in panel.series:
        traces += _traces(one, linked)
    return {"data": traces, "layout": _layout(panel, linked)}


def encoded(values: ArrayLike) -> Any:
    """Numbers in a form that plotly reads: short arrays as a list, long ones as the bytes of 32-bit floats."""
    array = np.asarray(values, dtype=float)
    if array.ndim == 1 and array.size <= 12 and np.isfinite(array).all():
        return [float(f"{value:.7g}") for value in array]
    data = {"dtype": "f4", "bdata": base64.b64encode(array.astype("<f4").tobytes()).decode()}
    if array.ndim > 1:
        data["shape"] = ", ".join(str(length) for length in array.shape)
    return data


def thinned(x: Array, y: Array, buckets: int = BUCKETS) -> tuple[Array, Array]:
    """The first, least, greatest and last value of each part of a long line, and both ends of its gaps. Peaks and jumps remain."""
    if len(x) <= 4 * buckets:
        return x, y
    gaps = np.flatnonzero(np.diff(np.isnan(y)))
    keep = {*gaps, *(gaps + 1)}
    for start, end in itertools.pairwise(np.linspace(0, len(x), buckets + 1).astype(int)):
        part = y[start:end]
        # NaN is sorted to the end.
        order = np.argsort(part)
        keep |= {start, end - 1, start + order[0], start + order[np.isfinite(part).sum() - 1]}
    kept = np.array(sorted(keep))
    return x[kept], y[kept]


def _traces(one: Series, linked: bool) -> list[dict[str, Any]]:
    x, y = np.asarray(one.x, dtype=float), np.asarray(one.y, dtype=float)
    common = {"name": one.name, "opacity": one.opacity, "hoverinfo": "none"}
    if one.kind == "band":
        upper = np.asarray(one.upper, dtype=float)
        red, green, blue = (int(one.colour[k : k + 2], 16) for k in (1, 3, 5))
        edge = {"type": "scatter", "mode": "lines", "x": encoded(x), "opacity": 1.0, "line": {"width": 0.0}}
        filled = {"y": encoded(upper), "fill": "tonexty", "fillcolor": f"rgba({red},{green},{blue},{one.opacity})"}
        return [common | edge | {"y": encoded(y)}, common | edge | filled]
    if one.kind == "bars":
        return [common | _bars(one, x, y)]
    if one.kind == "line" and not one.marker:
        x, y = thinned(x, y)
    mode = "markers" if one.kind == "points" else "lines+markers" if one.marker else "lines"
    trace: dict[str, Any] = common | {"type": "scatter", "mode": mode, "x": encoded(x), "y": encoded(y)}
    if one.kind == "line":
        trace["line"] = {"color": one.colour, "width": one.width, "dash": one.dash or "solid"}
    if one.marker or one.kind == "points":
        trace["marker"] = {"color": one.colour, "size": one.size, "symbol": one.marker or "circle"}
        trace["marker"]["line"] = {"width": 1.3 if "open" in one.marker else 0.0, "color": one.colour}
    if one.texts is not None:
        # A point on the border is drawn whole.
        trace |= {"mode": f"{mode}+text", "text": list(one.texts), "textposition": list(one.text_sides), "cliponaxis": False}
        trace["textfont"] = {"size": 12, "color": one.colour}
    return [trace if linked else trace | _hover(one)]


def _hover(one: Series) -> dict[str, Any]:
    said: dict[str, Any] = {"hoverinfo": "all", "hovertemplate": "%{x:.4~g}: <b>%{y:.4~g}</b><extra>" + escape(one.name) + "</extra>"}
    if one.labels is not None:
        said |= {"customdata": list(one.labels), "hovertemplate": said["hovertemplate"].replace("%{x:.4~g}", "%{customdata}")}
    return said


def _bars(one: Series, x: Array, y: Array) -> dict[str, Any]:
    trace: dict[str, Any] = {"type": "bar", "x": encoded(x), "y": encoded(y), "marker": {"color": one.colour}}
    if one.bar_width is not None:
        trace["width"] = one.bar_width
    if one.hatched is not None and any(one.hatched):
        trace["marker"]["pattern"] = {"shape": ["/" if hatched else "" for hatched in one.hatched], "size": 6}
    if one.errors is not None:
        below, above = one.errors
        trace["error_y"] = {"type": "data", "symmetric": False, "array": encoded(above), "arrayminus": encoded(below)}
    return trace | _hover(one)


def _field(panel: Panel, one: Field) -> dict[str, Any]:
    trace: dict[str, Any] = {"type": "contour", "name": one.name, "showscale": not one.lines_only}
    trace |= {"x": encoded(one.x), "y": encoded(one.y), "z": encoded(one.values)}
    if one.levels is not None:
        start, end, size = one.levels
        trace |= {"autocontour": False, "contours": {"start": start, "end": end, "size": size}, "zmin": start, "zmax": end}
    if one.lines_only:
        trace["contours"] = trace.get("contours", {}) | {"coloring": "none", "showlabels": True}
        trace["line"] = {"width": 1.0, "color": MUTED}
        trace["hovertemplate"] = "%{x:.3~g}, %{y:.3~g}: <b>%{z:.4~g}</b><extra>" + escape(one.name) + "</extra>"
        return trace
    # The points have the values; between them the colours are interpolated.
    share = None if one.middle is None or one.levels is None else (one.middle - one.levels[0]) / (one.levels[1] - one.levels[0])
    trace |= {"hoverinfo": "skip", "colorscale": [list(stop) for stop in colour_stops(share)]}
    trace["colorbar"] = {"title": {"text": one.unit}}
    if one.ticks:
        trace["colorbar"] |= {"tickvals": [place for place, _ in one.ticks], "ticktext": [text for _, text in one.ticks]}
    return trace


def _axis(label: str, ticks: Sequence[Tick], span: tuple[float, float] | None, scale: str) -> dict[str, Any]:
    axis: dict[str, Any] = {"title": {"text": label}}
    if scale == "log":
        # Without a format plotly shows digits between powers of ten smaller.
        axis |= {"type": "log", "tickformat": "~g"}
        if not ticks and span is not None and span[1] / span[0] >= 30.0:
            axis["dtick"] = 1
    if span is not None:
        axis |= {"range": [float(v) for v in (np.log10(span) if scale == "log" else span)], "autorange": False}
    if ticks:
        axis |= {"tickmode": "array", "tickvals": [float(place) for place, _ in ticks], "ticktext": [text for _, text in ticks]}
    return axis


def around(values: Sequence[ArrayLike], margin: float = MARGIN) -> tuple[float, float]:
    """The range of all values with a margin."""
    every = np.concatenate([np.ravel(np.asarray(one, dtype=float)) for one in values])
    low, high = float(np.nanmin(every)), float(np.nanmax(every))
    return low - margin * (high - low), high + margin * (high - low)


def _layout(panel: Panel, linked: bool) -> dict[str, Any]:
    if panel.equal and panel.x_range is None and panel.scale == panel.x_scale == "linear":
        x, y = ([getattr(one, axis) for one in panel.series] for axis in "xy")
        panel = replace(panel, x_range=around(x), y_range=around(y))
    layout: dict[str, Any] = {
        "xaxis": _axis(panel.x_label, panel.x_ticks, panel.x_range, panel.x_scale),
        "yaxis": _axis(panel.y_label, panel.y_ticks, panel.y_range, panel.scale),
        "hovermode": "x" if linked else "closest", "hoverdistance": -1 if linked else 24,
        "barmode": "relative" if panel.stacked else "group",
        "margin": {}, "shapes": _shapes(panel), "annotations": _annotations(panel),
    }  # fmt: skip
    if linked:
        layout["margin"]["l"], layout["yaxis"]["automargin"] = 62, False  # The plot areas of all panels have the same left edge.
    if any(mark.label for mark in panel.marks) or any(shade.label for shade in panel.shades):
        layout["margin"]["t"] = 24
    if panel.equal:
        layout["yaxis"] |= {"scaleanchor": "x", "scaleratio": 1}
        layout["xaxis"]["showgrid"] = layout["yaxis"]["showgrid"] = False
    return layout


def _shapes(panel: Panel) -> list[dict[str, Any]]:
    along, across = {"xref": "x", "yref": "paper", "y0": 0, "y1": 1}, {"xref": "paper", "yref": "y", "x0": 0, "x1": 1}
    shaded = {"type": "rect", "line": {"width": 0}, "layer": "below", **along}
    marked = {"type": "line", "line": {"color": INK, "width": 0.8}, "opacity": 0.35, **along}
    return [
        *(shaded | {"x0": float(s.start), "x1": float(s.end), "fillcolor": s.colour, "opacity": s.opacity} for s in panel.shades),
        *(marked | {"x0": float(m.x), "x1": float(m.x)} for m in panel.marks),
        *(across | {"type": "line", "y0": float(v.y), "y1": float(v.y), "line": {"color": v.colour, "width": 1, "dash": "dash"}} for v in panel.levels),
    ]  # fmt: skip


def _annotations(panel: Panel) -> list[dict[str, Any]]:
    narrow = 0.03 * (panel.x_range[1] - panel.x_range[0]) if panel.x_range else 0.0
    above, beside = {"xref": "x", "yref": "paper", "y": 1, "yshift": 1}, {"xref": "paper", "x": 1, "xanchor": "right", "yref": "y"}
    white = {"bgcolor": INK, "borderpad": 2, "font": {"color": "#ffffff"}}
    shades = [s for s in panel.shades if s.label and s.end - s.start > narrow]
    found = [above | {"text": s.label, "x": 0.5 * float(s.start + s.end)} for s in shades]
    found += [above | white | {"text": m.label, "x": float(m.x)} for m in panel.marks if m.label]
    for level in filter(lambda level: level.label, panel.levels):
        place = float(np.log10(level.y) if panel.scale == "log" else level.y)
        found.append(beside | {"text": level.label, "y": place, "font": {"color": level.colour}})
    return found
