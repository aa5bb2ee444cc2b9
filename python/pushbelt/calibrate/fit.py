"""Bounded least squares, confidence intervals, and detection of parameters that the table does not determine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from pushbelt.fmu.geometry import Array

from pushbelt.rig.model import Model
from pushbelt.rig.parameters import Parameter, assign
from pushbelt.rig.worker import Found

CONFIDENCE = 0.95
UNDETERMINED = 1.0
"""Largest half-width of the interval of a determined parameter, in its coordinate: the start value itself, or a factor of e."""
TOLERANCE = 1e-7, 1e-5
"""Relative changes of the sum of squares and of the coordinates at which a fit ends."""
MOST_EVALUATIONS = 40
AT_BOUND = 1e-3
"""Distance within which a coordinate counts as at its bound."""
RAISE = 1.1
"""Factor by which the friction is raised while points have no steady state at the start values."""
PARTNER = 0.9
"""Correlation above which two parameters can hardly be separated."""


class FitError(RuntimeError):
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
    """Fits parameters. Those that the table does not determine are reset to their start values one by one."""
    count = len(model.values)
    if count <= len(parameters):
        raise FitError(f"{count} measured values can't determine {len(parameters)} parameters")
    start = np.array([parameter.coordinate(parameter.start) for parameter in parameters])
    (before,) = model.states([assign(parameters, start)])
    given_up: dict[int, Undetermined] = {}
    place, states = _carrying(model, parameters, start, list(before))
    if all(found.reason is not None for found in states):
        raise FitError(f"no point has a steady state at the start values: {states[0].reason}")
    evaluations = 0
    while True:
        free = [k for k in range(len(parameters)) if k not in given_up]
        if not free:
            raise FitError("the table determines none of the parameters: " + _why(parameters, given_up))
        place, states, converged, used = _least_squares(model, parameters, place, free, states)
        evaluations += used
        inner = [k for k in free if not _at_bound(parameters[k], place[k])]
        spread = _spread(model, parameters, place, inner, states)
        worst = int(np.argmax(spread.halves)) if inner else 0
        if not inner or spread.halves[worst] <= UNDETERMINED:
            break
        given_up[inner[worst]] = _undetermined(parameters, inner, worst, spread)
        place = np.where(np.arange(len(place)) == inner[worst], start, place)
        (states,) = model.states([assign(parameters, place)])
    halves = dict(zip(inner, spread.halves.tolist(), strict=True))
    return Fit(
        estimates=tuple(
            Estimate(parameter, float(place[k]), halves.get(k), given_up.get(k))
            for k, parameter in enumerate(parameters)
        ),
        correlations=spread.correlations,
        singular_values=spread.singular_values,
        chi_squared=(chi_squared(model, before), chi_squared(model, states)),
        freedom=_used(model, states) - len(inner),
        factor=spread.factor,
        before=tuple(before),
        after=tuple(states),
        evaluations=evaluations,
        converged=converged,
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


def _least_squares(
    model: Model, parameters: Sequence[Parameter], start: Array, free: Sequence[int], states: list[Found]
) -> tuple[Array, list[Found], bool, int]:
    """Minimises the sum of squares. Returns coordinates, states, whether it converged, and the number of evaluations."""
    chosen = [parameters[k] for k in free]
    known: dict[bytes, list[Found]] = {start[free].tobytes(): states}

    def whole(coordinates: Array) -> Array:
        place = start.copy()
        place[free] = coordinates
        return place

    def solved(coordinates: Array) -> list[Found]:
        key = coordinates.tobytes()
        if key not in known:
            (known[key],) = model.states([assign(parameters, whole(coordinates))])
        return known[key]

    def residuals(coordinates: Array) -> Array:
        return model.residuals(solved(coordinates))

    def slopes(coordinates: Array) -> Array:
        fixed = assign(parameters, whole(coordinates))
        return model.slopes(chosen, fixed, coordinates, solved(coordinates), central=False)

    low, high = np.array([parameter.bounds for parameter in chosen]).T
    found = least_squares(
        residuals,
        start[free],
        jac=slopes,
        bounds=(low, high),
        ftol=TOLERANCE[0],
        xtol=TOLERANCE[1],
        gtol=None,
        max_nfev=MOST_EVALUATIONS,
    )
    return whole(found.x), solved(found.x), found.status > 0, found.nfev


def _at_bound(parameter: Parameter, coordinate: float) -> bool:
    low, high = parameter.bounds
    return min(coordinate - low, high - coordinate) < AT_BOUND


def _used(model: Model, states: Sequence[Found]) -> int:
    """Measured values of points that have a steady state."""
    return sum(states[value.point].reason is None for value in model.values)


def chi_squared(model: Model, states: Sequence[Found]) -> float:
    """Sum of squares over the points that have a steady state, in standard deviations."""
    return float(np.nansum(((model.column(states) - model.measured) / model.deviations) ** 2))


def _spread(
    model: Model, parameters: Sequence[Parameter], place: Array, inner: Sequence[int], states: list[Found]
) -> _Spread:
    """Covariance (JᵀJ)⁻¹ by singular values, over the points that have a steady state."""
    if not inner:
        return _Spread(np.empty(0), np.empty((0, 0)), np.empty(0), 1.0)
    chosen = [parameters[k] for k in inner]
    slopes = model.slopes(chosen, assign(parameters, place), place[list(inner)], states, central=True)
    used = np.array([states[value.point].reason is None for value in model.values])
    _, singular, turned = np.linalg.svd(slopes[used], full_matrices=False)
    # Singular values below rounding correspond to directions without influence, with an infinite interval.
    floored = np.maximum(singular, 1e-12 * max(float(singular[0]), 1.0))
    covariance = turned.T @ np.diag(floored**-2.0) @ turned
    deviations = np.sqrt(np.diag(covariance))
    freedom = int(used.sum()) - len(inner)
    if freedom < 1:
        raise FitError(
            f"{int(used.sum())} values at points with a steady state can't determine {len(inner)} parameters"
        )
    reduced = chi_squared(model, states) / freedom
    trusted = all(value.measured.given for value in model.values)
    factor = float(np.sqrt(max(reduced, 1.0) if trusted else reduced))
    halves = student.ppf(0.5 + 0.5 * CONFIDENCE, freedom) * factor * deviations
    return _Spread(halves, covariance / np.outer(deviations, deviations), singular, factor)


def _undetermined(parameters: Sequence[Parameter], inner: Sequence[int], worst: int, spread: _Spread) -> Undetermined:
    correlations = spread.correlations[worst].copy()
    correlations[worst] = 0.0
    nearest = int(np.argmax(np.abs(correlations)))
    near = abs(correlations[nearest]) >= PARTNER
    partner = parameters[inner[nearest]].name if near else None
    return Undetermined(float(spread.halves[worst]), partner, float(correlations[nearest]) if near else 0.0)
