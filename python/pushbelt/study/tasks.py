"""What is solved: an FMU, parameters, and tasks, with an identity of everything that determines the results; and the solver of tasks.

This module is sent to the workers with the procedure of the tasks and the modules of `pushbelt.fmu` (see `cluster`): a worker needs the
packages `distributed`, `fmpy` and `numpy`, but not this project.
"""

import hashlib
import itertools
import json
import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar

from pushbelt.errors import ArgumentError
from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.enumerations import RingModel
from pushbelt.fmu.steady import SteadyStates
from pushbelt.fmu.unit import Archive, UnitError, belt_described

Row = dict[str, Any]  # The result of a task. `reason` is why it has none; `time` is its processor time, s.


@dataclass(frozen=True)
class Tasks(ABC):
    fmu: Path
    parameters: Mapping[str, float]  # Start values of the FMU by name
    procedure: ClassVar[tuple[ModuleType, ...]]  # Modules that determine the results. They are sent to the workers.
    measure: ClassVar[Any]
    """The function that solves a task, from `SteadyStates` and the task to a row. It raises UnitError with the reason if there is no result."""
    common: ClassVar[Mapping[str, float]] = {}  # Start values of all tasks

    @cached_property
    def archive(self) -> bytes:
        return self.fmu.read_bytes()

    @cached_property
    def description(self) -> Any:
        return belt_described(self.fmu)

    @cached_property
    def variables(self) -> Mapping[str, Any]:
        return {variable.name: variable for variable in self.description.modelVariables}

    @abstractmethod
    def tasks(self) -> Sequence[Any]:
        """All tasks; their places number them."""

    @abstractmethod
    def document(self) -> Mapping[str, Any]:
        """Parameters and points as JSON values, for the identity."""

    @cached_property
    def identity(self) -> str:
        """A hash of the FMU, the parameters, the points and the procedure."""
        document = {
            "fmu": hashlib.sha256(self.archive).hexdigest(),
            "procedure": [hashlib.sha256(Path(str(one.__file__)).read_bytes()).hexdigest() for one in self.procedure],
            **self.document(),
        }
        return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()


class Solver:
    """The loaded FMU. Tasks can be solved in several threads: each has an instance that no other uses."""

    def __init__(self, archive: Archive, parameters: Mapping[str, float], measure: Callable[[SteadyStates, Any], Row]) -> None:
        """The FMU is loaded, so that its errors are raised here."""
        self._archive, self._parameters, self._measure = archive, parameters, measure
        self._idle = [SteadyStates(archive, parameters)]
        assert self._idle[0].unit

    def solve(self, chunk: Sequence[tuple[int, Any]]) -> list[tuple[int, dict[str, Any]]]:
        """Numbers and rows of numbered tasks. The row of a failed task has the reason."""
        return [(number, self._row(task)) for number, task in chunk]

    def _row(self, task: Any) -> dict[str, Any]:
        """The result of a task, or the reason for a missing one as `reason`; and the processor time as `time`, s."""
        begin = time.thread_time()
        try:
            # Removal from a list is atomic.
            states = self._idle.pop()
        except IndexError:
            states = SteadyStates(self._archive, self._parameters)
        try:
            found = self._measure(states, task)
        except Exception as error:
            states.close()
            found = {"reason": str(error) if isinstance(error, UnitError) else f"{type(error).__name__}: {error}"}
        finally:
            self._idle.append(states)
        return {**found, "time": time.thread_time() - begin}

    def close(self) -> None:
        while self._idle:
            self._idle.pop().close()


def variator(name: str, model: str = "ALE", changes: Mapping[str, Any] | None = None, varied: Collection[str] = ()) -> dict[str, Any]:
    """Parameters of a published variator (`bench168` or `belt155`) or a file ….json but the varied ones, with a ring model and changes."""
    found = {**parameter_set(name), "ring.model": RingModel[model]}
    return {key: value for key, value in found.items() if key not in varied} | dict(changes or {})


def ascending(name: str, values: Sequence[float], *, positive: bool) -> tuple[float, ...]:
    """The values of an axis. Raises ArgumentError if they do not ascend, or are not finite or positive."""
    found = tuple(float(value) for value in values)
    if not found or any(low >= high for low, high in itertools.pairwise(found)):
        raise ArgumentError(f"the values of {name} must not be empty and must ascend: {found}")
    if not all(map(math.isfinite, found)) or (positive and found[0] <= 0.0):
        raise ArgumentError(f"the values of {name} must be {'positive' if positive else 'finite'}: {found}")
    return found


def spread(low: float, high: float, count: int) -> tuple[float, ...]:
    """Values evenly spaced in their logarithm, to 1e-6."""
    step = (high / low) ** (1.0 / max(count - 1, 1))
    return tuple(round(low * step**k, 6) for k in range(count))
