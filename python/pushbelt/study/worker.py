"""Worker side: the FMU is unpacked and loaded once, and solves one task after another.

This module is sent to the workers with the procedure of the tasks and the modules of `pushbelt.fmu` (see `cluster`): a worker needs the
packages `distributed`, `fmpy` and `numpy`, but not this project.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pushbelt.fmu.steady import SteadyStates
from pushbelt.fmu.unit import Archive, UnitError


class Solver:
    """The loaded FMU. Tasks can be solved in several threads: each has an instance that no other uses."""

    def __init__(
        self, archive: Archive, parameters: Mapping[str, float], measure: Callable[[SteadyStates, Any], dict[str, Any]]
    ) -> None:
        """The FMU is loaded, so that its errors are raised here."""
        self._archive, self._parameters, self._measure = archive, parameters, measure
        self._idle = [SteadyStates(archive, parameters)]
        assert self._idle[0].unit
        self.instances = 1  # Number of instances created so far, without those that replaced another one

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
            self.instances += 1
        try:
            found = self._measure(states, task)
        except Exception as error:  # noqa: BLE001
            states.close()
            found = {"reason": str(error) if isinstance(error, UnitError) else f"{type(error).__name__}: {error}"}
        finally:
            self._idle.append(states)
        return {**found, "time": time.thread_time() - begin}

    def close(self) -> None:
        while self._idle:
            self._idle.pop().close()
