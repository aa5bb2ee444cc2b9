"""What may be wrong with a table if its residuals are more than scatter: one cause at a time, such as an offset of a channel, as one more fitted
coordinate; and trends of the residuals over each column."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.stats import t as student

from pushbelt.fmu.geometry import Array
from pushbelt.tables import units
from pushbelt.tables.columns import CONDITIONS, QUANTITIES, REQUIRED
from pushbelt.tables.points import Point, Rig
from pushbelt.tables.sheet import TableError, same

from . import model as models
from .fit import CONFIDENCE, Estimate, Fit, FitError, fit
from .model import Model
from .parameters import Parameter, ParameterError, Size, assign
from .worker import Found, Job

SURE = 0.99  # Confidence of all tests of causes together, and of all tests of trends
REFITTED = 8  # Largest number of causes with which the fit is repeated
DISTINCT = 1e-4  # Share of the squared slopes of a cause that the fitted parameters must leave
FIELDS = ("ratio", "speed_ratio", "speed", "torque", "force", "primary_force")  # Conditions of a point
FRICTION, ORDER = "friction.pulley", "row order"
Values = Mapping[str, float]
Change = Callable[[Values, Point, float], tuple[Values, Point]]


@dataclass(frozen=True)
class Cause:
    """An error of a table, or a law that the parameters lack."""

    size: Parameter
    change: Change  # Values and point without the error, if it has a size
    columns: tuple[str, ...] = ()  # Those with the factor
    advice: str = ""  # What to do, or where a law holds


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
    chance: float  # Probability of such a trend among as many tests of scatter
    tests: int

    @property
    def significant(self) -> bool:
        return self.chance < 1.0 - SURE


def with_causes(model: Model, causes: Sequence[Cause]) -> Model:
    """The model with the sizes of causes as further variables. What a cause changes of a measured value is taken from the model's one."""

    def solve(jobs: Sequence[Job]) -> list[Found]:
        changed = [_changed(causes, *job) for job in jobs]
        return [_less(one, new, point) for one, (_, new), (_, point) in zip(model.solve(changed), changed, jobs, strict=True)]

    found = Model(model.points, solve)
    found.most_solves = model.most_solves
    return found


def _changed(causes: Sequence[Cause], values: Values, point: Point) -> Job:
    for cause in causes:
        if (size := values.get(cause.size.name)) is not None:
            values, point = cause.change({name: value for name, value in values.items() if name != cause.size.name}, point, size)
    return values, point


def _less(found: Found, new: Point, point: Point) -> Found:
    off = {one.key or one.quantity: other.value - one.value for one, other in zip(point.measured, new.measured, strict=True)}
    return found._replace(values={name: value - off.get(name, 0.0) for name, value in found.values.items()})


# Causes


def columns(rig: Rig) -> dict[str, Array]:
    """Numbers that a table has for each point, by title: conditions, times, the order of the rows, and unknown columns."""
    sheet, rows = rig.sheet, np.searchsorted(rig.sheet.lines, [point.line for point in rig.points])
    known = {sheet.title(name): column for name, column in sheet.values.items() if name in (*REQUIRED, "ratio.geometric", "ratio.speed", "time")}
    others = {title: column for title, column in sheet.others.items() if column.dtype != object}
    found = {title: column[rows] for title, column in {**known, **others}.items()}
    return {**found, ORDER: np.arange(len(rows), dtype=float)}


def friction_over(rig: Rig, title: str, parameters: Sequence[Parameter]) -> Cause:
    """A fitted friction that is a linear function of a column about its mean. Raises ParameterError if it is not fitted, and TableError without
    such numbers."""
    friction = next((one for one in parameters if one.name == FRICTION), None)
    if friction is None:
        raise ParameterError(f"{FRICTION} over {title} requires {FRICTION} in --fit")
    numbers = columns(rig)
    own = next((name for name in numbers if name == title or same(name, title) or rig.sheet.title(title) == name), None)
    if own is None or not np.nanstd(numbers[own]) > 0.0:
        raise TableError(f"there is no column {title} with numbers that differ; there are {', '.join(numbers)}", rig.sheet.path)
    column, unit = numbers[own], friction.start / np.nanstd(numbers[own])
    away = {point.line: float(x) for point, x in zip(rig.points, np.nan_to_num(column - np.nanmean(column)), strict=True)}

    def change(values: Values, point: Point, slope: float) -> Job:
        value = values.get(FRICTION, friction.start) + slope * away[point.line]
        return {**values, FRICTION: min(max(value, friction.low), friction.high)}, point

    name = f"slope of {FRICTION} over {own}"
    advice = f"{FRICTION} holds at the mean of {own}, {np.nanmean(column):.5g}"
    return Cause(Size(name, (name,), "1", 0.0, -10.0 * unit, 10.0 * unit, scale=unit), change, advice=advice)


