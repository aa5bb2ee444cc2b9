"""The speed to follow: WLTC class 3b (UN Global Technical Regulation No. 15) or NEDC, read from the package `wltp`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pushbelt.fmu.geometry import Array

from .piecewise import interpolate

PARTS = {"low": (0, 589), "medium": (589, 1022), "high": (1022, 1477), "extra high": (1477, 1800)}
"""Parts of the cycle, s."""


@dataclass(frozen=True)
class Cycle:
    """A speed trace; between its points speed runs linearly."""

    time: Array
    """s, shape (n,), ascending."""
    speed: Array
    """m/s, shape (n,), at least 0."""
    start: float = 0.0
    """Where it starts in the cycle that it is a section of, s."""

    @property
    def duration(self) -> float:
        """Length, s."""
        return float(self.time[-1])

    @property
    def distance(self) -> float:
        """m."""
        return float(np.trapezoid(self.speed, self.time))

    @cached_property
    def _points(self) -> tuple[list[float], list[float]]:
        return self.time.tolist(), self.speed.tolist()

    def at(self, time: float) -> float:
        """Speed at a time, m/s; before the start and after the end that of the nearest point."""
        return interpolate(time, *self._points)

    def section(self, start: float, stop: float) -> Cycle:
        """A part of it, with time from 0 on.

        Raises ValueError unless it starts at standstill: the simulated belt starts at rest.
        """
        if not self.time[0] <= start < stop <= self.time[-1]:
            raise ValueError(f"{start:g} to {stop:g} s is no part of a cycle of {self.duration:g} s")
        if self.at(start) > 0.0:
            raise ValueError(f"the car moves at {start:g} s: a section starts at standstill")
        inside = (self.time > start) & (self.time < stop)
        time = np.concatenate([[start], self.time[inside], [stop]])
        return Cycle(time - start, np.interp(time, self.time, self.speed), self.start + start)


def wltc_class_3b() -> Cycle:
    """The whole cycle, 1800 s in steps of 1 s."""
    # Only the table is loaded: the rest of the package needs pandas.
    from wltp.cycles import class3

    return _by_seconds(class3.class_data_b()["cycle"])


def nedc() -> Cycle:
    """The New European Driving Cycle, 1180 s in steps of 1 s."""
    from wltp.cycles import nedc as table

    return _by_seconds(table.cycle_data()["cycle"])


def _by_seconds(kilometres_per_hour: Sequence[float]) -> Cycle:
    speed = np.array(kilometres_per_hour, dtype=float) / 3.6
    return Cycle(np.arange(len(speed), dtype=float), speed)


CYCLES: Mapping[str, tuple[str, Callable[[], Cycle]]] = {
    "wltc": ("WLTC class 3b", wltc_class_3b),
    "nedc": ("NEDC", nedc),
}
"""By the name that a user gives: title and table."""
