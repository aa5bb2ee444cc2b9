"""Steady states: their start values for different conditions at shafts and sheaves (speeds in rad/s, torques in N·m, forces in N), and one after
another on one instance of the FMU. Forces are whole ones: a cylinder with an area has the pressure for them.

Enumerations are plain numbers, for workers that do not have this package.
"""

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager

from .closing import closed_by
from .enumerations import Axial, Drive
from .unit import Archive, Instance, UnitError

StartValues = dict[str, float]
At = Callable[[Mapping[str, float]], Instance]  # As `SteadyStates.at`


def _steady(
    parameters: Mapping[str, float], ratio: float, speed: float, force: float, drives: tuple[Drive, Drive], axial: Axial
) -> StartValues:
    return {
        **parameters, "initial.steady": True, "initial.ratio": ratio, "initial.primarySpeed": speed,
        "primary.drive": drives[0].value, "primary.axial": axial.value,
        "secondary.drive": drives[1].value, "secondary.axial": Axial.FORCE.value, **closed_by(parameters, "secondary", force, ratio, speed),
    }  # fmt: skip


def driven_by_torque(parameters: Mapping[str, float], ratio: float, speed: float, torque: float, force: float) -> StartValues:
    """Primary shaft driven by a torque, secondary held at speed/ratio; primary sheave held, secondary force specified."""
    values = _steady(parameters, ratio, speed, force, (Drive.TORQUE, Drive.SPEED), Axial.HELD)
    return values | {"primary.torque": torque, "secondary.speedSetpoint": speed / ratio}


def driven_by_slip(parameters: Mapping[str, float], ratio: float, speed: float, slip: float, force: float) -> StartValues:
    """Both shafts held at speeds with a slip between them; primary sheave held, secondary force specified."""
    values = _steady(parameters, ratio, speed, force, (Drive.SPEED, Drive.SPEED), Axial.HELD)
    return values | {"primary.speedSetpoint": speed, "secondary.speedSetpoint": speed / ratio * (1.0 - slip)}


def driven_at_speed(
    parameters: Mapping[str, float], ratio: float, speed: float, load: float, force: float, held: bool = False
) -> StartValues:
    """Primary shaft held at a speed, secondary shaft under a load torque (0: no load); both clamping forces specified.
    The run starts with the primary force that holds the ratio. With `held` the primary sheave is held instead."""
    values = _steady(parameters, ratio, speed, force, (Drive.SPEED, Drive.TORQUE), Axial.HELD if held else Axial.FORCE)
    return values | {"primary.speedSetpoint": speed, "secondary.torque": load}


class SteadyStates(AbstractContextManager["SteadyStates"]):
    """An instance of the FMU that is started at one steady state after another. It is replaced after a failed call. It
    is a context manager, which frees its instance at its end."""

    def __init__(self, archive: Archive, parameters: Mapping[str, float] | None = None) -> None:
        """`parameters` are start values of all states. The FMU is loaded at the first state."""
        self.archive, self.parameters = archive, dict(parameters or {})
        self._unit: Instance | None = None

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

    def at(self, values: Mapping[str, float], near: bytes | bool = False) -> Instance:
        """The instance in the steady state of the parameters and these start values, first sought near a stored state of `started`, or
        near the state before if `near` is True. Raises UnitError with the reason if there is none."""
        unit = self.started(values, near)
        if unit.not_steady:
            raise UnitError(unit.not_steady)
        return unit

    def sequence(self) -> At:
        """`at` for states one after another: each but the first is sought near the one before."""
        near = False

        def at(values: Mapping[str, float]) -> Instance:
            nonlocal near
            before, near = near, True
            return self.at(values, before)

        return at

    def started(self, values: Mapping[str, float], near: bytes | bool = False) -> Instance:
        """The instance in its initial state, which may not be the requested one. Raises UnitError if a call fails."""
        unit = self.unit
        try:
            if near and isinstance(near, bytes):
                unit.restore(near, 0.0)
            unit.restart({**self.parameters, **values}, bool(near))
            unit.initialise()
        except UnitError:
            self.close()
            raise
        return unit
