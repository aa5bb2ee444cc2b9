"""Linear models of a variator about its steady states."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

import numpy as np

from ..errors import ArgumentError
from ..fmu import unit as calls
from ..fmu.start_values import checked
from ..fmu.unit import UnitError
from .model import LinearModel, LinearPointError
from .grid import LinearGrid
from .physical import NotPhysicalError, with_enough_modes
from ..points import SAFETY, SPEED, Point, SteadyStateError, Values, WorkingPoints, over

FREQUENCY = 50.0  # Default frequency, Hz, below which modes are states of a linear model
STATES = ("modal", "physical")  # Kinds of states of a linear model
Find = Callable[[calls.Instance], LinearModel]


def model_of(solver: calls.Instance, frequency: float, states: str, sample_time: float | None) -> LinearModel:
    def modal(below: float) -> LinearModel:
        return LinearModel.of(solver.linearise(below))

    if states not in STATES:
        raise ArgumentError(f"states = {states!r} is not one of {', '.join(STATES)}")
    model = with_enough_modes(modal, frequency) if states == "physical" else modal(frequency)
    return model if sample_time is None else model.sampled(sample_time)


class LinearPoints(WorkingPoints):
    """Steady states, and linear models about them."""

    def linearize(
        self,
        ratio: float,
        torque: float,
        *,
        speed: float = SPEED,
        force: float | None = None,
        safety: float = SAFETY,
        frequency: float = FREQUENCY,
        states: str = "modal",
        sample_time: float | None = None,
    ) -> LinearModel:
        """The linear model about the steady state at a ratio r_S/r_P (1) and a primary torque (N·m), in 0.5 s with `ALE`.

        The primary pulley turns at `speed`, rad/s. `force` is the secondary clamping force, N, with `safety` as in `steady`.
        The primary clamping force and the secondary torque are those that hold the point. Modes below `frequency`, Hz, become
        states. Inputs are the loads that act with this variator's `drive` and `axial`: by default both torques (N·m) and both
        clamping forces (N). The run over time is not affected.

        With `states="physical"` the states are ω_P, ω_S (rad/s) and ln i, without those that are held, so that the matrices of
        several points can be interpolated. With `sample_time`, s, the model also has the discrete-time matrices `ad`, `bd`, `cd`, `dd`.

        Raises SteadyStateError if there is no such point or the belt slips through, and LinearPointError if the point has no
        linear model or requires other loads than the specified ones.
        """
        find = partial(model_of, frequency=frequency, states=states, sample_time=sample_time)
        return self._linearize(self._values, ratio, torque, speed, force, safety, find)

    def linear_grid(
        self,
        ratios: Iterable[float],
        torques: Iterable[float],
        *,
        speed: float | Iterable[float] = SPEED,
        force: float | Iterable[float] | None = None,
        safety: float = SAFETY,
        frequency: float = FREQUENCY,
        states: str = "modal",
        sample_time: float | None = None,
        changes: Mapping[str, Iterable[Any]] | None = None,
        after_each: Callable[[], object] = lambda: None,
    ) -> LinearGrid:
        """Linear models over ratios (1) × primary torques (N·m), each as returned by `linearize`.

        `speed` (rad/s), `force` (N) and each parameter in `changes` are further axes if they have more than one value.
        `after_each` is called after each point. A point without a model has None and a reason.
        """
        several = {"ratio": ratios, "torque": torques, "speed": speed, "force": force}
        lists = {name: list(values) for name, values in several.items() if isinstance(values, Iterable)}
        for name, values in (changes or {}).items():
            lists[name] = [checked(self._declared, {name: value})[name] for value in values]
        if empty := [name for name, values in lists.items() if not values]:
            raise ArgumentError(f"the grid has no {empty[0]}")
        axes = {name: np.array(values, dtype=float) for name, values in lists.items()}
        find = partial(model_of, frequency=frequency, states=states, sample_time=sample_time)

        def model(**at: Any) -> LinearModel:
            values = {**self._values, **{name: at[name] for name in changes or ()}}
            point = {**several, **at}
            try:
                return self._linearize(values, *(point[name] for name in several), safety, find)
            finally:
                after_each()

        return LinearGrid(axes, *over(lists, model, SteadyStateError, LinearPointError))

    def _linearize(
        self, values: Values, ratio: float, torque: float, speed: float, force: float | None, safety: float, find: Find
    ) -> LinearModel:
        """The linear model at a point with these start values: about the steady state under the loads that hold it."""
        force = self._least_force(values, ratio, torque, speed, safety) if force is None else force
        point = Point(ratio, torque, speed, force)
        state = self._steady(values, point)
        slower = point.speed / state["primary.speed"]
        loads = {
            "primary.torque": point.torque,
            "secondary.torque": state.load_torque,
            "primary.clampingForce": state["primary.axialForce"],
            "secondary.clampingForce": point.force,
            "primary.speedSetpoint": point.speed,
            "secondary.speedSetpoint": slower * state["secondary.speed"],
        }
        start = {"initial.steady": True, "initial.ratio": point.ratio, "initial.primarySpeed": point.speed}

        def read(solver: calls.Instance) -> LinearModel:
            try:
                return find(solver)
            except (UnitError, NotPhysicalError) as error:
                raise LinearPointError(f"no linear model {point}: {error}") from error

        model = self._solved({**values, **loads, **start}, point, read)
        if model.remarks:
            raise LinearPointError(f"no linear model {point}: {'; '.join(model.remarks)}")
        return model
