"""Computing times of the simulations of the load cases (fig. 9).

All models start in the steady state of ALE, or of ALE0, and settle for a part of a revolution; the evaluated part is a revolution under a
constant load, or the whole periods of a swinging load that are at least a revolution. The time of the start is recorded separately.
"""

from __future__ import annotations

import platform
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
import pandas as pd

from pushbelt import tables

from .results import REFERENCE
from .rings import table

STORED = Path(__file__).parents[2] / "figure-9.csv"
"""The times that the report shows: those of a full run."""

WAVE_FREQUENCY = 50.0
"""Frequency of the swinging load torque, Hz."""
WAVE_DEPTH = 0.4
"""Largest reduction of the swinging load torque, relative to the load of the case."""
LOADS = CONSTANT, SWINGING = "constant", "swinging"

FORWARD, SHORT_STEPS = ", forward", ", steps of RCM"
VARIANTS = ("RCM", "ANCF", f"ALE0{FORWARD}", f"ALE{FORWARD}", "ALE0", "ALE", f"ALE{FORWARD}{SHORT_STEPS}")
"""All models with derivatives by forward differentiation, then with the FMU's, and with steps as long as those of RCM."""
SLOW = ("RCM", "ANCF")
"""Models that run once; the others take so little time that they run thrice."""
STEPS_OF_RCM = 32 * 180
"""Steps of RCM in a revolution: a passage of its mesh over the cells is resolved (`PASSING` in `paper/src/belts.rs`)."""
COUNTS = ("steps", "residuals", "jacobians")


def wave(load: float, moment: float) -> float:
    """A load torque that swings between the load of the case and `WAVE_DEPTH` below it, N·m."""
    return load * (1.0 - 0.5 * WAVE_DEPTH * (1.0 - np.cos(2.0 * np.pi * WAVE_FREQUENCY * moment)))


def duration(least: float, load: str) -> float:
    """Duration of the evaluated part, s: `least`, or the whole periods that are at least as long."""
    return least if load == CONSTANT else float(np.ceil(least * WAVE_FREQUENCY) / WAVE_FREQUENCY)


def changes(variant: str, turn: float) -> dict[str, float]:
    """Start values of a variant; `turn` is the duration of a revolution, s."""
    values = {"solver.forward": True} if FORWARD in variant else {}
    return {**values, "solver.maxStep": turn / STEPS_OF_RCM} if SHORT_STEPS in variant else values


def write(frame: pd.DataFrame, version: str, path: Path = STORED) -> None:
    """Stores times with date, machine and version of the FMU."""
    date = datetime.now(timezone.utc).date()
    remark = f"{date}, {machine()}, PushbeltPaper.fmu {version}; processor times of one thread"
    header = [tables.title(name, "s") if frame[name].dtype == float else name for name in frame.columns]
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
    total = times["settled"] + times["looked"]
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
    found["start"] = times.groupby(by, sort=False)["start"].mean()
    for name, of in parts.items():
        found[name] = np.exp(np.log(_relative(of, of)).groupby(by, sort=False).mean())
    return pd.DataFrame(found)


def spread(times: pd.DataFrame) -> float:
    """Median over cases and models of slowest minus fastest repetition, relative to the median."""
    least, median, most = (whole(times, of) for of in ("min", "median", "max"))
    return float(((most - least) / median)[most > least].median())