def _of_columns(rig: Rig, names: Sequence[str], without: Callable[[Array, float], Array]) -> Change:
    """What follows from columns without an error."""

    @lru_cache(4)
    def points(size: float) -> dict[int, Point]:
        return {point.line: point for point in rig.changed({name: without(rig.sheet.values[name], size) for name in names})}

    def change(values: Values, point: Point, size: float) -> Job:
        if (new := points(size).get(point.line)) is None:
            return values, point
        known = {one.quantity: one.value for one in new.measured}
        measured = tuple(replace(one, value=known.get(one.quantity, one.value)) for one in point.measured)
        return values, replace(point, measured=measured, **{name: getattr(new, name) for name in FIELDS})

    return change


def _scaled(point: Point, **factors: float) -> Point:
    """A point whose measured quantities have factors."""
    return replace(point, measured=tuple(replace(one, value=one.value * factors.get(one.quantity, 1.0)) for one in point.measured))


def _size(name: str, unit: str, scale: float, low: float = -np.inf, high: float = np.inf) -> Size:
    return Size(name, (name,), unit, 0.0, low, high, scale=scale)


def _factor(name: str) -> Parameter:
    return Parameter(name, (name,), "1", 1.0, 0.1, 10.0)


def causes(rig: Rig, parameters: Sequence[Parameter]) -> list[Cause]:
    """What can be wrong with the columns that a table has, and what the model leaves out."""
    sheet, found = rig.sheet, []
    taken = {name: one for name, one in sheet.taken.items() if name in sheet.values and name in {**CONDITIONS, **QUANTITIES}}
    for name, one in taken.items():
        own, unit = sheet.values[name][np.isfinite(sheet.values[name])], one.scale.factor
        if own.size:
            scale = float(np.sqrt(np.mean(own**2))) or 1.0
            high = 0.9 * own.min() if own.min() > 0.0 else scale
            offset = _size(f"offset of {one.title}", one.unit or "1", scale / unit, -scale / unit, high / unit)
            found.append(Cause(offset, _of_columns(rig, (name,), lambda column, size, unit=unit: column - size * unit)))
            found.append(Cause(_factor(f"factor of {one.title}"), _of_columns(rig, (name,), lambda column, size: column / size), (name,)))
    for quantity in ("clampingForce", "torque", "pressure"):
        both = tuple(f"{pulley}.{quantity}" for pulley in ("primary", "secondary"))
        if taken.keys() >= set(both):
            name = f"factor of {taken[both[0]].title} and {taken[both[1]].title}"
            found.append(Cause(_factor(name), _of_columns(rig, both, lambda column, size: column / size), both))
    torque, turns = sheet.title("primary.torque"), sheet.values.get("ratio.geometric", sheet.values.get("ratio.speed", np.ones(len(sheet))))
    power = _size(f"power of the ratio in {torque} (1: it is that of the other shaft)", "1", 1.0)
    found.append(Cause(power, _of_columns(rig, ("primary.torque",), lambda column, size: column * turns**-size)))
    measured = {one.quantity for point in rig.points for one in point.measured}
    if "efficiency" in measured:

        def without_torque(values: Values, point: Point, size: float) -> Job:
            # Of the driving direction: driven over driving power.
            share = abs(point.torque / (point.torque - size or np.inf)) ** np.sign(point.torque)
            return values, replace(_scaled(point, efficiency=share), torque=point.torque - size)

        if "efficiency" in taken:
            scale = float(np.sqrt(np.mean([point.torque**2 for point in rig.points]))) or 1.0
            found.append(Cause(_size(f"torque of a pump or gear in {torque} and the efficiency", "N.m", scale, -scale, scale), without_torque))
        else:
            name = "factor of the efficiency (losses outside of the belt)"
            found.append(Cause(_factor(name), lambda values, point, size: (values, _scaled(point, efficiency=1.0 / size))))
    if any(point.ratio is not None for point in rig.points):

        def geometric(values: Values, point: Point, share: float) -> Job:
            less = 1.0 - share * point.slip
            new = point if "slip" in taken else replace(point, measured=tuple(
                replace(one, value=1.0 - less * (1.0 - one.value)) if one.quantity == "slip" else one for one in point.measured
            ))  # fmt: skip
            return values, new if point.ratio is None else replace(new, ratio=less * point.ratio)

        name = f"share of the slip in {sheet.title('ratio.geometric')} (1: it is the ratio of speeds)"
        found.append(Cause(_size(name, "1", 1.0, -5.0, 5.0), geometric))
    speeds = np.array([point.speed / (point.ratio or point.speed_ratio or 1.0) for point in rig.points])
    for both in (False, True):

        def with_oil(values: Values, point: Point, size: float, both: bool = both) -> Job:
            force = point.force + size * (point.speed / (point.ratio or point.speed_ratio or 1.0)) ** 2
            own = both * size * point.speed**2
            thrust = [1.0 + own / (one.value * point.force) for one in point.measured if one.quantity == "thrustRatio"]
            new = _scaled(point, thrustRatio=point.force / force * (thrust or [1.0])[0])
            return values, replace(new, force=force, primary_force=point.primary_force and point.primary_force + own)

        scale = float(np.mean([point.force for point in rig.points]) / np.mean(speeds**2))
        name = f"missing centrifugal force of the oil of {'both pulleys' if both else 'the secondary pulley'}"
        found.append(Cause(_size(name, "N.s2/rad2", scale, -0.5 * scale, 5.0 * scale), with_oil))
    steady = [point for point in rig.points if point.ratio is not None]
    if "thrustRatio" in measured and len(steady) > 2:
        rate = dict(zip((point.line for point in steady), np.gradient(np.log([point.ratio for point in steady])), strict=True))

        def at_rest(values: Values, point: Point, size: float) -> Job:
            return values, _scaled(point, thrustRatio=np.exp(-size * rate.get(point.line, 0.0)))

        name = "share of the thrust ratio by the change of ln i from row to row (points while shifting)"
        found.append(Cause(_size(name, "1", 1.0), at_rest))
    for title, column in columns(rig).items():
        if FRICTION in {one.name for one in parameters} and (title in sheet.others or title == ORDER) and np.nanstd(column) > 0.0:
            option = f'--friction-over "{title}"' if title != ORDER else ""
            found.append(replace(friction_over(rig, title, parameters), advice=option))
    names = {parameter.name for parameter in parameters}
    return [cause for cause in found if cause.size.name not in names]


