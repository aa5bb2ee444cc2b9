"""Computing times of whole simulations of the load cases (fig. 9).

All models start in the steady state of ALE, or of ALE0, at a part of the load torque. The load of the case is applied at the start
of the run, so none of them is at rest. A whole simulation is the settling and at least one revolution of the belt: exactly one under a
constant load, whole periods under a load that swings. The time of the start is recorded separately.
"""

from __future__ import annotations

import platform
import time
from collections.abc import Callable
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
import pandas as pd

from pushbelt import tables
from pushbelt.fmu.results import LoadCase, SteadyState
from pushbelt.fmu.unit import Archive, Instance

from . import cases
from .cases import Parameters
from .results import REFERENCE
from .rings import table

STORED = Path(__file__).parents[2] / "figure-9.csv"
"""The long form's result."""

START_LOAD = 0.8
"""Load torque of the start, relative to that of the case."""
WAVE_FREQUENCY = 50.0
"""Frequency of the swinging load torque, Hz."""
WAVE_DEPTH = 0.4
"""Largest reduction of the swinging load torque, relative to the load of the case."""
LOADS = ("constant", "swinging")

BY_HAND, SHORT_STEPS = ", derivatives by hand", ", steps of RCM"
VARIANTS = ("RCM", "ANCF", "ALE0", "ALE", f"ALE0{BY_HAND}", f"ALE{BY_HAND}", f"ALE{SHORT_STEPS}")
"""Models with derivatives by forward differentiation, then as the FMU has them, and with steps as long as those of RCM."""
STEPS_OF_RCM = 32 * 180
"""Steps of RCM in a revolution: a passage of its mesh over the cells is resolved (`PASSING` in `paper/src/belts.rs`)."""
COUNTS = ("steps", "residuals", "jacobians")


def wave(load: float, moment: float) -> float:
    """A load torque that swings between the load of the case and `WAVE_DEPTH` below it, N·m."""
    return load * (1.0 - 0.5 * WAVE_DEPTH * (1.0 - np.cos(2.0 * np.pi * WAVE_FREQUENCY * moment)))


def spans(turn: float, load: str, settling: float, looking: float) -> tuple[float, float]:
    """Durations of settling and of the evaluated part, s, from that of a revolution and from numbers of revolutions."""
    periods = np.ceil(looking * turn * WAVE_FREQUENCY)
    return settling * turn, looking * turn if load == "constant" else float(periods / WAVE_FREQUENCY)


def measure(
    archive: Archive,
    parameters: Parameters,
    case: LoadCase,
    state: SteadyState,
    variant: str,
    load: str,
    repetition: int,
    revolutions: tuple[float, float],
    progress: Callable[[float], None],
) -> dict[str, str | float]:
    """Processor times and work of one simulation. `progress` is called with the revolutions of each step."""
    turn = cases.revolution(parameters, state)
    settling, looking = spans(turn, load, *revolutions)
    model = variant.partition(",")[0]
    values = cases.held(parameters, model, case, START_LOAD * state.load_torque)
    values["solver.forward"] = model.startswith("ALE") and not variant.endswith(BY_HAND)
    if variant.endswith(SHORT_STEPS):
        values["solver.maxStep"] = turn / STEPS_OF_RCM
    clocks = [time.process_time()]
    with Instance(archive, values) as unit:
        unit.initialise()
        clocks.append(time.process_time())
        unit.set({"secondary.torque": state.load_torque})
        for begin, part in ((0.0, settling), (settling, looking)):
            for moment in cases.moments(part) if part else ():
                if load == "swinging":
                    unit.set({"secondary.torque": wave(state.load_torque, unit.time)})
                before = unit.time
                unit.step_to(begin + moment)
                progress((unit.time - before) / turn)
            clocks.append(time.process_time())
        work = [int(unit.get(f"solver.{count}")) for count in COUNTS]
    keys = ("case", "model", "load", "repetition", "settling", "looking", "start time", "settling time", "looking time", *COUNTS)
    row = (case.name, variant, load, repetition, settling, looking, *np.diff(clocks).tolist(), *work)
    return dict(zip(keys, row, strict=True))


def write(frame: pd.DataFrame, version: str, path: Path = STORED) -> None:
    """Stores times with date, machine and version of the FMU."""
    units = ["", "", "", "", *5 * [" [s]"], *len(COUNTS) * [""]]
    date = datetime.now(timezone.utc).date()
    remark = f"{date}, {machine()}, PushbeltPaper.fmu {version}; processor times of one thread"
    header = [name + unit for name, unit in zip(frame.columns, units, strict=True)]
    tables.write(path, header, frame.itertuples(index=False), digits=6, remark=remark)


def machine() -> str:
    """Processor and system."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{names[0] if names else platform.processor()} ({len(names)} threads), {platform.system()}"


def stored() -> tuple[pd.DataFrame, str]:
    """The long form's result, and when and where it was measured."""
    with STORED.open(encoding="utf-8") as file:
        remark = file.readline().removeprefix("#").strip()
    return table(STORED, comment="#"), remark


def whole(times: pd.DataFrame, of: str = "median") -> pd.Series:
    """Time of whole simulations, s, median or another value of the repetitions, by load, model and case."""
    total = times["settling time"] + times["looking time"]
    return total.groupby([times["load"], times["model"], times["case"]], sort=False).agg(of)


def ratios(times: pd.DataFrame, of: pd.Series | None = None) -> pd.Series:
    """Times by load, model and case, by default the medians, relative to the reference model's median."""
    return _relative(whole(times) if of is None else of, whole(times))


def _relative(of: pd.Series, to: pd.Series) -> pd.Series:
    return of / to.xs(REFERENCE, level="model").reindex(of.index.droplevel("model")).to_numpy()


def factors(times: pd.DataFrame) -> pd.DataFrame:
    """By load and model: mean, least and largest time relative to the reference model's, and its three factors, geometric means over
    the cases: steps, residuals a step, time a residual (with its share of Jacobians). Also Jacobians a step, and the time of the start, s."""
    keys = ["load", "model", "case"]
    counts = times.groupby(keys, sort=False)[list(COUNTS)].median()
    ratio, seconds = ratios(times), whole(times)
    parts = {
        "steps": counts["steps"],
        "residuals a step": counts["residuals"] / counts["steps"],
        "time a residual": seconds / counts["residuals"],
        "Jacobians a step": counts["jacobians"] / counts["steps"],
    }
    by = ["load", "model"]
    found = {name: ratio.groupby(by, sort=False).agg(name) for name in ("mean", "min", "max")}
    found["start"] = times.groupby(by, sort=False)["start time"].mean()
    for name, of in parts.items():
        found[name] = np.exp(np.log(_relative(of, of)).groupby(by, sort=False).mean())
    return pd.DataFrame(found)


def spread(times: pd.DataFrame) -> float:
    """Median over cases and models of slowest minus fastest repetition, relative to the median."""
    least, median, most = (whole(times, of) for of in ("min", "median", "max"))
    return float(((most - least) / median)[most > least].median())
