"""Residuals and their derivatives from points and parameters, by steady states of the FMU in several processes."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from pushbelt.fmu.geometry import Array
from pushbelt.fmu.unit import Archive
from pushbelt.report import page
from pushbelt.report.side_by_side import Call, progress_bar, worker_pool
from pushbelt.tables.columns import MEASURED
from pushbelt.tables.points import Point

from .parameters import Parameter, assign
from .worker import Found, Job, solve_all

STEP = 1e-3
"""Step of the finite differences in a parameter's coordinate, in which the start value is 1. For steps between 1e-4 and 3e-3
central differences agree within about 1e-3. The limited accuracy of shift rates sets the lower end."""
LOST = 100.0
"""Residual of a point without a steady state, in standard deviations. It is so large that no fit improves by losing a point that
the belt can carry. It is constant, so a lost point has no slope and does not influence the fit."""
FAR = 10.0  # Upper limit of a residual in the comparison of start points, in standard deviations
CONTRADICTION = 0.5  # One-sided slopes contradict each other if they differ by more than this share of the larger one
LONGEST = 2.5  # Number of solutions after which a search ends, in expected ones
CHUNK = 6  # Number of points per job of a process


class Model:
    """Residuals as functions of the parameters."""

    def __init__(self, points: Sequence[Point], solve: Callable[[Sequence[Job]], list[Found]], most_solves: float = np.inf) -> None:
        """`solve` solves jobs: values of variables, and a point. A search ends after `most_solves` solutions."""
        self.points, self.solve = tuple(points), solve
        rows = [
            {"point": place, **vars(point), **vars(one), "near": None, "measured": one.value, "sd": one.deviation, "key": one.key or one.quantity}
            for place, point in enumerate(points)
            for one in point.measured
        ]
        numbers = ("time", "ratio", "speed_ratio", "primary_force", "measured", "sd")
        self.values = pd.DataFrame(rows).astype(dict.fromkeys(numbers, float))
        """A row for each measured value, SI, in the order of the table: its point, and standard deviation `sd`."""
        self.deviations = self.values["sd"].to_numpy()
        self.solves = 0  # Number of steady states and recorded shifts solved so far
        self.most_solves = most_solves
        self._last = 0  # Number of those of all points with one set of values

    def states(self, values: Mapping[str, float]) -> list[Found]:
        """Results of the model at all points with these values."""
        found = self._count([(values, point) for point in self.points])
        self._last = sum(one.solves for one in found)
        # Slip and steady state of the last values are good estimates for the next ones.
        self.points = tuple(
            replace(point, slip=one.values.get("slip", point.slip), near=one.near or point.near, by_ratio=one.by_ratio or point.by_ratio)
            for point, one in zip(self.points, found, strict=True)
        )
        return found

    @property
    def exhausted(self) -> bool:
        """Whether another solution of all points would take too long."""
        return self.solves + self._last > self.most_solves

    def _count(self, jobs: Sequence[Job]) -> list[Found]:
        found = self.solve(jobs) if jobs else []
        self.solves += sum(one.solves for one in found)
        return found

    def rows(self, states: Sequence[Found], kept: Sequence[bool] | bool = True) -> pd.DataFrame:
        """The measured values with the model's, `found`, or the `reason` why there is none, and whether the fit contains them. `residual` is
        model minus measurement, `relative` the same in standard deviations."""
        found = self.column(states)
        reasons = np.array([states[place].reason for place in self.values["point"]], dtype=object)
        rows = self.values.assign(found=found, reason=reasons, kept=kept, residual=found - self.values["measured"])
        return rows.assign(relative=rows["residual"] / rows["sd"])

    def column(self, states: Sequence[Found]) -> Array:
        """Model values, one for each measured one; NaN where a point has no steady state."""
        keys = zip(self.values["point"], self.values["key"], strict=True)
        return np.array([states[place].values.get(key, np.nan) for place, key in keys], dtype=float)

    def relative(self, states: Sequence[Found]) -> Array:
        """Model minus measurement in standard deviations; NaN where a point has no steady state."""
        return (self.column(states) - self.values["measured"].to_numpy()) / self.deviations

    def distance(self, states: Sequence[Found]) -> float:
        """Merit of a start point: a sum of squares in which each residual is limited to `FAR`. The residual of a
        lost point is `FAR` times one plus the share of its torque that the belt does not carry."""
        found, missing = np.abs(self.relative(states)), np.array([states[place].missing for place in self.values["point"]])
        return float(np.sum(np.where(np.isnan(found), FAR * missing, np.minimum(found, FAR)) ** 2))

    def slopes(
        self, parameters: Sequence[Parameter], fixed: Mapping[str, float], at: Array, base: Sequence[Found], width: float = STEP
    ) -> Array:
        """Derivatives of the residuals with respect to the coordinates, one column per parameter: differences over `width` to both sides. A steady
        state may jump to another branch between two values of a parameter. Such a jump is not a slope. If the two one-sided slopes
        contradict each other, the smallest of both and their mean is used. A lost point has no slope."""
        carried, lost = [place for place, found in enumerate(base) if found.reason is None], Found({})
        jobs: dict[tuple[int, float, int], Job] = {}
        for k, parameter in enumerate(parameters):
            for step in (width, -width):
                if parameter.bounds[0] <= at[k] + step <= parameter.bounds[1]:
                    values = {**fixed, **assign(parameters, at + step * (np.arange(len(at)) == k))}
                    jobs |= {(k, step, place): (values, self.points[place]) for place in carried}
        moved = dict(zip(jobs, self._count(list(jobs.values())), strict=True))

        def differences(step: float) -> Array:
            """One-sided slopes of the model values; NaN where nothing was solved, also where a step would leave the bounds."""
            columns = [self.column([moved.get((k, step, place), lost) for place in range(len(self.points))]) for k in range(len(at))]
            return (np.transpose(columns) - self.column(base)[:, np.newaxis]) / step

        return _agreed(differences(width), differences(-width)) / self.deviations[:, np.newaxis]


def _agreed(one: Array, other: Array) -> Array:
    """Mean of the slopes to both sides, or the available one, else 0. If they contradict each other, one state is on another branch.
    If it is an outer one, the smaller slope is correct; if it is the middle one, their mean is. So the smallest is used."""
    one, other = np.where(np.isfinite(one), one, other), np.where(np.isfinite(other), other, one)
    every = np.array([0.5 * (one + other), one, other])
    smallest = np.take_along_axis(every, np.abs(np.nan_to_num(every)).argmin(axis=0)[None], axis=0)[0]
    contradicting = np.abs(one - other) > CONTRADICTION * np.maximum(np.abs(one), np.abs(other))
    return np.nan_to_num(np.where(contradicting, smallest, every[0]))


def plain(value: float | None, digits: int = 5, none: str = "") -> str:
    """A number with so many significant digits; `none` for one that is unknown."""
    return none if value is None or value != value else f"{value:.{digits}g}".replace("-", page.MINUS)


def quantities(rows: pd.DataFrame) -> list[str]:
    """Measured quantities, in the order of the table of quantities."""
    return [quantity for quantity in MEASURED if (rows["quantity"] == quantity).any()]


def of(rows: pd.DataFrame, quantity: str) -> pd.DataFrame:
    """Those of a quantity that have a model value."""
    return rows[(rows["quantity"] == quantity) & rows["found"].notna()]


class Score(NamedTuple):
    """Residuals of a quantity with a parameter set, SI; NaN without any."""

    quantity: str
    variator: str
    count: int  # type: ignore[assignment]  # Values at points with a steady state
    lost: int  # Values at points without one
    rms: float
    bias: float  # Mean of model minus measurement
    relative: float  # Root mean square in standard deviations
    explained: float  # 1 minus the residual sum of squares over that about the measured mean; NaN for a constant quantity


def score(rows: pd.DataFrame, quantity: str, variator: str = "") -> Score:
    known = of(rows, quantity)
    squares, spread = known["residual"] ** 2, ((known["measured"] - known["measured"].mean()) ** 2).sum()
    explained = 1.0 - squares.sum() / spread if spread else np.nan
    rms, bias, relative = np.sqrt(squares.mean()), known["residual"].mean(), np.sqrt((known["relative"] ** 2).mean())
    lost = int((rows["quantity"] == quantity).sum()) - len(known)
    return Score(quantity, variator, len(known), lost, *map(float, (rms, bias, relative, explained)))


@contextmanager
def opened(fmu: Path, parameters: Mapping[str, float], points: Sequence[Point], workers: int, expected: float) -> Iterator[Model]:
    """A model whose points are solved in parallel processes. A bar shows how many of the expected ones are solved."""
    with Archive.unpack(fmu) as archive, progress_bar(expected, "steady states") as bar, worker_pool(workers) as run:

        def update(count: float) -> None:
            bar.total = max(bar.total, bar.n + count)
            bar.update(count)

        def solve(jobs: Sequence[Job]) -> list[Found]:
            chunks = [jobs[k : k + CHUNK] for k in range(0, len(jobs), CHUNK)]
            calls: list[Call] = [(solve_all, (fmu, archive.directory, dict(parameters), chunk)) for chunk in chunks]
            return [state for chunk in run(calls, update) for state in chunk]

        yield Model(points, solve, LONGEST * expected)
        bar.total = bar.n
