"""Steady states at a specified belt torque: the nine load cases, computed with the FMU.

The FMU starts in the steady state for its inputs; the belt torque on the primary pulley is an output.
The secondary torque for a specified belt torque is corrected by the difference until it is there.
"""

from collections.abc import Mapping

from ..errors import PushbeltError
from .data import load_case_speed
from .geometry import ratio_of
from .results import LoadCase, LoadCaseResult, SteadyState
from .steady import driven_at_speed
from .unit import Archive, Instance

TORQUE_TOLERANCE = 1e-4  # Relative tolerance of the belt torque
MOST_EVALUATIONS = 20  # Largest number of corrections
DRIFT_TIME = 0.2  # Simulated time in the check that a steady state persists, s
DRIFT_STEP = 0.01  # Communication step of this check, s


class NotFoundError(PushbeltError, RuntimeError):
    """There is no steady state at the specified belt torque."""


def solve(unit: Instance, start_values: Mapping[str, float], torque: float) -> SteadyState:
    """Initialises an instance in the steady state with a belt torque on P, N·m. The primary sheave is held at a ratio."""
    # The first guess has an efficiency of 98 %, and a correction one of 100 %.
    load, near = -0.98 * torque * start_values["initial.ratio"], False
    for _ in range(MOST_EVALUATIONS):
        unit.restart({**start_values, "secondary.torque": load}, near)
        unit.initialise()
        if unit.not_steady:
            raise NotFoundError(f"at a load torque of {load:.4g} N·m the FMU reports: {unit.not_steady}")
        excess, near = -unit.get("primary.shaftTorque") - torque, True
        if abs(excess) <= TORQUE_TOLERANCE * abs(torque):
            return SteadyState(unit.outputs(), unit.profile(), load)
        load += excess * start_values["initial.ratio"]
    raise NotFoundError(f"no load torque gives a belt torque of {torque:g} N·m; the last one is off by {excess:g} N·m")


def run(archive: Archive, parameters: Mapping[str, float], case: LoadCase) -> LoadCaseResult:
    """Runs one load case, and continues it."""
    start_values = driven_at_speed(parameters, ratio_of(case.theta), load_case_speed(), 0.0, case.clamping_force, held=True)
    with Instance(archive, start_values) as unit:
        steady = solve(unit, start_values, case.torque)
        for step in range(round(DRIFT_TIME / DRIFT_STEP)):
            unit.step_to((step + 1) * DRIFT_STEP)
        return LoadCaseResult(case, steady, unit.get("thrustRatio") / steady["thrustRatio"] - 1.0)
