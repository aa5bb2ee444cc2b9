"""Worker side: the FMU is unpacked and loaded once, and solves one task after another.

This module is sent to the workers with the procedure of the tasks and the modules of `pushbelt.fmu` (see `cluster`): a worker needs the
packages `distributed`, `fmpy` and `numpy`, but not this project.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pushbelt.fmu.steady import Pool, SteadyStates, attempt
from pushbelt.fmu.unit import Archive


class Solver:
    """The loaded FMU. Tasks can be solved in several threads."""

    def __init__(
        self, archive: Archive, parameters: Mapping[str, float], measure: Callable[[SteadyStates, Any], dict[str, Any]]
    ) -> None:
        self.pool, self._measure = Pool(archive, parameters), measure

    def solve(self, chunk: Sequence[tuple[int, Any]]) -> list[tuple[int, dict[str, Any]]]:
        """Numbers and rows of numbered tasks. The row of a failed task has the reason."""
        return [(number, attempt(lambda task=task: self._found(task))) for number, task in chunk]

    def _found(self, task: Any) -> dict[str, Any]:
        with self.pool.one() as states:
            return self._measure(states, task)

    def close(self) -> None:
        """Frees the instances."""
        self.pool.close()
