"""The closed circuit of `hydraulics.py --limits` in importers that do more than to exchange values once a step.

- Rollback: the importer repeats a step from a stored state until the pressure at its end fits the volume that the cylinder then has.
- Intermediate updates of FMI 3.0: the importer reads the volume and sets the pressure at each internal step, too. An internal step may be
  longer than a communication step, so it does the same at each communication point.

Prints from which compliance on each is stable, and how often a step is repeated, or the pressure set in it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from fmpy.fmi3 import FMU3Slave
from hydraulics import FEEDBACK, START, is_stable

import pushbelt
from pushbelt.fmu.files import found
from pushbelt.fmu.unit import Archive

STEPS, MOST_ROUNDS, CLOSE = (0.5e-3, 1e-3, 2e-3, 5e-3), 12, 10.0
"""Communication steps, s; rounds of a step, and the change of the pressure that ends them, Pa."""
FIRST = START["primary.pressure"] + 1e5
"""Pressure at the start, Pa: 1 bar more than in the equilibrium."""
LEAST, MOST = 0.0, 4e6
"""Bounds that end a run, Pa."""
LEAST_COMPLIANCE, STIFF = 1e-14, 1e-13
"""The stiffest circuit that is tried, and that of which rounds are counted, m³/Pa."""


def rolled_back(step: float, compliance: float, end: float) -> tuple[np.ndarray, float]:
    """Pressures at the ends of the steps, Pa, and the rounds of a step. Each solves p_1 = p_0 − (V(p_1) − V_0)/C by the secant method; the
    pressure is linear within the step."""
    with pushbelt.Variator("bench168", START) as variator:
        volume, pressures, rounds, fall = variator.start()["primary.cylinder.volume"], [FIRST], 0, 0.0
        variator.set({"primary.pressure": FIRST})
        for _ in range(round(end / step)):
            begin, start, tried = variator.snapshot(), volume, []
            pressure = pressures[-1] + fall
            for _ in range(MOST_ROUNDS):
                variator.restore(begin)
                volume = variator.step(step, {"primary.pressure": pressure})["primary.cylinder.volume"]
                rounds += 1
                tried.append((pressure, pressures[-1] - (volume - start) / compliance - pressure))
                (last, before), (here, off) = tried[-2:] if len(tried) > 1 else [(pressure + 1.0, 0.0), tried[-1]]
                slope = (off - before) / (here - last) if len(tried) > 1 else -1.0 - step * 6e-9 / compliance
                change = float(np.clip(-off / slope if slope else off, -1e6, 1e6))
                if abs(change) < CLOSE:
                    break
                pressure += change
            fall = pressure - pressures[-1]
            pressures.append(pressure)
            if not LEAST < pressure < MOST:
                break
    return np.array(pressures), rounds / (len(pressures) - 1)


@contextmanager
def updated(compliance: float) -> Iterator[tuple[FMU3Slave, Callable[[], float], list[float]]]:
    """The FMU of FMI 3.0 in the steady state, the function that sets the pressure of the closed circuit, and what it has set, Pa."""
    fmu: Path = found("PUSHBELT_FMU3", "PushbeltVariator3.fmu", "cargo fmu build --fmi3")
    with Archive.unpack(fmu) as archive:
        described, variables = archive.description, archive.variables
        volume, pressure = (variables[f"primary.{name}"].valueReference for name in ("cylinder.volume", "pressure"))
        unit = FMU3Slave(
            guid=described.guid, unzipDirectory=str(archive.directory), modelIdentifier=described.coSimulation.modelIdentifier, instanceName="variator"
        )
        run: list[float] = []

        def follow() -> float:
            run.append(FIRST - (unit.getFloat64([volume])[0] - begin) / compliance)
            if LEAST < run[-1] < MOST:
                unit.setFloat64([pressure], [run[-1]])
            return run[-1]

        def update(_: Any, at: float, may_set: bool, may_get: bool, *__: Any) -> None:
            if may_set and may_get:
                follow()

        unit.instantiate(intermediateUpdate=update, requiredIntermediateVariables=[volume, pressure])
        for name, value in {**START, "inputs.ramp": 0.0}.items():
            kind = variables[name].type
            getattr(unit, f"set{'Int64' if kind == 'Enumeration' else kind}")([variables[name].valueReference], [value])
        unit.enterInitializationMode()
        unit.exitInitializationMode()
        begin = unit.getFloat64([volume])[0]
        unit.setFloat64([pressure], [FIRST])
        try:
            yield unit, follow, run
        finally:
            unit.terminate()
            unit.freeInstance()


def with_updates(step: float, compliance: float, end: float) -> tuple[np.ndarray, float]:
    """Pressures at the ends of the steps, Pa, and how often one was set in a step."""
    with updated(compliance) as (unit, follow, run):
        pressures = [FIRST]
        for k in range(round(end / step)):
            unit.doStep(currentCommunicationPoint=k * step, communicationStepSize=step)
            pressures.append(follow())
            if not LEAST < min(run) <= max(run) < MOST:
                break
    return np.array(pressures), len(run) / (len(pressures) - 1)


WAYS = {"rollback": rolled_back, "intermediate updates": with_updates}


def is_quiet(way: str, step: float, compliance: float) -> bool:
    """`hydraulics.is_stable` for these importers: the ripple has fallen to a tenth over 200 ms, or 40 steps."""
    end = max(0.2, 40.0 * step)
    pressures, _ = WAYS[way](step, compliance, end)
    ripple = np.abs(np.diff(pressures, 2))
    part = len(ripple) // 3
    return len(pressures) > end / step and ripple[-part:].max() < 0.1 * ripple[:part].max()


def limit(stable: Any) -> float:
    """The compliance from which on a circuit is stable, m³/Pa, to a fifth."""
    low, high = LEAST_COMPLIANCE, 1e-11
    if stable(low):
        return low
    while high > 1.2 * low:
        middle = float(np.sqrt(low * high))
        low, high = (low, middle) if stable(middle) else (middle, high)
    return high


def main() -> None:
    """Prints the limits and the numbers."""
    once = next(iter(FEEDBACK.values()))
    for step in STEPS:
        limits = [limit(lambda c, step=step: is_stable(step, c, once)), *(limit(lambda c, step=step, way=way: is_quiet(way, step, c)) for way in WAYS)]
        print(f"{1e3 * step} ms: stable from", ", ".join(f"{c:.1e}" for c in limits), "m³/Pa on: once a step,", ", ".join(WAYS), flush=True)
        rounds, updates = rolled_back(step, STIFF, 0.2)[1], with_updates(step, 10.0 * STIFF, 0.2)[1]
        print(f"{1e3 * step} ms: {rounds:.1f} rounds a step at {STIFF:.0e} m³/Pa, {updates:.1f} updates at {10.0 * STIFF:.0e}", flush=True)


if __name__ == "__main__":
    main()
