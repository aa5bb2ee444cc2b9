"""The load cases of the paper's 5.4 through the FMU: every ring model, the same loads, the same run.

The paper's secondary loads are unpublished measurements. Here the clamping force is that of `variators.json`, and the load
torque is the one at which the belt torque on P in the steady state of `ALE` is the case's; all models get this load.
Lagrangian rings have no steady state, so every model runs for some revolutions and is looked at in the last one.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from pushbelt_demo.data import load_case_speed
from pushbelt_demo.geometry import Array, ratio_of
from pushbelt_demo.load_cases import held_primary, steady_state
from pushbelt_demo.results import LoadCase, SteadyState, Trace
from pushbelt_demo.unit import Archive, Variator, output_names

from .results import CaseRun, Revolution, SpeedPoint, Times

STEP = 1e-3
"""Communication step of runs whose computing time is taken, s."""

WAVE_FREQUENCY = 20.0
"""Frequency of a load torque that swings, Hz."""

WAVE_DEPTH = 0.4
"""How far it falls below the load of the case, as a share of it."""

ORDER = ("RCM", "ANCF", "ALE0", "ALE")
"""The paper's order of the ring models."""


@dataclass(frozen=True)
class Effort:
    """How long and how often the cases are run."""

    settling: float
    """Revolutions before the one that is looked at."""
    samples: int
    """Samples of that revolution."""
    repetitions: int
    """Runs of which computing times are taken."""

    def runs(self, wavy: bool) -> int:
        """Runs of one case with one model, with a load that swings or without."""
        return 1 + self.repetitions * (2 if wavy else 1)


def ring_models(archive: Archive) -> dict[str, int]:
    """Ring models that the unit offers, in the paper's order, with their numbers."""
    variables = {variable.name: variable for variable in archive.description.modelVariables}
    offered = {item.name: int(item.value) for item in variables["ring.model"].declaredType.items}
    names = [name for name in ORDER if name in offered] + [name for name in offered if name not in ORDER]
    return {name: offered[name] for name in names}


def find_load(archive: Archive, parameters: Mapping[str, float], case: LoadCase) -> SteadyState:
    """The steady state of `ALE` in which the belt torque on P is that of the case."""
    values = {**parameters, "ring.model": ring_models(archive)["ALE"]}
    speed = load_case_speed()
    state, _ = steady_state(archive, values, ratio_of(case.theta), speed, case.torque, case.clamping_force)
    return state


def at_speeds(
    archive: Archive, parameters: Mapping[str, float], case: LoadCase, speeds: tuple[float, ...]
) -> tuple[SpeedPoint, ...]:
    """Steady states of `ALE` at other primary speeds, rad/s, with the same belt torque."""
    values = {**parameters, "ring.model": ring_models(archive)["ALE"]}
    found = []
    for speed in speeds:
        state, _ = steady_state(archive, values, ratio_of(case.theta), speed, case.torque, case.clamping_force)
        found.append(SpeedPoint(speed, state["thrustRatio"], state["efficiency"]))
    return tuple(found)


def wave(load: float, moment: float) -> float:
    """A load torque that swings between the load of the case and `WAVE_DEPTH` below it, N·m."""
    return load * (1.0 - 0.5 * WAVE_DEPTH * (1.0 - np.cos(2.0 * np.pi * WAVE_FREQUENCY * moment)))


class Runner:
    """Runs one load case with one ring model."""

    def __init__(
        self,
        archive: Archive,
        parameters: Mapping[str, float],
        model: str,
        case: LoadCase,
        steady: SteadyState,
        effort: Effort,
    ) -> None:
        self.archive, self.model, self.case, self.effort = archive, model, case, effort
        self.load = steady.load_torque
        self.start_values = {
            **held_primary(parameters, ratio_of(case.theta), load_case_speed(), case.clamping_force),
            "ring.model": ring_models(archive)[model],
            "secondary.torque": self.load,
        }
        pitch_line = parameters["geometry.beltLength"] - 2.0 * np.pi * parameters["belt.pitchOffset"]
        self.revolution = pitch_line / steady["belt.speed"]
        """Duration of a revolution, s."""

    @property
    def duration(self) -> float:
        """Simulated time of a run, s."""
        return (self.effort.settling + 1.0) * self.revolution

    def _started(self) -> tuple[Variator, float]:
        """An initialised instance, and the processor time from parameters to the first step, s."""
        begin = time.process_time()
        unit = Variator(self.archive, self.start_values)
        unit.initialise()
        return unit, time.process_time() - begin

    def look(self) -> tuple[Revolution, Variator]:
        """Runs, and samples the last revolution. The instance that is returned is freed already."""
        unit, _ = self._started()
        with unit:
            start = self.effort.settling * self.revolution
            for moment in _moments(start):
                unit.step_to(moment)
            outputs = unit.reader(output_names(unit.variables.values()))
            times = start + self.revolution * np.linspace(0.0, 1.0, self.effort.samples + 1)
            rows, push, radial, macro = [], [], [], []
            for moment in times:
                if moment > unit.time:
                    unit.step_to(float(moment))
                rows.append(unit.read(outputs))
                macro.append(float(unit.flag("macroSlip")))
                profile = unit.profile()
                push.append(profile.push_force)
                radial.append(profile.radial_deviation)
            table = np.array(rows)
            columns = {name: table[:, k] for k, name in enumerate(outputs.names)} | {"macroSlip": np.array(macro)}
            revolution = Revolution(
                Trace(times - start, columns), np.array(push), np.array(radial), unit.profile().position
            )
        return revolution, unit

    def clock(self, wavy: bool) -> tuple[float, float]:
        """Processor times of one run: of all its steps, and from parameters to the first step, s."""
        unit, starting = self._started()
        with unit:
            stepping = 0.0
            for moment in _moments(self.duration):
                if wavy:
                    unit.set({"secondary.torque": wave(self.load, unit.time)})
                begin = time.process_time()
                unit.step_to(moment)
                stepping += time.process_time() - begin
        return stepping, starting

    def times(self, wavy: bool, progress: Callable[[], None]) -> Times:
        """Processor times of all repetitions."""
        pairs = []
        for _ in range(self.effort.repetitions):
            pairs.append(self.clock(wavy))
            progress()
        stepping, starting = zip(*pairs, strict=True)
        return Times(stepping, starting, self.duration)

    def run(self, wavy: bool, progress: Callable[[], None]) -> CaseRun:
        """Everything about this case and model; `progress` hears of each run."""
        revolution, unit = self.look()
        progress()
        thrust = revolution.trace["thrustRatio"]
        return CaseRun(
            self.model,
            self.case,
            self.load,
            revolution,
            self.times(False, progress),
            self.times(True, progress) if wavy else None,
            bool(revolution.trace["macroSlip"].any()),
            not any("steady state" in warning for warning in unit.warnings),
            float(thrust[-1] / thrust[0] - 1.0),
            tuple(unit.warnings),
        )


def _moments(end: float) -> Array:
    """Communication points of a run until `end`, s."""
    return end * np.arange(1, round(end / STEP) + 1) / max(round(end / STEP), 1)
