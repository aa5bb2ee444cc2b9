"""Steady states at a given belt torque: the nine load cases, each found through the FMU.

The FMU starts in the steady state that its inputs call for; the belt torque on the primary pulley is an output.
Which secondary torque goes with a wanted belt torque is found by the secant method, one instance an evaluation.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack

from .data import load_case_speed
from .geometry import ratio_of
from .results import LoadCase, LoadCaseResult, SteadyState
from .unit import HELD, SPEED_DRIVE, Archive, Variator

TORQUE_TOLERANCE = 1e-4
"""Belt torque met within this, relative."""

MOST_EVALUATIONS = 20
"""Evaluations after which the search is given up."""

DRIFT_TIME = 0.2
"""How long a steady state is stepped on to see whether it stays, s."""

DRIFT_STEP = 0.01
"""Communication step of that, s."""


class NotFoundError(RuntimeError):
    """There is no steady state at the wanted belt torque."""


def find_load(belt_torque: Callable[[float], float], wanted: float, guess: float) -> tuple[float, int]:
    """Load torque at which the belt torque is the wanted one, and the number of evaluations. Torques in N·m.

    The second guess scales the first; from then on it is the secant method, kept inside the bracket once there is one
    and to steps of half the first guess before that.
    """
    tolerance = TORQUE_TOLERANCE * abs(wanted)
    points: list[tuple[float, float]] = []
    load = guess
    for evaluations in range(1, MOST_EVALUATIONS + 1):
        excess = belt_torque(load) - wanted
        if abs(excess) <= tolerance:
            return load, evaluations
        points.append((load, excess))
        load = _next_load(points, wanted, guess)
    load, excess = points[-1]
    raise NotFoundError(
        f"no load torque gives a belt torque of {wanted:g} N·m; the last, {load:g} N·m, gives {wanted + excess:g} N·m"
    )


def _next_load(points: list[tuple[float, float]], wanted: float, guess: float) -> float:
    """The next load torque to try, from all tried ones with their excess of belt torque."""
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
        # Belt torque falls with the (negative) load torque, so the nearest on either side enclose the solution.
        low, high = max(above), min(below)
        if low < high and not low < candidate < high:
            candidate = 0.5 * (low + high)
    return candidate


def held_primary(parameters: Mapping[str, float], ratio: float, speed: float, force: float) -> dict[str, float]:
    """Start values of a load case: primary speed (rad/s) and sheave held, secondary clamping force (N) given."""
    return {
        **parameters,
        "primary.drive": SPEED_DRIVE,
        "primary.axial": HELD,
        "initial.steady": True,
        "initial.ratio": ratio,
        "initial.primarySpeed": speed,
        "primary.speedSetpoint": speed,
        "secondary.clampingForce": force,
    }


def steady_state(
    archive: Archive,
    parameters: Mapping[str, float],
    ratio: float,
    speed: float,
    torque: float,
    force: float,
    load_guess: float | None = None,
    drift_time: float = 0.0,
) -> tuple[SteadyState, float]:
    """Steady state with the primary speed (rad/s) and primary sheave held at a ratio.

    Belt torque on P (N·m) and secondary clamping force (N) are given. Also returns the relative change of the thrust
    ratio when the state is stepped on for `drift_time` seconds.
    """
    held = held_primary(parameters, ratio, speed, force)
    begin = time.perf_counter()
    with ExitStack() as instances:

        def start(load: float) -> Variator:
            instances.close()
            unit = instances.enter_context(Variator(archive, {**held, "secondary.torque": load}))
            unit.initialise()
            if unit.not_steady:
                raise NotFoundError(f"at a load torque of {load:.4g} N·m the FMU says: {unit.not_steady}")
            return unit

        unit: Variator

        def belt_torque(load: float) -> float:
            nonlocal unit
            unit = start(load)
            return -unit.read(unit.reader(["primary.shaftTorque"]))[0]

        guess = -0.98 * torque * ratio if load_guess is None else load_guess
        load, evaluations = find_load(belt_torque, torque, guess)
        # The search ends with an evaluation at its result: that instance is the one to look at.
        outputs, solve_time = unit.outputs(), time.perf_counter() - begin
        state = SteadyState(outputs, unit.profile(), load, evaluations, solve_time, tuple(unit.warnings))
        steps = round(drift_time / DRIFT_STEP)
        for step in range(steps):
            unit.step_to((step + 1) * DRIFT_STEP)
        drift = unit.outputs()["thrustRatio"] / state["thrustRatio"] - 1.0 if steps else 0.0
    return state, drift


def run(archive: Archive, parameters: Mapping[str, float], case: LoadCase) -> LoadCaseResult:
    """Runs one load case."""
    steady, drift = steady_state(
        archive,
        parameters,
        ratio_of(case.theta),
        load_case_speed(),
        case.torque,
        case.clamping_force,
        drift_time=DRIFT_TIME,
    )
    return LoadCaseResult(case, steady, drift)
