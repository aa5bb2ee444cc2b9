"""Residuals and their derivatives from points and parameters, by steady states of the FMU in several processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pushbelt.fmu.geometry import Array
from pushbelt.fmu.unit import Archive
from pushbelt.report.side_by_side import Call, worker_pool
from pushbelt.tables.points import Measured, Point

from .parameters import Parameter, assign
from .worker import Found, Job, solve_all

STEP = 1e-3
"""Step of the finite differences in a parameter's coordinate, in which the start value is 1. For steps between 1e-4 and 3e-3
central differences agree within about 1e-3. The limited accuracy of shift rates sets the lower end."""
LOST = 100.0
"""Residual of a point without a steady state, in standard deviations. It is so large that no fit improves by losing a point that
the belt can carry. It is constant, so a lost point has no slope and does not influence the fit."""
FAR = 10.0  # Upper limit of a residual in the comparison of start points, in standard deviations
OUTSTANDING = 3.0
"""A one-sided slope above this multiple of the upper quartile of its quantity is checked by a step to the other side."""
CONTRADICTION = 0.5  # One-sided slopes contradict each other if they differ by more than this share of the larger one
CHUNK = 6  # Number of points per job of a process


class Value(NamedTuple):
    """A measured value and its point."""

    point: int  # Index of the point
    measured: Measured

    def of(self, state: Found) -> float | None:
        """The model's value in the state of its point; None without a steady state."""
        return state.values.get(self.measured.key or self.measured.quantity)


class Model:
    """Residuals as functions of the parameters."""

    def __init__(self, points: Sequence[Point], solve: Callable[[Sequence[Job]], list[Found]]) -> None:
        """`solve` solves jobs: values of variables, and a point."""
        self.points = tuple(points)
        self.values = tuple(Value(place, one) for place, point in enumerate(self.points) for one in point.measured)
        self.measured = np.array([value.measured.value for value in self.values])  # Measured values
        self.deviations = np.array([value.measured.deviation for value in self.values])
        """Standard deviations of the measured values."""
        self.solves = 0  # Number of steady states and recorded shifts solved so far
        self.solve = solve

    def states(self, assignments: Sequence[Mapping[str, float]]) -> list[list[Found]]:
        """Results of the model at all points, for several sets of values."""
        found, count = self._count([(values, point) for values in assignments for point in self.points]), len(self.points)
        # The slip of the last set of values is a good estimate for the next one.
        self.points = tuple(
            replace(point, slip=one.values.get("slip", point.slip)) if point.speed_ratio is not None else point
            for point, one in zip(self.points, found[-count:], strict=True)
        )
        return [found[k * count : (k + 1) * count] for k in range(len(assignments))]

    def _count(self, jobs: Sequence[Job]) -> list[Found]:
        found = self.solve(jobs) if jobs else []
        self.solves += sum(one.solves for one in found)
        return found

    def column(self, states: Sequence[Found]) -> Array:
        """Model values, one for each measured one; NaN where a point has no steady state."""
        return np.array([value.of(states[value.point]) for value in self.values], dtype=float)

    def residuals(self, states: Sequence[Found]) -> Array:
        """Model minus measurement in standard deviations; `LOST` at points without a steady state."""
        found = (self.column(states) - self.measured) / self.deviations
        return np.where(np.isnan(found), LOST, found)

    def distance(self, states: Sequence[Found]) -> float:
        """Merit of a start point: a sum of squares in which each residual is limited to `FAR`. The residual of a
        lost point is `FAR` times one plus the share of its torque that the belt does not carry."""
        found = np.abs(self.column(states) - self.measured) / self.deviations
        missing = np.array([states[value.point].missing for value in self.values])
        return float(np.sum(np.where(np.isnan(found), FAR * missing, np.minimum(found, FAR)) ** 2))

    def slopes(
        self, parameters: Sequence[Parameter], fixed: Mapping[str, float], at: Array, base: Sequence[Found], central: bool
    ) -> Array:
        """Derivatives of the residuals with respect to the coordinates, one column per parameter: central differences, or, if not
        `central`, one-sided ones, with steps to the other side only for outstanding points.

        A steady state may jump to another branch between two values of a parameter. Such a jump is not a slope. If the two
        one-sided slopes contradict each other, the smallest of both and their mean is used. A lost point has no slope.
        """
        carried = [place for place, found in enumerate(base) if found.reason is None]
        middle = self.column(base)

        def differences(side: int, places: Sequence[Sequence[int]]) -> Array:
            """One-sided slopes of the model values; NaN where nothing was solved, also where a step would leave the bounds."""
            keys, jobs = [], []
            for k, (parameter, some) in enumerate(zip(parameters, places, strict=True)):
                low, high = parameter.bounds
                inside = [step for step in (STEP, -STEP) if low <= at[k] + step <= high]
                for step in inside[side : side + 1]:
                    values = {**fixed, **assign(parameters, at + step * (np.arange(len(at)) == k))}
                    keys += [(place, k, step) for place in some]
                    jobs += [(values, self.points[place]) for place in some]
            found = np.full((len(self.values), len(parameters)), np.nan)
            for (place, k, step), state in zip(keys, self._count(jobs), strict=True):
                for row, value in enumerate(self.values):
                    if value.point == place and (moved := value.of(state)) is not None:
                        found[row, k] = (moved - middle[row]) / step
            return found

        everywhere = [carried] * len(parameters)
        one = differences(0, everywhere)
        again = everywhere if central else [self._outstanding(column, carried) for column in one.T]
        return _agreed(one, differences(1, again)) / self.deviations[:, np.newaxis]

    def _outstanding(self, slopes: Array, carried: Sequence[int]) -> list[int]:
        """Indices, among the points with a steady state, of points whose slope is much larger than that of others, or is missing."""
        found, quantities = ~np.isfinite(slopes), np.array([value.measured.quantity for value in self.values])
        for own in (quantities == quantity for quantity in np.unique(quantities)):
            usual = np.nanquantile(np.abs(slopes[own]), 0.75) if np.isfinite(slopes[own]).any() else 0.0
            found |= own & (np.abs(slopes) > OUTSTANDING * usual)
        return sorted({self.values[row].point for row in np.flatnonzero(found)}.intersection(carried))


