"""What to measure next: working points that narrow the intervals of the fitted parameters, by optimal design.

A place adds JᵀJ of what would be measured there to the information of the table and the priors. The plan minimises the sum of the squared relative
widths (A-optimal), which is ruled by the widest interval, in the mean over the loss of each one of its points. So no interval depends on one place.
"""

from __future__ import annotations

import itertools
import math
import sys
from argparse import Namespace
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import t as student

from pushbelt import tables
from pushbelt.errors import PushbeltError
from pushbelt.fmu.data import parameter_set, torque_capacity
from pushbelt.fmu.geometry import Array
from pushbelt.maps.plan import MARGIN, stops
from pushbelt.report.page import short
from pushbelt.tables.columns import CONDITIONS, QUANTITIES, SHIFTS
from pushbelt.tables.points import Measured, Point
from pushbelt.tables.units import usual

from . import fit, model
from .model import Model
from .parameters import Pair, Parameter, assign

RATIO, SPEED, TORQUE, FORCE = CONDITION = ("ratio.geometric", "primary.speed", "primary.torque", "secondary.clampingForce")
LEVELS: Mapping[str, int] = {RATIO: 5, SPEED: 3, TORQUE: 7, FORCE: 2}  # Numbers of values of a condition among the places
USED = 0.9  # Largest share of the belt's capacity at a place
LEAST = 0.05  # Least share of the capacity, unless there are limits of the torque
WIDTH = 0.05
"""Half-width of the differences, in a parameter's coordinate. A place whose slopes change within it, as near a jump of the steady state, counts with
the smaller slopes."""
SAME = 0.05  # Relative difference of all conditions below which two places are the same
SOLUTION = 0.03  # Processor time of a steady state of a place, s


class PlanError(PushbeltError, ValueError):
    """Nothing can be planned. The message has the reason."""


class Plan(NamedTuple):
    points: list[Point]  # The most useful first; a name has the parameter whose interval widens most without the point
    before: Mapping[str, float]  # Relative half-width of each parameter's expected interval with the table and the priors; infinite without any
    after: Mapping[str, float]  # The same with the planned points
    unseen: list[str]  # Parameters that no place within the limits determines


def limits(given: Mapping[str, Pair], values: Mapping[str, float], table: Sequence[Point]) -> dict[str, Pair]:
    """Ranges of the conditions, SI: the given ones, else those of a table, else for the ratio between the end stops. Without a table the torque has
    none, and its range is a share of the capacity. `values` are parameters of the variator. Raises PlanError for a range that is not ascending or not
    on the variator, or that is missing."""
    low, high = stops(values)
    possible = {name: (CONDITIONS[name].low, CONDITIONS[name].high) for name in CONDITION} | {RATIO: (low, high)}
    found: dict[str, Pair] = {RATIO: (low * MARGIN, high / MARGIN)}
    if table:
        rows = np.array([(point.ratio or point.speed_ratio, point.speed, point.torque, point.force) for point in table], dtype=float)
        found = {name: (own.min(), own.max()) for name, own in zip(CONDITION, rows.T, strict=True)}
    for name, (least, most) in given.items():
        if name not in possible:
            raise PlanError(f"--within {name}: limits are those of {', '.join(CONDITION)}")
        low, high = possible[name]
        if not low <= least <= most <= high:
            raise PlanError(f"--within {name}={least:g}:{most:g} is no ascending range within {low:.4g} to {high:.4g} {usual(CONDITIONS[name].dimension)[0]}")
    found |= given
    if missing := [name for name in (SPEED, FORCE) if name not in found]:
        raise PlanError(f"there are no limits of {' and '.join(missing)}: add a table, or --within {missing[0]}=LOW:HIGH")
    return found


def candidates(within: Mapping[str, Pair], values: Mapping[str, float], table: Sequence[Point], share: float = USED) -> list[Point]:
    """Places within the limits, up to a share of the torque capacity, that are not in the table. They have the quantities of the table with their
    median standard deviations, NaN for the assumed ones."""
    stated = [one for point in table for one in point.measured if one.quantity in QUANTITIES and one.quantity not in SHIFTS]
    wanted = [q for q in QUANTITIES if q not in SHIFTS and (not stated or any(one.quantity == q for one in stated))]
    own = {q: [one.deviation for one in stated if one.quantity == q and one.given] or [math.nan] for q in wanted}
    measured = tuple(Measured(q, math.nan, float(np.median(all_)), not math.isnan(all_[0])) for q, all_ in own.items())
    known = np.array([(point.ratio or point.speed_ratio, point.speed, point.torque, point.force) for point in table], dtype=float).reshape(-1, 4)

    def places() -> Iterator[tuple[float, float, float, float]]:
        grid = (np.unique(space(*within[name], LEVELS[name])) for name, space in ((RATIO, np.geomspace), (SPEED, np.linspace), (FORCE, np.geomspace)))
        for ratio, speed, force in itertools.product(*grid):
            capacity = torque_capacity(values, ratio, force)
            low, high = within.get(TORQUE, (LEAST * capacity, math.inf))
            ends = max(low, -share * capacity), min(high, share * capacity)
            if ends[0] <= ends[1]:
                yield from ((ratio, speed, torque, force) for torque in np.unique(np.linspace(*ends, LEVELS[TORQUE])))

    new = (place for place in places() if not np.any(np.all(np.abs(known - place) <= SAME * np.abs(place), axis=1)))
    return [Point(0, "", ratio, None, speed, torque, force, None, measured) for ratio, speed, torque, force in new]


