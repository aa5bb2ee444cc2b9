"""Bounded least squares with few steady states, and without outliers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress

import numpy as np
from scipy.optimize import least_squares, lsq_linear

from pushbelt.fmu.geometry import Array

from .model import LOST, Model
from .parameters import Parameter, assign
from .worker import Found

TOLERANCE = 1e-4, 1e-4
"""A search ends where its next step is expected to reduce the sum of squares by less than the first value plus this share of it."""
CONFIRMED = 10.0
"""Central differences at the end may expect a reduction of this multiple of the tolerance."""
SMALLEST = 3e-4
"""Relative length of steps at which a search ends."""
MOST_EVALUATIONS = 40
MOST_JACOBIANS = 6
"""Largest number of times that a search computes all derivatives."""
REACH, FARTHEST = 0.3, 1.0
"""Length of the first step in the coordinate of the parameter with the largest influence, and in that of any other."""
NEAR = 0.05
"""Change of that coordinate within which derivatives hold."""
AT_BOUND = 1e-3
"""Distance within which a coordinate counts as at its bound."""


class Search:
    """Least squares of scipy, whose derivatives are differences of steady states at the start.

    Each evaluation updates them along its step (Broyden), which costs no further steady states. Central differences at the end give the
    intervals, and confirm the end or continue the search.
    """

    def __init__(self, model: Model, parameters: Sequence[Parameter], place: Array, states: list[Found]) -> None:
        self.model, self.parameters = model, tuple(parameters)
        self.place, self.states = place, states
        self.evaluations, self.converged = 0, False
        self._low, self._high = np.array([parameter.bounds for parameter in parameters]).T
        self.residuals = self._all_residuals(place, states)
        self.weights = np.ones(len(self.residuals))
        """Factors of the residuals in the sum of squares: 0 for an outlier."""
        self.slopes = self._differences(range(len(place)), central=False)
        self._moved = np.inf
        """Length of all steps since the last central differences."""

    # Residuals and derivatives, of the measured values and the priors

    def _all_residuals(self, place: Array, states: Sequence[Found]) -> Array:
        priors = [(p.value(float(x)) - p.prior[0]) / p.prior[1] for p, x in zip(self.parameters, place, strict=True) if p.prior]
        return np.concatenate([self.model.residuals(states), priors])

    def _differences(self, free: Iterable[int], central: bool) -> Array:
        """Derivatives; the columns of parameters that are not free are 0."""
        free = list(free)
        chosen, fixed = [self.parameters[k] for k in free], assign(self.parameters, self.place)
        found = np.zeros((len(self.residuals), len(self.place)))
        found[: len(self.model.values), free] = self.model.slopes(chosen, fixed, self.place[free], self.states, central)
        for row, k in enumerate((k for k, p in enumerate(self.parameters) if p.prior), len(self.model.values)):
            parameter = self.parameters[k]
            slope = parameter.value(float(self.place[k])) if parameter.logarithmic else parameter.start
            found[row, k] = slope / parameter.prior[1]
        return found

    def _influence(self, free: Sequence[int]) -> Array:
        """Influence of each parameter on the residuals, relative to the largest one."""
        found = np.maximum(np.linalg.norm((self.weights[:, None] * self.slopes)[:, free], axis=0), 1e-12)
        return found / found.max()

    # Search

    def run(self, free: Sequence[int], waiting: Iterable[int] = ()) -> None:
        """Minimises the sum of squares over the free parameters. The derivatives at the end are also those of the waiting ones."""
        free, every = list(free), sorted({*free, *waiting})
        self.converged = False
        for _ in range(MOST_JACOBIANS):
            self.descend(free)
            for k in free:
                if self.at_bound(k):
                    self.hold(k, float(min(self._low[k], self._high[k], key=lambda end: abs(end - self.place[k]))))
            renewed = self._moved > NEAR or (self._moved > 0.0 and not self.expects_little(free, CONFIRMED))
            if renewed:
                self.slopes, self._moved = self._differences(every, central=True), 0.0
            self.converged = self.expects_little(free, CONFIRMED)
            if self.converged or not renewed or self.evaluations >= MOST_EVALUATIONS:
                return

    def descend(self, free: Sequence[int], most: int = MOST_EVALUATIONS) -> None:
        """Minimises the sum of squares with updated derivatives, by at most so many evaluations."""
        free = list(free)
        # scipy takes the first reach from the size of its start, so its unknowns are steps from there.
        scale = np.minimum(1.0 / self._influence(free), FARTHEST / REACH)
        origin = self.place[free] - REACH * scale

        def residuals(unknowns: Array) -> Array:
            place = self.place.copy()
            place[free] = np.clip(origin + unknowns, self._low[free], self._high[free])
            return self.weights * (self.residuals if np.allclose(place, self.place, 0.0, 1e-12) else self._try(place))

        def slopes(_: Array) -> Array:
            # scipy ends only by relative reductions of what was already solved.
            if self.evaluations >= MOST_EVALUATIONS or self.expects_little(free):
                raise StopIteration
            return self.weights[:, None] * self.slopes[:, free]

        with suppress(StopIteration):
            least_squares(
                residuals, self.place[free] - origin, slopes, (self._low[free] - origin, self._high[free] - origin), "dogbox",
                ftol=TOLERANCE[1], xtol=SMALLEST, gtol=1e-8, x_scale=scale, max_nfev=most + 1,
            )  # fmt: skip

    def _try(self, place: Array) -> Array:
        """Residuals at a place. Updates the derivatives, and moves there if it is better."""
        step = place - self.place
        (states,) = self.model.states([assign(self.parameters, place)])
        self.evaluations += 1
        found = self._all_residuals(place, states)
        change = found - self.residuals - self.slopes @ step
        change[(found == LOST) | (self.residuals == LOST)] = 0.0
        self.slopes = self.slopes + np.outer(change, step) / float(step @ step)
        if self._total(found) < self._total(self.residuals):
            self._moved += float((np.abs(step) * self._influence(range(len(step)))).max())
            self.place, self.states, self.residuals = place, states, found
        return found

    def _total(self, residuals: Array) -> float:
        return float(np.sum((self.weights * residuals) ** 2))

    def expects_little(self, free: Sequence[int], share: float = 1.0) -> bool:
        """Whether the linear model expects a reduction of the sum of squares within the bounds that is below this multiple of the tolerance."""
        slopes, residuals = (self.weights[:, None] * self.slopes)[:, free], self.weights * self.residuals
        low, high = (end[free] - self.place[free] for end in (self._low, self._high))
        # `lsq_linear` requires a range of each unknown.
        found = lsq_linear(slopes, -residuals, (np.minimum(low, 0.0), np.maximum(high, low + 1e-12)))
        # A lost point is constant, and does not make the search coarse.
        total = self._total(np.where(self.residuals == LOST, 0.0, self.residuals))
        return float(residuals @ residuals) - 2.0 * found.cost <= share * (TOLERANCE[0] + TOLERANCE[1] * total)

    def hold(self, k: int, coordinate: float) -> None:
        """Fixes a parameter at a coordinate."""
        if self.place[k] != coordinate:
            self.place = np.where(np.arange(len(self.place)) == k, coordinate, self.place)
            (self.states,) = self.model.states([assign(self.parameters, self.place)])
            self.residuals = self._all_residuals(self.place, self.states)
            self._moved = np.inf

    def at_bound(self, k: int) -> bool:
        """Whether a parameter is at a bound."""
        return bool(min(self.place[k] - self._low[k], self._high[k] - self.place[k]) < AT_BOUND)
