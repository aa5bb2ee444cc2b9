"""The variator over time, its steady states and linear models, for programs and notebooks: `pushbelt.Variator`."""

from __future__ import annotations

import math
import os
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
from numpy.lib.recfunctions import unstructured_to_structured
from numpy.typing import NDArray

from .errors import PushbeltError, VariatorWarning
from .fmu import cache, capacity
from .fmu import unit as calls
from .fmu.data import clamping_force, parameter_set, pitch_radius, torque_capacity
from .fmu.enumerations import Axial, Drive, RingModel
from .fmu.files import default_fmu
from .fmu.results import Profile, SteadyState, dataframe, item
from .fmu.start_values import SETTABLE, StartValueError, checked
from .fmu.starts import driven_by_torque
from .fmu.unit import UnitError
from .linear import LinearModel, LinearPointError
from .linear_grid import LinearGrid
from .linear_physical import NotPhysicalError, with_enough_modes

if TYPE_CHECKING:
    import pandas
    import xarray

SPEED = 200.0
"""Default primary speed of a steady state, rad/s."""
SAFETY = 1.3
"""Default safety factor of the clamping force of a steady state."""
LEAST_FORCE = 4e3
"""Least clamping force of a steady state with `SAFETY`, N."""
MOST_STATES = 3
"""Largest number of steady states that are solved for a clamping force with `SAFETY`."""
SAME_FORCE = 0.01
"""Relative change below which a clamping force with `SAFETY` is not improved further."""
OVERRUN = 0.5
"""Thrust ratio that is assumed in overrun before a steady state is solved. Thrust ratios in overrun are mostly larger."""
FREQUENCY = 50.0
"""Default frequency, Hz, below which modes are states of a linear model."""

STATES = ("modal", "physical")
"""Kinds of states of a linear model."""
LOADS = frozenset({"primary.torque", "secondary.clampingForce"})
"""Inputs whose units are checked by the capacity of the belt."""

Read = TypeVar("Read")

Values = Mapping[str, Any]
"""Values by names of FMU variables, in SI units; enumerations by name or number."""
Parameters = str | os.PathLike[str] | Values


class SteadyStateError(PushbeltError, RuntimeError):
    """There is no steady state at a working point, or the belt slips through there."""


class Point(NamedTuple):
    """A working point: geometric ratio (1), primary torque (N·m), primary speed (rad/s), secondary clamping force (N)."""

    ratio: float
    torque: float
    speed: float
    force: float

    def __str__(self) -> str:
        return f"at ratio {self.ratio:g}, {self.torque:g} N·m, {self.speed:g} rad/s and {self.force:g} N"


def _check(point: Point) -> None:
    """Raises StartValueError if a number of a point is not usable."""
    for name, value in point._asdict().items():
        if not math.isfinite(value):
            raise StartValueError(f"{name} = {value!r} is not finite")
    if point.ratio <= 0.0:
        raise StartValueError(f"ratio = {point.ratio:g} is out of range: r_S/r_P is above 0")
    if point.force < 0.0:
        raise StartValueError(f"force = {point.force:g} N is out of range: a clamping force is at least 0 N")


def _table(inputs: pandas.DataFrame) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    """Times and columns of a table of inputs. Raises ValueError if it is not usable."""
    if not hasattr(inputs, "columns") or not hasattr(inputs, "index"):
        raise ValueError(f"inputs are a pandas.DataFrame over time, not {type(inputs).__name__}")
    columns = {str(name): inputs[name].to_numpy() for name in inputs.columns}
    times = columns.pop("time", inputs.index.to_numpy())
    try:
        times = np.asarray(times, dtype=float)
        columns = {name: np.asarray(values, dtype=float) for name, values in columns.items()}
    except (TypeError, ValueError) as error:
        raise ValueError(f"time and inputs must be numbers: {error}") from error
    if len(times) < 2:
        raise ValueError(
            f"the table of inputs has {len(times)} rows: at least 2 are needed, for the begin and the end of the run"
        )
    if not np.isfinite(times).all() or not (np.diff(times) > 0.0).all():
        raise ValueError("the times of the inputs must be finite and must ascend")
    return times, columns


