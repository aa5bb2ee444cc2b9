"""Working points and recorded shifts with their measured values, SI."""

from __future__ import annotations

from dataclasses import dataclass

SHIFTS = ("di/dt", "ds/dt")
"""Quantities of a point whose ratio changes."""
SAMPLED = "ratio.geometric"
"""Quantity of a recorded shift."""


@dataclass(frozen=True)
class Measured:
    """A measured value."""

    quantity: str
    value: float
    """SI."""
    deviation: float
    """Standard deviation, SI."""
    given: bool
    """Whether the standard deviation is from the table."""
    key: str = ""
    """Name of the model's value; empty if it is the quantity."""
    time: float | None = None
    """Time of a sample, s."""


@dataclass(frozen=True)
class Point:
    """A working point with measured values. Exactly one of `ratio` and `speed_ratio` is given."""

    line: int
    name: str
    ratio: float | None
    """Geometric ratio r_S/r_P."""
    speed_ratio: float | None
    """Primary speed/secondary speed."""
    speed: float
    """Primary speed, rad/s."""
    torque: float
    """Torque on the primary shaft, N·m."""
    force: float
    """Secondary clamping force, N."""
    primary_force: float | None
    """Primary clamping force, N; only with a shift rate."""
    measured: tuple[Measured, ...]
    slip: float = 0.0
    """Estimate of the model's slip, from which the search for a speed ratio starts."""

    @property
    def shifting(self) -> bool:
        """Whether the measured values are shift rates."""
        return self.measured[0].quantity in SHIFTS


@dataclass(frozen=True)
class Record(Point):
    """A recorded shift: a point at its first sample, and the samples. The measured values are the ratios of the later samples."""

    samples: tuple[tuple[float, float, float, float, float, float], ...] = ()
    """Time from the first one in s, primary speed, primary torque, primary force, secondary force, ratio; SI."""
