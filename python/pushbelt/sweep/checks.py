"""Checks of the steady states of every study."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import xarray
from xarray import DataArray

from pushbelt.fmu.geometry import Array
from pushbelt.report.page import Check
from pushbelt.report.style import RPM

from .study import AXES

def name_of(results: xarray.Dataset, at: Mapping[str, float]) -> str:
    """Description of a point."""
    force = f", {at['force']:.0f} N" if results.sizes["force"] > 1 else ""
    return f"ratio {at['ratio']:.3g}, utilisation {at['utilisation']:g}, μ {at['friction']:g}, {RPM * at['speed']:.0f} rpm{force}"


def names_of(results: xarray.Dataset, points: DataArray) -> list[str]:
    """Descriptions of the points at which a mask is true."""
    places = points.transpose(*AXES).stack(point=list(AXES))
    return [name_of(results, dict(zip(AXES, at, strict=True))) for at in places.point.values[places.values]]


def of_all(column: Callable[[str], Array], steady: Array) -> tuple[tuple[str, Array, float], ...]:
    """What holds at every steady state: a statement, values in per cent, and their limit."""
    power = np.maximum(column("primary.power"), column("secondary.power"))
    # Powers are those of the belt, so they exclude the drag of the shafts.
    gap = column("primary.power") + column("secondary.power") - column("loss.total") + column("loss.shafts")
    with np.errstate(invalid="ignore", divide="ignore"):
        imbalance = 100.0 * np.abs(np.where(power > 1.0, gap / power, 0.0))
    # With saturated friction a small change of load is a large change of slip, so these points are excluded.
    drift = 100.0 * np.abs(np.where(steady & (column("macroSlip") == 0.0), column("drift"), 0.0))
    return (
        ("Losses of the belt sum to its net power within 0.2 % of the driving power", imbalance, 0.2),
        ("Steady states are stationary: thrust ratio constant over a step of 1 ms within 0.01 %", drift, 0.01),
    )


def evaluate(results: xarray.Dataset) -> list[Check]:
    """All checks."""
    steady, positive = results.steady, results.utilisation >= 0.0
    driving = steady & positive

    def ascends(statement: str, values: DataArray, axis: str) -> Check:
        steps = values.diff(axis)
        return _check(results, statement, steps <= 0.0, int(steps.notnull().sum()), "steps from point to point")

    def at_most(statement: str, values: Array, limit: float) -> Check:
        inside = results.thrustRatio.copy(data=values).where(steady)
        worst = float(inside.max()) if steady.any() else 0.0
        return _check(results, statement, inside > limit, int(steady.sum()), f"at most {worst:.2g} %")

    # Every point below a utilisation with a steady state has one.
    backwards = {"utilisation": slice(None, None, -1)}
    beyond = driving.isel(backwards).cumsum("utilisation").isel(backwards) > 0
    carried = results.thrustRatio.where(steady & (results.macroSlip == 0.0))
    hole = "If a utilisation has a steady state, all smaller ones have one"
    return [
        ascends("Thrust ratio falls from overdrive to underdrive", -carried, "ratio"),
        ascends("Slip grows with torque utilisation", results.slip.where(driving), "utilisation"),
        _single_peak(results, results.efficiency.where(driving)),
        *(at_most(*one) for one in of_all(lambda name: results[name].values, steady.values)),
        _check(results, hole, ~steady & beyond & positive, steady.size),
    ]


def _check(results: xarray.Dataset, statement: str, wrong: DataArray, asked: int, found: str = "") -> Check:
    """A check that fails if `wrong` is true at any point. The first such points are listed."""
    places = names_of(results, wrong)
    text = ", ".join(filter(None, [f"{asked - len(places)} of {asked}", found]))
    return Check(statement, not places, text + (f". Not: {'; '.join(places[:3])}" if places else ""))


def _single_peak(results: xarray.Dataset, values: DataArray) -> Check:
    """Check that values have one maximum over the utilisation: no rise after a fall."""
    wrong = xarray.zeros_like(values, dtype=bool)
    lines, marks = (one.values.reshape(-1, values.sizes["utilisation"]) for one in (values, wrong))
    for line, mark in zip(lines, marks, strict=True):
        found = np.flatnonzero(np.isfinite(line))
        steps = np.diff(line[found])
        mark[found[np.flatnonzero((steps[:-1] < 0.0) & (steps[1:] > 0.0)) + 1]] = True
    return _check(results, "Efficiency has one peak over the torque utilisation", wrong, len(lines), "lines")
