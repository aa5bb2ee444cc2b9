"""What the simulations give, as plain data. SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from statistics import median

import numpy as np

from pushbelt.fmu.geometry import Array
from pushbelt.fmu.results import LoadCase, SteadyState, Trace

from .rings import Rings

MODELS = ("RCM", "ANCF", "ALE0", "ALE")
"""Ring models in the paper's order."""

REFERENCE, *OTHERS = MODELS
"""The model that the paper compares the others with, and the others."""

CHOSEN_CASE = "underdrive-30"
"""The paper's case 3, whose push force and spiral running it shows."""


@dataclass(frozen=True)
class Effort:
    """How long and how often the cases are run."""

    settling: float
    """Revolutions before the part that is looked at."""
    looking: float
    """Revolutions that are looked at."""
    samples: int
    """Samples a revolution."""
    clocked: float
    """Revolutions of a run whose computing time is taken, from the start on."""
    repetitions: int
    """How often that run is repeated."""

    def revolutions(self, wavy: bool) -> float:
        """Revolutions that are simulated, with a load that swings or without."""
        return self.settling + self.looking + self.clocked * self.repetitions * (2 if wavy else 1)


@dataclass(frozen=True)
class Window:
    """The part of a run that is looked at, sampled at even times from its start on."""

    trace: Trace
    """Time since the start of the part, and outputs."""
    push_force: Array
    """Push force at the places, one row a time, N."""
    radial_deviation: Array
    """Radius less the arc's mean radius at the places, one row a time, m."""
    position: Array
    """Places ξ, m."""

    def mean(self, name: str) -> float:
        """Mean of an output over time."""
        time = self.trace.time
        return float(np.trapezoid(self.trace[name], time) / (time[-1] - time[0]))

    @property
    def thrust_ratio(self) -> float:
        """Mean axial force on P over that on S."""
        return self.mean("primary.axialForce") / self.mean("secondary.axialForce")

    @property
    def efficiency(self) -> float:
        """Work at S over work at P, of the belt: the paper's shafts have no drag."""
        return -self.mean("secondary.power") / self.mean("primary.power")

    @property
    def loss(self) -> float:
        """Mean of all losses of the belt, so without the drag of the shafts, W."""
        return self.mean("loss.total") - self.mean("loss.shafts")

    @property
    def efficiency_from_losses(self) -> float:
        """1 − losses over driving power: the same number where the power balance closes."""
        return 1.0 - self.loss / self.mean("primary.power")

    @property
    def change(self) -> float:
        """Change of the thrust ratio from the first half to the second, relative."""
        half = len(self.trace.time) // 2
        forces = [self.trace[f"{pulley}.axialForce"] for pulley in ("primary", "secondary")]
        first, second = (forces[0][part].mean() / forces[1][part].mean() for part in (slice(half), slice(half, None)))
        return float(second / first - 1.0)

    def ripple(self, name: str) -> float:
        """Root mean square of an output about the straight line through it, relative to its mean."""
        time, values = self.trace.time, self.trace[name]
        line = np.polynomial.Polynomial.fit(time, values, 1)(time)
        return float(np.sqrt(np.mean((values - line) ** 2)) / abs(values.mean()))


@dataclass(frozen=True)
class Times:
    """Processor times of one thread for the same run, once a repetition, s."""

    stepping: tuple[float, ...]
    """All steps."""
    starting: tuple[float, ...]
    """From parameters to the first step."""
    simulated: float
    """How long the run is, s of simulated time."""

    @property
    def median(self) -> float:
        """Median of the steps' time."""
        return median(self.stepping)

    @property
    def spread(self) -> float:
        """Largest less smallest, relative to the median."""
        return (max(self.stepping) - min(self.stepping)) / self.median


@dataclass(frozen=True)
class CaseRun:
    """A load case with one ring model."""

    model: str
    case: LoadCase
    load_torque: float
    """Secondary torque, the same for all models, N·m."""
    window: Window
    times: Times
    """Of the run of the load case."""
    wavy_times: Times | None
    """Of a run with a load torque that swings."""
    slipped: bool
    """Whether the belt was in macro-slip at some time of the part that was looked at."""
    steady: bool
    """Whether the unit found the steady state it was asked to start from."""
    messages: tuple[str, ...] = ()


@dataclass(frozen=True)
class Failure:
    """A load case that a model could not be run through."""

    model: str
    case: LoadCase
    reason: str


@dataclass(frozen=True)
class SpeedPoint:
    """The steady state of a load case at another speed."""

    speed: float
    """Primary speed, rad/s."""
    thrust_ratio: float


@dataclass(frozen=True)
class Shift:
    """A change of ratio on one mesh, sampled at communication points."""

    spent: float
    """Processor time, s."""
    ratio: Array
    """Geometric ratio."""
    residual: Array
    """Energy supplied less lost less stored, J."""
    stored: Array
    """Energy stored, J."""


@dataclass(frozen=True)
class PaperResults:
    """All of it."""

    fmu_version: str
    parameters: Mapping[str, float]
    runs: tuple[CaseRun, ...]
    rings: Rings
    speeds: Mapping[str, tuple[SpeedPoint, ...]]
    """Thrust ratios at other speeds, by case."""
    rigid: Mapping[str, Mapping[str, float]]
    """Thrust ratios of ALE and ALE0 in their steady states with rigid sheaves, by case."""
    meshes: Mapping[str, Mapping[str, SteadyState]]
    """Steady states of ALE on several meshes, by case."""
    shifts: Mapping[str, Shift]
    """The same shift of ALE on two meshes."""
    failures: tuple[Failure, ...]
    """Cases with a failure are left out of `runs` for all models."""
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

    def thrust_difference(self, case: LoadCase, model: str) -> float:
        """Thrust ratio against the reference model's, relative."""
        ours, reference = self.run(case, model), self.run(case, REFERENCE)
        return ours.window.thrust_ratio / reference.window.thrust_ratio - 1.0

    def efficiency_difference(self, case: LoadCase, model: str) -> float:
        """Efficiency less the reference model's."""
        ours, reference = self.run(case, model), self.run(case, REFERENCE)
        return ours.window.efficiency - reference.window.efficiency

    def time_ratio(self, case: LoadCase, model: str) -> float:
        """Median computing time over the reference model's."""
        return self.run(case, model).times.median / self.run(case, REFERENCE).times.median

    def wavy_time_ratio(self, case: LoadCase, model: str) -> float | None:
        """The same for the load that swings."""
        ours, reference = self.run(case, model).wavy_times, self.run(case, REFERENCE).wavy_times
        return ours.median / reference.median if ours and reference else None
