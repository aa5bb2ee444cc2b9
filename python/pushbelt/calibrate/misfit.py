"""What may be wrong with a table whose residuals are more than scatter: one cause at a time, such as an offset of a channel, as one more fitted
coordinate; and trends of the residuals over each column."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np
from scipy.stats import f as fisher
from scipy.stats import t as student

from pushbelt.fmu.geometry import Array
from pushbelt.tables import units
from pushbelt.tables.columns import COLUMNS, POWER, QUANTITIES, REQUIRED, SURE
from pushbelt.tables.names import DEVIATION
from pushbelt.tables.points import Point, Rig
from pushbelt.tables.sheet import TableError, same

from . import model as models
from .fit import CONFIDENCE, Estimate, Fit, FitError, fit
from .model import Model
from .parameters import Parameter, ParameterError, additional, assign
from .worker import Found, Job

CHANCE = 0.01  # Probability that scatter is taken for a cause, and for a trend, over all tests
REFITTED = 4  # Largest number of causes with which the fit is repeated
DISTINCT = 1e-4  # Least share of the squared slopes of a cause that no fitted parameter has
FIELDS = ("ratio", "speed_ratio", "speed", "torque", "force", "primary_force")  # Conditions of a point
FRICTION, ORDER = "friction.pulley", "row order"
Values = Mapping[str, float]


@dataclass(frozen=True)
class Cause:
    """An error of a table, or a law that the parameters lack."""

    size: Parameter
    change: Callable[[Values, Point, float], Job]  # Values and point without it, if it has a size
    columns: tuple[str, ...] = ()  # Those with the factor
    advice: str = ""  # What to do, or where a law holds
    begin: float | None = None  # Size from which it is fitted, whatever the derivatives say; None: the start


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


class Groups(NamedTuple):
    """Groups of points by the cells of a column."""

    column: str
    counts: Mapping[str, int]  # Numbers of their points; the first group has most
    causes: list[Cause]  # Differences of the friction of the others from that of the first one


def with_causes(model: Model, causes: Sequence[Cause]) -> Model:
    """The model with the sizes of causes as further variables. What a cause changes of a measured value and its deviation is in the
    model's one, so that the residuals are right."""

    def changed(values: Values, point: Point) -> Job:
        for cause in causes:
            size = values.get(cause.size.name)
            if size is not None:
                values, point = cause.change({name: value for name, value in values.items() if name != cause.size.name}, point, size)
        return values, point

    def solve(jobs: Sequence[Job]) -> list[Found]:
        new, found = [changed(*job) for job in jobs], []
        # A size that some points do not have gives equal jobs.
        keys = [(tuple(values.items()), point) for values, point in new]
        distinct = dict(zip(keys, new, strict=True))
        solved = dict(zip(distinct, model.solve(list(distinct.values())), strict=True))
        for key, (_, point), (_, measured) in zip(keys, jobs, new, strict=True):
            values = dict(solved[key].values)
            for one, other in zip(point.measured, measured.measured, strict=True):
                if (name := one.key or one.quantity) in values:
                    values[name] = one.value + one.deviation / other.deviation * (values[name] - other.value)
            found.append(solved[key]._replace(values=values))
            solved[key] = solved[key]._replace(solves=0)
        return found

    return Model(model.points, solve, model.most_solves)


# Causes


def columns(rig: Rig) -> dict[str, Array]:
    """Numbers that a table has for each point, by title: conditions, times, unknown columns, and the order of the rows."""
    sheet, rows = rig.sheet, rig.rows
    found = {sheet.title(name): rig.values[name] for name in ("ratio.geometric", "ratio.speed", *REQUIRED, "time") if name in rig.values}
    found |= {title: column for title, column in sheet.others.items() if column.dtype != object}
    return {**{title: column[rows] for title, column in found.items()}, ORDER: np.arange(len(rows), dtype=float)}


def _friction_law(
    rig: Rig, title: str, some: Mapping[str, Array], parameters: Sequence[Parameter]
) -> tuple[str, Callable[[str, Array, float, str], Cause]]:
    """The column of a title, and what adds a size times weights of the points to the friction."""
    friction = next((one for one in parameters if one.name == FRICTION), None)
    own = next((name for name in some if name == rig.sheet.title(title) or same(name, title)), None)
    if friction is None:
        raise ParameterError(f"{FRICTION} over {title} requires {FRICTION} in --fit")
    if own is None:
        raise TableError(f"there is no column {title}; there are {', '.join(some)}", rig.sheet.path)

    def law(name: str, weights: Array, scale: float, advice: str) -> Cause:
        by_line = {point.line: float(weight) for point, weight in zip(rig.points, weights, strict=True)}

        def change(values: Values, point: Point, size: float) -> Job:
            value = values[FRICTION] + size * by_line[point.line]
            return {**values, FRICTION: min(max(value, friction.low), friction.high)}, point

        return Cause(additional(name, "1", scale * friction.start), change, advice=advice)

    return own, law


