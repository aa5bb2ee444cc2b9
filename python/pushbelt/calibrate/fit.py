"""A fit: least squares without outliers, confidence intervals, and detection of parameters that the table does not determine."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import t as student

from pushbelt.errors import PushbeltError
from pushbelt.fmu.geometry import Array

from .model import Model
from .parameters import Parameter, assign
from .search import Search
from .worker import Found

CONFIDENCE = 0.95
UNDETERMINED = 1.0
"""Largest half-width of the interval of a determined parameter, in its coordinate: the start value itself, or a factor of e."""
MISFIT = 3.0  # Root mean square of the residuals, in standard deviations, above which a fit is bad
LOST_SHARE = 1.0 / 3.0  # Share of values at points without a steady state above which a fit is bad
RAISE = 1.1  # Factor by which the friction is raised while points have no steady state at the start values
PARTNER = 0.9  # Correlation above which two parameters can hardly be separated


class FitError(PushbeltError, RuntimeError):
    """There is nothing to fit."""


class Undetermined(NamedTuple):
    """Reason why a parameter was reset to its start value."""

    half: float  # Half-width of its interval in its coordinate; infinite if it has no influence
    partner: str | None  # Parameter from which it cannot be separated
    correlation: float


class Estimate:
    """A parameter after the fit."""

    def __init__(self, parameter: Parameter, coordinate: float, half: float | None, undetermined: Undetermined | None) -> None:
        """`half`: half-width of its confidence interval in its coordinate; None if it is at a bound or not determined."""
        self.parameter, self.half, self.undetermined = parameter, half, undetermined
        self.value = parameter.value(coordinate)
        self.interval = None if half is None else parameter.interval(coordinate, half)
        self.at_bound = half is None and undetermined is None


class Spread(NamedTuple):
    """Confidence intervals of parameters, in their coordinates."""

    halves: Array
    correlations: Array
    singular_values: Array  # Of the Jacobian of the residuals, in standard deviations per unit of coordinate
    factor: float  # Factor of the standard deviations in the intervals


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

    @property
    def determined(self) -> list[Estimate]:
        """Estimates with an interval."""
        return [estimate for estimate in self.estimates if estimate.half is not None]


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
    search = Search(model, parameters, place, states)
    # Directions that the data hardly see take most steps of a search, so their parameters wait until the others are fitted.
    waiting, again = _weak(search.slopes), True
    _leave_out(search, [k for k in range(len(parameters)) if k not in waiting])
    while True:
        left = [k for k in range(len(parameters)) if k not in given_up]
        if not left:
            why = ", ".join(f"{parameters[k].name} (±{100.0 * reason.half:.3g} %)" for k, reason in given_up.items())
            raise FitError(f"the table determines none of the parameters: {why}")
        if again:
            search.run([k for k in left if k not in waiting], waiting)
        inner = [k for k in left if not search.at_bound(k)]
        spread = _spread(search, inner)
        wide = [k for k, half in enumerate(spread.halves) if half > UNDETERMINED]
        again = True
        if wide:
            # One that waits goes first, because nothing has to be fitted again.
            worst = max(wide, key=lambda k: (inner[k] in waiting, spread.halves[k]))
            lost, again = inner[worst], inner[worst] not in waiting
            given_up[lost] = _undetermined([parameters[k].name for k in inner], worst, spread)
            waiting = waiting - {lost}
            search.hold(lost, start[lost])
        elif waiting:
            waiting = frozenset()
        else:
            break
    halves = dict(zip(inner, spread.halves.tolist(), strict=True))
    estimates = (Estimate(p, float(search.place[k]), halves.get(k), given_up.get(k)) for k, p in enumerate(parameters))
    return _result(search, tuple(estimates), spread, before)


def _result(search: Search, estimates: tuple[Estimate, ...], spread: Spread, before: Sequence[Found]) -> Fit:
    model, kept = search.model, search.kept[: len(search.model.values)]
    (first, used_before), (last, used), (of_all, _) = (
        _rms(model, states, some) for states, some in ((before, kept), (search.states, kept), (search.states, kept | True))
    )
    misfit = None
    if len(kept) - used > LOST_SHARE * len(kept):
        misfit = f"{len(kept) - used} of {len(kept)} values are outliers or at points without a steady state"
    elif last > MISFIT:
        misfit = f"the root mean square of the residuals is {last:.3g} standard deviations, above {MISFIT:g}"
    elif last > 1.0 and used_before == used and last >= first * (1.0 - 1e-6):
        misfit = f"the root mean square of the residuals, {last:.3g} standard deviations, has not fallen"
    return Fit(
        estimates, spread, (first, last), before, search.states, search.evaluations, search.converged, tuple(kept.tolist()), of_all, misfit
    )


def _rms(model: Model, states: Sequence[Found], kept: Array) -> tuple[float, int]:
    """Root mean square of kept residuals at points that have a steady state, in standard deviations, and their number."""
    found = ((model.column(states) - model.measured) / model.deviations)[kept]
    used = sum(states[model.values[k].point].reason is None for k in np.flatnonzero(kept))
    return float(np.sqrt(np.nansum(found**2) / max(used, 1))), used


def _carrying(model: Model, parameters: Sequence[Parameter], start: Array, states: list[Found]) -> tuple[Array, list[Found]]:
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


def _weak(slopes: Array) -> frozenset[int]:
    """Parameters that the derivatives do not determine with the given standard deviations; at least one remains."""
    free, found = list(range(slopes.shape[1])), set()
    while len(free) > 1:
        _, singular, turned = np.linalg.svd(slopes[:, free], full_matrices=False)
        halves = 2.0 * np.linalg.norm(turned.T / np.maximum(singular, 1e-12), axis=1)
        if halves.max() <= UNDETERMINED:
            break
        found.add(free.pop(int(np.argmax(halves))))
    return frozenset(found)


def _leave_out(search: Search, free: Sequence[int]) -> None:
    """Fits with the robust loss `soft_l1`, and leaves out, worst first, values whose residual exceeds the scatter of all others with the confidence of
    the intervals: a t-test of the largest of many (Bonferroni). The scatter counts at least as the standard deviations. All values of a row,
    or of a sample, go together, because a faulty cell may be one of the conditions."""
    search.run(free, robust=True)
    kept = search.kept[: len(search.model.values)]
    values, size = search.model.values, np.abs(search.residuals)
    rows = [(value.point, value.measured.time) for value in values]
    carried = np.array([search.states[value.point].reason is None for value in values])
    while True:
        tested = np.flatnonzero(kept & carried)
        freedom = len(tested) - len(search.parameters) - 1
        if freedom < 1:
            return
        worst = tested[np.argmax(size[tested])]
        scatter = max(float(np.sum(size[tested] ** 2) - size[worst] ** 2) / freedom, 1.0) ** 0.5
        if size[worst] <= student.ppf(1.0 - 0.5 * (1.0 - CONFIDENCE) / len(tested), freedom) * scatter:
            return
        kept &= [row != rows[worst] for row in rows]


def _spread(search: Search, inner: Sequence[int]) -> Spread:
    """Covariance (JᵀJ)⁻¹ by singular values, over the points that have a steady state, and the priors. `inner` are the parameters that are
    not at a bound."""
    if not inner:
        return Spread(np.empty(0), np.empty((0, 0)), np.empty(0), 1.0)
    values = search.model.values
    used = search.kept.copy()
    used[: len(values)] &= [search.states[value.point].reason is None for value in values]
    freedom = int(used.sum()) - len(inner)
    if freedom < 1:
        raise FitError(f"{used.sum()} values at points with a steady state can't determine {len(inner)} parameters")
    _, singular, turned = np.linalg.svd(search.slopes[used][:, list(inner)], full_matrices=False)
    # Singular values below rounding correspond to directions without influence, with an infinite interval.
    floored = np.maximum(singular, 1e-12 * max(float(singular[0]), 1.0))
    covariance = turned.T @ np.diag(floored**-2.0) @ turned
    deviations = np.sqrt(np.diag(covariance))
    reduced = float(np.sum(search.residuals[used] ** 2)) / freedom
    trusted = all(value.measured.given for value in values)
    factor = float(np.sqrt(max(reduced, 1.0) if trusted else reduced))
    halves = student.ppf(0.5 + 0.5 * CONFIDENCE, freedom) * factor * deviations
    return Spread(halves, covariance / np.outer(deviations, deviations), singular, factor)


def _undetermined(names: Sequence[str], worst: int, spread: Spread) -> Undetermined:
    """Why the worst of some parameters is not determined."""
    correlations = spread.correlations[worst] * (np.arange(len(names)) != worst)
    nearest = int(np.argmax(np.abs(correlations)))
    near = abs(correlations[nearest]) >= PARTNER
    return Undetermined(float(spread.halves[worst]), names[nearest] if near else None, float(correlations[nearest]))
