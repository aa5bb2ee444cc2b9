"""Steady states at a specified belt torque, such as those of the nine load cases.

The FMU starts in the steady state for its inputs; the belt torque on the primary pulley is an output.
The secondary torque for a specified belt torque is corrected by the difference until it is there.
"""

from collections.abc import Mapping

from .results import SteadyState
from .unit import Instance, UnitError

TORQUE_TOLERANCE = 1e-4  # Relative tolerance of the belt torque
MOST_EVALUATIONS = 20  # Largest number of corrections


def solve(unit: Instance, start_values: Mapping[str, float], torque: float) -> SteadyState:
    """Initialises an instance in the steady state with a belt torque on P, N·m. The primary sheave is held at a ratio.
    Raises UnitError if there is none."""
    # The first guess has an efficiency of 98 %, and a correction one of 100 %.
    load, near = -0.98 * torque * start_values["initial.ratio"], False
    for _ in range(MOST_EVALUATIONS):
        unit.restart({**start_values, "secondary.torque": load}, near)
        unit.initialise()
        if unit.not_steady:
            raise UnitError(f"at a load torque of {load:.4g} N·m the FMU reports: {unit.not_steady}")
        excess, near = -unit.get("primary.shaftTorque") - torque, True
        if abs(excess) <= TORQUE_TOLERANCE * abs(torque):
            return SteadyState(unit.outputs(), unit.profile(), load)
        load += excess * start_values["initial.ratio"]
    raise UnitError(f"no load torque gives a belt torque of {torque:g} N·m; the last one is off by {excess:g} N·m")