def _signs(model: Model, fixed: Values, found: Fit, limit: float) -> Cause | None:
    """The opposite sign of the torque in the rows that are then closer to the model; None if there are none."""
    sizes = np.abs(found.residuals[: len(model.values)])
    rows = [k for k in np.unique(model.values["point"][sizes > limit]) if model.points[k].torque]
    turned = [replace(model.points[k], torque=-model.points[k].torque, near=b"") for k in rows]
    other = Model(turned, model.solve) if turned else None
    if other is None:
        return None
    loss = np.minimum(np.nan_to_num(np.abs(other.relative(other.states([fixed])[0])), nan=np.inf), limit) ** 2
    before = np.bincount(model.values["point"], np.minimum(sizes, limit) ** 2)
    better = {rows[k] for k, sum_ in enumerate(np.bincount(other.values["point"], loss)) if sum_ < before[rows[k]] - limit**2}
    lines = {model.points[k].line for k in better}

    def change(values: Values, point: Point, size: float) -> Job:
        return values, replace(point, torque=-point.torque, near=b"") if point.line in lines else point

    name = f"sign of the primary torque in {len(lines)} rows, lines {', '.join(map(str, sorted(lines)))}"
    return Cause(_size(name, "1", 1.0), change) if lines else None


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


def _slopes(model: Model, parameters: Sequence[Parameter], fixed: Values, found: Fit, some: Sequence[Cause]) -> tuple[Array, Array]:
    """Derivatives of the residuals with respect to the parameters, also those that are not determined, and to the sizes of causes; for these by the
    derivatives with respect to the conditions of the points."""
    place = model.values["point"].to_numpy()
    conditions = []
    for name in FIELDS:
        own = [value for point in model.points if (value := getattr(point, name)) is not None]
        if own and any(own):
            scale = float(np.sqrt(np.mean(np.square(own))))
            conditions.append(Cause(_size(name, "1", scale), lambda values, point, size, name=name: (values, _moved(point, name, size))))
    without = [k for k, column in enumerate(found.slopes.T) if not column.any()]
    moving = with_causes(model, conditions)
    chosen = [*(parameters[k] for k in without), *(one.size for one in conditions)]
    at = np.concatenate([found.place[without], np.zeros(len(conditions))])
    solved = moving.slopes(chosen, {**fixed, **assign(chosen, at)}, at, found.after)
    base = found.slopes.copy()
    base[: len(place), without] = solved[:, : len(without)]
    slopes = np.zeros((len(base), len(some)))
    old = np.array([one.value for point in model.points for one in point.measured])
    friction = [(parameter, column) for parameter, column in zip(parameters, base.T, strict=True) if parameter.name == FRICTION]
    for k, cause in enumerate(some):
        jobs = [cause.change(fixed, point, cause.size.value(cause.size.coordinate(cause.size.start) + models.STEP)) for point in model.points]
        column = (old - [one.value for _, point in jobs for one in point.measured]) / model.deviations
        for one, own in zip(conditions, solved[:, len(without) :].T, strict=True):
            name, before = one.size.name, model.points
            moved = [(getattr(new, name) or 0.0) - (getattr(point, name) or 0.0) for (_, new), point in zip(jobs, before, strict=True)]
            column += own * one.size.coordinate(1.0) * np.array(moved)[place]
        for parameter, own in friction:
            moved = [parameter.coordinate(values[FRICTION]) - parameter.coordinate(fixed[FRICTION]) for values, _ in jobs]
            column += own[: len(place)] * np.array(moved)[place]
        slopes[: len(place), k] = column / models.STEP
    return base, slopes