def _agreed(one: Array, other: Array) -> Array:
    """Mean of the slopes to both sides, or the available one, else 0. If they contradict each other, one state is on another branch.
    If it is an outer one, the smaller slope is correct; if it is the middle one, their mean is. So the smallest is used."""
    one, other = np.where(np.isfinite(one), one, other), np.where(np.isfinite(other), other, one)
    mean = 0.5 * (one + other)
    smallest = np.where(np.abs(one) < np.abs(other), one, other)
    smallest = np.where(np.abs(mean) < np.abs(smallest), mean, smallest)
    contradicting = np.abs(one - other) > CONTRADICTION * np.maximum(np.abs(one), np.abs(other))
    return np.nan_to_num(np.where(contradicting, smallest, mean))


@contextmanager
def opened(
    fmu: Path, parameters: Mapping[str, float], points: Sequence[Point], workers: int, update: Callable[[float], object]
) -> Iterator[Model]:
    """A model whose points are solved in parallel processes. `update` is called with the number of points solved."""
    with Archive.unpack(fmu) as archive, worker_pool(workers) as run:

        def solve(jobs: Sequence[Job]) -> list[Found]:
            chunks = [jobs[k : k + CHUNK] for k in range(0, len(jobs), CHUNK)]
            calls: list[Call] = [(solve_all, (fmu, archive.directory, dict(parameters), chunk)) for chunk in chunks]
            found: list[Any] = run(calls, update)
            return [state for chunk in found for state in chunk]

        yield Model(points, solve)
