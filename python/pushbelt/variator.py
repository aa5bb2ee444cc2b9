"""The variator over time and its steady states, for programs and notebooks: `pushbelt.Variator`."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.lib.recfunctions import unstructured_to_structured
from numpy.typing import NDArray

from .fmu import cache
from .fmu import unit as calls
from .fmu.data import clamping_force, curve_of, parameter_set, torque_capacity
from .fmu.files import default_fmu
from .fmu.geometry import theta_of
from .fmu.results import Profile, SteadyState
from .fmu.start_values import SETTABLE, StartValueError, checked
from .fmu.starts import driven_by_torque
from .fmu.unit import UnitError

if TYPE_CHECKING:
    import xarray

SPEED = 200.0
"""Primary speed of a steady state unless another is given, rad/s."""
SAFETY = 1.3
"""Safety factor of the clamping force of a steady state unless a force is given."""
LEAST_FORCE = 4e3
"""Least such force, N."""

Values = Mapping[str, Any]
"""Values by names of FMU variables, in SI units; enumerations by name or number."""
Parameters = str | os.PathLike[str] | Values


class VariatorWarning(UserWarning):
    """What the FMU warns of: a start that is not the one that was asked for, say."""


class SteadyStateError(RuntimeError):
    """There is no steady state at a working point, or the belt slips through there."""


def start_values(parameters: Parameters) -> dict[str, Any]:
    """Values of a published variator by name, of a parameter set by its file (`….json`), or those that are given."""
    return dict(parameters) if isinstance(parameters, Mapping) else parameter_set(os.fspath(parameters))


class Variator:
    """A variator that is stepped through time. A context manager: `close` is called at its end.

        with pushbelt.Variator("bench168", {"initial.ratio": 1.5}) as variator:
            state = variator.step(0.01, {"primary.torque": 60.0, "secondary.torque": -85.0})

    Names are those of the FMU's variables (`docs/variables.md`), units are SI: N·m, N, rad/s, m, W, s. Torques are
    external torques on the shafts, positive in the direction of positive speed: an engine's is above 0, a load's below.
    """

    def __init__(
        self, parameters: Parameters = "bench168", changes: Values | None = None, *, fmu: Path | None = None
    ) -> None:
        """Makes a variator.

        `parameters` is a published variator (`bench168`, `belt155`), the file of a parameter set, or a mapping of start
        values; `changes` go over them. Start values of inputs hold until `step` sets others. Without `fmu`, the FMU is
        that of the package.

        Raises StartValueError for a name or a value that the FMU doesn't take, OSError and ValueError for files that
        can't be read.
        """
        self._unit = self._solver = None
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

    def __enter__(self) -> Variator:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Frees the instance; what was recorded can still be read."""
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
        """Finds the state to start from and returns its outputs; the first `step` does it too.

        By default that is the steady state at `initial.ratio` and `initial.primarySpeed`. Where it is another one,
        a VariatorWarning says so.
        """
        if not self._rows:
            self._open.initialise()
            self._record()
        return self._last()

    def step(self, duration: float, inputs: Values | None = None) -> dict[str, float]:
        """Advances by a duration, s, with inputs as given or as last set; returns the outputs at its end.

        An input that changes reaches its value within `inputs.ramp` (1 ms by default; with −1 at the end of the step).
        A tunable parameter may be among the inputs.

        Raises StartValueError for a wrong name or value, and UnitError where the FMU can't do the step.
        """
        if not (math.isfinite(duration) and duration > 0.0):
            raise ValueError(f"a step takes a time above 0 s, not {duration!r} s")
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
                    raise StartValueError(f"{name} can be set before the start only")
        self._open.set(found)
        self._values |= found

    def __getitem__(self, name: str) -> float:
        """Value of a variable now; `variables` has its unit."""
        if name in self._values:
            return self._values[name]
        if name not in self.variables:
            raise KeyError(f"the FMU has no variable {name}")
        self.start()
        return self._open.get(name)

    def profile(self) -> Profile:
        """Fields along the belt now: position (m), push force and ring tension (N), normal force (N/m) and more."""
        self.start()
        return self._open.profile()

    @property
    def outputs(self) -> NDArray[Any]:
        """All communication points so far as a record array: `outputs["time"]` in s, `outputs["primary.speed"]` in rad/s.

        Columns are the real inputs and outputs, stored and residual energy, and `macroSlip` as 0 or 1. A value of an
        input is that at the end of the step before.
        """
        names = ["time", *self._recorded.names, "macroSlip"]
        rows = np.array(self._rows) if self._rows else np.empty((0, len(names)))
        return unstructured_to_structured(rows, dtype=np.dtype([(name, float) for name in names]))

    @property
    def _open(self) -> calls.Variator:
        if self._unit is None:
            raise UnitError("the variator is closed")
        return self._unit

    def _record(self) -> None:
        unit = self._open
        self._rows.append(np.array([unit.time, *unit.get_reals(self._recorded), unit.get("macroSlip")]))
        texts = unit.warnings
        for text in texts[self._warned :]:
            warnings.warn(text, VariatorWarning, stacklevel=4)
        self._warned = len(texts)

    def _last(self) -> dict[str, float]:
        return dict(zip(("time", *self._recorded.names, "macroSlip"), self._rows[-1].tolist(), strict=True))

    # Steady states

    def steady(
        self, ratio: float, torque: float, *, speed: float = SPEED, force: float | None = None, safety: float = SAFETY
    ) -> SteadyState:
        """The steady state at a geometric ratio r_S/r_P (1) and a primary torque (N·m). The run over time stays as it is.

        The primary pulley turns at `speed`, rad/s, less the slip; its sheave is held at the ratio. `force` is the
        secondary clamping force, N: without it the one that carries the torque with a factor of `safety`, at least 4 kN.
        The state has outputs by name, `profile`, and `load_torque`, the secondary torque that goes with it.

        Raises SteadyStateError where there is none, or where the belt slips through.
        """
        force = self.least_force(ratio, torque, safety) if force is None else force
        point = f"at ratio {ratio:g}, {torque:g} N·m, {speed:g} rad/s and {force:g} N"
        held = driven_by_torque(self._values, ratio, speed, torque, force)
        values = checked(self.variables, {**held, "initial.equilibrium": False})
        solver = self._solver or calls.Variator(self._archive, {})
        # An instance that refused a call can't go on.
        self._solver = None
        try:
            solver.restart(values)
            solver.initialise()
            if solver.not_steady:
                raise SteadyStateError(f"no steady state {point}: {solver.not_steady}")
            state = SteadyState(solver.outputs(), solver.profile(), solver.get("secondary.externalTorque"))
        except UnitError as error:
            solver.free()
            raise SteadyStateError(f"no steady state {point}: {error}") from error
        except SteadyStateError:
            self._solver = solver
            raise
        self._solver = solver
        if state["macroSlip"]:
            raise SteadyStateError(
                f"the belt slips through {point}: its torque utilisation is {state['torqueUtilisation']:.2f}"
            )
        return state

    def least_force(self, ratio: float, torque: float, safety: float = SAFETY) -> float:
        """Secondary clamping force that carries a primary torque (N·m) with a safety factor, at least 4 kN; N."""
        values = self._values
        pitch_radius = curve_of(values, theta_of(ratio)).primary_radius - values["belt.pitchOffset"]
        friction, wedge_angle = values["friction.pulley"], values["geometry.wedgeAngle"]
        return max(clamping_force(torque, pitch_radius, friction, wedge_angle, safety), LEAST_FORCE)

    def torque_capacity(self, ratio: float, force: float) -> float:
        """Primary torque at which the belt slips through on S at a ratio, under a secondary clamping force (N); N·m."""
        return torque_capacity(self._values, ratio, force)

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

        A data set with the dimensions `ratio` and `torque`, a variable an output (`thrustRatio`, `slip`, `efficiency`, …;
        its attributes `units` and `long_name` say what it is), `clampingForce` in N, and `reason`: why there is no steady
        state, empty where there is one. Values are NaN there. Needs `pushbelt[maps]`.
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
            used = self.least_force(ratios[m], torques[n], safety) if force is None else force
            try:
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
