"""Bounded least squares without outliers, confidence intervals, and detection of parameters that the table does not determine."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear
from scipy.stats import t as student

from pushbelt.errors import PushbeltError
from pushbelt.fmu.geometry import Array

from .model import LOST, Model
from .parameters import Parameter, assign
from .worker import Found

CONFIDENCE = 0.95
UNDETERMINED = 1.0
"""Largest half-width of the interval of a determined parameter, in its coordinate: the start value itself, or a factor of e."""
TOLERANCE = 1e-4, 1e-4
"""A search ends where its next step is expected to reduce the sum of squares by less than the first value plus this share of it."""
CONFIRMED = 10.0
"""The derivatives at the end may expect a reduction of this multiple of the tolerance."""
MOST_EVALUATIONS = 40
MOST_JACOBIANS = 6
"""Largest number of times that a search computes all derivatives."""
REACH = 0.3, 1.0, 1e-5
"""First, largest and smallest length of a step in a coordinate."""
NEAR = 0.05
"""Length of steps, in the coordinate of the parameter with the largest influence, within which derivatives hold."""
DAMPING = 0.01
"""Weight of the squared step. It is far below that of a determined parameter, and shortens steps along directions that the data
do not see."""
MISFIT = 3.0
"""Root mean square of the residuals, in standard deviations, above which a fit is bad."""
LOST_SHARE = 1.0 / 3.0
"""Share of values at points without a steady state above which a fit is bad."""
AT_BOUND = 1e-3
"""Distance within which a coordinate counts as at its bound."""
RAISE = 1.1
"""Factor by which the friction is raised while points have no steady state at the start values."""
PARTNER = 0.9
"""Correlation above which two parameters can hardly be separated."""


class FitError(PushbeltError, RuntimeError):
    """There is nothing to fit."""


@dataclass(frozen=True)
class Undetermined:
    """Reason why a parameter was reset to its start value."""

    half: float
    """Half-width of its interval in its coordinate; infinite if it has no influence."""
    partner: str | None
    """Parameter from which it cannot be separated."""
    correlation: float


@dataclass(frozen=True)
class Estimate:
    """A parameter after the fit."""

    parameter: Parameter
    coordinate: float
    half: float | None
    """Half-width of its confidence interval in its coordinate; None if it is at a bound or not determined."""
    undetermined: Undetermined | None

    @property
    def value(self) -> float:
        """Its value."""
        return self.parameter.value(self.coordinate)

    @property
    def interval(self) -> tuple[float, float] | None:
        """Its confidence interval."""
        return None if self.half is None else self.parameter.interval(self.coordinate, self.half)

    @property
    def at_bound(self) -> bool:
        """Whether it is at a bound."""
        return self.half is None and self.undetermined is None


@dataclass(frozen=True)
class Fit:
    """Result of the fit."""

    estimates: tuple[Estimate, ...]
    correlations: Array
    """Correlations between the parameters that have an interval, in their order."""
    singular_values: Array
    """Singular values of the Jacobian of the residuals for the same parameters, in standard deviations per unit of coordinate."""
    chi_squared: tuple[float, float]
    """Sum of squares before and after, of the points with a steady state."""
    freedom: int
    """Degrees of freedom: values used minus parameters."""
    factor: float
    """Factor of the standard deviations in the intervals."""
    before: tuple[Found, ...]
    after: tuple[Found, ...]
    evaluations: int
    converged: bool
    used: tuple[int, int]
    """Values at points with a steady state, before and after, without outliers."""
    count: int
    """All measured values."""
    kept: tuple[bool, ...]
    """For each measured value, whether it is no outlier."""
    rms_of_all: float
    """Root mean square of the residuals after, with the outliers."""

    @property
    def rms(self) -> tuple[float, float]:
        """Root mean square of the residuals in standard deviations, before and after."""
        first, last = (float(np.sqrt(total / max(used, 1))) for total, used in zip(self.chi_squared, self.used, strict=True))
        return first, last

    @property
    def misfit(self) -> str | None:
        """Reason why the model with these parameters does not fit; None if it does."""
        before, after = self.rms
        if self.count - self.used[1] > LOST_SHARE * self.count:
            return f"{self.count - self.used[1]} of {self.count} values are outliers or at points without a steady state"
        if after > MISFIT:
            return f"the root mean square of the residuals is {after:.3g} standard deviations, above {MISFIT:g}"
        if after > 1.0 and self.used[0] == self.used[1] and after >= before * (1.0 - 1e-6):
            return f"the root mean square of the residuals, {after:.3g} standard deviations, has not fallen"
        return None

    @property
    def fits(self) -> bool:
        """Whether the model with these parameters fits."""
        return self.misfit is None

    @property
    def determined(self) -> list[Estimate]:
        """Estimates with an interval."""
        return [estimate for estimate in self.estimates if estimate.half is not None]


@dataclass(frozen=True)
class _Spread:
    """Confidence intervals of free parameters."""

    halves: Array
    correlations: Array
    singular_values: Array
    factor: float


def fit(model: Model, parameters: Sequence[Parameter]) -> Fit:
    """Fits parameters. Those that the table does not determine are held at their start values, those at a bound are held there.

    First a fit with a robust loss finds the outliers, which are then left out.
    """
    count = len(model.values) + sum(parameter.prior is not None for parameter in parameters)
    if count <= len(parameters):
        raise FitError(f"{count} measured values can't determine {len(parameters)} parameters")
    start = np.array([parameter.coordinate(parameter.start) for parameter in parameters])
    (before,) = model.states([assign(parameters, start)])
    given_up: dict[int, Undetermined] = {}
    place, states = _carrying(model, parameters, start, list(before))
    if all(found.reason is not None for found in states):
        raise FitError(f"no point has a steady state at the start values: {states[0].reason}")
    search = _Search(model, parameters, place, states)
    # Directions that the data hardly see take most steps of a search, so their parameters wait until the others are fitted.
    waiting, again = search.weak(), True
    search.leave_out([k for k in range(len(parameters)) if k not in waiting])
    while True:
        left = [k for k in range(len(parameters)) if k not in given_up]
        if not left:
            raise FitError("the table determines none of the parameters: " + _why(parameters, given_up))
        if again:
            search.run([k for k in left if k not in waiting], waiting)
        inner = search.inner(left)
        spread = search.spread(inner)
        wide = [k for k, half in enumerate(spread.halves) if half > UNDETERMINED]
        again = True
        if wide:
            # One that waits goes first, because nothing has to be fitted again.
            worst = max(wide, key=lambda k: (inner[k] in waiting, spread.halves[k]))
            lost, again = inner[worst], inner[worst] not in waiting
            given_up[lost] = _undetermined(parameters, inner, worst, spread)
            waiting = waiting - {lost}
            search.hold(lost, start[lost])
        elif waiting:
            waiting = frozenset()
        else:
            break
    halves = dict(zip(inner, spread.halves.tolist(), strict=True))
    estimates = (Estimate(p, float(search.place[k]), halves.get(k), given_up.get(k)) for k, p in enumerate(parameters))
    return _result(search, tuple(estimates), spread, before)


def _result(search: _Search, estimates: tuple[Estimate, ...], spread: _Spread, before: Sequence[Found]) -> Fit:
    model, after, kept = search.model, search.states, search.kept[: len(search.model.values)]
    priors, used, everything = len(search.kept) - len(kept), _used(model, after, kept), kept | True
    return Fit(
        estimates=estimates,
        correlations=spread.correlations,
        singular_values=spread.singular_values,
        chi_squared=(chi_squared(model, before, kept), chi_squared(model, after, kept)),
        freedom=used + priors - len(spread.halves),
        factor=spread.factor,
        before=tuple(before),
        after=tuple(after),
        evaluations=search.evaluations,
        converged=search.converged,
        used=(_used(model, before, kept), used),
        count=len(model.values),
        kept=tuple(kept.tolist()),
        rms_of_all=float(np.sqrt(chi_squared(model, after, everything) / max(_used(model, after, everything), 1))),
    )


def _carrying(
    model: Model, parameters: Sequence[Parameter], start: Array, states: list[Found]
) -> tuple[Array, list[Found]]:
    """Initial coordinates and states. The friction is raised as long as this brings the model closer to the measurements."""
    place = start
    friction = next((k for k, parameter in enumerate(parameters) if parameter.name == "friction.pulley"), None)
    while friction is not None and any(found.reason is not None for found in states):
        higher = place.copy()
        higher[friction] *= RAISE
        if higher[friction] > parameters[friction].bounds[1]:
            break
        (found,) = model.states([assign(parameters, higher)])
        if model.distance(found) >= model.distance(states):
            break
        place, states = higher, found
    return place, states


def _why(parameters: Sequence[Parameter], given_up: Mapping[int, Undetermined]) -> str:
    return ", ".join(f"{parameters[k].name} (±{100.0 * reason.half:.3g} %)" for k, reason in given_up.items())


class _Search:
    """Bounded least squares by Gauss-Newton steps in a trust region.

    The derivatives are differences of steady states at the start. Then each trial updates them along its step (Broyden), which
    costs no further steady states. Central differences at the end give the intervals, and confirm the end or continue the search.
    """

    def __init__(self, model: Model, parameters: Sequence[Parameter], place: Array, states: list[Found]) -> None:
        self.model, self.parameters = model, tuple(parameters)
        self.place, self.states = place, states
        self.evaluations, self.converged = 0, False
        self._low, self._high = np.array([parameter.bounds for parameter in parameters]).T
        self._residuals = self._all_residuals(place, states)
        self.kept = np.ones(len(self._residuals), dtype=bool)
        """Which measured values, and priors, are no outliers."""
        self._robust = False
        self._slopes = self._differences(range(len(place)), central=False)
        self._length = 0.0
        """Length of the last step, as the reach counts."""
        self._moved = np.inf
        """Length of all steps since the last central differences."""

    # Residuals and derivatives, of the measured values and the priors

    def _all_residuals(self, place: Array, states: Sequence[Found]) -> Array:
        priors = [(p.value(float(x)) - p.prior[0]) / p.prior[1] for p, x in zip(self.parameters, place, strict=True) if p.prior]
        return np.concatenate([self.model.residuals(states), priors])

    def _differences(self, free: Sequence[int], central: bool) -> Array:
        """Derivatives; the columns of parameters that are not free are 0."""
        free = list(free)
        chosen = [self.parameters[k] for k in free]
        fixed = assign(self.parameters, self.place)
        found = np.zeros((len(self._residuals), len(self.place)))
        found[: len(self.model.values), free] = self.model.slopes(chosen, fixed, self.place[free], self.states, central)
        for row, k in enumerate((k for k, p in enumerate(self.parameters) if p.prior), len(self.model.values)):
            parameter = self.parameters[k]
            slope = parameter.value(float(self.place[k])) if parameter.logarithmic else parameter.start
            found[row, k] = slope / parameter.prior[1]
        return found

    def _loss(self, residuals: Array) -> float:
        """Sum of squares, or the robust loss `soft_l1`, 2 (√(1 + r²) − 1), of which an outlier has a share that grows linearly."""
        squares = residuals[self.kept] ** 2
        return float(np.sum(2.0 * (np.sqrt(1.0 + squares) - 1.0) if self._robust else squares))

    @property
    def _weights(self) -> Array:
        """Factors of the residuals, whose squares then have the slope of the loss."""
        return self.kept * ((1.0 + self._residuals**2) ** -0.25 if self._robust else 1.0)

    # Search

    def hold(self, k: int, coordinate: float) -> None:
        """Fixes a parameter at a coordinate."""
        if self.place[k] != coordinate:
            self.place = np.where(np.arange(len(self.place)) == k, coordinate, self.place)
            (self.states,) = self.model.states([assign(self.parameters, self.place)])
            self._residuals = self._all_residuals(self.place, self.states)
            self._moved = np.inf

    def weak(self) -> frozenset[int]:
        """Parameters that the derivatives do not determine with the given standard deviations; at least one remains."""
        free, found = list(range(len(self.place))), set()
        while len(free) > 1:
            _, singular, turned = np.linalg.svd(self._slopes[:, free], full_matrices=False)
            halves = 2.0 * np.linalg.norm(turned.T / np.maximum(singular, 1e-12), axis=1)
            if halves.max() <= UNDETERMINED:
                break
            found.add(free.pop(int(np.argmax(halves))))
        return frozenset(found)

    def run(self, free: Sequence[int], waiting: Iterable[int] = (), robust: bool = False) -> None:
        """Minimises the loss over the free parameters. The derivatives at the end are also those of the waiting ones. A robust search ends
        without them."""
        self._robust = robust
        free, every = list(free), sorted({*free, *waiting})
        reach, jacobians, confirmed = REACH[0], 0, False
        self.converged = False
        while self.evaluations < MOST_EVALUATIONS:
            total = self._loss(self._residuals)
            step, expected = self._step(free, reach)
            # A lost point is constant, and does not make the search coarse.
            tolerance = TOLERANCE[0] + TOLERANCE[1] * self._loss(np.where(self._residuals == LOST, 0.0, self._residuals))
            if expected <= tolerance * (CONFIRMED if confirmed or robust else 1.0) or reach < REACH[2] or confirmed and jacobians >= MOST_JACOBIANS:
                if robust:
                    break
                if self._moved <= NEAR:
                    self.converged = expected <= tolerance * CONFIRMED or reach >= REACH[2]
                    break
                self._renew(every)
                jacobians, confirmed, reach = jacobians + 1, True, max(reach, 0.1)
                continue
            better = self._try(step, total, expected)
            largest = self._length
            if better > 0.75:
                reach = min(max(reach, 2.0 * largest), REACH[1])
            elif better < 0.25:
                reach = 0.25 * largest if better <= 0.0 else 0.5 * largest
                if better <= 0.0 and reach < 0.01 and jacobians < MOST_JACOBIANS:
                    self._slopes = self._differences(every, central=False)
                    jacobians, reach = jacobians + 1, 0.1
        if robust:
            return
        for k in free:
            if _at_bound(self.parameters[k], float(self.place[k])):
                near = self._low[k] if self.place[k] - self._low[k] < self._high[k] - self.place[k] else self._high[k]
                self.hold(k, float(near))
        if self._moved > NEAR:
            self._renew(every)

    def _renew(self, free: Sequence[int]) -> None:
        """Derivatives by central differences at this place."""
        self._slopes, self._moved = self._differences(free, central=True), 0.0

    def _step(self, free: Sequence[int], reach: float) -> tuple[Array, float]:
        """The step of the linear model within the bounds and the reach, and the reduction that it expects."""
        weights = self._weights
        slopes, residuals = (weights[:, None] * self._slopes)[:, free], weights * self._residuals
        # The reach is that of the parameter with the largest influence; others may move farther.
        influence = np.maximum(np.linalg.norm(slopes, axis=0), 1e-12)
        reaches = np.minimum(reach * influence.max() / influence, REACH[1])
        low = np.maximum(self._low[free] - self.place[free], -reaches)
        high = np.minimum(self._high[free] - self.place[free], reaches)
        # `lsq_linear` requires a range of each unknown.
        high = np.maximum(high, low + 1e-12)
        rows = np.vstack([slopes, np.sqrt(DAMPING) * np.eye(len(free))])
        found = lsq_linear(rows, np.concatenate([-residuals, np.zeros(len(free))]), (low, high), method="bvls")
        step = np.zeros(len(self.place))
        step[list(free)] = np.clip(found.x, low, high)
        after = residuals + slopes @ step[list(free)]
        self._length = float((np.abs(step[list(free)]) * influence).max() / influence.max())
        return step, float(residuals @ residuals - after @ after)

    def _try(self, step: Array, total: float, expected: float) -> float:
        """Solves at the end of a step, updates the derivatives, and moves there if it is better. Returns the actual reduction over
        the expected one."""
        place = np.clip(self.place + step, self._low, self._high)
        (states,) = self.model.states([assign(self.parameters, place)])
        self.evaluations += 1
        found = self._all_residuals(place, states)
        change = found - self._residuals - self._slopes @ step
        change[(found == LOST) | (self._residuals == LOST)] = 0.0
        self._slopes = self._slopes + np.outer(change, step) / float(step @ step)
        reduction = total - self._loss(found)
        if reduction > 0.0:
            self.place, self.states, self._residuals = place, states, found
            self._moved += self._length
        return reduction / expected

    # Outliers

    def leave_out(self, free: Sequence[int]) -> None:
        """Fits with the robust loss, and leaves out, worst first, values whose residual exceeds the scatter of all others
        with the confidence of the intervals: a t-test of
        the largest of many (Bonferroni). The scatter counts at least as the standard deviations. All values of a row, or of a sample,
        go together, because a faulty cell may be one of the conditions."""
        self.run(free, robust=True)
        values, size = self.model.values, np.abs(self._residuals)
        rows = [(value.point, value.measured.time) for value in values]
        carried = np.array([self.states[value.point].reason is None for value in values])
        while True:
            tested = np.flatnonzero(self.kept[: len(values)] & carried)
            freedom = len(tested) - len(self.parameters) - 1
            if freedom < 1:
                return
            worst = tested[np.argmax(size[tested])]
            scatter = max(float(np.sum(size[tested] ** 2) - size[worst] ** 2) / freedom, 1.0) ** 0.5
            if size[worst] <= student.ppf(1.0 - 0.5 * (1.0 - CONFIDENCE) / len(tested), freedom) * scatter:
                return
            self.kept[: len(values)] &= [row != rows[worst] for row in rows]

    # Intervals

    def inner(self, free: Sequence[int]) -> list[int]:
        """Free parameters that are not at a bound."""
        return [k for k in free if not _at_bound(self.parameters[k], float(self.place[k]))]

    def spread(self, inner: Sequence[int]) -> _Spread:
        """Covariance (JᵀJ)⁻¹ by singular values, over the points that have a steady state, and the priors."""
        if not inner:
            return _Spread(np.empty(0), np.empty((0, 0)), np.empty(0), 1.0)
        model = self.model
        used = np.array([self.states[value.point].reason is None for value in model.values])
        used = np.concatenate([used, np.ones(len(self._residuals) - len(used), dtype=bool)]) & self.kept
        _, singular, turned = np.linalg.svd(self._slopes[used][:, list(inner)], full_matrices=False)
        # Singular values below rounding correspond to directions without influence, with an infinite interval.
        floored = np.maximum(singular, 1e-12 * max(float(singular[0]), 1.0))
        covariance = turned.T @ np.diag(floored**-2.0) @ turned
        deviations = np.sqrt(np.diag(covariance))
        freedom = int(used.sum()) - len(inner)
        if freedom < 1:
            raise FitError(
                f"{int(used.sum())} values at points with a steady state can't determine {len(inner)} parameters"
            )
        reduced = float(np.sum(self._residuals[used] ** 2)) / freedom
        trusted = all(value.measured.given for value in model.values)
        factor = float(np.sqrt(max(reduced, 1.0) if trusted else reduced))
        halves = student.ppf(0.5 + 0.5 * CONFIDENCE, freedom) * factor * deviations
        return _Spread(halves, covariance / np.outer(deviations, deviations), singular, factor)


def _at_bound(parameter: Parameter, coordinate: float) -> bool:
    low, high = parameter.bounds
    return min(coordinate - low, high - coordinate) < AT_BOUND


def _used(model: Model, states: Sequence[Found], kept: Array) -> int:
    """Kept values of points that have a steady state."""
    return sum(states[value.point].reason is None for value, one in zip(model.values, kept, strict=True) if one)


def chi_squared(model: Model, states: Sequence[Found], kept: Array) -> float:
    """Sum of squares of kept values at points that have a steady state, in standard deviations."""
    return float(np.nansum(((model.column(states) - model.measured) / model.deviations)[kept] ** 2))


def _undetermined(parameters: Sequence[Parameter], inner: Sequence[int], worst: int, spread: _Spread) -> Undetermined:
    correlations = spread.correlations[worst].copy()
    correlations[worst] = 0.0
    nearest = int(np.argmax(np.abs(correlations)))
    near = abs(correlations[nearest]) >= PARTNER
    partner = parameters[inner[nearest]].name if near else None
    return Undetermined(float(spread.halves[worst]), partner, float(correlations[nearest]) if near else 0.0)