def friction_over(rig: Rig, title: str, parameters: Sequence[Parameter]) -> Cause:
    """A fitted friction that is a linear function of a column about its mean. Raises ParameterError if it is not fitted, and TableError without
    such numbers."""
    own, law = _friction_law(rig, title, numbers := columns(rig), parameters)
    column = numbers[own]
    if not np.nanstd(column) > 0.0:
        raise TableError(f"{own} has no numbers that differ", rig.sheet.path)
    away, advice = np.nan_to_num(column - np.nanmean(column)), f"{FRICTION} holds at the mean of {own}, {np.nanmean(column):.5g}"
    return law(f"slope of {FRICTION} over {own}", away, 1.0 / float(np.nanstd(column)), advice)


def friction_by(rig: Rig, title: str, parameters: Sequence[Parameter]) -> Groups:
    """A fitted friction of each group of points with the same cell in a column. Raises ParameterError if the friction is not fitted, and TableError
    if there are not two groups, or one has fewer than two points."""
    some = columns(rig) | {name: column[rig.rows] for name, column in rig.sheet.others.items()}
    own, law = _friction_law(rig, title, some, parameters)
    cells = np.array(["" if cell != cell else f"{cell:.9g}" if isinstance(cell, float) else f"{cell}".strip() for cell in some[own].tolist()])
    names, counts = np.unique(cells, return_counts=True)
    few = [f"{name or 'empty'} ({count})" for name, count in zip(names, counts, strict=True) if count < 2 or not name]
    if few or len(names) < 2:
        why = f"{len(few)} groups are empty or have one point: {', '.join(few[:5])}" if few else f"all cells are {names[0]}"
        raise TableError(f"{own} does not group the points: {why}. At least two groups of at least two points are required", rig.sheet.path)
    order = np.argsort(-counts, kind="stable")
    first, *others = names[order].tolist()
    sizes = [law(f"{FRICTION} of {own} = {name} above that of {first}", cells == name, 1.0, "") for name in others]
    sizes[0] = replace(sizes[0], advice=f"{FRICTION} holds for {own} = {first}")
    return Groups(own, dict(zip(names[order].tolist(), counts[order].tolist(), strict=True)), sizes)


def compared(groups: Groups, found: Fit) -> list[str]:
    """The friction of each group with its interval, and whether they differ: an F-test of all differences."""
    names, spread = [one.parameter.name for one in found.determined], found.spread
    wanted = [FRICTION, *(cause.size.name for cause in groups.causes)]
    if missing := [name for name in wanted if name not in names]:
        return [f"the groups of {groups.column} can't be compared: the table does not determine {missing[0]}"]
    at = [names.index(name) for name in wanted]
    own = [found.determined[k] for k in at]
    halves = spread.halves[at] * [one.value if one.parameter.logarithmic else one.parameter.scale or one.parameter.start for one in own]
    squares, away = spread.correlations[np.ix_(at, at)] * np.outer(halves, halves), np.array([one.value for one in own[1:]])
    quantile, count = student.ppf(0.5 + 0.5 * CONFIDENCE, spread.freedom), len(away)
    chance = fisher.sf(quantile**2 * away @ np.linalg.solve(squares[1:, 1:], away) / count, count, spread.freedom)
    lines = []
    for k, (name, points) in enumerate(groups.counts.items()):
        sums = [0, k] if k else [0]
        value, half = sum(own[m].value for m in sums), float(np.sqrt(squares[np.ix_(sums, sums)].sum()))
        lines.append(f"{FRICTION} of {groups.column} = {name} ({points} points): {value:.5g} (95 %: {value - half:.5g} to {value + half:.5g})")
    verdict = "differ" if chance < CHANCE else "differ by no more than scatter"
    return [*lines, f"the frictions of the {count + 1} groups {verdict} (chance {chance:.1g})"]


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


