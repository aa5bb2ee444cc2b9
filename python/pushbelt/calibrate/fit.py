"""A fit: bounded least squares by few steady states, without outliers; confidence intervals; parameters that a table does not determine."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from pushbelt.errors import PushbeltError
from pushbelt.fmu.geometry import Array

from .model import LOST, Model
from .parameters import Parameter, assign
from .worker import Found

CONFIDENCE = 0.95
CHANCE = 0.01  # Probability that scatter is taken for a cause, a difference of groups or a trend, over all tests
UNDETERMINED = 1.0
"""Largest half-width of the interval of a determined parameter, in its coordinate: the start value itself, or a factor of e."""
MISFIT = 3.0  # Root mean square of the residuals, in standard deviations, above which a fit is bad
LOST_SHARE = 1.0 / 3.0  # Share of values at points without a steady state above which a fit is bad
RAISE = 1.1  # Factor by which the friction is raised while points have no steady state at the start values
PARTNER = 0.9  # Correlation above which two parameters can hardly be separated
TOLERANCE, COARSE = 1e-3, 1e-2  # Relative reduction of the sum of squares plus 1, and of the robust loss, with which a search ends
CHANGE = 1e-4  # Relative change of the coordinates with which a search ends
MOST_EVALUATIONS, MOST_SEARCHES = 40, 5  # Largest numbers of trials in a search, and of searches, each with new derivatives
NEAR = 0.05  # Largest change of a coordinate with which derivatives hold
AT_BOUND = 1e-3  # Distance within which a coordinate counts as at its bound


class FitError(PushbeltError, RuntimeError):
    """There is nothing to fit."""


class Estimate(NamedTuple):
    """A parameter after the fit."""

    parameter: Parameter
    value: float
    half: float | None  # Half-width of its confidence interval in its coordinate; None if it is at a bound or not determined
    interval: tuple[float, float] | None
    undetermined: str | None  # Why it was reset to its start value

    @property
    def at_bound(self) -> bool:
        return self.half is None and self.undetermined is None


class Spread(NamedTuple):
    """Confidence intervals of parameters, in their coordinates."""

    halves: Array
    correlations: Array
    singular_values: Array  # Of the Jacobian of the residuals, in standard deviations per unit of coordinate
    factor: float  # Factor of the standard deviations in the intervals
    freedom: int  # Number of values less that of the parameters


class Fit(NamedTuple):
    """Result of the fit. Values before and after are those without outliers."""

    estimates: tuple[Estimate, ...]
    spread: Spread  # Of the parameters that have an interval, in their order
    rms: tuple[float, float]  # Root mean square of the residuals in standard deviations, before and after
    before: Sequence[Found]
    after: Sequence[Found]
    evaluations: int
    converged: bool
    kept: tuple[bool, ...]  # For each measured value, whether it is no outlier
    rms_of_all: float  # Root mean square of the residuals after, with the outliers
    misfit: str | None  # Why the model with these parameters does not fit; None if it does
    place: Array  # Coordinates of all parameters
    residuals: Array  # After, in standard deviations, of all measured values and then of the priors
    slopes: Array  # Their derivatives; 0 for a parameter that is not determined

    @property
    def determined(self) -> list[Estimate]:
        """Estimates with an interval."""
        return [estimate for estimate in self.estimates if estimate.half is not None]


def fit(model: Model, parameters: Sequence[Parameter], begin: Array | None = None) -> Fit:
    """Fits parameters, from their start values or from coordinates `begin`. Those that the table does not determine are held at their start values,
    those at a bound are held there.
    First a fit with a robust loss finds the outliers, which are then left out."""
    count = len(model.values) + sum(parameter.prior is not None for parameter in parameters)
    if count <= len(parameters):
        raise FitError(f"{count} measured values can't determine {len(parameters)} parameters")
    start = np.array([parameter.coordinate(parameter.start) for parameter in parameters])
    begin = start if begin is None else begin
    before = model.states(assign(parameters, begin))
    given_up: dict[int, str] = {}
    place, states = _carrying(model, parameters, begin, before)
    lost = [found.reason for found in states if found.reason is not None]
    if len(lost) == len(states) or model.exhausted:
        why = f"{len(lost)} of {len(states)} points have no steady state near the start values: {lost[0] if lost else ''}"
        raise FitError(f"{why}. Are forces and torques in the units of the table, or in pounds?")
    search = Search(model, parameters, place, states)
    # Directions that the data hardly see take most steps of a search, so their parameters wait until the others are fitted.
    waiting, again = weak_parameters(search.slopes), True
    _leave_out(search, [k for k in range(len(parameters)) if k not in waiting])
    while True:
        left = [k for k in range(len(parameters)) if k not in given_up]
        if not left:
            why = ", ".join(f"{parameters[k].name} {reason}" for k, reason in given_up.items())
            raise FitError(f"the table determines none of the parameters: {why}")
        if again:
            search.run([k for k in left if k not in waiting] or left, waiting)
        inner = [k for k in left if not search.at_bound(k)]
        spread = _spread(search, inner)
        wide = [k for k, half in enumerate(spread.halves) if half > UNDETERMINED]
        again = True
        if wide:
            # One that waits goes first, because nothing has to be fitted again.
            worst = max(wide, key=lambda k: (inner[k] in waiting, spread.halves[k]))
            dropped, again = inner[worst], inner[worst] not in waiting
            given_up[dropped] = _undetermined([parameters[k].name for k in inner], worst, spread)
            waiting = waiting - {dropped}
            search.hold(dropped, float(start[dropped]))
        elif waiting:
            waiting = frozenset()
        else:
            break
    halves, estimates = dict(zip(inner, spread.halves.tolist(), strict=True)), []
    for k, (parameter, at) in enumerate(zip(parameters, search.place.tolist(), strict=True)):
        interval = parameter.interval(at, halves[k]) if k in halves else None
        estimates.append(Estimate(parameter, parameter.value(at), halves.get(k), interval, given_up.get(k)))
    (at_start, at_end), kept = map(model.relative, (before, search.states)), search.kept[: len(model.values)]
    first, last, of_all = _rms(at_start[kept]), _rms(at_end[kept]), _rms(at_end)
    left = len(kept) - np.isfinite(at_end[kept]).sum()
    misfit = None
    if model.exhausted and not search.converged:
        lost = [found.reason for found in search.states if found.reason is not None]
        misfit = f"the search ended after {model.solves} solutions: {len(lost)} of {len(search.states)} points have no steady state"
    elif left > LOST_SHARE * len(kept):
        misfit = f"{left} of {len(kept)} values are outliers or at points without a steady state"
    elif last > MISFIT:
        misfit = f"the root mean square of the residuals is {last:.3g} standard deviations, above {MISFIT:g}"
    elif last > 1.0 and (np.isfinite(at_start[kept]).sum() == len(kept) - left) and last >= first * (1.0 - 1e-6):
        misfit = f"the root mean square of the residuals, {last:.3g} standard deviations, has not fallen"
    solved = before, search.states, search.evaluations, search.converged
    return Fit(tuple(estimates), spread, (first, last), *solved, tuple(kept.tolist()), of_all, misfit, search.place, search.residuals, search.slopes)


def _rms(relative: Array) -> float:
    """Root mean square of residuals, without those of points that have no steady state."""
    return float(np.sqrt(np.nansum(relative**2) / max(np.isfinite(relative).sum(), 1)))


def _carrying(model: Model, parameters: Sequence[Parameter], start: Array, states: list[Found]) -> tuple[Array, list[Found]]:
    """Initial coordinates and states. The friction is raised as long as this brings the model closer to the measurements."""
    place = start
    raised = np.array([RAISE if parameter.name == "friction.pulley" else 1.0 for parameter in parameters])
    while raised.max() > 1.0 and any(found.reason is not None for found in states) and not model.exhausted:
        higher = place * raised
        if any(x > parameter.bounds[1] for x, parameter in zip(higher, parameters, strict=True)):
            break
        found = model.states(assign(parameters, higher))
        if model.distance(found) >= model.distance(states):
            break
        place, states = higher, found
    return place, states


def weak_parameters(slopes: Array) -> frozenset[int]:
    """Parameters that the derivatives do not determine with the given standard deviations; at least one remains."""
    free, found = list(range(slopes.shape[1])), set()
    while len(free) > 1:
        halves = 2.0 * np.sqrt(np.diag(covariance(slopes[:, free])[0]))
        if halves.max() <= UNDETERMINED:
            break
        found.add(free.pop(int(np.argmax(halves))))
    return frozenset(found)


def covariance(slopes: Array) -> tuple[Array, Array]:
    """Covariance (JᵀJ)⁻¹, and singular values. Those below rounding correspond to directions without influence."""
    _, singular, turned = np.linalg.svd(slopes, full_matrices=False)
    floored = np.maximum(singular, 1e-12 * max(float(singular[0]), 1.0))
    return turned.T @ np.diag(floored**-2.0) @ turned, singular


def _leave_out(search: Search, free: Sequence[int]) -> None:
    """Fits with the robust loss `soft_l1`, and leaves out, worst first, values whose residual exceeds the scatter of all others with the confidence of
    the intervals: a t-test of the largest of many (Bonferroni). The scatter counts at least as the standard deviations. All values of a row,
    or of a sample, go together, because a faulty cell may be one of the conditions."""
    search.run(free, robust=True)
    values = search.model.values
    kept, size = search.kept[: len(values)], np.abs(search.residuals[: len(values)])
    rows, carried = values.groupby(["point", "time"], dropna=False).ngroup().to_numpy(), search.carried()[: len(values)]
    while True:
        tested = np.flatnonzero(kept & carried)
        freedom = len(tested) - len(search.parameters) - 1
        if freedom < 1:
            return
        worst = tested[np.argmax(size[tested])]
        scatter = max(float(np.sum(size[tested] ** 2) - size[worst] ** 2) / freedom, 1.0) ** 0.5
        if size[worst] <= student.ppf(1.0 - 0.5 * (1.0 - CONFIDENCE) / len(tested), freedom) * scatter:
            return
        kept &= rows != rows[worst]


def _spread(search: Search, inner: Sequence[int]) -> Spread:
    """Over the points that have a steady state, and the priors. `inner` are the parameters that are not at a bound."""
    if not inner:
        return Spread(np.empty(0), np.empty((0, 0)), np.empty(0), 1.0, 0)
    used = search.kept & search.carried()
    freedom = int(used.sum()) - len(inner)
    if freedom < 1:
        raise FitError(f"{used.sum()} values at points with a steady state can't determine {len(inner)} parameters")
    matrix, singular = covariance(search.slopes[used][:, list(inner)])
    deviations = np.sqrt(np.diag(matrix))
    reduced = float(np.sum(search.residuals[used] ** 2)) / freedom
    factor = float(np.sqrt(max(reduced, 1.0) if search.model.values["given"].all() else reduced))
    halves = student.ppf(0.5 + 0.5 * CONFIDENCE, freedom) * factor * deviations
    return Spread(halves, matrix / np.outer(deviations, deviations), singular, factor, freedom)


def _undetermined(names: Sequence[str], worst: int, spread: Spread) -> str:
    """Why the worst of some parameters is not determined."""
    correlations = spread.correlations[worst] * (np.arange(len(names)) != worst)
    nearest = int(np.argmax(np.abs(correlations)))
    half = "any size" if spread.halves[worst] > 1e3 else f"±{100.0 * spread.halves[worst]:.0f} %"
    text = f"cannot be identified from this table (its interval would be {half}), so it remains at its start value"
    if abs(correlations[nearest]) >= PARTNER:
        text += f"; the table cannot separate it from {names[nearest]} (correlation {correlations[nearest]:.2f})"
    return text


def _robust(squares: Array) -> Array:
    """The loss `soft_l1`, 2 (√(1 + r²) − 1), of which an outlier has a share that grows linearly, and its derivatives. A second one of 0 gives
    Gauss-Newton steps with weights, which do not overshoot far from the minimum."""
    roots = np.sqrt(1.0 + squares)
    return np.array([2.0 * (roots - 1.0), 1.0 / roots, np.zeros_like(squares)])


class Search:
    """Bounded least squares. The derivatives are central differences of steady states. Each trial updates them along its step (Broyden),
    which costs no further steady states. A search ends within the range of its derivatives, which then also give the intervals; else it
    continues with those at its end."""

    def __init__(self, model: Model, parameters: Sequence[Parameter], place: Array, states: list[Found]) -> None:
        self.model, self.parameters = model, tuple(parameters)
        self.place, self.states = place, states
        self.evaluations, self.converged = 0, False
        self._bounds = np.array([parameter.bounds for parameter in parameters]).T
        self.residuals = self._residuals(place, states)
        self.kept = np.ones(len(self.residuals), dtype=bool)  # Which measured values, and priors, are no outliers
        self.slopes = np.zeros((len(self.residuals), len(place)))
        self._differentiate(range(len(place)))

    def _residuals(self, place: Array, states: Sequence[Found]) -> Array:
        """Of the measured values and the priors."""
        priors = [(p.value(float(x)) - p.prior[0]) / p.prior[1] for p, x in zip(self.parameters, place, strict=True) if p.prior]
        return np.nan_to_num(np.concatenate([self.model.relative(states), priors]), nan=LOST)

    def carried(self) -> Array:
        """Which residuals are not those of points without a steady state."""
        return self.residuals != LOST

    def _differentiate(self, free: Iterable[int]) -> None:
        """Computes the derivatives. Those with respect to parameters that are not free are 0."""
        free, fixed, values = list(free), assign(self.parameters, self.place), len(self.model.values)
        self.slopes, self._differentiated = np.zeros_like(self.slopes), self.place
        self.slopes[:values, free] = self.model.slopes([self.parameters[k] for k in free], fixed, self.place[free], self.states)
        for row, (k, prior) in enumerate(((k, p.prior) for k, p in enumerate(self.parameters) if p.prior), values):
            parameter = self.parameters[k]
            self.slopes[row, k] = (parameter.value(float(self.place[k])) if parameter.logarithmic else parameter.start) / prior[1]

    def _move(self, place: Array) -> tuple[Array, list[Found], Array]:
        states = self.model.states(assign(self.parameters, place))
        return place, states, self._residuals(place, states)

    def hold(self, k: int, coordinate: float) -> None:
        if self.place[k] != coordinate:
            self.place, self.states, self.residuals = self._move(np.where(np.arange(len(self.place)) == k, coordinate, self.place))

    def at_bound(self, k: int) -> bool:
        return bool(np.abs(self._bounds[:, k] - self.place[k]).min() < AT_BOUND)

    def run(self, free: Sequence[int], waiting: Iterable[int] = (), robust: bool = False) -> None:
        """Minimises the sum of squares over the free parameters, with derivatives at its end by the waiting ones, too; or a robust loss."""
        every = [*free, *waiting]
        for _ in range(MOST_SEARCHES):
            found = self._search(list(free), robust)
            if robust:
                return
            self.converged = found and self._near
            if self._near or self.model.exhausted:
                break
            self._differentiate(every)
        for k in filter(self.at_bound, free):
            self.hold(k, float(min(self._bounds[:, k], key=lambda end: abs(end - self.place[k]))))
        if not self._near:
            self._differentiate(every)

    @property
    def _near(self) -> bool:
        """Whether the place is within the range of the derivatives."""
        return bool(np.abs(self.place - self._differentiated).max() <= NEAR)

    def _search(self, free: list[int], robust: bool) -> bool:
        """Searches from the place, with the derivatives there. Returns whether it reached a minimum."""
        trial = self.place, self.states, self.residuals

        def residuals(at: Array) -> Array:
            nonlocal trial
            place = self.place.copy()
            place[free] = at
            found = self.residuals
            if np.abs(step := place - self.place).max() > 1e-9:
                if self.model.exhausted:
                    return np.full(len(found) + 1, np.inf)  # A step that is refused
                trial = self._move(place)
                self.evaluations += 1
                found = trial[2]
                change = found - self.residuals - self.slopes @ step
                change[(found == LOST) | ~self.carried()] = 0.0
                self.slopes = self.slopes + np.outer(change, step) / float(step @ step)
            # A constant residual, of a standard deviation, makes the relative tolerance an absolute one for small residuals.
            return np.append(self.kept * found, 1.0)

        def slopes(at: Array) -> Array:
            if np.array_equal(trial[0][free], at):
                self.place, self.states, self.residuals = trial
            return np.vstack([self.kept[:, None] * self.slopes[:, free], np.zeros(len(free))])

        squares = self.kept * self.residuals**2
        losses = _robust(squares)[0] if robust else squares
        # Neither lost points nor outliers make the search coarse.
        ftol = (COARSE if robust else TOLERANCE) * (1.0 + np.minimum(losses, MISFIT**2).sum()) / (1.0 + losses.sum())
        found = least_squares(
            residuals, self.place[free], slopes, self._bounds[:, free], loss=_robust if robust else "linear",
            ftol=ftol, xtol=CHANGE, gtol=None, max_nfev=MOST_EVALUATIONS,
        )  # fmt: skip
        return bool(found.status > 0)
