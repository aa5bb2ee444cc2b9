"""The manoeuvre: launch from standstill, shift, torque steps, over-torque and recovery, defined by its inputs."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

import numpy as np

from pushbelt.fmu.data import InputTable
from pushbelt.fmu.results import Profile, Trace
from pushbelt.fmu.unit import Archive, Instance, output_names

from .results import ManoeuvreResult

STEP = 1e-3
"""Communication step, s."""

START_VALUES: Mapping[str, float] = {
    "secondary.inertia": 4.0,
    "initial.ratio": 2.2,
    "initial.primarySpeed": 0.0,
}
"""Start values: the vehicle as an inertia on the secondary shaft, at standstill in underdrive."""

SNAPSHOT_STEP = 0.025
"""Time between records of the fields along the belt, s."""


def run(
    archive: Archive,
    parameters: Mapping[str, float],
    inputs: InputTable,
    progress: Callable[[float], None] = lambda _: None,
    duration: float | None = None,
) -> ManoeuvreResult:
    """Simulates the inputs from their first to their last row (or for `duration` seconds).

    `progress` is called with the simulated time of each step, s.
    """
    stop = float(inputs.time[-1]) if duration is None else duration
    steps = round(stop / STEP)
    begin = time.perf_counter()
    with Instance(archive, {**parameters, **START_VALUES, **inputs.at(0.0)}) as unit:
        unit.initialise()
        outputs = unit.reals(output_names(unit.variables.values()))
        rows = np.empty((steps + 1, len(outputs.names)))
        flags = np.empty(steps + 1)
        snapshots: dict[float, Profile] = {}
        every = round(SNAPSHOT_STEP / STEP)
        for step in range(steps + 1):
            if step > 0:
                unit.step_to(step * STEP)
                progress(STEP)
            rows[step] = unit.get_reals(outputs)
            flags[step] = unit.get("macroSlip")
            if step % every == 0:
                snapshots[round(step * STEP, 3)] = unit.profile()
            unit.set(inputs.at(step * STEP))
        warnings = tuple(unit.warnings)
    columns = {name: rows[:, k] for k, name in enumerate(outputs.names)}
    columns["macroSlip"] = flags
    for name in inputs.columns:
        columns[name] = np.interp(np.arange(steps + 1) * STEP, inputs.time, inputs.columns[name])
    return ManoeuvreResult(
        trace=Trace(np.arange(steps + 1) * STEP, columns),
        wall_time=time.perf_counter() - begin,
        step=STEP,
        snapshots=snapshots,
        messages=warnings,
    )
