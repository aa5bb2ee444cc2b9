"""Checks of the steady states of every study."""

from __future__ import annotations

import numpy as np
import xarray
from xarray import DataArray

from pushbelt.report.page import Check
from pushbelt.report.style import RPM

from .study import AXES


def names_of(results: xarray.Dataset, points: DataArray) -> list[str]:
    """Descriptions of the points at which a mask is true."""
    if "point" in results.dims:
        return [f"point {number}" for number in points.point.values[points.values]]
    places = points.transpose(*AXES).stack(place=list(AXES))
    force = ", {force:.0f} N" if results.sizes["force"] > 1 else ""
    text = "ratio {ratio:.3g}, utilisation {utilisation:g}, μ {friction:g}, {rpm:.0f} rpm" + force
    values = (dict(zip(AXES, at, strict=True)) for at in places.place.values[places.values])
    return [text.format(**at, rpm=RPM * at["speed"]) for at in values]


def evaluate(results: xarray.Dataset) -> list[Check]:
    steady, held = results.steady, results.macroSlip == 0.0
    power = np.maximum(results["primary.power"], results["secondary.power"])
    # Powers are those of the belt, so they exclude the drag of the shafts.
    gap = results["primary.power"] + results["secondary.power"] - results["loss.total"] + results["loss.shafts"]
    limits = (
        ("Losses of the belt sum to its net power within 0.2 % of the driving power", (gap / power).where(power > 1.0, 0.0), 0.2),
        # With saturated friction a small change of load is a large change of slip, so these points are excluded.
        ("Steady states are stationary: thrust ratio constant over a step of 1 ms within 0.01 %", results.drift.where(held, 0.0), 0.01),
    )
    found = []
    for statement, values, limit in limits:
        inside = 100.0 * abs(values).where(steady)
        worst = float(inside.max()) if steady.any() else 0.0
        found.append(_check(results, statement, inside > limit, int(steady.sum()), f"at most {worst:.2g} %"))
    return found if "point" in results.dims else [*found, *_of_grid(results)]


def _of_grid(results: xarray.Dataset) -> list[Check]:
    steady, positive = results.steady, results.utilisation >= 0.0
    driving = steady & positive

    def ascends(statement: str, values: DataArray, axis: str) -> Check:
        steps = values.diff(axis)
        return _check(results, statement, steps <= 0.0, int(steps.notnull().sum()), "steps from point to point")

    # Every point below a utilisation with a steady state has one.
    backwards = {"utilisation": slice(None, None, -1)}
    beyond = driving.isel(backwards).cumsum("utilisation").isel(backwards) > 0
    carried = results.thrustRatio.where(steady & (results.macroSlip == 0.0))
    # Below a value on either side.
    efficiency = results.efficiency.where(driving).transpose(*AXES)
    up, down = (np.fmax.accumulate(efficiency.values[..., ::way], axis=-1)[..., ::way] for way in (1, -1))
    valleys = efficiency < np.fmin(up, down)
    hole = "If a utilisation has a steady state, all smaller ones have one"
    return [
        ascends("Thrust ratio falls from overdrive to underdrive", -carried, "ratio"),
        ascends("Slip grows with torque utilisation", results.slip.where(driving), "utilisation"),
        _check(results, "Efficiency has one peak over the torque utilisation", valleys, int(driving.sum()), "points"),
        _check(results, hole, ~steady & beyond & positive, steady.size),
    ]


def _check(results: xarray.Dataset, statement: str, wrong: DataArray, asked: int, found: str = "") -> Check:
    """A check that fails if `wrong` is true at any point. The first such points are listed."""
    places = names_of(results, wrong)
    text = ", ".join(filter(None, [f"{asked - len(places)} of {asked}", found]))
    return Check(statement, not places, text + (f". Not: {'; '.join(places[:3])}" if places else ""))
