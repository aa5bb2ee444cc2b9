"""Enumerations of the FMU by name. A test compares them with the model description."""

from enum import IntEnum

RingModel = IntEnum("RingModel", "ALE0 ALE")  # Values of `ring.model`
BeltKind = IntEnum("BeltKind", "PUSH_BELT PULL_CHAIN")  # Values of `belt.kind`
Drive = IntEnum("Drive", "TORQUE SPEED")
"""Values of `primary.drive` and `secondary.drive`: whether torque or speed of the shaft is prescribed."""
Axial = IntEnum("Axial", "FORCE HELD")
"""Values of `primary.axial` and `secondary.axial`: whether the clamping force is prescribed or the sheave is held."""
StartState = IntEnum("StartState", "UNLOADED STEADY REDUCED_TORQUE NO_EQUILIBRIUM NOT_FOUND CLAMPED")
"""Values of `initial.found`: the kind of state from which a run started."""
