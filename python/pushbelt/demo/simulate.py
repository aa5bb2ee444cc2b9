"""The simulations of the demo, in parallel processes with a progress bar: load cases and a manoeuvre."""

import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pushbelt.fmu.data import load_case_speed, load_cases, manoeuvre_inputs, parameter_set
from pushbelt.fmu.geometry import ratio_of
from pushbelt.fmu.load_cases import solve
from pushbelt.fmu.results import LoadCase, LoadCaseResult, Profile, Trace
from pushbelt.fmu.steady import driven_at_speed
from pushbelt.fmu.unit import Archive, Instance, belt_described, output_names
from pushbelt.report.side_by_side import run_all as run_side_by_side
from pushbelt.report.side_by_side import tick

STEP = 1e-3  # Communication step of the manoeuvre, s
DRIFT_TIME = 0.2  # Simulated time in the check that a steady state persists, s
DRIFT_STEP = 0.01  # Communication step of this check, s
SNAPSHOT_STEP = 0.025  # Time between records of the fields along the belt, s
START_VALUES: Mapping[str, float] = {"secondary.inertia": 4.0, "initial.ratio": 2.2, "initial.primarySpeed": 0.0}
"""Start values of the manoeuvre: the vehicle as an inertia on the secondary shaft, at standstill in underdrive."""
_CASE_TICKS, _MANOEUVRE_TICKS = 5, 100
SHORT_TORQUES, SHORT_DURATION = (100.0,), 1.0  # Torques of the load cases, N·m, and duration of the manoeuvre, s, at a first look


class ManoeuvreResult(NamedTuple):
    """The manoeuvre: launch from standstill, shift, torque steps, over-torque and recovery, defined by its inputs."""

    trace: Trace
    wall_time: float  # Wall-clock time of the run, including reading all outputs at every step, s
    snapshots: Mapping[float, Profile]  # Fields along the belt, by time, s
    messages: tuple[str, ...] = ()  # Warnings of the FMU


class DemoResults(NamedTuple):
    """All results of the demo, in SI units, by names of FMU variables."""

    fmu_version: str
    cases: tuple[LoadCaseResult, ...]
    manoeuvre: ManoeuvreResult
    parameters: Mapping[str, float]  # Parameters of the variator in the load cases and the manoeuvre
    units: Mapping[str, str]
    variator: str  # Name or file of the parameter set


def _manoeuvre(archive: Archive, variator: str, inputs: Trace, duration: float) -> ManoeuvreResult:
    """Simulates the inputs for a duration, s."""
    times = np.arange(round(duration / STEP) + 1) * STEP
    begin = time.perf_counter()
    with Instance(archive, {**parameter_set(variator), **START_VALUES, **inputs.at(0.0)}) as unit:
        unit.initialise()
        outputs = unit.reals(output_names(unit.variables.values()))
        rows, flags = np.empty((len(times), len(outputs.names))), np.empty(len(times))
        snapshots: dict[float, Profile] = {}
        for step, now in enumerate(times.tolist()):
            if step > 0:
                unit.step_to(now)
                tick(_MANOEUVRE_TICKS * STEP / duration)
            rows[step], flags[step] = unit.get_reals(outputs), unit.get("macroSlip")
            if step % round(SNAPSHOT_STEP / STEP) == 0:
                snapshots[round(now, 3)] = unit.profile()
            unit.set(inputs.at(now))
        warnings = tuple(unit.warnings)
    columns = dict(zip(outputs.names, rows.T, strict=True)) | {"macroSlip": flags}
    columns |= {name: np.interp(times, inputs.time, values) for name, values in inputs.columns.items()}
    return ManoeuvreResult(Trace(times, columns), time.perf_counter() - begin, snapshots, warnings)


def _case(archive: Archive, variator: str, case: LoadCase) -> LoadCaseResult:
    """Solves a load case, and continues it."""
    start_values = driven_at_speed(parameter_set(variator), ratio_of(case.theta), load_case_speed(), 0.0, case.clamping_force, held=True)
    with Instance(archive, start_values) as unit:
        steady = solve(unit, start_values, case.torque)
        for step in range(round(DRIFT_TIME / DRIFT_STEP)):
            unit.step_to((step + 1) * DRIFT_STEP)
        tick(_CASE_TICKS)
        return LoadCaseResult(case, steady, unit.get("thrustRatio") / steady["thrustRatio"] - 1.0)


def run_all(fmu: Path, variator: str, *, short: bool = False) -> DemoResults:
    """Runs all, or a short extent of it, with an FMU and a parameter set."""
    parameters, inputs = parameter_set(variator), manoeuvre_inputs()
    cases = [case for case in load_cases(parameters) if not short or case.torque in SHORT_TORQUES]
    duration = SHORT_DURATION if short else float(inputs.time[-1])
    belt_described(fmu)
    with Archive.unpack(fmu) as archive:
        # The manoeuvre starts first, because it takes longest and cannot be divided.
        calls: list[tuple[Callable[..., Any], tuple[Any, ...]]] = [(_manoeuvre, (archive, variator, inputs, duration))]
        calls += [(_case, (archive, variator, case)) for case in cases]
        total = _MANOEUVRE_TICKS + _CASE_TICKS * len(cases)
        run, *states = run_side_by_side(calls, total, "load cases and manoeuvre")
        return DemoResults(archive.version, tuple(states), run, parameters, archive.units, variator)
