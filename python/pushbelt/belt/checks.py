"""Stress of the ring at a load case, from steady states of the FMU, against the strength of its steel."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pushbelt.fmu.data import SAFETY_RANGE
from pushbelt.points import SteadyStateError
from pushbelt.steel import Material, check_ranges
from pushbelt.variator import Variator

MARGIN = 0.02  # Distance of the outer ratios from the end stops, relative
PULLEYS = ("primary", "secondary")
LOADS = {"torque": (-2000.0, 2000.0, " N.m"), "speed": (1.0, 2000.0, " rad/s"), "safety": (*SAFETY_RANGE, "")}
"""Range of each value of a load case."""


@dataclass(frozen=True)
class Load:
    """A load case: torque (N·m), primary speed (rad/s), safety factor of the clamping force."""

    torque: float = 100.0
    speed: float = 2000.0 * math.pi / 30.0
    safety: float = 1.3

    def __post_init__(self) -> None:
        check_ranges(self, "the load case", LOADS)


@dataclass(frozen=True)
class Stress:
    """Stress of the ring in a steady state, Pa; or the reason for a missing one."""

    ratio: float
    force: float  # Secondary clamping force, N
    largest: float = math.nan
    equivalent: float = math.nan  # Largest amplitude without mean stress that does the damage of a pulley's cycle
    reason: str | None = None

    def passes(self, steel: Material) -> bool:
        """Whether the stress is within the strength and the fatigue limit with the safety factor."""
        return self.largest <= steel.strength / steel.safety and self.equivalent <= steel.allowed


def stresses(fmu: Path, values: Mapping[str, float], reach: float, load: Load, steel: Material) -> list[Stress]:
    """Stress of the ring near both ends of the ratio's range and at ratio 1."""
    ends = reach * (1.0 - MARGIN)
    ratios = (1.0 / ends, 1.0, ends) if ends > 1.0 + MARGIN else (1.0,)
    found = []
    with Variator(dict(values), fmu=fmu) as variator:
        for ratio in ratios:
            force = variator.least_force(ratio, load.torque, load.safety)
            try:
                state = variator.steady(ratio, load.torque, speed=load.speed, force=force)
            except SteadyStateError as error:
                found.append(Stress(ratio, force, reason=str(error)))
                continue
            cycles = ([state[f"ring.{what}.{pulley}"] for what in ("stressAmplitude", "stressMean")] for pulley in PULLEYS)
            found.append(Stress(ratio, force, state["ring.stressMax"], max(steel.equivalent(*one) for one in cycles)))
    return found
