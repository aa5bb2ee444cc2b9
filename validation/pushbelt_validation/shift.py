"""How fast the ratio changes after a step of the primary clamping force, measured on the FMU.

A run starts in a steady state at a speed ratio s = r_P/r_S. The primary force is then multiplied by exp(step) at once.
ds/dt is the mean over a window after the step. It starts after the transient of the step and ends before the ratio changes much.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pushbelt.fmu.geometry import Array
from pushbelt.fmu.unit import Instance
from pushbelt.maps.line import TIME_STEP, WINDOW

LOG_STEP = 0.3
"""Step of ln F_P."""


@dataclass(frozen=True)
class ShiftRun:
    """A run after a step of the primary force."""

    time: Array
    """s after the step."""
    speed_ratio: Array
    """s = r_P/r_S."""
    start: float
    """s before the step."""
    log_step: float
    """Step of ln F_P."""
    log_thrust_ratio: float
    """ln(F_P/F_S) before the step."""
    tilts: tuple[float, float]
    """Tilt of the primary and of the secondary pulley before the step, rad."""

    @property
    def rate(self) -> float:
        """Mean ds/dt over the window, 1/s."""
        return mean_rate(self.time, self.speed_ratio)

    @property
    def gain(self) -> float:
        """`rate` per unit of ln F_P, 1/s."""
        return self.rate / self.log_step


def times() -> Array:
    """Times after the step at which the ratio is read, s."""
    return TIME_STEP * np.arange(1, round(WINDOW[1] / TIME_STEP) + 1)


def mean_rate(time: Array, speed_ratio: Array) -> float:
    """Mean slope over the window, 1/s."""
    start, stop = (float(np.interp(moment, time, speed_ratio)) for moment in WINDOW)
    return (stop - start) / (WINDOW[1] - WINDOW[0])


def shift(unit: Instance, log_step: float = LOG_STEP) -> ShiftRun:
    """Simulates the step from a steady state at time 0 with both clamping forces specified."""
    force, start = unit.get("primary.axialForce"), 1.0 / unit.get("ratio.geometric")
    thrust_ratio = unit.get("thrustRatio")
    tilts = unit.get("primary.tilt"), unit.get("secondary.tilt")
    unit.set({"primary.clampingForce": force * math.exp(log_step)})
    moments, found = times(), []
    for moment in moments:
        unit.step_to(float(moment))
        found.append(1.0 / unit.get("ratio.geometric"))
    return ShiftRun(moments, np.array(found), start, log_step, math.log(thrust_ratio), tilts)