def causes(rig: Rig, model: Model, parameters: Sequence[Parameter]) -> list[Cause]:
    """What can be wrong with the columns of a table, and what the model leaves out."""
    sheet, found = rig.sheet, []
    values = {name: column for name, column in rig.values.items() if name in COLUMNS}
    taken = {name: one for name, one in sheet.taken.items() if name in values}

    def add(size: Parameter, without: Callable[[float], Mapping[str, Array]], columns: Sequence[str] = (), begin: float | None = None) -> None:
        """A cause, with the columns that a table of a size has without it."""

        @lru_cache(4)
        def points(size: float) -> dict[int, Point]:
            with np.errstate(all="ignore"):
                new = {name: np.clip(column, COLUMNS[name].low, COLUMNS[name].high) for name, column in without(size).items() if name in COLUMNS}
                return {point.line: point for point in rig.changed({**without(size), **new})}

        def change(values: Values, point: Point, size: float) -> Job:
            new = points(size).get(point.line, point)
            known = {one.quantity: one for one in new.measured}
            measured = tuple(known.get(one.quantity, one) for one in point.measured)
            return values, replace(point, measured=measured, **{name: getattr(new, name) for name in FIELDS})

        found.append(Cause(size, change, tuple(columns), begin=begin))

    def add_weighted(name: str, unit: str, scale: float, weights: Mapping[str, Array | float], begin: float | None = None) -> None:
        add(additional(name, unit, scale), lambda size: {name: values[name] - size * weight for name, weight in weights.items()}, (), begin)

    def add_factor(name: str, powers: Mapping[str, Array | float]) -> None:
        size = Parameter(name, (), "1", 1.0, 0.1, 10.0)
        # A deviation has the factor of its value.
        scaled = {name: (values[name], power) for name, power in powers.items()}
        for name, power in powers.items():
            if name + DEVIATION in rig.values:
                scaled[name + DEVIATION] = rig.values[name + DEVIATION], power
            elif name in QUANTITIES:
                scaled[name + DEVIATION] = np.hypot(QUANTITIES[name].absolute, QUANTITIES[name].relative * values[name]), power
        add(size, lambda size: {name: column / size**power for name, (column, power) in scaled.items()}, list(powers))

    rms = {name: float(np.sqrt(np.nanmean(values[name] ** 2))) or 1.0 for name in taken if np.isfinite(values[name]).any()}
    for name, one in ((name, taken[name]) for name in rms):
        add_weighted(f"offset of {one.title}", one.unit or "1", rms[name] / one.scale.factor, {name: one.scale.factor})
        add_factor(f"factor of {one.title}", {name: 1.0})
    for quantity in ("torque", "clampingForce", "pressure"):
        both = {f"{pulley}.{quantity}": 1.0 for pulley in ("primary", "secondary")}
        if rms.keys() >= both.keys():
            add_factor(f"factor of {' and '.join(taken[name].title for name in both)}", both)
    speed, torque, force = (values[name] for name in REQUIRED)
    ratio = values.get("ratio.geometric", values.get("ratio.speed", np.ones(len(sheet))))
    name, driving = sheet.title("primary.torque"), np.sign(torque)
    power = additional(f"power of the ratio in {name} (1: it is that of the other shaft)", "1", 2.0)
    add(power, lambda size: {"primary.torque": torque / ratio**size})
    if "efficiency" in taken:
        pump = additional(f"torque of a pump or gear in {name} and the efficiency", "N.m", rms["primary.torque"])
        add(pump, lambda size: {
            "primary.torque": torque - size, "efficiency": values["efficiency"] * np.abs(torque / (torque - size)) ** driving
        })  # fmt: skip
    elif "secondary.torque" in taken:
        add_factor("efficiency of a gear on the secondary shaft", {"secondary.torque": driving})
    slips = np.zeros(len(sheet))
    slips[rig.rows] = [point.slip for point in model.points]
    if "ratio.geometric" in taken:
        title = f"share of the slip in {sheet.title('ratio.geometric')} (1: it is the ratio of speeds)"
        add_weighted(title, "1", 2.0, {"ratio.geometric": ratio * slips})
    squares = {"secondary.clampingForce": -((speed / ratio) ** 2), "primary.clampingForce": -(speed**2)}
    for names in (("secondary.clampingForce",), tuple(squares)):
        if values.keys() >= set(names):
            title = f"missing centrifugal force of the oil of {'both pulleys' if len(names) > 1 else 'the secondary pulley'}"
            add_weighted(title, "N.s2/rad2", float(np.nanmean(force) / np.nanmean((speed / ratio) ** 2)), {name: squares[name] for name in names})
    thrust = next((name for name in ("thrustRatio", "primary.clampingForce") if name in values), None)
    if thrust and len(sheet) > 2:
        moving = values[thrust] * np.gradient(np.log(ratio))
        add_weighted("change of the thrust ratio by that of ln i from row to row (points while shifting)", "1", 1.0, {thrust: moving})
    slipping = {point.line: abs(one.value) / one.deviation for point in model.points for one in point.measured
                if one.quantity == "slip" and one.value * point.torque < 0.0}  # fmt: skip
    gaining = np.isfinite(rig.values.get(POWER, np.full(len(sheet), np.nan))) & ~np.isfinite(values.get("efficiency", torque))
    wrong = np.isin(sheet.lines, list(slipping)) | gaining
    if gaining.any() or max(slipping.values(), default=0.0) > SURE:
        title = f"opposite sign of {name} in {wrong.sum()} rows, lines {', '.join(map(str, sheet.lines[wrong]))} (1: it is opposite)"
        add_weighted(title, "1", 2.0, {"primary.torque": 2.0 * torque * wrong}, 1.0)
    if any(one.name == FRICTION for one in parameters):
        laws = [title for title, column in columns(rig).items() if title in (*sheet.others, ORDER) and np.nanstd(column) > 0.0]
        options = ["" if title == ORDER else f'--friction-over "{title}"' for title in laws]
        found += [replace(friction_over(rig, title, parameters), advice=option) for title, option in zip(laws, options, strict=True)]
    return [cause for cause in found if cause.size.name not in {one.name for one in parameters}]


# Tests


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
    fixed, some, used = assign(parameters, found.place), causes(rig, model, parameters), found.residuals != models.LOST
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


# Sentences


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