def _steps(times: NDArray[np.float64], step: float) -> Iterator[float]:
    """Ends of steps of at most `step`, s, between the rows of a table."""
    for begin, end in zip(times[:-1], times[1:], strict=True):
        count = max(1, math.ceil((end - begin) / step - 1e-9))
        yield from (float(begin + (end - begin) * (k + 1) / count) for k in range(count))


def _model(solver: calls.Variator, frequency: float, states: str, sample_time: float | None) -> LinearModel:
    """The linear model about the state of an instance."""

    def modal(below: float) -> LinearModel:
        return LinearModel.of(solver.linearise(below))

    if states not in STATES:
        raise ValueError(f"states = {states!r} is not one of {', '.join(STATES)}")
    model = with_enough_modes(modal, frequency) if states == "physical" else modal(frequency)
    return model if sample_time is None else model.sampled(sample_time)


def _user() -> int:
    """The `stacklevel` of a warning that is attributed to the first caller outside of this package."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").split(".")[0] == __package__:
        level, frame = level + 1, frame.f_back
    return level


def start_values(parameters: Parameters) -> dict[str, Any]:
    """Parameters of a published variator by name, of a parameter file (`….json`), or of a mapping."""
    return dict(parameters) if isinstance(parameters, Mapping) else parameter_set(os.fspath(parameters))


class Variator:
    """A variator that is advanced in time by `step`. It is a context manager, which calls `close` at its end.

        with pushbelt.Variator("bench168", {"initial.ratio": 1.5}) as variator:
            state = variator.step(0.01, {"primary.torque": 60.0, "secondary.torque": -85.0})

    Names are those of the FMU's variables (`docs/variables.md`), units are SI: N·m, N, rad/s, m, W, s. Torques are
    external torques on the shafts, positive in the direction of positive speed: that of an engine is positive, that of a load negative.
    """

    def __init__(
        self, parameters: Parameters = "bench168", changes: Values | None = None, *, fmu: Path | None = None
    ) -> None:
        """Creates a variator.

        `parameters` is a published variator (`bench168`, `belt155`), the file of a parameter set, or a mapping of start
        values. `changes` override them. Start values of inputs hold until `step` sets others. The default of `fmu` is
        the FMU of the package.

        Raises StartValueError for a name or a value that the FMU does not accept, and OSError or ValueError for files
        that cannot be read.
        """
        self._unit = self._solver = None
        self._name = (
            parameters
            if isinstance(parameters, str)
            else "own values"
            if isinstance(parameters, Mapping)
            else os.fspath(parameters)
        )
        self._archive = cache.unpacked(Path(fmu) if fmu is not None else default_fmu())
        self.variables: Mapping[str, Any] = {v.name: v for v in self._archive.description.modelVariables}
        """The FMU's variables by name: each has `description`, `unit`, `min`, `max`, `start`, `causality`."""
        described = {
            v.name: v.start for v in self.variables.values() if v.causality in SETTABLE and v.start is not None
        }
        given = {**described, **start_values(parameters), **(changes or {})}
        self._values = checked(self.variables, given)
        self._unit = calls.Variator(self._archive, self._values)
        inputs = [v.name for v in self.variables.values() if v.causality == "input"]
        self._recorded = self._unit.reals([*inputs, *calls.output_names(self.variables.values())])
        self._rows: list[NDArray[np.float64]] = []
        self._warned = 0
        self._last_steady: tuple[Values, SteadyState] | None = None

    def __enter__(self) -> Variator:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        ring = RingModel(int(self._values["ring.model"])).name
        state = "closed" if self._unit is None else f"at {self._unit.time:g} s" if self._rows else "not started"
        return f"<Variator {self._name}: ring {ring}, {state}, {len(self._rows)} rows of outputs>"

    def close(self) -> None:
        """Frees the instance. Recorded outputs can still be read."""
        for instance in (self._unit, self._solver):
            if instance is not None:
                instance.free()
        self._unit = self._solver = None

    # Over time

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self._open.time

    def start(self) -> dict[str, float]:
        """Computes the initial state and returns its outputs. The first `step` calls it if necessary.

        By default this is the steady state at `initial.ratio` and `initial.primarySpeed`. If the run starts from another
        state, a VariatorWarning is issued.
        """
        if not self._rows:
            self._check_start()
            self._open.initialise()
            self._record()
        return self._last()

    def _check_start(self) -> None:
        """Refuses loads that look like a wrong unit, and warns of an excessive speed, before the FMU solves the initial state."""
        values = self._values
        if values["initial.primarySpeed"] == 0.0:
            return
        if values["initial.steady"] and (hint := self._wrong_unit()):
            raise StartValueError(hint)
        if why := capacity.excessive_speed(values, values["initial.ratio"], values["initial.primarySpeed"]):
            warnings.warn(f"initial.primarySpeed: {why}", VariatorWarning, stacklevel=_user())

    def _wrong_unit(self) -> str | None:
        """Description of a wrong unit of the present secondary force or primary torque; None if they may be right."""
        values = self._values
        torque, force = values["primary.torque"], values["secondary.clampingForce"]
        if values["primary.drive"] != Drive.TORQUE or values["secondary.axial"] != Axial.FORCE or torque == 0.0:
            return None
        carried = torque_capacity(values, values["initial.ratio"], force)
        if abs(torque) <= capacity.BEYOND * carried + capacity.DRAG or not capacity.wrong_unit(torque, force, carried):
            return None
        why = capacity.shortfall(values, values["initial.ratio"], torque, force)
        return f"primary.torque = {torque:g} N.m, secondary.clampingForce = {force:g} N: {why}"

    def step(self, duration: float, inputs: Values | None = None) -> dict[str, float]:
        """Advances by a duration, s, with the given inputs and the last values of the others; returns the outputs at its end.

        An input that changes reaches its value within `inputs.ramp` (1 ms by default; −1 means at the end of the step).
        The inputs may include tunable parameters.

        Raises StartValueError for a wrong name or value, and UnitError if the FMU cannot complete the step.
        """
        if not (math.isfinite(duration) and duration > 0.0):
            raise ValueError(f"the duration of a step must be above 0 s, not {duration!r} s")
        self.start()
        if inputs:
            self.set(inputs)
        self._open.step_to(self.time + duration)
        self._record()
        return self._last()

    def set(self, values: Values) -> None:
        """Sets inputs and tunable parameters, and before the start any parameter."""
        found = checked(self.variables, values)
        if self._rows:
            for name in found:
                variable = self.variables[name]
                if variable.causality == "parameter" and variable.variability != "tunable":
                    raise StartValueError(f"{name} can only be set before the start")
        self._open.set(found)
        self._values |= found
        if self._rows and LOADS.intersection(found) and (hint := self._wrong_unit()):
            warnings.warn(hint, VariatorWarning, stacklevel=_user())

    def __getitem__(self, name: str) -> float:
        """Present value of a variable; `variables` has its unit."""
        if name in self._values:
            return self._values[name]
        item(self.variables, name, "FMU", "variable")
        self.start()
        return self._open.get(name)

    def profile(self) -> Profile:
        """Present fields along the belt: position (m), push force and ring tension (N), normal force (N/m) and more."""
        self.start()
        return self._open.profile()

    @property
    def outputs(self) -> NDArray[Any]:
        """All communication points so far as a record array: `outputs["time"]` in s, `outputs["primary.speed"]` in rad/s.

        Columns are the real inputs and outputs, stored and residual energy, and `macroSlip` as 0 or 1. The value of an
        input is that at the end of the previous step.
        """
        names = ["time", *self._recorded.names, "macroSlip"]
        rows = np.array(self._rows) if self._rows else np.empty((0, len(names)))
        return unstructured_to_structured(rows, dtype=np.dtype([(name, float) for name in names]))

    def to_dataframe(self) -> pandas.DataFrame:
        """`outputs` as a table over `time` (s). Needs `pushbelt[maps]`."""
        return dataframe(self.outputs).set_index("time")

    def simulate(
        self, inputs: pandas.DataFrame, *, step: float = 1e-2, outputs: Iterable[str] | None = None
    ) -> pandas.DataFrame:
        """Runs the variator with a table of inputs over time and returns a table of the outputs. Needs `pushbelt[maps]`.

        The index of `inputs`, or its column `time`, is time in s; the other columns are inputs and tunable parameters by name, linear
        between the rows. The run goes from the first time to the last, in steps of at most `step`, s, which end at each row. Each step has the
        inputs of its end, reached within `inputs.ramp` as in `step`. A new variator starts with the first row. An earlier run is continued: the first time is then the present one. By default all
        outputs are returned.

        Raises ValueError for a table that is not usable, StartValueError for a wrong name or value.
        """
        times, columns = _table(inputs)
        if not (math.isfinite(step) and step > 0.0):
            raise ValueError(f"step = {step!r} s is not a number above 0")
        if self._rows and abs(times[0] - self.time) > 1e-9:
            raise ValueError(f"the first time of the inputs is {times[0]:g} s, but the run is at {self.time:g} s")
        wanted = None if outputs is None else [item(self._columns, name, "run") for name in outputs]
        for k in range(len(times)):
            checked(self.variables, {name: values[k] for name, values in columns.items()})
        self.set({name: values[0] for name, values in columns.items()})
        self.start()
        first, begin = len(self._rows) - 1, self.time
        for at in _steps(times, step):
            values = {name: float(np.interp(at, times, column)) for name, column in columns.items()}
            self.step(begin + at - times[0] - self.time, values)
        found = dataframe(self.outputs[first:])
        found["time"] = found["time"] - begin + times[0]
        found = found.set_index("time")
        return found if wanted is None else found[wanted]

    @property
    def _columns(self) -> dict[str, str]:
        return {name: name for name in (*self._recorded.names, "macroSlip")}

    @property
    def _open(self) -> calls.Variator:
        if self._unit is None:
            raise UnitError("the variator is closed")
        return self._unit

    def _record(self) -> None:
        unit = self._open
        self._rows.append(np.array([unit.time, *unit.get_reals(self._recorded), unit.get("macroSlip")]))
        self._warn()

    def _warn(self) -> None:
        """Issues the warnings of the FMU since the last call."""
        texts = self._open.warnings
        for text in texts[self._warned :]:
            warnings.warn(text, VariatorWarning, stacklevel=_user())
        self._warned = len(texts)

    def _last(self) -> dict[str, float]:
        return dict(zip(("time", *self._recorded.names, "macroSlip"), self._rows[-1].tolist(), strict=True))

    # Steady states

    def steady(
        self, ratio: float, torque: float, *, speed: float = SPEED, force: float | None = None, safety: float = SAFETY
    ) -> SteadyState:
        """The steady state at a geometric ratio r_S/r_P (1) and a primary torque (N·m). The run over time is not affected.

        The primary pulley turns at `speed`, rad/s, less the slip; its sheave is held at the ratio. `force` is the
        secondary clamping force, N. By default it carries the torque with a factor of `safety` and is at least 4 kN.
        The state has outputs by name, `profile`, and `load_torque`, the secondary torque in the steady state.

        Raises SteadyStateError if there is no steady state, or if the belt slips through.
        """
        force = self.least_force(ratio, torque, safety, speed=speed) if force is None else force
        return self._steady(self._values, Point(ratio, torque, speed, force))

    def _steady(self, values: Values, point: Point) -> SteadyState:
        """The steady state at a point with these start values. The last one is kept."""
        held = driven_by_torque(values, point.ratio, point.speed, point.torque, point.force)
        if self._last_steady is None or self._last_steady[0] != held:
            self._last_steady = (held, self._solve_steady(values, held, point))
        return self._last_steady[1]

    def _solve_steady(self, values: Values, held: Values, point: Point) -> SteadyState:
        _check(point)
        if why := capacity.shortfall(values, point.ratio, point.torque, point.force):
            raise SteadyStateError(f"no steady state {point}: {why}")
        if why := capacity.excessive_speed(values, point.ratio, point.speed):
            warnings.warn(why, VariatorWarning, stacklevel=_user())
        state = self._solved(
            held,
            point,
            lambda solver: SteadyState(solver.outputs(), solver.profile(), solver.get("secondary.externalTorque")),
        )
        if state["macroSlip"]:
            raise SteadyStateError(
                f"the belt slips through {point}: its torque utilisation is {state['torqueUtilisation']:.2f}"
            )
        return state

    def _solved(self, values: Values, point: Point, read: Callable[[calls.Variator], Read]) -> Read:
        """Result of `read` for an instance that starts in the steady state of these start values."""
        values = checked(self.variables, {**values, "initial.equilibrium": False})
        solver = self._solver or calls.Variator(self._archive, {})
        # An instance in which a call failed cannot be used any more.
        self._solver = None
        try:
            solver.restart(values)
            solver.initialise()
            if solver.not_steady:
                raise SteadyStateError(f"no steady state {point}: {solver.not_steady}")
            found = read(solver)
        except UnitError as error:
            solver.free()
            raise SteadyStateError(f"no steady state {point}: {error}") from error
        except RuntimeError:
            self._solver = solver
            raise
        self._solver = solver
        return found

    def least_force(
        self,
        ratio: float,
        torque: float,
        safety: float = SAFETY,
        *,
        speed: float = SPEED,
        thrust_ratio: float | None = None,
    ) -> float:
        """Secondary clamping force with which both pulleys carry a primary torque (N·m) with a safety factor, at least 4 kN; N.

        The primary pulley is clamped by the thrust ratio κ times this force. κ is that of at most three steady states at
        `speed` (rad/s), about 0.05 s each, or `thrust_ratio`, with which nothing is solved.
        """
        return self._least_force(self._values, ratio, torque, speed, safety, thrust_ratio)

    def _least_force(
        self,
        values: Values,
        ratio: float,
        torque: float,
        speed: float,
        safety: float,
        thrust_ratio: float | None = None,
    ) -> float:
        """F min(1, κ(F)) carries the torque with the safety factor: fixed-point iteration, as κ varies little with F."""
        _check(Point(ratio, torque, speed, 0.0))
        if not (math.isfinite(safety) and safety > 0.0):
            raise ValueError(f"safety = {safety!r} is not a number above 0")
        needed = clamping_force(torque, pitch_radius(values, ratio), values["friction.pulley"], values["geometry.wedgeAngle"], safety)
        if why := capacity.excessive_force(torque, needed):
            raise SteadyStateError(f"no clamping force at ratio {ratio:g}: {why}")
        if thrust_ratio is not None:
            return max(needed / min(1.0, thrust_ratio), LEAST_FORCE)
        if torque == 0.0:
            return LEAST_FORCE
        force = max(needed if torque > 0.0 else needed / OVERRUN, LEAST_FORCE)
        found = False
        for _ in range(MOST_STATES):
            try:
                state = self._steady(values, Point(ratio, torque, speed, force))
            except SteadyStateError:
                if found:
                    break
                force = 2.0 * force
                continue
            found = True
            better = max(needed / min(1.0, state["thrustRatio"]), LEAST_FORCE)
            if abs(better / force - 1.0) < SAME_FORCE:
                break
            force = better
        return force

    def torque_capacity(self, ratio: float, force: float, thrust_ratio: float = 1.0) -> float:
        """Primary torque at which the belt slips through at a ratio, under a secondary clamping force (N); N·m.

        It is that of the secondary pulley, at which the torque utilisation is 1. With a thrust ratio below 1 it is that of the primary.
        """
        return torque_capacity(self._values, ratio, min(1.0, thrust_ratio) * force)

    def thrust_map(
        self,
        ratios: Iterable[float],
        torques: Iterable[float],
        *,
        speed: float = SPEED,
        force: float | None = None,
        safety: float = SAFETY,
    ) -> xarray.Dataset:
        """Steady states over geometric ratios (1) and primary torques (N·m), with speed and force as in `steady`.

        Returns a data set with the dimensions `ratio` and `torque`. It has a variable for each output (`thrustRatio`, `slip`,
        `efficiency`, … with the attributes `units` and `long_name`), `clampingForce` in N, and `reason`, which is empty at
        points with a steady state. Points without one have the value NaN. Needs `pushbelt[maps]`.
        """
        try:
            import xarray
        except ModuleNotFoundError as error:
            raise ModuleNotFoundError(
                "thrust_map needs xarray: pip install 'pushbelt[maps]'", name=error.name
            ) from error

        ratios, torques = np.array(list(ratios), dtype=float), np.array(list(torques), dtype=float)
        names = [*calls.output_names(self.variables.values()), "clampingForce"]
        values = np.full((len(names), len(ratios), len(torques)), np.nan)
        reasons = np.full((len(ratios), len(torques)), "", dtype=object)
        for m, n in np.ndindex(reasons.shape):
            used = math.nan if force is None else force
            try:
                used = self.least_force(ratios[m], torques[n], safety, speed=speed) if force is None else force
                state = self.steady(ratios[m], torques[n], speed=speed, force=used)
            except SteadyStateError as error:
                reasons[m, n] = str(error)
            else:
                values[:, m, n] = [*(state[name] for name in names[:-1]), used]
        axes = ("ratio", "torque")
        about = {"clampingForce": {"units": "N", "long_name": "Secondary clamping force"}}
        for name in names[:-1]:
            variable = self.variables[name]
            about[name] = {"units": variable.unit or "1", "long_name": variable.description}
        return xarray.Dataset(
            {name: (axes, values[k], about[name]) for k, name in enumerate(names)} | {"reason": (axes, reasons)},
            coords={
                "ratio": ("ratio", ratios, {"units": "1", "long_name": "Geometric ratio r_S/r_P"}),
                "torque": ("torque", torques, {"units": "N.m", "long_name": "Primary torque"}),
            },
            attrs={"primary speed": speed, "units of it": "rad/s"},
        )

    # Linear models

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
        force = self.least_force(ratio, torque, safety, speed=speed) if force is None else force
        return self._linearize(self._values, Point(ratio, torque, speed, force), frequency, states, sample_time)

    def linearize_here(
        self, frequency: float = FREQUENCY, *, states: str = "modal", sample_time: float | None = None
    ) -> LinearModel:
        """The linear model about the present state of the run, which must be steady; modes below `frequency`, Hz, become states.

        If the belt slips through, or if the state requires other loads than the present inputs, a VariatorWarning is issued, and the
        model's `remarks` contain the difference. Raises LinearPointError if the state is not steady.
        """
        self.start()
        try:
            model = _model(self._open, frequency, states, sample_time)
        except (UnitError, NotPhysicalError) as error:
            raise LinearPointError(f"no linear model at {self.time:g} s: {error}") from error
        self._warn()
        return model

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
        several = {"speed": speed, "force": force}
        given: dict[str, Iterable[Any]] = {"ratio": ratios, "torque": torques}
        given |= {name: values for name, values in several.items() if isinstance(values, Iterable)}
        lists = {name: list(values) for name, values in {**given, **(changes or {})}.items()}
        for name, values in lists.items():
            if not values:
                raise ValueError(f"the grid has no {name}")
        lists = {
            name: values if name in given else [checked(self.variables, {name: value})[name] for value in values]
            for name, values in lists.items()
        }
        axes = {name: np.array(values, dtype=float) for name, values in lists.items()}
        shape = tuple(len(values) for values in lists.values())
        models, reasons = np.full(shape, None, dtype=object), np.full(shape, "", dtype=object)
        for place in np.ndindex(shape):
            at = {name: values[k] for (name, values), k in zip(lists.items(), place, strict=True)}
            values = {**self._values, **{name: at[name] for name in changes or ()}}
            used, turning = at.get("force", force), at.get("speed", speed)
            try:
                if used is None:
                    used = self._least_force(values, at["ratio"], at["torque"], turning, safety)
                point = Point(at["ratio"], at["torque"], turning, used)
                models[place] = self._linearize(values, point, frequency, states, sample_time)
            except (SteadyStateError, LinearPointError) as error:
                reasons[place] = str(error)
            after_each()
        return LinearGrid(axes, models, reasons)

    def _linearize(
        self, values: Values, point: Point, frequency: float, states: str, sample_time: float | None
    ) -> LinearModel:
        """The linear model at a point with these start values: about the steady state under the loads that hold it."""
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

        def read(solver: calls.Variator) -> LinearModel:
            try:
                return _model(solver, frequency, states, sample_time)
            except (UnitError, NotPhysicalError) as error:
                raise LinearPointError(f"no linear model {point}: {error}") from error

        model = self._solved({**values, **loads, **start}, point, read)
        if model.remarks:
            raise LinearPointError(f"no linear model {point}: {'; '.join(model.remarks)}")
        return model
