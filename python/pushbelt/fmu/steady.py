"""Steady states on one instance of the FMU, one after another."""

from __future__ import annotations

from collections.abc import Mapping

from .unit import Archive, Instance, UnitError


class SteadyStates:
    """An instance of the FMU that is started at one steady state after another. It is replaced after a failed call. It
    is a context manager, which frees its instance at its end."""

    def __init__(self, archive: Archive, parameters: Mapping[str, float] | None = None) -> None:
        """`parameters` are start values of all states. The FMU is loaded at the first state."""
        self.archive, self.parameters = archive, dict(parameters or {})
        self._unit: Instance | None = None

    def __enter__(self) -> SteadyStates:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        if self._unit is not None:
            self._unit.free()
        self._unit = None

    @property
    def unit(self) -> Instance:
        if self._unit is None:
            self._unit = Instance(self.archive, {})
        return self._unit

    def at(self, values: Mapping[str, float]) -> Instance:
        """The instance in the steady state of the parameters and these start values. Raises UnitError with the reason
        if there is none."""
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