def plan(opened: Model, known: int, parameters: Sequence[Parameter], values: Mapping[str, float], count: int, share: float = USED) -> Plan:
    """The best `count` of the places. The first `known` points of the model are those of the table, the others the places; `values` are all parameters
    of the variator; a place uses at most this share of the belt's capacity. Raises PlanError if there are too few places, or if they determine no
    parameter."""
    at = np.array([parameter.coordinate(parameter.start) for parameter in parameters])
    (states,) = opened.states([assign(parameters, at)])
    assumed = [QUANTITIES[q].assumed(value) if q in QUANTITIES else value for q, value in zip(opened.values["quantity"], opened.column(states), strict=True)]
    opened.deviations = np.where(np.isnan(opened.deviations), assumed, opened.deviations)
    slopes, owner = opened.slopes(parameters, {}, at, states, WIDTH), opened.values["point"].to_numpy()

    def carried(place: int) -> bool:
        """Whether both pulleys carry the torque with a reserve; the primary one carries the thrust ratio times as much."""
        point, found = opened.points[place], states[place]
        capacity = torque_capacity(values, point.ratio or 1.0, point.force) * min(found.values.get("thrustRatio", 0.0), 1.0)
        return found.reason is None and abs(point.torque) <= share * capacity

    usable = [place for place in range(known, len(states)) if carried(place)]
    if len(usable) < count:
        limit = f"a steady state at a torque of at most {100.0 * share:.0f} % of the capacity"
        raise PlanError(f"{len(usable)} of {len(states) - known} places within the limits have {limit}; {count} are to be planned: widen --within")
    priors = [parameter.start / parameter.prior[1] * (np.arange(len(at)) == k) for k, parameter in enumerate(parameters) if parameter.prior]
    before = np.vstack([slopes[owner < known], *priors])
    every = np.vstack([before, slopes[np.isin(owner, usable)]])
    weak = fit._weak(every)
    seen = [k for k in range(len(at)) if k not in weak]
    if _halves(every[:, seen]).max() > fit.UNDETERMINED:
        raise PlanError(f"no place within the limits determines {' or '.join(parameter.name for parameter in parameters)}: widen --within")
    before, slopes = before[:, seen], slopes[:, seen]
    information = np.array([slopes[owner == place].T @ slopes[owner == place] for place in usable])
    # Before anything is known a parameter is uncertain by its own size.
    total = before.T @ before + np.eye(len(seen)) / fit.UNDETERMINED**2
    chosen = _exchanged(total, information, count)
    total = total + information[chosen].sum(axis=0)
    without = np.diagonal(np.linalg.inv(total - information[chosen]), axis1=1, axis2=2)
    serves = np.argmax(without / np.diag(np.linalg.inv(total)), axis=1)
    names = [parameters[k].name for k in seen]
    points = [replace(opened.points[usable[chosen[k]]], name=names[serves[k]]) for k in np.argsort(-without.sum(axis=1), kind="stable")]
    rows = np.vstack([before, *(slopes[owner == usable[place]] for place in chosen)])
    widths = [dict(zip(names, _halves(some).tolist(), strict=True)) for some in (before, rows)]
    return Plan(points, *widths, [parameters[k].name for k in sorted(weak)])


def _halves(slopes: Array) -> Array:
    """Half-widths of the expected intervals."""
    freedom = len(slopes) - slopes.shape[1]
    if freedom < 1:
        return np.full(slopes.shape[1], np.inf)
    return student.ppf(0.5 + 0.5 * fit.CONFIDENCE, freedom) * np.sqrt(np.diag(fit._covariance(slopes)[0]))


def _exchanged(known: Array, information: Array, count: int) -> list[int]:
    """Indices of the best places: each one is exchanged for a better one until none is better (Fedorov)."""
    chosen, before = np.linspace(0, len(information) - 1, count).round().astype(int).tolist(), None
    while chosen != before:
        before = list(chosen)
        for k in range(count):
            rest = chosen[:k] + chosen[k + 1 :]
            free = np.setdiff1d(np.arange(len(information)), rest)
            total = known + information[rest].sum(axis=0)
            left = np.stack([total, *(total - information[rest])])
            cost = np.trace(np.linalg.inv(left[:, None] + information[free]), axis1=2, axis2=3).sum(axis=0)
            best = int(np.argmin(cost))
            if cost[best] < (1.0 - 1e-9) * cost[free == chosen[k]][0]:
                chosen[k] = int(free[best])
    return chosen
