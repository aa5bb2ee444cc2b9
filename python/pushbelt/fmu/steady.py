"""Steady states on one instance of the FMU, one after another."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from .unit import Archive, Instance, UnitError


class SteadyStates:
    """An instance of the FMU that is started at one steady state after another. It is replaced after a failed call.

    It is a context manager, which frees its instance at its end.
    """

    def __init__(self, archive: Archive, parameters: Mapping[str, float] | None = None) -> None:
        """`parameters` are start values of all states. The FMU is loaded at the first state."""
        self.archive, self.parameters = archive, dict(parameters or {})
        self._unit: Instance | None = None

    def __enter__(self) -> SteadyStates:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Frees the instance."""
        if self._unit is not None:
            self._unit.free()
        self._unit = None

    @property
    def unit(self) -> Instance:
        """The instance."""
        if self._unit is None:
            self._unit = Instance(self.archive, {})
        return self._unit

    def at(self, values: Mapping[str, float]) -> Instance:
        """The instance in the steady state of the parameters and these start values.

        Raises UnitError with the reason if there is none.
        """
        unit = self.started(values)
        if unit.not_steady:
            raise UnitError(unit.not_steady)
        return unit

    def started(self, values: Mapping[str, float]) -> Instance:
        """The instance in its initial state, which may not be the requested one. Raises UnitError if a call fails."""
        unit = self.unit
        try:
            unit.restart({**self.parameters, **values})
            unit.initialise()
        except UnitError:
            self.close()
            raise
        return unit


def attempt(solve: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """The results of a solution, or the reason for missing ones as `reason`; and the processor time as `time`, s."""
    begin = time.thread_time()
    try:
        found = solve()
    except UnitError as error:
        found = {"reason": str(error)}
    except Exception as error:  # noqa: BLE001
        found = {"reason": f"{type(error).__name__}: {error}"}
    return {**found, "time": time.thread_time() - begin}


class Pool:
    """Instances for several threads: each solves with one that no other uses."""

    def __init__(self, archive: Archive, parameters: Mapping[str, float] | None = None) -> None:
        """The FMU is loaded, so that its errors are raised here."""
        self._archive, self._parameters = archive, parameters
        self._idle = [SteadyStates(archive, parameters)]
        assert self._idle[0].unit
        self.instances = 1
        """Number of instances created so far, without those that replaced another one."""

    @contextmanager
    def one(self) -> Iterator[SteadyStates]:
        """An instance of the pool. It is freed if the block fails."""
        try:
            # Removal from a list is atomic.
            states = self._idle.pop()
        except IndexError:
            states = SteadyStates(self._archive, self._parameters)
            self.instances += 1
        done = False
        try:
            yield states
            done = True
        finally:
            if not done:
                states.close()
            self._idle.append(states)

    def close(self) -> None:
        """Frees the instances."""
        while self._idle:
            self._idle.pop().close()
