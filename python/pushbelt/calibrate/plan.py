"""What to measure next: working points that narrow the intervals of the fitted parameters, by optimal design.

A place adds JᵀJ of what would be measured there to the information of the table and the priors. The plan minimises the sum of the relative widths to
the eighth power, which the widest one rules, in the mean over the loss of any one point. So no interval depends on a single place.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import t as student

from pushbelt import tables
from pushbelt.errors import ArgumentError
from pushbelt.fmu.data import torque_capacity
from pushbelt.fmu.geometry import Array
from pushbelt.maps.plan import MARGIN, stops
from pushbelt.tables.columns import CONDITIONS, QUANTITIES, SHIFTS
from pushbelt.tables.points import Measured, Point
from pushbelt.tables.units import usual

from . import fit
from .model import Model
from .parameters import Pair, Parameter, assign

STEADY = [quantity for quantity in QUANTITIES if quantity not in SHIFTS]
RATIO, SPEED, TORQUE, FORCE = CONDITION = ("ratio.geometric", "primary.speed", "primary.torque", "secondary.clampingForce")
LEVELS: Mapping[str, int] = {RATIO: 5, SPEED: 3, TORQUE: 7, FORCE: 2}  # Numbers of values of a condition among the places
USED = 0.9  # Largest share of the belt's capacity at a place
LEAST = 0.05  # Least share of the capacity, if there are no limits of the torque
WIDTH = 0.05
"""Half-width of the differences, in a parameter's coordinate. Where slopes change within it, as at a jump, the smaller counts."""
SAME = 0.05  # Relative difference of all conditions up to which two places are the same


class Plan(NamedTuple):
    points: list[Point]  # The most useful first; the name is that of the parameter whose interval widens most without the point
    widths: Mapping[str, tuple[float, float, float]]
    """Relative half-width of each parameter's expected interval before, after, and at most without one of the points; infinite without one."""
    unseen: list[str]  # Parameters that no place within the limits determines


def limits(given: Mapping[str, Pair], values: Mapping[str, float], table: Sequence[Point]) -> dict[str, Pair]:
    """Ranges of the conditions, SI: the given ones, else those of a table, else of the ratio between the end stops. The torque may have none. `values`
    are parameters of the variator. Raises ArgumentError for a range that is missing, or does not ascend within what is possible."""
    ends = stops(values)
    found: dict[str, Pair] = {RATIO: (ends[0] * MARGIN, ends[1] / MARGIN)}
    if table:
        found = {name: (own.min(), own.max()) for name, own in zip(CONDITION, _conditions(table).T, strict=True)}
    found |= given
    if unknown := given.keys() - set(CONDITION):
        raise ArgumentError(f"--within {unknown.pop()}: limits are those of {', '.join(CONDITION)}")
    if missing := [name for name in (SPEED, FORCE) if name not in found]:
        raise ArgumentError(f"there are no limits of {' and '.join(missing)}: add a table, or --within {missing[0]}=LOW:HIGH")
    for name, (least, most) in given.items():
        column = CONDITIONS[name]
        low, high = ends if name == RATIO else (column.low, column.high)
        if not low <= least <= most <= high:
            unit = usual(column.dimension)[0]
            raise ArgumentError(f"--within {name}={least:g}:{most:g} is no ascending range within {low:.4g} to {high:.4g} {unit}")
    return found


def _conditions(points: Sequence[Point]) -> Array:
    return np.array([(point.ratio or point.speed_ratio, point.speed, point.torque, point.force) for point in points], dtype=float).reshape(-1, 4)


def candidates(within: Mapping[str, Pair], values: Mapping[str, float], table: Sequence[Point]) -> list[Point]:
    """Places within the limits, up to `USED` of the torque capacity, that are not in the table. What is measured there are the quantities of the
    table, with their median standard deviations, NaN for assumed ones; without a table all. Raises ArgumentError if there is no place."""
    known = [one for point in table for one in point.measured]
    wanted = [q for q in STEADY if any(one.quantity == q for one in known)] or STEADY
    own = {q: [one.deviation for one in known if one.quantity == q and one.given] for q in wanted}
    measured = tuple(Measured(q, math.nan, float(np.median(sds or [math.nan])), bool(sds)) for q, sds in own.items())
    axes = (np.unique(space(*within[name], LEVELS[name])) for name, space in ((RATIO, np.geomspace), (SPEED, np.linspace), (FORCE, np.geomspace)))
    taken, found = _conditions(table), []
    for ratio, speed, force in itertools.product(*axes):
        capacity = torque_capacity(values, ratio, force)
        low, high = within.get(TORQUE, (LEAST * capacity, math.inf))
        low, high = max(low, -USED * capacity), min(high, USED * capacity)
        for torque in np.unique(np.linspace(low, high, LEVELS[TORQUE])) if low <= high else ():
            place = (ratio, speed, torque, force)
            if not np.any(np.all(np.abs(taken - place) <= SAME * np.abs(place), axis=1)):
                found.append(Point(0, "", ratio, None, speed, torque, force, None, measured))
    if not found:
        raise ArgumentError(f"no place within the limits has a torque below {100.0 * USED:.0f} % of the capacity")
    return found


