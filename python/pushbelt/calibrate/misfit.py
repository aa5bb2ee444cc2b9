"""Tests of a table whose residuals are more than scatter: which cause explains them, and trends of the residuals over each column."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.stats import t as student

from pushbelt.fmu.geometry import Array
from pushbelt.tables import units
from pushbelt.tables.points import Point, Rig

from . import model as models
from .causes import FIELDS, Cause, Values, causes, with_causes
from .fit import CHANCE, CONFIDENCE, Estimate, Fit, FitError, fit
from .friction import FRICTION, columns, over_unknown_columns
from .model import Model
from .parameters import Parameter, additional, assign
from .worker import Job

REFITTED = 4  # Largest number of causes with which the fit is repeated
DISTINCT = 1e-4  # Least share of the squared slopes of a cause that no fitted parameter has


class Named(NamedTuple):
    """A cause, with the fit that contains it."""

    cause: Cause
    fit: Fit
    loss: float  # Sum of squares over all values, in which each one counts at most like an outlier

    @property
    def estimate(self) -> Estimate:
        return self.fit.estimates[-1]


class Trend(NamedTuple):
    """Residuals of a quantity over a column."""

    quantity: str
    column: str
    rise: float  # Change of the residual over the column's range, in standard deviations
    places: Array  # The column at each measured value, NaN at those of other quantities
    chance: float  # Probability of such a trend among all tests of scatter
    tests: int

    @property
    def significant(self) -> bool:
        return self.chance < CHANCE


def ratio_of_speeds(rig: Rig, found: Fit) -> list[str]:
    """The certain evidence that a geometric ratio is computed from the speeds: it is their ratio, within a tenth of the slips to be expected."""
    values, names = rig.values, ("ratio.geometric", "primary.speed", "secondary.speed")
    if not values.keys() >= {*names}:
        return []
    ratio, primary, secondary = (values[name][rig.rows] for name in names)
    apart, slips = np.abs(1.0 - ratio * secondary / primary), np.array([one.values.get("slip", np.nan) for one in found.before])
    known = np.isfinite(apart) & np.isfinite(slips)
    if known.sum() < 2 or not apart[known].max() < 0.1 * (usual := float(np.sqrt(np.mean(slips[known] ** 2)))):
        return []
    one, first, second = map(rig.sheet.title, names)
    text = f"{one} is {first}/{second} in all {known.sum()} rows, within {apart[known].max():.1g}, where slips of {usual:.1g} are to be expected"
    return [f'{text}: it is the ratio of speeds, --map "{one}=ratio.speed"']


def _tested(tested: Array, basis: Array, residuals: Array) -> tuple[Array, Array, Array]:
    """Of each column the reduction of the sum of squares by it beside a basis, its coefficient, and the probability of so large a one by chance. The
    scatter counts at least as the standard deviations."""
    norms = np.linalg.norm(basis, axis=0)
    turned, singular, _ = np.linalg.svd(basis[:, norms > 0.0] / norms[norms > 0.0], full_matrices=False)
    turned = turned[:, singular > 1e-6]
    left, rest = (some - turned @ (turned.T @ some) for some in (tested, residuals))
    squares, freedom = np.sum(left**2, axis=0), max(len(rest) - turned.shape[1] - 1, 1)
    distinct = squares > DISTINCT * np.maximum(np.sum(tested**2, axis=0), 1e-30)
    coefficients = np.where(distinct, left.T @ rest / np.where(distinct, squares, 1.0), 0.0)
    gains = coefficients**2 * squares
    scatter = np.maximum((rest @ rest - gains) / freedom, 1.0)
    return gains, coefficients, 2.0 * student.sf(np.sqrt(gains / scatter), freedom)


def _slopes(model: Model, parameters: Sequence[Parameter], fixed: Values, found: Fit, some: Sequence[Cause]) -> Array:
    """Derivatives of the residuals with respect to the sizes of causes, by those with respect to the friction and the conditions of the points."""

    def conditions(jobs: Sequence[Job]) -> Array:
        return np.array([[values.get(FRICTION, 0.0), *(getattr(point, name) or 0.0 for name in FIELDS)] for values, point in jobs])

    def moved(name: str, values: Values, point: Point, change: float) -> Job:
        value = getattr(point, name)
        return values, point if value is None else replace(point, **{name: value + change})

    place, before = model.values["point"].to_numpy(), conditions([(fixed, point) for point in model.points])
    scales = np.sqrt(np.mean(before**2, axis=0))
    sizes = [additional(name, "1", float(scale)) for name, scale in zip(FIELDS, scales[1:], strict=True) if scale > 0.0]
    with_sizes, at = with_causes(model, [Cause(size, partial(moved, size.name)) for size in sizes]), np.zeros(len(sizes))
    by = np.zeros((len(place), len(scales)))
    by[:, 1:][:, scales[1:] > 0.0] = with_sizes.slopes(sizes, {**fixed, **assign(sizes, at)}, at, found.after) / scales[1:][scales[1:] > 0.0]
    for k, one in enumerate(parameters):
        if one.name == FRICTION:
            by[:, 0] = found.slopes[: len(place), k] / (fixed[FRICTION] if one.logarithmic else one.start)
    slopes, residuals = np.zeros((len(found.residuals), len(some))), _bounded(found)[: len(place)]
    old = np.array([one.value for point in model.points for one in point.measured])
    for k, cause in enumerate(some):
        jobs = [cause.change(fixed, point, cause.size.value(cause.size.coordinate(cause.size.start) + models.STEP)) for point in model.points]
        new = np.array([(one.value, one.deviation) for _, point in jobs for one in point.measured])
        column = (model.deviations * residuals + old - new[:, 0]) / new[:, 1] - residuals + np.sum(by * (conditions(jobs) - before)[place], axis=1)
        slopes[: len(place), k] = column / models.STEP
    return slopes


def _bounded(found: Fit, scatter: float | None = None) -> Array:
    """Residuals without the excess of outliers among so many, with this scatter or that of the fit."""
    count = len(found.kept)
    limit = float(student.isf(0.5 * (1.0 - CONFIDENCE) / count, count)) * max(scatter or found.rms[1], 1.0)
    return np.clip(found.residuals, -limit, limit)


def trends(rig: Rig, model: Model, found: Fit) -> list[Trend]:
    """Tests of the residuals of each quantity over each column, beside the parameters and a constant; the least probable ones first."""
    used, quantities = found.residuals != models.LOST, model.values["quantity"].to_numpy()
    tests = []
    for title, column in columns(rig).items():
        own = np.pad(column[model.values["point"]], (0, len(used) - len(quantities)), constant_values=np.nan)
        for quantity in dict.fromkeys(quantities):
            there = used & np.isfinite(own) & np.pad(quantities == quantity, (0, len(used) - len(quantities)))
            if there.sum() > 2 and (extent := float(np.ptp(own[there]))) > 1e-9 * np.abs(own[there]).max():
                tested = np.where(there, (own - own[there].mean()) / extent, 0.0)[used, None]
                _, (slope,), (chance,) = _tested(tested, np.column_stack([found.slopes[used], there[used]]), _bounded(found)[used])
                places = np.where(there, own, np.nan)[: len(quantities)]
                tests.append(Trend(quantity, title, float(slope), places, float(chance), 0))
    return sorted((one._replace(chance=min(len(tests) * one.chance, 1.0), tests=len(tests)) for one in tests), key=lambda one: one.chance)


def search(rig: Rig, model: Model, parameters: Sequence[Parameter], found: Fit) -> list[Named]:
    """The cause that explains most of the residuals, and those that explain as much; none if all may be scatter.

    Causes are first tested by derivatives at the end of the fit (a score test, Bonferroni). Then the fit is repeated with the best of them. Two explain
    as much if their sums of squares differ by less than one more parameter would reduce it by chance (95 %)."""
    fixed, used = assign(parameters, found.place), found.residuals != models.LOST
    some = [*causes(rig, model), *over_unknown_columns(rig, parameters)]
    some = [cause for cause in some if cause.size.name not in {one.name for one in parameters}]
    gains, _, chances = _tested(_slopes(model, parameters, fixed, found, some)[used], found.slopes[used], _bounded(found)[used])
    fits = []
    best = [some[k] for k in np.argsort(-gains)[:REFITTED] if chances[k] < CHANCE / len(some)]
    for cause in [*best, *(one for one in some if one.begin is not None and one not in best)]:
        begin = cause.size.coordinate(cause.size.start if cause.begin is None else cause.begin)
        try:
            own = fit(with_causes(model, [cause]), [*parameters, cause.size], np.append(found.place, begin))
        except FitError:
            continue
        if own.estimates[-1].interval is not None:
            fits.append((cause, own))
    scatter = max(min((one.rms[1] for _, one in fits), default=1.0), 1.0)

    def loss(one: Fit) -> float:
        return float(np.sum((_bounded(one, scatter)[: len(one.kept)] / scatter) ** 2))

    freedom = max(len(found.kept) - len(parameters) - 1, 1)
    better = loss(found) - student.isf(0.5 * CHANCE / len(some), freedom) ** 2
    named = sorted((Named(cause, own, loss(own)) for cause, own in fits), key=lambda one: one.loss)
    return [one for one in named if one.loss < better and one.loss - named[0].loss < student.isf(0.5 * (1.0 - CONFIDENCE), freedom) ** 2]


def sentence(rig: Rig, found: Fit, named: Named) -> str:
    """A cause with its size, the residuals and the parameters with it, and what to do."""
    size, (low, high) = named.estimate, named.estimate.interval or (np.nan, np.nan)
    shown = f"{size.parameter.name} = {size.value:.4g} {size.parameter.unit}".removesuffix(" 1") + f" (95 %: {low:.4g} to {high:.4g})"
    after, before = (f"{one.rms[1]:.3g}" + f" and {one.kept.count(False)} outliers" * (not all(one.kept)) for one in (named.fit, found))
    values = ", ".join(f"{one.parameter.name} = {one.value:.4g}" for one in named.fit.estimates[:-1])
    advice = named.cause.advice
    for column in (rig.sheet.taken[name] for name in named.cause.columns):
        # A factor may be that of another unit.
        for unit in (words.split()[0] for words in units.SPELLED[column.column.dimension]):
            scale = units.find(unit, column.column.dimension)
            factor = column.scale.factor / scale.factor if scale and scale.factor != column.scale.factor else np.nan
            if min(low, 0.99 * size.value) <= factor <= max(high, 1.01 * size.value):
                advice += f' --map "{column.title}={column.turned}{column.name} [{unit}]"'
    return "; ".join(filter(None, [f"{shown} leaves {after} standard deviations in place of {before}", values, advice.strip()]))


def trend(one: Trend) -> str:
    return f"residuals of {one.quantity} change by {one.rise:.3g} standard deviations over {one.column} (chance {one.chance:.1g}, of {one.tests} tests)"
