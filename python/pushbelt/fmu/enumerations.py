"""Enumerations of the FMU by name. A test compares them with the model description."""

from __future__ import annotations

from enum import IntEnum


class RingModel(IntEnum):
    """Values of `ring.model`."""

    ALE0 = 1
    ALE = 2


class BeltKind(IntEnum):
    """Values of `belt.kind`."""

    PUSH_BELT = 1
    PULL_CHAIN = 2


class Drive(IntEnum):
    """Values of `primary.drive` and `secondary.drive`: whether torque or speed of the shaft is prescribed."""

    TORQUE = 1
    SPEED = 2


class Axial(IntEnum):
    """Values of `primary.axial` and `secondary.axial`: whether the clamping force is prescribed or the sheave is held."""

    FORCE = 1
    HELD = 2


class StartState(IntEnum):
    """Values of `initial.found`: the kind of state from which a run started."""

    UNLOADED = 1
    STEADY = 2
    REDUCED_TORQUE = 3
    NO_EQUILIBRIUM = 4
    NOT_FOUND = 5
    CLAMPED = 6
