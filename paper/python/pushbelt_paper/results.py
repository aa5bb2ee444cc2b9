"""Results of the simulations as plain data, in SI units."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd

from pushbelt.fmu.geometry import Array
from pushbelt.fmu.results import LoadCase, SteadyState, Trace

from .rings import Rings

MODELS = ("RCM", "ANCF", "ALE0", "ALE")
"""Ring models in the paper's order."""

REFERENCE, *OTHERS = MODELS
"""The reference model of the paper, and the other models."""

CHOSEN_CASE = "underdrive-30"
"""The paper's case 3, for which it shows push force and spiral running."""

PULLEYS = ("primary", "secondary")


@dataclass(frozen=True)
class Effort:
    """Duration of the runs of the cases: revolutions before the evaluated part, revolutions of it, samples per revolution."""

    settling: float
    looking: float
    samples: int


@dataclass(frozen=True)
class Window:
    """The evaluated part of a run, sampled at evenly spaced times since its start. Fields have one row per time and one
    column per place ξ of `position`, m: push force, N, and radius minus the arc's mean radius, m."""

    trace: Trace
    push_force: Array
    radial_deviation: Array
    position: Array
    slipped: bool = False
    """Whether the belt was in macro-slip at any time."""

    def mean(self, name: str) -> float:
        """Mean of an output over time."""
        time = self.trace.time
        return float(np.trapezoid(self.trace[name], time) / (time[-1] - time[0]))

    @property
    def thrust_ratio(self) -> float:
        """Mean axial force on P divided by that on S."""
        return self.mean("primary.axialForce") / self.mean("secondary.axialForce")

    @property
    def efficiency(self) -> float:
        """Efficiency of the belt, work at S divided by work at P. The paper's shafts have no drag."""
        return -self.mean("secondary.power") / self.mean("primary.power")

    @property
    def loss(self) -> float:
        """Mean of all losses of the belt, without the drag of the shafts, W."""
        return self.mean("loss.total") - self.mean("loss.shafts")

    @property
    def efficiency_from_losses(self) -> float:
        """1 minus losses divided by driving power. It equals `efficiency` if the power balance closes."""
        return 1.0 - self.loss / self.mean("primary.power")

    @property
    def spiral(self) -> list[float]:
        """Spiral running on both pulleys, m."""
        return [self.mean(f"spiral.{pulley}") for pulley in PULLEYS]

    @property
    def change(self) -> float:
        """Change of the thrust ratio from the first half to the second, relative."""
        half = len(self.trace.time) // 2
        forces = [self.trace[f"{pulley}.axialForce"] for pulley in PULLEYS]
        first, second = (forces[0][part].mean() / forces[1][part].mean() for part in (slice(half), slice(half, None)))
        return float(second / first - 1.0)

    def ripple(self, name: str) -> float:
        """Root mean square of an output about the straight line through it, relative to its mean."""
        time, values = self.trace.time, self.trace[name]
        line = np.polynomial.Polynomial.fit(time, values, 1)(time)
        return float(np.sqrt(np.mean((values - line) ** 2)) / abs(values.mean()))


@dataclass(frozen=True)
class CaseRun:
    """Results of a load case with one ring model."""

    model: str
    case: LoadCase
    load_torque: float
    """Secondary torque, the same for all models, N·m."""
    window: Window
    """Under a constant load only."""
    steady: bool
    """Whether the run started from the requested steady state."""
    times: Mapping[str, str | float]
    """Processor times and work."""


class Failure(NamedTuple):
    """A load case that failed with a model, and why."""

    model: str
    case: LoadCase
    reason: str


class Shift(NamedTuple):
    """A change of ratio, sampled at communication points: processor time in s, Jacobians, geometric ratio, energy residual (supplied minus
    lost minus stored) and stored energy in J."""

    spent: float
    jacobians: int
    ratio: Array
    residual: Array
    stored: Array


@dataclass(frozen=True)
class PaperResults:
    """All results."""

    fmu_version: str
    parameters: Mapping[str, float]
    runs: tuple[CaseRun, ...]
    rings: Rings
    speeds: Mapping[str, Mapping[float, float]]
    """Thrust ratios at other speeds, by case and speed in rad/s."""
    sheaves: Mapping[str, Mapping[str, Mapping[str, SteadyState]]]
    """Steady states of ALE, and of ALE0 with free centres and about the axes, by case, sheaves (elastic, rigid) and model."""
    meshes: Mapping[str, Mapping[str, SteadyState]]
    """Steady states of ALE on several meshes, by case and mesh."""
    shifts: Mapping[str, Shift]
    """The same shift of ALE, by mesh, and with A_i = [t, n] (`directions`)."""
    misaligned: SteadyState
    """The steady state of ALE in space, with pulleys that are out of line."""
    times: pd.DataFrame
    """Computing times of this run."""
    failures: tuple[Failure, ...]
    """Failures. `runs` does not contain these cases for any model."""
    effort: Effort
    short: bool

    @property
    def cases(self) -> tuple[LoadCase, ...]:
        """The load cases that were run, in the paper's order."""
        return tuple(dict.fromkeys(run.case for run in self.runs))

    def run(self, case: LoadCase, model: str) -> CaseRun:
        """A run."""
        return next(run for run in self.runs if run.case == case and run.model == model)

    def of(self, model: str) -> list[CaseRun]:
        """All runs of a model."""
        return [run for run in self.runs if run.model == model]

    def chosen(self, model: str) -> CaseRun:
        """The run of the case whose fields along the belt are shown."""
        return next((run for run in self.of(model) if run.case.name == CHOSEN_CASE), self.of(model)[0])

    def by_model(
        self, value: Callable[[CaseRun], float | Iterable[float]], models: Iterable[str] = MODELS
    ) -> dict[str, list[float]]:
        """Values of all runs of each model."""
        return {m: np.ravel([value(run) for run in self.of(m)]).tolist() for m in models}  # type: ignore[arg-type]

    def thrust_difference(self, run: CaseRun) -> float:
        """Thrust ratio against the reference model's, relative."""
        return run.window.thrust_ratio / self.run(run.case, REFERENCE).window.thrust_ratio - 1.0

    def efficiency_difference(self, run: CaseRun) -> float:
        """Difference of the efficiency to the reference model's."""
        return run.window.efficiency - self.run(run.case, REFERENCE).window.efficiency
