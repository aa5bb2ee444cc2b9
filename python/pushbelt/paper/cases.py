"""The load cases of the paper's section 5.4 with the FMU: the same loads and the same run for every ring model.

The paper's secondary loads are unpublished measurements. Here the clamping force is that of `variators.json`, and the load
torque is the one for which the belt torque on P in the steady state of `ALE` is the case's; all models have this load.
Lagrangian rings have no steady state, so every model runs for a while from the unit's initial state, and the end of the run
is evaluated.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

import numpy as np

from pushbelt.fmu.data import load_case_speed
from pushbelt.fmu.enumerations import Drive
from pushbelt.fmu.geometry import Array, ratio_of
from pushbelt.fmu.load_cases import held_primary, steady_state
from pushbelt.fmu.results import LoadCase, SteadyState, Trace
from pushbelt.fmu.tilt import RIGID
from pushbelt.fmu.unit import Archive, Instance, output_names
from pushbelt.paper.belts import RingModel

from .results import CaseRun, Effort, Shift, SpeedPoint, Times, Window

STEP = 1e-3
"""Communication step of runs for the computing time, s."""

WAVE_FREQUENCY = 50.0
"""Frequency of the oscillating load torque, Hz."""

WAVE_DEPTH = 0.4
"""Largest reduction of the oscillating load torque, relative to the load of the case."""

MESHES: Mapping[str, Mapping[str, float]] = {
    "aligned": {},
    "even": {"mesh.aligned": False},
    "even, fine": {"mesh.aligned": False, "mesh.primaryArc": 60, "mesh.secondaryArc": 60, "mesh.strand": 36},
    "fine": {"mesh.primaryArc": 60, "mesh.secondaryArc": 60, "mesh.strand": 36},
}
"""Meshes of `ALE`: the default, the same number of elements evenly spaced, and three times as many of either."""

OFFSET = 5e-4
"""Axial offset of the pulleys in the run in space, m."""

SHIFT_FORCE = 1.2
"""Primary clamping force of the shift on two meshes, relative to that at rest."""


def steady(
    archive: Archive, parameters: Mapping[str, float], case: LoadCase, model: str = "ALE", speed: float | None = None
) -> SteadyState:
    """The steady state of a model with the belt torque of the case on P; primary speed in rad/s."""
    values = {**parameters, "ring.model": RingModel[model]}
    speed = load_case_speed() if speed is None else speed
    return steady_state(archive, values, ratio_of(case.theta), speed, case.torque, case.clamping_force)


def at_speeds(
    archive: Archive, parameters: Mapping[str, float], case: LoadCase, speeds: tuple[float, ...]
) -> tuple[SpeedPoint, ...]:
    """Steady states of `ALE` at other primary speeds, rad/s, with the same belt torque."""
    states = [(speed, steady(archive, parameters, case, speed=speed)) for speed in speeds]
    return tuple(SpeedPoint(speed, state["thrustRatio"]) for speed, state in states)


def on_sheaves(
    archive: Archive, parameters: Mapping[str, float], case: LoadCase
) -> dict[str, dict[str, SteadyState]]:
    """Steady states of `ALE` and of `ALE0` with free centres and about the axes, on sheaves that tilt and on rigid ones."""
    rigid = {"primary.tiltStiffness": RIGID, "secondary.tiltStiffness": RIGID}
    return {
        sheaves: {
            model: steady(archive, {**parameters, **stiffness}, case, model) for model in ("ALE", "ALE0", "ALE0Centred")
        }
        for sheaves, stiffness in (("elastic", {}), ("rigid", rigid))
    }


def on_meshes(archive: Archive, parameters: Mapping[str, float], case: LoadCase) -> dict[str, SteadyState]:
    """The steady state of `ALE` on meshes with and without borders at the arcs, and on finer ones."""
    return {name: steady(archive, {**parameters, **mesh}, case) for name, mesh in MESHES.items()}


def misaligned(archive: Archive, parameters: Mapping[str, float], case: LoadCase) -> SteadyState:
    """The steady state of `ALE` in space with pulleys that are out of line."""
    return steady(archive, {**parameters, "ring.spatial": True, "geometry.pulleyOffset": OFFSET}, case)


def shift_on_meshes(archive: Archive, parameters: Mapping[str, float], duration: float) -> dict[str, Shift]:
    """`ALE` on two meshes, and with A_i = [t, n], from its equilibrium at ratio 1 under a primary clamping force that is `SHIFT_FORCE` times as large."""
    found = {}
    directions = {"ring.referenceDirections": True}
    for name, changes in (("aligned", {}), ("even", MESHES["even"]), ("directions", directions)):
        start = {**parameters, **changes, "ring.model": RingModel.ALE, "primary.drive": Drive.SPEED}
        with Instance(archive, start) as unit:
            unit.initialise()
            unit.set({"primary.clampingForce": SHIFT_FORCE * unit.get("primary.axialForce")})
            outputs = unit.reals(("ratio.geometric", "energy.residual", "stored.energy"))
            rows, begin = [unit.get_reals(outputs)], time.process_time()
            for moment in _moments(duration):
                unit.step_to(float(moment))
                rows.append(unit.get_reals(outputs))
            spent = time.process_time() - begin
            jacobians = int(unit.get("solver.jacobians"))
        found[name] = Shift(spent, jacobians, *np.array(rows).T)
    return found


def wave(load: float, moment: float) -> float:
    """A load torque that oscillates between the load of the case and `WAVE_DEPTH` below it, N·m."""
    return load * (1.0 - 0.5 * WAVE_DEPTH * (1.0 - np.cos(2.0 * np.pi * WAVE_FREQUENCY * moment)))


class Runner:
    """Runs one load case with one ring model. `progress` is called with the revolutions of each step."""

    def __init__(
        self,
        archive: Archive,
        parameters: Mapping[str, float],
        model: str,
        case: LoadCase,
        steady: SteadyState,
        effort: Effort,
        progress: Callable[[float], None] = lambda revolutions: None,
    ) -> None:
        self.archive, self.model, self.case, self.effort, self.progress = archive, model, case, effort, progress
        self.load = steady.load_torque
        self.start_values = {
            **held_primary(parameters, ratio_of(case.theta), load_case_speed(), case.clamping_force),
            "ring.model": RingModel[model],
            "secondary.torque": self.load,
        }
        pitch_line = parameters["geometry.beltLength"] - 2.0 * np.pi * parameters["belt.pitchOffset"]
        self.revolution = pitch_line / steady["belt.speed"]
        """Duration of a revolution, s."""

    def _started(self) -> tuple[Instance, float]:
        """An initialised instance, and the processor time from parameters to the first step, s."""
        begin = time.process_time()
        unit = Instance(self.archive, self.start_values)
        unit.initialise()
        return unit, time.process_time() - begin

    def _step(self, unit: Instance, moment: float) -> float:
        """Advances to a time, s; returns the processor time of the step, s."""
        before, begin = unit.time, time.process_time()
        unit.step_to(moment)
        spent = time.process_time() - begin
        self.progress((moment - before) / self.revolution)
        return spent

    def record(self) -> tuple[Window, bool, tuple[str, ...]]:
        """Runs and samples the end of the run. Also returns whether it started from a steady state, and the FMU's warnings."""
        unit, _ = self._started()
        effort = self.effort
        with unit:
            steady = unit.not_steady is None
            start = effort.settling * self.revolution
            for moment in _moments(start):
                self._step(unit, moment)
            outputs = unit.reals(output_names(unit.variables.values()))
            times = start + self.revolution * np.linspace(
                0.0, effort.looking, round(effort.looking * effort.samples) + 1
            )
            rows, push, radial, macro = [], [], [], []
            for moment in times:
                if moment > unit.time:
                    self._step(unit, float(moment))
                rows.append(unit.get_reals(outputs))
                macro.append(float(unit.get("macroSlip")))
                profile = unit.profile()
                push.append(profile.push_force)
                radial.append(profile.radial_deviation)
            table = np.array(rows)
            columns = {name: table[:, k] for k, name in enumerate(outputs.names)} | {"macroSlip": np.array(macro)}
            window = Window(Trace(times - start, columns), np.array(push), np.array(radial), profile.position)
        return window, steady, tuple(unit.warnings)

    def clock(self, wavy: bool) -> tuple[float, float]:
        """Processor times of one run: all its steps, and from setting the parameters to the first step, s."""
        unit, starting = self._started()
        stepping = 0.0
        with unit:
            for moment in _moments(self.effort.clocked * self.revolution):
                if wavy:
                    unit.set({"secondary.torque": wave(self.load, unit.time)})
                stepping += self._step(unit, moment)
        return stepping, starting

    def times(self, wavy: bool) -> Times:
        """Processor times of all repetitions."""
        pairs = [self.clock(wavy) for _ in range(self.effort.repetitions)]
        stepping, starting = zip(*pairs, strict=True)
        return Times(stepping, starting, self.effort.clocked * self.revolution)

    def run(self, wavy: bool) -> CaseRun:
        """All results of this case and model."""
        window, steady, warnings = self.record()
        return CaseRun(
            self.model,
            self.case,
            self.load,
            window,
            self.times(False),
            self.times(True) if wavy else None,
            bool(window.trace["macroSlip"].any()),
            steady,
            warnings,
        )


def _moments(end: float) -> Array:
    """Communication points of a run until `end`, s."""
    count = max(round(end / STEP), 1)
    return end * np.arange(1, count + 1) / count
