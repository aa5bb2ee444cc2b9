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
from .starts import driven_at_speed
from .unit import Archive, Instance

TORQUE_TOLERANCE = 1e-4
"""Relative tolerance of the belt torque."""

MOST_EVALUATIONS = 20
"""Largest number of evaluations in the search."""

DRIFT_TIME = 0.2
"""Simulated time in the check that a steady state persists, s."""

DRIFT_STEP = 0.01
"""Communication step of this check, s."""


class NotFoundError(PushbeltError, RuntimeError):
    """There is no steady state at the specified belt torque."""


def find_load(belt_torque: Callable[[float], float], wanted: float, guess: float) -> float:
    """Load torque for a specified belt torque, N·m. The last evaluation is at this load.

    The second guess scales the first. Further guesses are those of the secant method, limited to the bracket if there is one,
    and otherwise to steps of half the first guess.
    """
    tolerance = TORQUE_TOLERANCE * abs(wanted)
    points: list[tuple[float, float]] = []
    load = guess
    for _ in range(MOST_EVALUATIONS):
        excess = belt_torque(load) - wanted
        if abs(excess) <= tolerance:
            return load
        points.append((load, excess))
        load = _next_load(points, wanted, guess)
    load, excess = points[-1]
    raise NotFoundError(
        f"no load torque gives a belt torque of {wanted:g} N·m; the last one, {load:g} N·m, gives {wanted + excess:g} N·m"
    )


def _next_load(points: list[tuple[float, float]], wanted: float, guess: float) -> float:
    """Next load torque of the search, from all previous ones and their excess of belt torque."""
    load, excess = points[-1]
    if len(points) == 1:
        found = wanted + excess
        return load * wanted / found if found * wanted > 0.0 else 1.1 * load
    last_load, last_excess = points[-2]
    slope = (excess - last_excess) / (load - last_load) if load != last_load else 0.0
    limit = 0.5 * abs(guess)
    candidate = load - max(-limit, min(limit, excess / slope)) if slope else load + limit
    above = [tried for tried, value in points if value > 0.0]
    below = [tried for tried, value in points if value < 0.0]
    if above and below:
        # Belt torque falls with the (negative) load torque, so the nearest values on either side enclose the solution.
        low, high = max(above), min(below)
        if low < high and not low < candidate < high:
            candidate = 0.5 * (low + high)
    return candidate


def held_primary(parameters: Mapping[str, float], ratio: float, speed: float, force: float) -> dict[str, float]:
    """Start values of a load case: primary speed (rad/s) and sheave held, secondary clamping force (N) specified."""
    return driven_at_speed(parameters, ratio, speed, 0.0, force, held=True)


def steady_state(
    archive: Archive,
    parameters: Mapping[str, float],
    ratio: float,
    speed: float,
    torque: float,
    force: float,
    load_guess: float | None = None,
) -> SteadyState:
    """Steady state with the primary speed (rad/s) and primary sheave held at a ratio.

    Belt torque on P (N·m) and secondary clamping force (N) are specified.
    """
    start_values = held_primary(parameters, ratio, speed, force)
    with Instance(archive, start_values) as unit:
        return _solve(unit, start_values, torque, _first_guess(torque, ratio) if load_guess is None else load_guess)


def _first_guess(torque: float, ratio: float) -> float:
    """Load torque at an efficiency of 98 %, N·m."""
    return -0.98 * torque * ratio


def _solve(unit: Instance, start_values: Mapping[str, float], torque: float, load_guess: float) -> SteadyState:
    """Initialises an instance in the steady state with a belt torque on P, N·m."""

    def belt_torque(load: float) -> float:
        unit.restart({**start_values, "secondary.torque": load})
        unit.initialise()
        if unit.not_steady:
            raise NotFoundError(f"at a load torque of {load:.4g} N·m the FMU reports: {unit.not_steady}")
        return -unit.get("primary.shaftTorque")

    load = find_load(belt_torque, torque, load_guess)
    return SteadyState(unit.outputs(), unit.profile(), load)


def _drift(unit: Instance) -> float:
    """Relative change of the thrust ratio when an instance in a steady state is advanced by `DRIFT_TIME`."""
    before = unit.get("thrustRatio")
    for step in range(round(DRIFT_TIME / DRIFT_STEP)):
        unit.step_to((step + 1) * DRIFT_STEP)
    return unit.get("thrustRatio") / before - 1.0


def run(archive: Archive, parameters: Mapping[str, float], case: LoadCase) -> LoadCaseResult:
    """Runs one load case."""
    ratio = ratio_of(case.theta)
    start_values = held_primary(parameters, ratio, load_case_speed(), case.clamping_force)
    with Instance(archive, start_values) as unit:
        steady = _solve(unit, start_values, case.torque, _first_guess(case.torque, ratio))
        return LoadCaseResult(case, steady, _drift(unit))
