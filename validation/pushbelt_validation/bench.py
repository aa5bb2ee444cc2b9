"""Steady points and shifts of one variator on one instance of the FMU."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from pushbelt.fmu import data
from pushbelt.fmu.steady import StartValues, SteadyStates
from pushbelt.fmu.unit import Archive, UnitError

from . import shift

Outputs = dict[str, float]
T = TypeVar("T")


def rad(rpm: float) -> float:
    """rad/s."""
    return rpm * math.pi / 30.0


@dataclass(frozen=True)
class Plan:
    """Extent of the run."""

    short: bool = False

    def thin(self, values: Sequence[T], count: int = 3) -> list[T]:
        """All values; in a short run `count` of them, evenly spaced and including the first and the last."""
        if not self.short or len(values) <= count:
            return list(values)
        if count == 1:
            return [values[len(values) // 2]]
        return [values[round(k * (len(values) - 1) / (count - 1))] for k in range(count)]


@dataclass
class Bench:
    """Solver of steady points of a variator. It is a context manager, which frees its instance at its end. `solved` is
    called after each point. A point without a steady state gives None, and its reason is added to `failures`."""

    archive: Archive
    name: str = "bench168"
    solved: Callable[[], None] = lambda: None
    failures: list[str] = field(default_factory=list)
    changed: Mapping[str, float] = field(default_factory=dict)
    """Parameters with other values than those of the variator."""

    def __post_init__(self) -> None:
        self.parameters = {**data.parameter_set(self.name), **self.changed}
        self.states = SteadyStates(self.archive)

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *_: object) -> None:
        self.states.close()

    def given(self, name: str, values: Mapping[str, float] | None = None) -> float:
        """Value of a parameter: the specified one, else the variator's, else the FMU's start value."""
        for source in (values or {}, self.parameters):
            if name in source:
                return float(source[name])
        return float(self.states.unit.variables[name].start)

    def steady(self, values: StartValues, what: str = "") -> Outputs | None:
        """All outputs of the steady state. `what` is the name of the point in `failures`."""
        return self._attempt(lambda: self.states.at(values).outputs(), what)

    def shift(self, values: StartValues, log_step: float = shift.LOG_STEP, what: str = "") -> shift.ShiftRun | None:
        """A run after a step of the primary force."""
        return self._attempt(lambda: shift.shift(self.states.at(values), log_step), what)

    def _attempt(self, what_to_do: Callable[[], T], what: str) -> T | None:
        try:
            return what_to_do()
        except UnitError as error:
            self.failures.append(f"{what}: {error}")
            self.states.close()
            return None
        finally:
            self.solved()

    def capacity(self, ratio: float, force: float, changed: Mapping[str, float] | None = None) -> float:
        """Primary torque of full slip under a secondary force in N, N·m; parameters may be changed."""
        return data.torque_capacity({**self.parameters, **(changed or {})}, ratio, force)

    def force(self, ratio: float, torque: float, safety: float, least: float = 0.0) -> float:
        """Secondary force that carries a torque in N·m with a safety factor, N."""
        return max(safety * abs(torque) / self.capacity(ratio, 1.0), least)
