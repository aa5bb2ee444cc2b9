"""Standard deviation of the losses of a drive by what is known of the belt's parameters."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pushbelt.errors import ArgumentError
from pushbelt.fmu.data import parameter_deviations
from pushbelt.fmu.results import largest
from pushbelt.points import SteadyStateError
from pushbelt.variator import Variator

from .simulate import Run

STATES = 16  # Number of times of a run whose steady states are changed; each has the same share of the losses


def of_losses(fmu: Path, run: Run) -> tuple[float, list[str]]:
    """Relative standard deviation of the variator's lost energy, and the three parameters that make most of it. The controllers' demands are
    those of the run."""
    deviations = parameter_deviations(run.setup.variator)
    if not deviations:
        raise ArgumentError(f"--bands: no parameter of {run.setup.variator} has a known deviation")
    energy, found = np.cumsum(run["loss.total"]), []
    rows = np.searchsorted(energy, energy[-1] * (np.arange(STATES) + 0.5) / STATES)
    with Variator(run.setup.variator, fmu=fmu) as belt:
        for row in rows:
            torque, speed, force = (float(run[name][row]) for name in ("primary.shaftTorque", "primary.speed", "secondary.clampingForceTotal"))
            try:
                one = belt.bands(float(run["ratio.geometric"][row]), -torque, deviations, speed=speed, force=force)
            except SteadyStateError:
                continue
            found.append(one.chords["loss.total"] / one.outputs["loss.total"])
    if not found:
        raise ArgumentError(f"--bands: {run.setup.name} has no steady states near its {STATES} times")
    chords = np.mean(found, axis=0)
    return float(np.linalg.norm(chords)), largest(deviations, np.abs(chords))
