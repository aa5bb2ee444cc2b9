"""Bounded least squares by few steady states."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from scipy.optimize import lsq_linear

from pushbelt.fmu.geometry import Array

from .model import LOST, Model
from .parameters import Parameter, assign
from .worker import Found

TOLERANCE = 1e-4
"""A search ends where its next step is expected to reduce the sum of squares by less than this value plus this share of it."""
CONFIRMED = 10.0  # The derivatives at the end may expect a reduction of this multiple of the tolerance
MOST_EVALUATIONS = 40
MOST_JACOBIANS = 6  # Largest number of times that a search computes all derivatives
REACH = 0.3, 1.0, 1e-5  # First, largest and smallest length of a step in a coordinate
NEAR = 0.05
"""Length of steps, in the coordinate of the parameter with the largest influence, within which derivatives hold."""
DAMPING = 0.01
"""Weight of the squared step. It is far below that of a determined parameter, and shortens steps along directions that the data
do not see."""
AT_BOUND = 1e-3  # Distance within which a coordinate counts as at its bound


class Search:
    """Bounded least squares by Gauss-Newton steps in a trust region.

    The derivatives are differences of steady states at the start. Then each trial updates them along its step (Broyden), which
    costs no further steady states. Central differences at the end give the intervals, and confirm the end or continue the search.
    On tables of 30 points with three and six parameters this takes 0.6 and 0.8 times the steady states of scipy's `least_squares` with
    the same derivatives.
    """

    def __init__(self, model: Model, parameters: Sequence[Parameter], place: Array, states: list[Found]) -> None:
        self.model, self.parameters = model, tuple(parameters)
        self.place, self.states = place, states
        self.evaluations, self.converged = 0, False
        self._low, self._high = np.array([parameter.bounds for parameter in parameters]).T
        self.residuals = self._residuals(place, states)
        self.kept = np.ones(len(self.residuals), dtype=bool)  # Which measured values, and priors, are no outliers
        self._robust = False
        self.slopes = self._differences(range(len(place)), central=False)
        self._length = 0.0  # Length of the last step, as the reach counts
        self._moved = np.inf  # Length of all steps since the last central differences

    # Residuals and derivatives, of the measured values and the priors

    def _residuals(self, place: Array, states: Sequence[Found]) -> Array:
        priors = [(p.value(float(x)) - p.prior[0]) / p.prior[1] for p, x in zip(self.parameters, place, strict=True) if p.prior]
        return np.nan_to_num(np.concatenate([self.model.relative(states), priors]), nan=LOST)

    def _at(self, place: Array) -> tuple[list[Found], Array]:
        (states,) = self.model.states([assign(self.parameters, place)])
        return states, self._residuals(place, states)

    def carried(self) -> Array:
        """Which residuals are not those of points without a steady state."""
        return self.residuals != LOST

    def _differences(self, free: Sequence[int], central: bool) -> Array:
        """Derivatives; the columns of parameters that are not free are 0."""
        free = list(free)
        chosen = [self.parameters[k] for k in free]
        fixed = assign(self.parameters, self.place)
        found = np.zeros((len(self.residuals), len(self.place)))
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
        return self.kept * ((1.0 + self.residuals**2) ** -0.25 if self._robust else 1.0)

    # Search

    def hold(self, k: int, coordinate: float) -> None:
        """Fixes a parameter at a coordinate."""
        if self.place[k] != coordinate:
            self.place = np.where(np.arange(len(self.place)) == k, coordinate, self.place)
            self.states, self.residuals = self._at(self.place)
            self._moved = np.inf

    def run(self, free: Sequence[int], waiting: Iterable[int] = (), robust: bool = False) -> None:
        """Minimises the loss over the free parameters. The derivatives at the end are also those of the waiting ones. A robust search ends
        without them."""
        self._robust = robust
        free, every = list(free), sorted({*free, *waiting})
        reach, jacobians, confirmed, self.converged = REACH[0], 0, False, False
        while self.evaluations < MOST_EVALUATIONS:
            total = self._loss(self.residuals)
            step, expected = self._step(free, reach)
            # A lost point is constant, and does not make the search coarse.
            tolerance = TOLERANCE * (1.0 + self._loss(np.where(self.carried(), self.residuals, 0.0)))
            small = expected <= tolerance * (CONFIRMED if confirmed or robust else 1.0)
            if small or reach < REACH[2] or (confirmed and jacobians >= MOST_JACOBIANS):
                if robust:
                    return
                if self._moved <= NEAR:
                    self.converged = expected <= tolerance * CONFIRMED or reach >= REACH[2]
                    break
                self.slopes, self._moved = self._differences(every, central=True), 0.0
                jacobians, confirmed, reach = jacobians + 1, True, max(reach, 0.1)
                continue
            better = self._try(step, total, expected)
            if better > 0.75:
                reach = min(max(reach, 2.0 * self._length), REACH[1])
            elif better < 0.25:
                reach = (0.25 if better <= 0.0 else 0.5) * self._length
                if better <= 0.0 and reach < 0.01 and jacobians < MOST_JACOBIANS:
                    self.slopes = self._differences(every, central=False)
                    jacobians, reach = jacobians + 1, 0.1
        if robust:
            return
        for k in free:
            if self.at_bound(k):
                self.hold(k, float(min(self._low[k], self._high[k], key=lambda end: abs(end - self.place[k]))))
        if self._moved > NEAR:
            self.slopes, self._moved = self._differences(every, central=True), 0.0

    def _step(self, free: list[int], reach: float) -> tuple[Array, float]:
        """The step of the linear model within the bounds and the reach, and the reduction that it expects."""
        weights = self._weights
        slopes, residuals = weights[:, None] * self.slopes[:, free], weights * self.residuals
        # The reach is that of the parameter with the largest influence; others may move farther.
        influence = np.maximum(np.linalg.norm(slopes, axis=0), 1e-12)
        reaches = np.minimum(reach * influence.max() / influence, REACH[1])
        low = np.maximum(self._low[free] - self.place[free], -reaches)
        high = np.minimum(self._high[free] - self.place[free], reaches)
        # `lsq_linear` requires a range of each unknown.
        high = np.maximum(high, low + 1e-12)
        rows = np.vstack([slopes, np.sqrt(DAMPING) * np.eye(len(free))])
        found = lsq_linear(rows, np.concatenate([-residuals, np.zeros(len(free))]), (low, high), method="bvls")
        own = np.clip(found.x, low, high)
        after, step = residuals + slopes @ own, np.zeros(len(self.place))
        step[free] = own
        self._length = float((np.abs(own) * influence).max() / influence.max())
        return step, float(residuals @ residuals - after @ after)

    def _try(self, step: Array, total: float, expected: float) -> float:
        """Solves at the end of a step, updates the derivatives, and moves there if it is better. Returns the actual reduction over
        the expected one."""
        place = np.clip(self.place + step, self._low, self._high)
        states, found = self._at(place)
        self.evaluations += 1
        change = found - self.residuals - self.slopes @ step
        change[(found == LOST) | (self.residuals == LOST)] = 0.0
        self.slopes = self.slopes + np.outer(change, step) / float(step @ step)
        reduction = total - self._loss(found)
        if reduction > 0.0:
            self.place, self.states, self.residuals = place, states, found
            self._moved += self._length
        return reduction / expected

    def at_bound(self, k: int) -> bool:
        """Whether a parameter is at a bound."""
        return bool(min(self.place[k] - self._low[k], self._high[k] - self.place[k]) < AT_BOUND)
