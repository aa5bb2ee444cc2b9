"""Maps over ratio and utilisation: units, colours about zero, the capacity as border."""

from __future__ import annotations

import numpy as np
import pytest
import sample_maps
from test_charts import decoded

from pushbelt.maps import report
from pushbelt.maps.panels import Border, Quantity, levels_of, middle_of, panel
from pushbelt.report import charts, style
from pushbelt.sweep.maps import carried

RATIO, UTILISATION = np.array([0.5, 1.0, 2.0]), np.linspace(-0.9, 0.9, 13)
CAPACITY = np.array([[-0.95, -0.7, -np.nan], [0.8, 0.95, 2.0]])


def slip() -> np.ndarray:
    """Slip over ratio × utilisation, %, NaN beyond the capacity."""
    table = np.tile(UTILISATION**3, (3, 1))
    low, high = (np.where(np.isnan(side), end, side)[:, None] for side, end in zip(CAPACITY, (-9.0, 9.0), strict=True))
    return np.where((low <= UTILISATION) & (high >= UTILISATION), table, np.nan)


def drawn(values: np.ndarray, border: Border, levels: np.ndarray) -> dict:
    kinds = {"solved": np.isfinite(values), "no steady state": ~np.isfinite(values)}
    found = panel("a", Quantity("Slip", "slip", unit="%"), (RATIO, UTILISATION), values, levels, kinds, border)
    return charts.panel_data(found)


def test_the_colours_of_a_slip_of_both_signs_diverge_at_zero_and_have_a_unit() -> None:
    levels = levels_of(slip(), (-1.0, -0.5, -0.2, -0.1, 0.0, 0.1, 0.2, 0.5))
    (field,) = (one for one in drawn(slip(), Border(CAPACITY), levels)["data"] if one["type"] == "contour")
    middle = middle_of(levels)
    assert levels[middle] == 0.0 and field["colorbar"]["title"]["text"] == "%"
    assert dict(map(tuple, field["colorscale"]))[middle / (len(levels) - 1)] == style.DIVERGING[3]
    ticks = dict(zip(field["colorbar"]["ticktext"], field["colorbar"]["tickvals"], strict=True))
    assert ticks["0"] == middle and "\N{MINUS SIGN}0.2" in ticks
    one_sign = levels_of(np.abs(slip()), (0.0, 0.1, 0.2, 0.5))
    (field,) = (one for one in drawn(np.abs(slip()), Border(CAPACITY), one_sign)["data"] if one["type"] == "contour")
    assert [colour for _, colour in field["colorscale"]] == list(style.COLOUR_SCALE)


def test_the_capacity_is_the_border_of_the_colours() -> None:
    """The colours reach it, even between two points, and an area hides what is beyond."""
    values = slip()
    values[1, 6] = np.nan
    border = Border(CAPACITY, np.array([[-3.0, -3.0, np.nan], [2.0, 2.0, np.nan]]))
    found = drawn(values, border, np.linspace(-3.0, 2.0, 11))
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
    lines = [one.y for one in panels[0].series if one.name == "capacity"]
    assert np.array(lines) == pytest.approx(maps["capacity"][f, s].T)