def _moved(point: Point, name: str, size: float) -> Point:
    value = getattr(point, name)
    return point if value is None else replace(point, **{name: value + size})


def _limit(found: Fit) -> float:
    """Largest residual that counts in full, in standard deviations: that of an outlier among so many."""
    return float(student.isf(0.5 * (1.0 - CONFIDENCE) / len(found.kept), max(len(found.kept), 2))) * max(found.rms[1], 1.0)


def trends(rig: Rig, model: Model, found: Fit, basis: Array) -> list[Trend]:
    """Tests of the residuals of each quantity over each column, beside the parameters and a constant; the least probable ones first."""
    used, limit = found.residuals != models.LOST, _limit(found)
    residuals, quantities = np.clip(found.residuals, -limit, limit)[used], model.values["quantity"].to_numpy()
    tests = []
    for title, column in columns(rig).items():
        own = column[model.values["point"]]
        for quantity in dict.fromkeys(quantities):
            there = np.pad((quantities == quantity) & np.isfinite(own), (0, len(used) - len(own)))
            tested = np.where(there, np.pad(own, (0, len(used) - len(own))), 0.0)
            there &= used
            if there.sum() > 2 and (extent := np.ptp(tested[there])) > 1e-9 * np.abs(tested[there]).max():
                tested[there] -= tested[there].mean()
                _, (slope,), (chance,) = _tested(tested[used, None], np.column_stack([basis[used], there[used]]), residuals)
                tests.append(Trend(str(quantity), title, float(slope * extent), float(chance), 0))
    found_trends = [one._replace(chance=min(len(tests) * one.chance, 1.0), tests=len(tests)) for one in tests]
    return sorted(found_trends, key=lambda one: one.chance)


