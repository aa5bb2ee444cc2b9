"""Figures of merit of a drive: efficiency of the variator, its loss, and the energy of an oil pump."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pushbelt.fmu.geometry import Array

from .simulate import Run

PULLEYS = ("primary", "secondary")


@dataclass(frozen=True)
class Pump:
    """A pump of fixed displacement on the engine, which maintains the higher of the two pressures and a margin.

    P = (max(p_P, p_S) + margin) V n/η. It delivers more than the circuits take; the rest flows back through a valve. The values
    are typical; they are not from a source.
    """

    displacement: float = 12e-6  # V, m³ per revolution
    margin: float = 2e5  # Pressure lost on the way, Pa
    efficiency: float = 0.85  # η

    def power(self, run: Run) -> Array:
        """Power that the pump takes from the engine over time, W."""
        pressure = np.max([run[f"{pulley}.pressure"] for pulley in PULLEYS], axis=0) + self.margin
        revolutions = np.maximum(run["engine.speed"], 0.0) / (2.0 * math.pi)
        return pressure * self.displacement * revolutions / self.efficiency


class Merit(NamedTuple):
    supplied: float  # Energy that the shafts carry into the variator, at the primary in drive and at the secondary in overrun, J
    lost: float  # Energy lost in the variator, J
    pump: float  # Energy that the pump takes from the engine, J
    distance: float  # m
    pressure: float  # Mean pressure in the secondary circuit, Pa
    efficiency: float  # Of the variator over the cycle: 1 − lost/supplied; NaN if nothing was supplied
    with_pump: float  # The same if the pump counts as a loss, and its energy as supplied
    lost_per_km: float  # Energy lost in variator and pump, J/km; NaN at a standstill


def merit(run: Run, pump: Pump = Pump()) -> Merit:  # noqa: B008
    """Figures of merit of a run, by sums over the communication steps."""
    # Powers are those of the belt, without the drag of the shafts.
    into_the_belt = sum(np.maximum(run[f"{pulley}.power"], 0.0).sum() for pulley in PULLEYS)
    sums = (into_the_belt + run["loss.shafts"].sum(), pump.power(run).sum(), np.abs(run["speed.car"]).sum())
    supplied, pumped, distance = (run.setup.step * float(one) for one in sums)
    lost = run.variator_loss

    def over(part: float, whole: float) -> float:
        return part / whole if whole > 0.0 else math.nan

    return Merit(
        supplied, lost, pumped, distance, float(run["secondary.pressure"].mean()), 1.0 - over(lost, supplied),
        1.0 - over(lost + pumped, supplied + pumped), 1e3 * over(lost + pumped, distance),
    )  # fmt: skip
