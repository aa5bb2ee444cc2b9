"""Steady states at a specified belt torque: the nine load cases, computed with the FMU.

The FMU starts in the steady state for its inputs; the belt torque on the primary pulley is an output.
The secondary torque for a specified belt torque is found by the secant method.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ..errors import PushbeltError
from .data import load_case_speed
from .geometry import ratio_of
from .results import LoadCase, LoadCaseResult, SteadyState
from .steady import driven_at_speed
from .unit import Archive, Instance

TORQUE_TOLERANCE = 1e-4  # Relative tolerance of the belt torque
MOST_EVALUATIONS = 20  # Largest number of evaluations in the search
DRIFT_TIME = 0.2  # Simulated time in the check that a steady state persists, s
DRIFT_STEP = 0.01  # Communication step of this check, s


class NotFoundError(PushbeltError, RuntimeError):
    """There is no steady state at the specified belt torque."""


def find_load(belt_torque: Callable[[float], float], wanted: float, guess: float) -> float:
    """Load torque for a specified belt torque, N·m, by the secant method from the line through the first guess and the origin on, in
    steps of at most half the first guess. The last evaluation is at this load."""
    load, limit = guess, 0.5 * abs(guess)
    before: tuple[float, float] | None = None
    for _ in range(MOST_EVALUATIONS):
        found = belt_torque(load)
        excess = found - wanted
        if abs(excess) <= TORQUE_TOLERANCE * abs(wanted):
            return load
        slope = found / load if before is None else (found - before[1]) / (load - before[0])
        before = load, found
        load += limit if slope == 0.0 else max(-limit, min(limit, -excess / slope))
    assert before is not None
    last = f"the last one, {before[0]:g} N·m, gives {before[1]:g} N·m"
    raise NotFoundError(f"no load torque gives a belt torque of {wanted:g} N·m; {last}")


def solve(unit: Instance, start_values: Mapping[str, float], torque: float) -> SteadyState:
    """Initialises an instance in the steady state with a belt torque on P, N·m. The primary sheave is held at a ratio."""

    def belt_torque(load: float) -> float:
        unit.restart({**start_values, "secondary.torque": load})
        unit.initialise()
        if unit.not_steady:
            raise NotFoundError(f"at a load torque of {load:.4g} N·m the FMU reports: {unit.not_steady}")
        return -unit.get("primary.shaftTorque")

    # The first guess has an efficiency of 98 %.
    load = find_load(belt_torque, torque, -0.98 * torque * start_values["initial.ratio"])
    return SteadyState(unit.outputs(), unit.profile(), load)


def run(archive: Archive, parameters: Mapping[str, float], case: LoadCase) -> LoadCaseResult:
    """Runs one load case, and continues it."""
    start_values = driven_at_speed(parameters, ratio_of(case.theta), load_case_speed(), 0.0, case.clamping_force, held=True)
    with Instance(archive, start_values) as unit:
        steady = solve(unit, start_values, case.torque)
        for step in range(round(DRIFT_TIME / DRIFT_STEP)):
            unit.step_to((step + 1) * DRIFT_STEP)
        return LoadCaseResult(case, steady, unit.get("thrustRatio") / steady["thrustRatio"] - 1.0)
