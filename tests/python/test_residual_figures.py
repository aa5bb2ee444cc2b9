"""Residuals of calibrations and hold-outs: an outlier does not squeeze the other points."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pushbelt.calibrate.figures import chart as figures
from pushbelt.calibrate.figures import reach
from pushbelt.calibrate.model import Model
from pushbelt.calibrate.worker import Found
from pushbelt.report import charts
from pushbelt.report.charts import Panel
from pushbelt.tables.points import Measured, Point

ERRORS = np.array([0.4, -1.0, 0.7, 1.5, -2.2, 0.1, -0.6, 1.1, 0.9, -0.3])


def points(errors: np.ndarray, fifth: float | None = None) -> pd.DataFrame:
    """Thrust ratios with errors in standard deviations; the fifth one may be measured as something else."""
    found = np.linspace(0.8, 1.4, len(errors))
    measured = found - 0.01 * errors
    if fifth is not None:
        measured[4] = fifth
    rows = [Point(k, "", 0.5 + 0.1 * k, None, 1.0, 10.0 * k, 1.0, None, (Measured("thrustRatio", m, 0.01, True),)) for k, m in enumerate(measured)]
    return Model(rows, list).rows([Found({"thrustRatio": f}) for f in found])


def arrows(panel: Panel) -> list[tuple[str, str, float, float]]:
    """Marker, text and place of the marked points."""
    return [(one.marker, *values) for one in panel.series if one.texts for values in zip(one.texts, one.x, one.y, strict=True)]


def test_an_outlier_is_at_the_border_with_its_value_and_the_axes_fit_the_others() -> None:
    sound, (compared, torque, ratio) = (figures("thrustRatio", {"fitted": points(ERRORS, fifth)}).panels for fifth in (None, 8.0))
    assert compared.x_range[1] < 1.6 and compared.y_range[1] < 1.6
    ((*shown, x, _),) = arrows(compared)
    assert shown == ["triangle-right", "8, model 1.07"] and x == pytest.approx(compared.x_range[1], abs=0.03 * np.ptp(compared.x_range))
    for panel, other in ((torque, sound[1]), (ratio, sound[2])):
        assert panel.x_range == other.x_range and panel.y_range == pytest.approx(other.y_range, rel=0.2)
        ((*shown, _, y),) = arrows(panel)
        assert shown == ["triangle-down", "\N{MINUS SIGN}693"] and y == pytest.approx(0.96 * panel.y_range[0])
    assert not any(map(arrows, sound))
    # The outlier is nowhere among the other points.
    inside = [y for one in torque.series if one.kind == "points" and not one.texts for y in one.y]
    assert len(inside) == 9 and max(map(abs, inside)) <= torque.y_range[1]


@pytest.mark.parametrize(("errors", "expected"), [(ERRORS, 3.0), (4.0 * ERRORS, 8.8), (np.append(ERRORS, [55.0, -40.0]), 3.0)])
def test_the_reach_is_that_of_the_bulk(errors: np.ndarray, expected: float) -> None:
    assert reach(points(errors)) == pytest.approx(expected)


def test_the_other_set_does_not_determine_the_axes_but_is_counted() -> None:
    chart = figures("slip", {"fitted": points(ERRORS), "start values": points(ERRORS + 60.0)})
    assert chart.panels[0].x_range == figures("slip", {"fitted": points(ERRORS)}).panels[0].x_range
    assert all("10 values of start values are outside" in panel.note for panel in chart.panels[1:])
    assert [one.name for one in chart.panels[1].series] == ["within 2", "start values", "fitted"]
    charts.html(chart)
