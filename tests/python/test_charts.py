"""The figures of the reports: data in the page, the belt's animation, and maps over ratio and utilisation with the capacity as border."""

import base64
import itertools
import json
import re

import numpy as np
import plotly.graph_objects as go
import pytest
import sample_maps

from pushbelt.fmu import data
from pushbelt.fmu.geometry import Array, theta_of
from pushbelt.fmu.results import BeltState, Profile
from pushbelt.maps import report
from pushbelt.maps.panels import Quantity, levels_of, middle_of, panel
from pushbelt.report import belt_view, charts, page, style
from pushbelt.report.charts import Chart, Field, Level, Mark, Panel, Series, Shade
from pushbelt.sweep.report import carried

BENCH = data.parameter_set("bench168")

# Colour vision with one kind of cone missing, in linear RGB (Machado, Oliveira, Fernandes 2009, severity 1).
SIGHT = {
    "all cones": np.eye(3),
    "no M cones": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "no L cones": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "no S cones": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
RATIO, UTILISATION = np.array([0.5, 1.0, 2.0]), np.linspace(-0.9, 0.9, 13)
CAPACITY = np.array([[-0.95, -0.7, -np.nan], [0.8, 0.95, 2.0]])


def linear(colour: str) -> Array:
    share = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def lab(rgb: Array) -> Array:
    x, y, z = np.cbrt(XYZ @ np.clip(rgb, 0.0, 1.0) / np.array([0.9505, 1.0, 1.089]))
    return np.array([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


@pytest.mark.parametrize("sight", SIGHT)
def test_colours_differ_for_the_colour_blind(sight: str) -> None:
    names = ("BLUE", "ORANGE", "GREEN", "RED", "VIOLET", "INK", "MUTED")
    seen = {name: lab(np.array(SIGHT[sight]) @ linear(getattr(style, name))) for name in names}
    least = min((float(np.linalg.norm(seen[a] - seen[b])), a, b) for a, b in itertools.combinations(names, 2))
    assert least[0] > 20.0, least
    scale = [lab(np.array(SIGHT[sight]) @ linear(colour))[0] for colour in style.COLOUR_SCALE]
    assert (np.diff(scale) < -10.0).all()
    signed = [lab(np.array(SIGHT[sight]) @ linear(colour)) for colour in style.DIVERGING]
    assert (np.diff([one[0] for one in signed[:4]]) > 10.0).all() and (np.diff([one[0] for one in signed[3:]]) < -10.0).all()
    assert min(float(np.linalg.norm(a - b)) for a, b in zip(signed[:3], signed[:3:-1], strict=True)) > 20.0


def decoded(values: object) -> Array:
    if isinstance(values, list):
        return np.array(values, dtype=float)
    array = np.frombuffer(base64.b64decode(values["bdata"]), dtype="<f4").astype(float)
    return array.reshape([int(n) for n in values["shape"].split(",")]) if "shape" in values else array


EVERYTHING = Panel(
    "All kinds",
    [
        Series("line", [0.0, 1.0, 2.0], [1.0, 5.0, np.nan], dash="dash"),
        Series("points", [0.0, 1.0], [1.0, 2.0], kind="points", marker="x-thin-open", labels=["a", "b"], texts=["7", "8"],
               text_sides=["middle left", "middle right"]),
        Series("bars", [0.0, 1.0], [1.0, 2.0], kind="bars", hatched=[True, False], errors=([0.1, 0.1], [0.2, 0.2])),
        Series("band", [0.0, 1.0], [1.0, 2.0], kind="band", upper=[2.0, 3.0]),
    ],
    "x", "y",
    fields=[
        Field("map", [0.0, 1.0], [0.0, 1.0], [[1.0, 2.0], [3.0, np.nan]], levels=(1.0, 3.0, 0.5), ticks=((1.0, "1"),), unit="%", middle=2.0),
        Field("lines", [0.0, 1.0], [0.0, 1.0], [[1.0, 2.0], [3.0, 4.0]], lines_only=True),
    ],
    x_range=(0.0, 2.0), x_ticks=((0.0, "zero"),), shades=[Shade(0.0, 1.0, style.RED, "shade")], marks=[Mark(0.5, "1")],
    levels=[Level(2.0, "level")], equal=True,
)  # fmt: skip


@pytest.mark.parametrize("linked", [False, True])
@pytest.mark.parametrize("scale", ["linear", "log"])
def test_plotly_knows_every_setting(scale: str, linked: bool) -> None:
    """The Python package of plotly rejects properties that are not in its schema; the browser would ignore them."""
    figure = charts.panel_data(Panel(**{**EVERYTHING.__dict__, "scale": scale, "x_range": None}), linked)
    script = page._environment().get_template("charts.js.j2").render(dict.fromkeys(("ink", "muted", "grid"), style.INK))
    template = json.loads(re.search(r"const TEMPLATE = (.*?\n  });", script, re.DOTALL).group(1))
    assert len(go.Figure(data=figure["data"], layout={**figure["layout"], "template": template}).data) == 7


def test_axes_of_equal_scale_have_a_margin_around_the_lines() -> None:
    panel = Panel("Outline", [Series("a", [-2.0, 2.0], [-1.0, 1.0]), Series("b", [0.0], [1.5], kind="points")], equal=True)
    layout = charts.panel_data(panel)["layout"]
    assert layout["xaxis"]["range"] == pytest.approx([-2.24, 2.24])
    assert layout["yaxis"]["range"] == pytest.approx([-1.15, 1.65])


def test_colours_diverge_from_zero_wherever_it_is() -> None:
    for middle in (0.2, 0.5, 0.8):
        stops = dict(style.colour_stops(middle))
        assert stops[middle] == style.DIVERGING[3] and min(stops) == 0.0 and max(stops) == 1.0
    # Equal distances from zero have equally strong colours: the shorter side does not reach the darkest one.
    assert style.colour_stops(0.8)[-1][1] not in style.DIVERGING[-2:] and style.colour_stops(0.8)[0][1] == style.DIVERGING[0]
    assert [colour for _, colour in style.colour_stops()] == list(style.COLOUR_SCALE)


def test_a_chart_has_a_description_and_escapes_its_data() -> None:
    text = str(Chart([Panel("a < b", [Series("</script>", [0, 1], [2, 3])])], 'with "quotes"').__html__())
    assert 'aria-label="with &#34;quotes&#34;"' in text
    assert "a &lt; b" in text
    content = re.search(r'<script type="application/json">(.*?)</script>', text, re.DOTALL).group(1)
    trace = json.loads(content)["panels"][0]["data"][0]
    assert trace["name"] == "</script>"
    assert decoded(trace["y"]).tolist() == [2.0, 3.0]


def test_a_thinned_line_keeps_what_a_reader_sees() -> None:
    time = np.linspace(0.0, 10.0, 10001)
    values = np.sin(time)
    values[4321] = 7.0
    values[6000:6100] = values[8007] = np.nan
    x, y = charts.thinned(time, values)
    assert len(x) < 2500
    assert {x[0], x[-1]} == {0.0, 10.0}
    assert np.nanmax(y) == 7.0
    assert np.isnan(y[(x > 6.0005) & (x < 6.099)]).all()
    assert np.isnan(y[x == time[8007]]).tolist() == [True]
    known = np.isfinite(values) & (np.abs(time - time[4321]) > 0.02) & (np.abs(time - 6.05) > 0.07)
    solid = np.isfinite(y)
    assert np.interp(time[known], x[solid], y[solid]) == pytest.approx(values[known], abs=3e-3)


def test_offset_leads_from_the_reference_curve_to_the_belt() -> None:
    curve = data.curve_of(BENCH, theta_of(2.0))
    position = curve.length * np.arange(72) / 72
    none, outward = np.zeros(72), np.full(72, 1e-4)
    pitch = BENCH["belt.pitchOffset"]
    outputs = {f"{p}.radius": curve.radius(p) - pitch + 2e-4 for p in ("primary", "secondary")}
    offset = belt_view.belt_offset(BeltState(outputs, Profile(position, none, none, none, outward, none, none)), curve, pitch)
    assert set(np.round(offset, 9)) == {1e-4, 3e-4}


def slip() -> np.ndarray:
    """Slip over ratio × utilisation, %, NaN beyond the capacity."""
    table = np.tile(UTILISATION**3, (3, 1))
    low, high = (np.where(np.isnan(side), end, side)[:, None] for side, end in zip(CAPACITY, (-9.0, 9.0), strict=True))
    return np.where((low <= UTILISATION) & (high >= UTILISATION), table, np.nan)


def drawn(values: np.ndarray, levels: np.ndarray, at_border: np.ndarray | None = None) -> dict:
    kinds = {"solved": np.isfinite(values), "no steady state": ~np.isfinite(values)}
    return charts.panel_data(panel("a", Quantity("Slip", "slip", unit="%"), (RATIO, UTILISATION), values, levels, kinds, CAPACITY, at_border))


def test_the_colours_of_a_slip_of_both_signs_diverge_at_zero_and_have_a_unit() -> None:
    levels = levels_of(slip(), (-1.0, -0.5, -0.2, -0.1, 0.0, 0.1, 0.2, 0.5))
    (field,) = (one for one in drawn(slip(), levels)["data"] if one["type"] == "contour")
    middle = middle_of(levels)
    assert levels[middle] == 0.0 and field["colorbar"]["title"]["text"] == "%"
    assert dict(map(tuple, field["colorscale"]))[middle / (len(levels) - 1)] == style.DIVERGING[3]
    ticks = dict(zip(field["colorbar"]["ticktext"], field["colorbar"]["tickvals"], strict=True))
    assert ticks["0"] == middle and "\N{MINUS SIGN}0.2" in ticks
    one_sign = levels_of(np.abs(slip()), (0.0, 0.1, 0.2, 0.5))
    (field,) = (one for one in drawn(np.abs(slip()), one_sign)["data"] if one["type"] == "contour")
    assert [colour for _, colour in field["colorscale"]] == list(style.COLOUR_SCALE)


def test_the_capacity_is_the_border_of_the_colours() -> None:
    """The colours reach it, even between two points, and an area hides what is beyond."""
    values = slip()
    values[1, 6] = np.nan
    found = drawn(values, np.linspace(-3.0, 2.0, 11), np.array([[-3.0, -3.0, np.nan], [2.0, 2.0, np.nan]]))
    (field,) = (one for one in found["data"] if one["type"] == "contour")
    rows, z = (decoded(field[name]) for name in ("y", "z"))
    at = lambda k, u: float(np.interp(u, rows, z[:, k] / 2.0 - 3.0))  # noqa: E731
    assert at(0, 0.8) == pytest.approx(2.0, abs=1e-6), "the known value at the capacity"
    assert at(0, 0.45) == pytest.approx(0.45**3, abs=1e-6), "a solved point"
    assert at(1, -0.7) == pytest.approx(-3.0, abs=1e-6)
    assert rows.max() <= 0.9 + 0.15 + 1e-6, "at most one step beyond the points"
    assert np.isnan(z[np.abs(rows) < 0.05, 1]).all() and np.isfinite(z[np.abs(rows) < 0.05, 0]).all(), "a gap inside remains"
    lower, upper = (decoded(one["y"]) for one in found["data"] if one["name"] == "capacity")
    assert lower[:2] == pytest.approx([-0.95, -0.7]) and np.isnan(lower[2]) and upper == pytest.approx(CAPACITY[1])
    areas = [one for one in found["data"] if "fillcolor" in one]
    assert len(areas) == 2 and all(one["name"] == "" for one in areas), "the legend can't hide them"


def test_the_border_of_a_study_is_between_the_last_point_that_holds_and_the_next_one() -> None:
    utilisation = np.array([-1.0, -0.5, 0.0, 0.6, 1.2])
    holds = np.array([[0, 1, 1, 1, 0], [1, 1, 1, 1, 1], [0, 0, 1, 0, 0], [0, 0, 0, 0, 0]], dtype=bool)
    assert carried(utilisation, holds) == pytest.approx(np.array([[-0.75, np.nan, -0.25, np.nan], [0.9, np.nan, 0.3, np.nan]]), nan_ok=True)


def test_maps_end_at_their_own_capacity() -> None:
    maps = sample_maps.default_maps()
    maps.tables["valid"][...] = 1.0
    quantity = next(one for one in report.SHOWN if one.column == "slip")
    assert quantity.heading == "Slip (%)"
    (f, s), panels = (0, 0), report.contours([("", maps)], quantity).panels
    assert np.array([one.y for one in panels[0].series if one.name == "capacity"]) == pytest.approx(maps["capacity"][f, s].T)