def search(rig: Rig, model: Model, parameters: Sequence[Parameter], found: Fit) -> tuple[list[Named], list[Trend]]:
    """The cause that explains most of the residuals, and those that explain as much; none if all may be scatter. And the trends.

    Causes are first tested by derivatives at the end of the fit (a score test, Bonferroni). Then the fit is repeated with the best of them. Two explain
    as much if their sums of squares differ by less than one more parameter would reduce it by chance (95 %)."""
    fixed, limit, count = assign(parameters, found.place), _limit(found), len(model.values)
    some = causes(rig, parameters)
    basis, slopes = _slopes(model, parameters, fixed, found, some)
    used = found.residuals != models.LOST
    gains, _, chances = _tested(slopes[used], basis[used], np.clip(found.residuals, -limit, limit)[used])
    chosen = [some[k] for k in np.argsort(-gains)[:REFITTED] if chances[k] < (1.0 - SURE) / len(some)]
    if (sign := _signs(model, fixed, found, limit)) is not None:
        chosen.append(sign)
    fits = []
    for cause in chosen:
        at = np.append(found.place, cause.size.coordinate(cause.size.start))
        try:
            fits.append((cause, fit(with_causes(model, [cause]), [*parameters, cause.size], at)))
        except FitError:
            continue
    scatter = max(min([one.rms[1] for _, one in fits], default=1.0), 1.0)
    most = limit / max(found.rms[1], 1.0) * scatter

    def loss(one: Fit) -> float:
        return float(np.sum(np.minimum(np.abs(one.residuals[:count]), most) ** 2)) / scatter**2

    named = sorted((Named(cause, one, loss(one)) for cause, one in fits), key=lambda one: one.loss)
    freedom = max(count - len(parameters) - 1, 1)
    named = [one for one in named if loss(found) - one.loss > student.isf(0.5 * (1.0 - SURE) / len(some), freedom) ** 2]
    return [one for one in named if one.loss - named[0].loss < student.isf(0.5 * (1.0 - CONFIDENCE), freedom) ** 2], trends(rig, model, found, basis)


# Sentences


def sentence(rig: Rig, found: Fit, named: Named) -> str:
    """A cause with its size, the residuals and the parameters with it, and what to do."""
    size = named.estimate
    shown = f" = {size.value:.4g} {size.parameter.unit}".removesuffix(" 1") if size.interval else ""
    interval = f" (95 %: {size.interval[0]:.4g} to {size.interval[1]:.4g})" if size.interval else ""
    left, before = ((one.rms[1], len(one.kept) - sum(one.kept)) for one in (named.fit, found))
    values = ", ".join(f"{one.parameter.name} = {one.value:.4g}" for one in named.fit.estimates[:-1])
    text = f"{size.parameter.name}{shown}{interval}: {left[0]:.3g} standard deviations and {left[1]} outliers in place of {before[0]:.3g} and {before[1]}"
    return "; ".join(filter(None, [text, values, _unit_option(rig, named) or named.cause.advice]))


def trend(one: Trend) -> str:
    return f"residuals of {one.quantity} change by {one.rise:.3g} standard deviations over {one.column} (chance {one.chance:.1g}, of {one.tests} tests)"


def _unit_option(rig: Rig, named: Named) -> str:
    """The option that reads columns in another unit, if that is the factor."""
    taken = [rig.sheet.taken[name] for name in named.cause.columns]
    low, high = named.estimate.interval or (1.0, 1.0)
    for spelled in units.SPELLED[taken[0].column.dimension] if taken else ():
        unit = spelled.split()[0]
        if (scale := units.find(unit, taken[0].column.dimension)) is not None and scale.factor != taken[0].scale.factor:
            factor = taken[0].scale.factor / scale.factor
            if min(low, 0.99 * named.estimate.value) <= factor <= max(high, 1.01 * named.estimate.value):
                return " ".join(f'--map "{one.title}={one.turned}{one.name} [{unit}]"' for one in taken)
    return ""
