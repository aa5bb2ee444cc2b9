"""Steady states of a variator at working points, the clamping forces that they need, and linear models about them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from copy import copy
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .arguments import checks, kind, lists, mapping, number, optional, refused
from .errors import ArgumentError, PushbeltError, package, warn
from .fmu import capacity
from .fmu import unit as calls
from .fmu.bands import DEVIATION, bands, increased
from .fmu.closing import closed_by, closing_at
from .fmu.data import clamping_force, parameter_deviations, pitch_radius, torque_capacity
from .fmu.gradients import Asked, units_of
from .fmu.results import Bands, SteadyState, dataframe, item
from .fmu.start_values import StartValueError, Variables, checked
from .fmu.steady import SteadyStates, driven_by_torque
from .fmu.unit import Archive, UnitError
from .linear.grid import LinearGrid
from .linear.model import LinearModel, LinearPointError
from .linear.physical import MOST_HERTZ, NotPhysicalError, modes_needed, physical

if TYPE_CHECKING:
    import pandas
    import xarray

SPEED, SAFETY = 200.0, 1.3  # Default primary speed of a steady state, rad/s, and safety factor of its clamping force
LEAST_FORCE = 4e3  # Least clamping force of a steady state with `SAFETY`, N
MOST_STATES = 3  # Largest number of steady states that are solved for a clamping force with `SAFETY`
SAME_FORCE = 0.01  # Relative change below which a clamping force with `SAFETY` is not improved further
OVERRUN = 0.5  # Thrust ratio that is assumed in overrun before a steady state is solved. Thrust ratios in overrun are mostly larger
FREQUENCY = 50.0  # Default frequency, Hz, below which modes are states of a linear model
STEP = 1e-6  # Relative step of the derivatives of start values with respect to a point, in which they are nearly linear
STATES = ("modal", "physical")  # Kinds of states of a linear model


def _states(name: str, value: Any) -> str:
    if not isinstance(value, str) or value not in STATES:
        raise ArgumentError(refused(name, value, f"one of {', '.join(STATES)}"))
    return value


POINT = {
    "ratio": number(above=0.0), "torque": number("N·m"), "speed": number("rad/s"), "force": optional(number("N", least=0.0)),
    "safety": optional(number(above=0.0)), "thrust_ratio": optional(number(above=0.0)),
}  # fmt: skip
GRID = {"ratio": number(above=0.0, several=True), "torque": number("N·m", several=True)}
LINEAR = {"frequency": number("Hz", above=0.0), "states": _states, "sample_time": optional(number("s", above=0.0))}

Objects = NDArray[np.object_]
Values = Mapping[str, Any]  # Values by names of FMU variables, in SI units; enumerations by name or number


def over(axes: Mapping[str, Iterable[Any]], solve: Callable[..., Any], *lost: type[Exception]) -> tuple[Objects, Objects]:
    """Results of `solve` for all combinations of the values of the axes, and why it has none: the text of an error `lost`."""
    lists = {name: list(values) for name, values in axes.items()}
    shape = tuple(map(len, lists.values()))
    found, reasons = np.full(shape, None, dtype=object), np.full(shape, "", dtype=object)
    for place in np.ndindex(shape):
        try:
            found[place] = solve(**{name: values[k] for (name, values), k in zip(lists.items(), place, strict=True)})
        except lost as error:
            reasons[place] = str(error)
    return found, reasons


class SteadyStateError(PushbeltError, RuntimeError):
    """There is no steady state at a working point, or the belt slips through there."""


class Point(NamedTuple):
    """A working point: geometric ratio (1), primary torque (N·m), primary speed (rad/s), whole secondary clamping force (N)."""

    ratio: float
    torque: float
    speed: float
    force: float

    def __str__(self) -> str:
        return f"at ratio {self.ratio:g}, {self.torque:g} N·m, {self.speed:g} rad/s and {self.force:g} N"


def model_of(solver: calls.Instance, frequency: float, states: str, sample_time: float | None) -> LinearModel:
    """A linear model about the present state. For physical states the frequency is doubled until there are enough modes."""
    model = LinearModel.of(solver.linearise(frequency))
    if states == "physical":
        while len(model.poles) < modes_needed(model) and frequency < MOST_HERTZ:
            frequency *= 2.0
            model = LinearModel.of(solver.linearise(frequency))
        model = physical(model)
    return model if sample_time is None else model.sampled(sample_time)


class WorkingPoints:
    """Steady states of the variator of given start values, and linear models about them, on an instance of their own."""

    def __init__(self, archive: Archive, values: Values, name: str) -> None:
        """`values` are start values, of which all that are needed are checked."""
        self._archive, self._values = archive, dict(values)
        self.name = name
        """Name or file of the parameter set."""
        self._declared = archive.variables
        self._states = SteadyStates(archive)
        self._last_steady: tuple[Values, SteadyState, bytes] | None = None
        self.variables = Variables(self._declared.values())
        """The FMU's variables by name: each has `unit`, `description`, `start`, `min`, `max`, `causality` and more."""

    @checks(**POINT, **LINEAR)
    def linearize(
        self, ratio: float, torque: float, *, speed: float = SPEED, force: float | None = None, safety: float | None = SAFETY,
        frequency: float = FREQUENCY, states: str = "modal", sample_time: float | None = None,
    ) -> LinearModel:  # fmt: skip
        """The linear model about the steady state at a ratio r_S/r_P (1) and a primary torque (N·m), in 0.5 s with `ALE`.

        The primary pulley turns at `speed`, rad/s, with `force` and `safety` as in `steady`. The primary force and the secondary
        torque are those that hold the point. Modes below `frequency`, Hz, become states. Inputs are the loads that act with this
        variator's `drive` and `axial`: by default both torques (N·m) and both clamping forces (N), and the pressures (Pa) of
        cylinders with an area, which then hold the point. The run over time is not affected.

        With `states="physical"` the states are ω_P, ω_S (rad/s) and ln i, without those that are held, so that the matrices of
        several points can be interpolated. With `sample_time`, s, the model also has the discrete-time matrices `ad`, `bd`, `cd`, `dd`.

        Raises SteadyStateError if there is no such point or the belt slips through, and LinearPointError if the point has no
        linear model or requires other loads than the specified ones.
        """
        point = self._point(ratio, torque, speed, force, safety)
        state = self._steady(point)
        held = {"primary": state["primary.axialForce"], "secondary": point.force}
        start = {
            "initial.steady": True, "initial.ratio": ratio, "initial.primarySpeed": speed,
            "primary.torque": torque, "secondary.torque": state.load_torque,
            **{name: one for pulley, whole in held.items() for name, one in closed_by(self._values, pulley, whole, ratio, speed).items()},
            "primary.speedSetpoint": speed, "secondary.speedSetpoint": speed / state["primary.speed"] * state["secondary.speed"],
        }  # fmt: skip
        unit = self._solved({**self._values, **start}, point)
        try:
            model = model_of(unit, frequency, states, sample_time)
        except (UnitError, NotPhysicalError) as error:
            raise LinearPointError(f"no linear model {point}: {error}") from error
        if model.remarks:
            raise LinearPointError(f"no linear model {point}: {'; '.join(model.remarks)}")
        return model

    @checks(
        **POINT | GRID | {"speed": number("rad/s", several=True), "force": optional(number("N", least=0.0, several=True))},
        **LINEAR, changes=optional(lists), after_each=kind("a function", Callable),
    )  # fmt: skip
    def linear_grid(
        self, ratio: float | Iterable[float], torque: float | Iterable[float], *, speed: float | Iterable[float] = SPEED,
        force: float | Iterable[float] | None = None, safety: float | None = SAFETY,
        frequency: float = FREQUENCY, states: str = "modal", sample_time: float | None = None,
        changes: Mapping[str, Iterable[Any]] | None = None, after_each: Callable[[], object] = lambda: None,
    ) -> LinearGrid:  # fmt: skip
        """Linear models over ratios (1) × primary torques (N·m), each as returned by `linearize`.

        `speed` (rad/s), `force` (N) and each parameter in `changes` are further axes if they have more than one value.
        `after_each` is called after each point. A point without a model has None and a reason.
        """
        several: dict[str, Any] = {"ratio": ratio, "torque": torque, "speed": speed, "force": force}
        lists = {name: list(values) for name, values in several.items() if isinstance(values, Iterable)}
        for name, values in (changes or {}).items():
            lists[name] = [checked(self._declared, {name: value})[name] for value in values]
        if empty := [name for name, values in lists.items() if not values]:
            raise ArgumentError(f"the grid has no {empty[0]}")
        axes = {name: np.array(values, dtype=float) for name, values in lists.items()}

        def model(**at: Any) -> LinearModel:
            changed = copy(self)
            changed._values = {**self._values, **{name: at[name] for name in changes or ()}}
            point = several | {name: value for name, value in at.items() if name in several}
            try:
                return changed.linearize(**point, safety=safety, frequency=frequency, states=states, sample_time=sample_time)
            finally:
                after_each()

        return LinearGrid(axes, *over(lists, model, SteadyStateError, LinearPointError))

    @checks(**POINT)
    def steady(
        self, ratio: float, torque: float, *, speed: float = SPEED, force: float | None = None, safety: float | None = SAFETY
    ) -> SteadyState:
        """The steady state at a geometric ratio r_S/r_P (1) and a primary torque (N·m). The run over time is not affected.

        The primary pulley turns at `speed`, rad/s, less the slip; its sheave is held at the ratio. `force` is the whole secondary
        clamping force, N, with spring and rotating oil; a cylinder with an area has the pressure for it. By default it carries the
        torque with a factor of `safety` and is at least 4 kN. With `safety=None` it is that of this variator's inputs.
        The state has outputs by name, `profile`, and `load_torque`, the secondary torque in the steady state.

        Raises SteadyStateError if there is no steady state, or if the belt slips through.
        """
        return self._steady(self._point(ratio, torque, speed, force, safety))

    @checks(**POINT, deviations=optional(mapping))
    def bands(
        self, ratio: float, torque: float, deviations: Mapping[str, float] | None = None, *, speed: float = SPEED, force: float | None = None,
        safety: float | None = SAFETY,
    ) -> Bands:  # fmt: skip
        """Outputs of the steady state of `steady`, with standard deviations.

        `deviations` has those of parameters in their units, by default those of this variator's parameter set, and of `ratio`, `torque`,
        `speed` and `force`. Each is changed alone, by plus and by minus one of them; near the capacity samples are drawn, too.
        Raises SteadyStateError as `steady`.
        """
        if deviations is None:
            deviations = parameter_deviations(self.name)
        return self._bands(self._point(ratio, torque, speed, force, safety), deviations)

    def _bands(self, point: Point, deviations: Mapping[str, float]) -> Bands:
        for name in deviations.keys() - set(Point._fields):
            item(self._values, name, "variator", "parameter")
        outputs = self._steady(point).outputs
        assert self._last_steady is not None
        return bands(self._states, outputs, self._last_steady[2], lambda changes: self._changed(self._values, point, changes), deviations)

    def _changed(self, values: Values, point: Point, changes: Mapping[str, float]) -> dict[str, Any]:
        """Start values of a steady state with changes of parameters, within their ranges, and of the point."""
        of_point = {name: getattr(point, name) + more for name, more in changes.items() if name in Point._fields}
        others = {name: more for name, more in changes.items() if name not in of_point}
        values, there = {**values, **increased(self._declared, values, others)}, point._replace(**of_point)
        held = driven_by_torque(values, there.ratio, there.speed, there.torque, there.force)
        return checked(self._declared, {**held, "initial.equilibrium": False})

    def _gradient(self, values: Values, point: Point, stored: bytes, names: Iterable[str], hold: str) -> pandas.DataFrame:
        """`SteadyState.gradient` at a point, from its stored state."""

        def rates(name: str) -> dict[str, float]:
            if name not in Point._fields:
                return {name: 1.0}
            step = STEP * (abs(getattr(point, name)) or 1.0)
            above, below = (self._changed(values, point, {name: sign * step}) for sign in (1.0, -1.0))
            return {of: 0.5 * (above[of] - below[of]) / step for of in above if above[of] != below[of]}

        asked, units = Asked(tuple(dict.fromkeys(names)), hold).checked(self._declared), units_of(self._declared)
        self._states.unit.restore(stored, 0.0)
        table = dataframe(asked.of(self._states.unit, rates)).T.set_axis(asked.names, axis="columns")
        table.attrs = {"held": hold, "units": {name: units[name] for name in (*table.index, *table.columns)}}
        return table

    def _point(self, ratio: float, torque: float, speed: float, force: float | None, safety: float | None) -> Point:
        """A point with the given force, that of a safety factor, or that of the inputs."""
        if force is None:
            force = closing_at(self._values, "secondary", ratio, speed) if safety is None else self.least_force(ratio, torque, safety, speed=speed)
        return Point(ratio, torque, speed, force)

    def _steady(self, point: Point, near: bool = False) -> SteadyState:
        """The steady state at a point, perhaps `near` the one before. The last one is kept."""
        values = dict(self._values)  # Of now, for the derivatives
        held = driven_by_torque(values, point.ratio, point.speed, point.torque, point.force)
        if self._last_steady is not None and self._last_steady[0] == held:
            return self._last_steady[1]
        if why := capacity.shortfall(values, point.ratio, point.torque, point.force):
            raise SteadyStateError(f"no steady state {point}: {why}")
        if why := capacity.excessive_speed(values, point.ratio, point.speed):
            warn(why)
        unit = self._solved(held, point, near)
        derivatives = partial(self._gradient, values, point, stored := unit.state())
        state = SteadyState(unit.outputs(), unit.profile(), unit.get("secondary.externalTorque"), derivatives)
        if state["pastPeak"]:
            raise SteadyStateError(f"the belt slips through {point}, past the peak of its traction: its torque utilisation is {state['torqueUtilisation']:.2f}")
        self._last_steady = (held, state, stored)
        return state

    def _solved(self, values: Values, point: Point, near: bytes | bool = False) -> calls.Instance:
        """The instance in the steady state of these start values, first sought near a stored one or the one before."""
        try:
            return self._states.at(checked(self._declared, {**values, "initial.equilibrium": False}), near)
        except (StartValueError, UnitError) as error:
            raise SteadyStateError(f"no steady state {point}: {error}") from error

    @checks(**POINT | {"safety": number(above=0.0)})
    def least_force(
        self, ratio: float, torque: float, safety: float = SAFETY, *, speed: float = SPEED, thrust_ratio: float | None = None
    ) -> float:
        """Whole secondary clamping force with which both pulleys carry a primary torque (N·m) with a safety factor, at least 4 kN; N.

        The primary pulley is clamped by the thrust ratio κ times this force. κ is that of at most three steady states at
        `speed` (rad/s), together about 0.05 s, or `thrust_ratio`, with which nothing is solved.
        """
        # F min(1, κ(F)) carries the torque with the safety factor: fixed-point iteration, as κ varies little with F.
        values = self._values
        needed = clamping_force(torque, pitch_radius(values, ratio), values["friction.pulley"], values["geometry.wedgeAngle"], safety)
        if why := capacity.excessive_force(torque, needed):
            raise SteadyStateError(f"no clamping force at ratio {ratio:g}: {why}")
        if thrust_ratio is not None:
            return max(needed / min(1.0, thrust_ratio), LEAST_FORCE)
        if torque == 0.0:
            return LEAST_FORCE
        force, found = max(needed if torque > 0.0 else needed / OVERRUN, LEAST_FORCE), False
        for _ in range(MOST_STATES):
            try:
                state = self._steady(Point(ratio, torque, speed, force), near=found)
            except SteadyStateError:
                if found:
                    break
                force *= 2.0
                continue
            found = True
            better = max(needed / min(1.0, state["thrustRatio"]), LEAST_FORCE)
            if abs(better / force - 1.0) < SAME_FORCE:
                break
            force = better
        return force

    @checks(**POINT | {"force": number("N", least=0.0), "thrust_ratio": number(above=0.0)})
    def torque_capacity(self, ratio: float, force: float, thrust_ratio: float = 1.0) -> float:
        """Primary torque at which the belt slips through at a ratio, under a whole secondary clamping force (N); N·m.

        It is that of the secondary pulley, at which the torque utilisation is 1. With a thrust ratio below 1 it is that of the primary.
        """
        return torque_capacity(self._values, ratio, min(1.0, thrust_ratio) * force)

    @checks(**POINT | GRID, deviations=optional(mapping))
    def thrust_map(
        self, ratio: float | Iterable[float], torque: float | Iterable[float], *, speed: float = SPEED, force: float | None = None,
        safety: float | None = SAFETY, deviations: Mapping[str, float] | None = None,
    ) -> xarray.Dataset:
        """Steady states over geometric ratios (1) and primary torques (N·m), with speed and force as in `steady`.

        Returns a data set with the dimensions `ratio` and `torque` and the attributes `variator`, `fmu` and `version`. It has a variable
        for each output (`thrustRatio`, `slip`, `efficiency`, … with the attributes `units` and `long_name`), `clampingForce` in N, and
        `reason`, which is empty at points with a steady state. Points without one have the value NaN. With `deviations`, as of `bands`, each
        output has its standard deviation, such as `slip.sd`. Needs `pushbelt[maps]`.
        """
        dataset = package("xarray", "thrust_map needs xarray", "maps").Dataset
        axes = {"ratio": np.atleast_1d(np.asarray(ratio)), "torque": np.atleast_1d(np.asarray(torque))}
        if empty := [name for name, values in axes.items() if not len(values)]:
            raise ArgumentError(f"the map has no {empty[0]}")
        outputs = calls.output_names(self._declared.values())
        names = [*outputs, "clampingForce", *(name + DEVIATION for name in (outputs if deviations else ()))]

        def row(ratio: float, torque: float) -> list[float]:
            point = self._point(ratio, torque, speed, force, safety)
            state = self._steady(point)
            spread = self._bands(point, deviations).spread if deviations else {}
            return [*(state[name] for name in outputs), point.force, *(spread[name] for name in outputs if spread)]

        found, reasons = over(axes, row, SteadyStateError)
        gap = [np.nan] * len(names)
        values = np.moveaxis(np.array([[gap if one is None else one for one in line] for line in found]), -1, 0)
        texts = {name: (one.unit, one.description) for name, one in self.variables.items()}
        texts |= {"ratio": ("1", "Geometric ratio r_S/r_P"), "torque": ("N.m", "Primary torque"), "speed": ("rad/s", "Primary speed")}
        texts["clampingForce"] = ("N", "Whole secondary clamping force")
        texts |= {name + DEVIATION: (unit, f"Standard deviation: {text}") for name, (unit, text) in texts.items()}
        about = {name: {"units": unit, "long_name": text} for name, (unit, text) in texts.items()}
        return dataset(
            {name: (tuple(axes), one, about[name]) for name, one in zip(names, values, strict=True)} | {"reason": (tuple(axes), reasons)},
            {name: (name, axis, about[name]) for name, axis in axes.items()} | {"speed": ((), speed, about["speed"])},
            {"variator": self.name, "fmu": self._archive.description.modelName, "version": self._archive.version},
        )
