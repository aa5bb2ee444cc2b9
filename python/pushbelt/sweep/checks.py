"""Checks of the steady states of every study."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from pushbelt.fmu.geometry import Array
from pushbelt.report.page import Check

from .maps import Results, in_rpm
from .study import AXES

ROUGHEST = 10
"""Number of listed spots."""
AXIS = {name: place for place, name in enumerate(AXES)}


@dataclass(frozen=True)
class Spot:
    """A point that deviates from linear interpolation of its neighbours."""

    where: str
    quantity: str
    value: float
    expected: float
    """Value interpolated between its two neighbours along an axis."""
    axis: str

    @property
    def share(self) -> float:
        """Relative deviation from the expected value."""
        return self.value / self.expected - 1.0


def name_of(results: Results, place: Sequence[int]) -> str:
    """Description of a point."""
    grid = results.grid
    force, friction, speed, ratio, utilisation = place
    return (
        f"ratio {grid.ratio[ratio]:.3g}, utilisation {grid.utilisation[utilisation]:g}, μ {grid.friction[friction]:g}, "
        f"{in_rpm(grid.speed[speed]):.0f} rpm" + (f", {grid.force[force]:.0f} N" if len(grid.force) > 1 else "")
    )


def of_all(column: Callable[[str], Array], steady: np.ndarray) -> tuple[tuple[str, Array, float], ...]:
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


def evaluate(results: Results) -> list[Check]:
    """All checks."""
    carried = results.steady & (results["macroSlip"] == 0.0)
    torque = np.broadcast_to(np.array(results.grid.utilisation) >= 0.0, carried.shape)

    def where(points: np.ndarray, values: Array) -> Array:
        return np.where(points, values, np.nan)

    driving = results.steady & torque
    return [
        _falls(results, "Thrust ratio falls from overdrive to underdrive", where(carried, -results["thrustRatio"]), "ratio"),
        _falls(results, "Slip grows with torque utilisation", where(driving, results["slip"]), "utilisation"),
        _single_peak(results, where(driving, results["efficiency"])),
        *(_at_most(results, *one) for one in of_all(results.__getitem__, results.steady)),
        _no_holes(results),
    ]


def _check(results: Results, statement: str, wrong: np.ndarray, asked: int, found: str = "") -> Check:
    """A check that fails if `wrong` is true at any point. The first such points are listed."""
    places = np.argwhere(wrong)
    named = "; ".join(name_of(results, place) for place in places[:3])
    count = f"{asked - len(places)} of {asked}"
    return Check(
        statement, not len(places), ", ".join(filter(None, [count, found])) + (f". Not: {named}" if named else "")
    )


def _falls(results: Results, statement: str, values: Array, axis: str) -> Check:
    """Check that values ascend along an axis."""
    along = AXIS[axis]
    steps = np.diff(values, axis=along)
    wrong = np.zeros(values.shape, dtype=bool)
    np.moveaxis(wrong, along, 0)[1:] = np.moveaxis(steps <= 0.0, along, 0)
    return _check(results, statement, wrong, int(np.isfinite(steps).sum()), "steps from point to point")


def _single_peak(results: Results, values: Array) -> Check:
    """Check that values have one maximum over the utilisation: no rise after a fall."""
    wrong = np.zeros(values.shape, dtype=bool)
    for place in np.ndindex(values.shape[:-1]):
        line = values[place]
        found = np.flatnonzero(np.isfinite(line))
        if found.size > 2:
            steps = np.diff(line[found])
            valley = np.flatnonzero((steps[:-1] < 0.0) & (steps[1:] > 0.0)) + 1
            wrong[(*place, found[valley])] = True
    lines = int(np.prod(values.shape[:-1]))
    statement = "Efficiency has one peak over the torque utilisation"
    return _check(results, statement, wrong, lines, "lines")


def _at_most(results: Results, statement: str, values: Array, limit: float) -> Check:
    values = np.where(results.steady, values, np.nan)
    worst = np.nanmax(values) if results.steady.any() else 0.0
    return _check(results, statement, values > limit, int(results.steady.sum()), f"at most {worst:.2g} %")


def _no_holes(results: Results) -> Check:
    """Check that every point below a utilisation with a steady state has one."""
    positive = np.array(results.grid.utilisation) >= 0.0
    steady = results.steady & positive
    beyond = np.flip(np.logical_or.accumulate(np.flip(steady, -1), -1), -1)
    wrong = ~results.steady & beyond & positive
    return _check(results, "If a utilisation has a steady state, all smaller ones have one", wrong, wrong.size)


def spots(results: Results) -> list[Spot]:
    """The points with the largest deviations from their neighbours along ratio and utilisation, worst first."""
    carried = results.steady & (results["macroSlip"] == 0.0)
    found = [
        spot
        for column, axis in (("thrustRatio", "ratio"), ("thrustRatio", "utilisation"), ("efficiency", "ratio"))
        for spot in _spots(results, column, axis, carried)
    ]
    return sorted(found, key=lambda spot: -abs(spot.share))[:ROUGHEST]


def _spots(results: Results, column: str, axis: str, carried: np.ndarray) -> Iterable[Spot]:
    grid = np.array(getattr(results.grid, axis))
    if len(grid) < 3:
        return
    x = np.log(grid) if axis == "ratio" else grid
    values = np.moveaxis(np.where(carried, results[column], np.nan), AXIS[axis], -1)
    share = (x[1:-1] - x[:-2]) / (x[2:] - x[:-2])
    expected = (1.0 - share) * values[..., :-2] + share * values[..., 2:]
    distance = np.abs(values[..., 1:-1] / expected - 1.0)
    for flat in np.argsort(-np.nan_to_num(distance, nan=-1.0), axis=None)[:ROUGHEST]:
        inner = np.unravel_index(flat, distance.shape)
        if not np.isfinite(distance[inner]):
            continue
        moved = [*inner[:-1], inner[-1] + 1]
        place = list(moved[:-1])
        place.insert(AXIS[axis], moved[-1])
        yield Spot(name_of(results, place), column, float(values[tuple(moved)]), float(expected[inner]), axis)