def plan(model: Model, known: int, parameters: Sequence[Parameter], values: Mapping[str, float], count: int) -> Plan:
    """The best `count` of the places. The first `known` points of the model are those of the table, the others places, of which those count
    that use at most `USED` of the belt's capacity. `values` are parameters of the variator. Raises ArgumentError if there are too few
    places, or if they determine none of the parameters."""
    at = np.array([parameter.coordinate(parameter.start) for parameter in parameters])
    states = model.states(assign(parameters, at))
    assumed = [QUANTITIES[q].assumed(value) if q in STEADY else np.nan for q, value in zip(model.values["quantity"], model.column(states), strict=True)]
    model.deviations = np.where(np.isnan(model.deviations), assumed, model.deviations)
    slopes, owner = model.slopes(parameters, {}, at, states, WIDTH), model.values["point"].to_numpy()
    priors = [parameter.start / parameter.prior[1] * (np.arange(len(at)) == k) for k, parameter in enumerate(parameters) if parameter.prior]
    before = np.vstack([slopes[owner < known], *priors])
    usable = []
    for place, (point, found) in enumerate(zip(model.points, states, strict=True)):
        # This capacity is that of the secondary pulley; the primary one carries the thrust ratio times as much.
        carried = USED * torque_capacity(values, point.ratio or 1.0, point.force) * min(found.values.get("thrustRatio", 0.0), 1.0)
        if place >= known and abs(point.torque) <= carried:
            usable.append(place)
    if len(usable) < count:
        why = f"{len(usable)} of {len(states) - known} places within the limits have a steady state below {100.0 * USED:.0f} % of the capacity"
        raise ArgumentError(f"{why}, fewer than the {count} planned points: widen --within")
    every = np.vstack([before, slopes[np.isin(owner, usable)]])
    weak = fit.weak_parameters(every)
    seen = [k for k in range(len(at)) if k not in weak]
    if halves(every[:, seen]).max() > fit.UNDETERMINED:
        raise ArgumentError(f"no place within the limits determines {' or '.join(parameter.name for parameter in parameters)}")
    before, slopes, names = before[:, seen], slopes[:, seen], [parameters[k].name for k in seen]
    information = np.array([slopes[owner == place].T @ slopes[owner == place] for place in usable])
    # A parameter of which nothing is known is uncertain by its own size.
    start = before.T @ before + np.eye(len(seen)) / fit.UNDETERMINED**2
    chosen = _exchanged(start, information, count)
    total = start + information[chosen].sum(axis=0)
    without = np.diagonal(np.linalg.inv(total - information[chosen]), axis1=1, axis2=2)
    serves = np.argmax(without / np.diag(np.linalg.inv(total)), axis=1)
    points = [replace(model.points[usable[chosen[k]]], name=names[serves[k]]) for k in np.argsort(-without.sum(axis=1), kind="stable")]
    rows = [slopes[owner == usable[place]] for place in chosen]
    lost = np.max([halves(np.vstack([before, *rows[:k], *rows[k + 1 :]])) for k in range(count)], axis=0)
    widths = zip(halves(before).tolist(), halves(np.vstack([before, *rows])).tolist(), lost.tolist(), strict=True)
    return Plan(points, dict(zip(names, widths, strict=True)), [parameters[k].name for k in sorted(weak)])


def halves(slopes: Array) -> Array:
    """Half-widths of the expected intervals, in coordinates."""
    freedom = len(slopes) - slopes.shape[1]
    if freedom < 1:
        return np.full(slopes.shape[1], np.inf)
    return student.ppf(0.5 + 0.5 * fit.CONFIDENCE, freedom) * np.sqrt(np.diag(fit.covariance(slopes)[0]))


def _exchanged(start: Array, information: Array, count: int) -> list[int]:
    """Indices of the best places: each is exchanged for a better one until there is none (Fedorov)."""
    chosen: list[int] = np.linspace(0, len(information) - 1, count).round().astype(int).tolist()
    before: list[int] = []
    while chosen != before:
        before = list(chosen)
        for k in range(count):
            rest = chosen[:k] + chosen[k + 1 :]
            free = np.setdiff1d(np.arange(len(information)), rest)
            total = start + information[rest].sum(axis=0)
            # The plan with the new point, and the plan without each of the others.
            left = np.stack([total, *(total - information[rest])])
            cost = (np.diagonal(np.linalg.inv(left[:, None] + information[free]), axis1=2, axis2=3) ** 4).sum(axis=(0, 2))
            if cost.min() < (1.0 - 1e-9) * cost[free == chosen[k]][0]:
                chosen[k] = int(free[np.argmin(cost)])
    return chosen


def write(found: Plan, path: Path) -> list[str]:
    """Writes the plan as a table of `calibrate` with empty cells for what is measured. Returns the lines about the intervals, with which it begins."""
    served, measured = [point.name for point in found.points], found.points[0].measured
    lines = []
    for name, three in found.widths.items():
        before, after, lost = (f"±{100.0 * half:.3g} %" if half <= fit.UNDETERMINED else "not determined" for half in three)
        lines.append(f"{name}: {before} → {after}, {served.count(name)} points; {lost} without one point")
    lines += [f"{name}: not identified at any place within the limits" for name in found.unseen]
    names = [*CONDITION, *(one.quantity + end for one in measured for end in ("", ".sd")[: 1 + one.given])]
    units = {name: usual(CONDITIONS[name].dimension)[0] if name in CONDITION else "1" for name in names}
    cells = [cell for one in measured for cell in ("", one.deviation)[: 1 + one.given]]
    rows = [[f"{k} {name}", *row, *cells] for k, (name, row) in enumerate(zip(served, _conditions(found.points).tolist(), strict=True), 1)]
    about = "Expected half-widths of the 95 % intervals before, after and without one point; a name has the parameter that the point serves."
    remark = "\n# ".join([about, *lines])
    tables.write(path, ["name", *tables.titles(names, units)], rows, digits=5, remark=remark)
    return lines
