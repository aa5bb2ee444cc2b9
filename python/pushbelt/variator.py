"""The variator over time, its steady states and linear models, for programs and notebooks: `pushbelt.Variator`."""

from __future__ import annotations

import os
from collections import UserDict
from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .arguments import checks, kind, mapping, names, number, optional, path, text
from .errors import ArgumentError, warn
from .fmu import cache, capacity
from .fmu import unit as calls
from .fmu.data import parameter_set
from .fmu.enumerations import RingModel
from .fmu.files import default_fmu
from .fmu.results import Drawn, Profile, dataframe, in_notebook
from .fmu.start_values import SETTABLE, StartValueError, checked
from .fmu.unit import TRUTHS, UnitError
from .linear.model import LinearModel, LinearPointError
from .linear.physical import NotPhysicalError
from .points import FREQUENCY, LINEAR, Values, WorkingPoints, model_of
from .recording import InputTable, Ramp, Record, Recording

if TYPE_CHECKING:
    import pandas

LOADS = frozenset({"primary.torque", "secondary.clampingForce", "secondary.pressure"})
"""Inputs whose units are checked by the capacity of the belt."""

Parameters = str | os.PathLike[str] | Values


@dataclass(frozen=True, repr=False)
class Snapshot:
    """A state of a run. It can be stored, and restored in another variator of the same FMU, also in another process."""

    time: float  # s
    values: Mapping[str, float]  # Parameters and inputs
    state: bytes  # State of the FMU

    def __repr__(self) -> str:
        return f"<Snapshot at {self.time:g} s: {len(self.state)} bytes>"


class Inputs(UserDict[str, float]):
    """Present inputs by name; `inputs[name] = value` sets one."""

    def __init__(self, variator: Variator) -> None:
        self.data = {one.name: variator[one.name] for one in variator.variables.values() if one.causality == "input"}
        self._set = variator.set

    def __setitem__(self, name: str, value: Any) -> None:
        self._set(name, value)
        self.data[name] = value


class Variator(WorkingPoints, Drawn, AbstractContextManager["Variator"]):
    """A variator that is advanced in time by `step`. It is a context manager, which calls `close` at its end.

        with pushbelt.Variator("bench168", {"initial.ratio": 1.5}) as variator:
            state = variator.step(0.01, {"primary.torque": 60.0, "secondary.torque": -85.0})

    Names are those of the FMU's variables (`docs/variables.md`), units are SI: N·m, N, rad/s, m, W, s. Torques are
    external torques on the shafts, positive in the direction of positive speed: that of an engine is positive, that of a load negative.
    """

    @checks(changes=optional(mapping), fmu=optional(path))
    def __init__(
        self, parameters: Parameters = "bench168", changes: Values | None = None, *,
        fmu: str | os.PathLike[str] | None = None, record: Record | Sequence[str] | None = None,
    ) -> None:  # fmt: skip
        """Creates a variator.

        `parameters` is a published variator (`bench168`, `belt155`), the file of a parameter set, or a mapping of start
        values. `changes` override them. Start values of inputs hold until `step` sets others. The default of `fmu` is
        the FMU of the package. `record` has the columns of `outputs`, and as `Record` also the time between their rows.

        Raises StartValueError for a name or a value that the FMU does not accept, InputFileError, MissingFileError or FileError for
        files that cannot be used.
        """
        self._unit: calls.Instance | None = None
        archive = cache.unpacked(Path(fmu) if fmu is not None else default_fmu())
        declared = archive.variables
        if "ring.model" not in declared:
            raise ArgumentError(f"{archive.description.modelName} has no ring.model: Variator runs the belt; MapVariator is a variator from maps")
        given, name = (parameters, "own values") if isinstance(parameters, Mapping) else (parameter_set(parameters), os.fspath(parameters))
        described = {v.name: v.start for v in declared.values() if v.causality in SETTABLE and v.start is not None}
        self._start = checked(declared, {**described, **given, **(changes or {})})
        super().__init__(archive, self._start, name)
        inputs = [v.name for v in self._declared.values() if v.causality == "input"]
        names = [*inputs, *calls.output_names(self._declared.values())]
        self._names = ("time", *names, *TRUTHS)
        self._record = record if isinstance(record, Record) else Record(record)
        self._recording = Recording(self._names, self._record)
        self._now: NDArray[np.float64] | None = None  # The present row of outputs; None before the start
        self._warned = 0
        self._unit = calls.Instance(archive, self._start)
        self._reals = self._unit.reals(names)

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        ring = RingModel(int(self._values["ring.model"])).name
        state = "closed" if self._unit is None else "not started" if self._now is None else f"at {self._unit.time:g} s"
        return f"<Variator {self.name}: ring {ring}, {state}, {len(self._recording)} rows of outputs>"

    def _repr_html_(self) -> str | None:
        values = dict(self.inputs) if self._now is None else self._outputs()
        return in_notebook(self, lambda: self.variables.to_dataframe().filter(list(values), axis=0)[["unit", "description"]].assign(value=values))

    def close(self) -> None:
        """Frees the instances. Recorded outputs can still be read."""
        self._states.close()
        if self._unit is not None:
            self._unit.free()
        self._unit = None

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self._open.time

    def start(self) -> dict[str, float]:
        """Computes the initial state and returns its outputs. The first `step` calls it if necessary.

        By default this is the steady state at `initial.ratio` and `initial.primarySpeed`. If the run starts from another
        state, a VariatorWarning is issued.
        """
        if self._now is None:
            if self._values["initial.primarySpeed"] != 0.0 and self._values["initial.steady"] and (hint := self._wrong_unit()):
                raise StartValueError(hint)
            self._open.initialise()
            self._read()
        return self._outputs()

    def _wrong_unit(self) -> str | None:
        """Description of a wrong unit of the present secondary force, pressure or primary torque; None if they may be right."""
        torque, force, pressure = (self._values[name] for name in ("primary.torque", "secondary.clampingForce", "secondary.pressure"))
        oil = f", secondary.pressure = {pressure:g} Pa" if pressure else ""
        why = capacity.slip_of_units(self._values) if abs(torque) > capacity.DRAG else None
        return f"primary.torque = {torque:g} N.m, secondary.clampingForce = {force:g} N{oil}: {why}" if why else None

    @checks(duration=number("s", above=0.0), inputs=optional(mapping))
    def step(self, duration: float, inputs: Values | None = None) -> dict[str, float]:
        """Advances by a duration, s, with the given inputs and the last values of the others; returns the outputs at its end.

        An input that changes reaches its value within `inputs.ramp` (1 ms by default; −1 means at the end of the step).
        The inputs may include tunable parameters.

        Raises StartValueError for a wrong name or value, and UnitError if the FMU cannot complete the step.
        """
        self.start()
        if inputs:
            self.set(inputs)
        self._open.step_to(self.time + duration)
        self._read()
        return self._outputs()

    @checks(values=lambda name, value: value if isinstance(value, str) else mapping(name, value))
    def set(self, values: Values | str, value: Any = None) -> None:
        """Sets inputs and tunable parameters, and before the start any parameter: `set(name, value)`, `set({name: value, …})` or
        `variator[name] = value`."""
        found = checked(self._declared, {values: value} if isinstance(values, str) else values)
        for name in found if self._now is not None else ():
            if self._declared[name].causality == "parameter" and self._declared[name].variability != "tunable":
                raise StartValueError(f"{name} can only be set before the start")
        self._open.set(found)
        self._values |= found
        if self._now is not None and LOADS.intersection(found) and (hint := self._wrong_unit()):
            warn(hint)

    __setitem__ = set

    @checks(name=text)
    def __getitem__(self, name: str) -> float:
        """Present value of a variable; `variables` has its unit. Reading an output starts the run, as `step` does."""
        if name in self._values:
            return self._values[name]
        name = self.variables[name].name
        return self._started.get(name)

    get = __getitem__

    @property
    def inputs(self) -> Inputs:
        """Present values of the inputs by name. `inputs[name] = value` sets one."""
        return Inputs(self)

    def profile(self) -> Profile:
        """Present fields along the belt: position (m), push force and ring tension (N), normal force (N/m) and more."""
        return self._started.profile()

    @checks(**LINEAR)
    def linearize_here(self, frequency: float = FREQUENCY, *, states: str = "modal", sample_time: float | None = None) -> LinearModel:
        """The linear model about the present state of the run, which must be steady; modes below `frequency`, Hz, become states.

        If the belt slips through, or if the state requires other loads than the present inputs, a VariatorWarning is issued, and the
        model's `remarks` contain the difference. Raises LinearPointError if the state is not steady.
        """
        unit = self._started
        try:
            model = model_of(unit, frequency, states, sample_time)
        except (UnitError, NotPhysicalError) as error:
            raise LinearPointError(f"no linear model at {self.time:g} s: {error}") from error
        self._warn()
        return model

    @checks(changes=optional(mapping))
    def reset(self, changes: Values | None = None) -> None:
        """Returns to the state before the start, with the start values of the beginning and these changes. Recorded outputs are removed."""
        self._start = checked(self._declared, {**self._start, **(changes or {})})
        self._values = dict(self._start)
        self._recording.clear()
        self._now, self._warned = None, 0
        self._open.restart(self._start)

    def snapshot(self) -> Snapshot:
        """The present state of the run, to which `restore` returns."""
        unit = self._started
        return Snapshot(unit.time, dict(self._values), unit.state())

    @checks(snapshot=kind("a Snapshot", Snapshot))
    def restore(self, snapshot: Snapshot) -> None:
        """Returns to a state. The run continues from it as it did before, to the last bit. Later recorded outputs are removed."""
        self._open.restore(snapshot.state, snapshot.time)
        self._values = dict(snapshot.values)
        self._recording.cut(snapshot.time)
        self._read()

    @checks(step=number("s", above=0.0), outputs=optional(names))
    def simulate(self, inputs: pandas.DataFrame, *, step: float = 1e-2, outputs: Iterable[str] | None = None) -> pandas.DataFrame:
        """Runs the variator with a table of inputs over time and returns a table of the outputs. Needs `pushbelt[maps]`.

        The index of `inputs`, or its column `time`, is time in s; the other columns are inputs and tunable parameters by name, linear
        between the rows, also within a step. Two rows of the same time make a jump; an input that is constant after it jumps within
        `inputs.ramp`. A tunable parameter has in each step the value of the middle.

        The run goes from the first time to the last, in steps of at most `step`, s, which end at each row. A new variator starts with the
        first row. An earlier run is continued: the first time is then the present one. The table has a row for each step, as `record` of
        the variator says, with its columns or `outputs`.

        Raises ArgumentError for a table that is not usable, StartValueError for a wrong name or value.
        """
        return self._simulated(InputTable.of(inputs), step, outputs)

    @checks(duration=number("s", above=0.0), inputs=optional(mapping), step=number("s", above=0.0), outputs=optional(names))
    def run(self, duration: float, inputs: Values | None = None, *, step: float = 1e-2, outputs: Iterable[str] | None = None) -> pandas.DataFrame:
        """Runs the variator for a duration, s, with constant inputs and the present values of the others, and returns the table that
        `simulate` returns. Needs `pushbelt[maps]`."""
        constant = {name: np.full(2, value) for name, value in checked(self._declared, inputs or {}).items()}
        return self._simulated(InputTable(self.time + np.array([0.0, duration]), constant), step, outputs)

    def _simulated(self, table: InputTable, step: float, outputs: Iterable[str] | None) -> pandas.DataFrame:
        begin = float(table.times[0])
        if self._now is not None and abs(begin - self.time) > 1e-9:
            raise ArgumentError(f"the first time of the inputs is {begin:g} s, but the run is at {self.time:g} s")
        columns = self._record.columns if outputs is None else tuple(outputs)
        found = Recording(self._names, Record(columns, self._record.interval))
        for k in range(len(table.times)):
            checked(self._declared, table.row(k))
        self.set(table.row(0))
        self.start()
        origin = self.time - begin
        found.add(self._row)
        for ramp in table.ramps(step):
            self._follow(ramp, origin)
            found.add(self._row)
        self.set(table.row(-1))
        frame = dataframe(found.table())
        frame["time"] -= origin
        return frame.set_index("time")

    def _follow(self, ramp: Ramp, origin: float) -> None:
        """A step in which the inputs change linearly."""
        inputs = [name for name in ramp.begin if self._declared[name].causality == "input"]
        tunable = {name: 0.5 * (value + ramp.end[name]) for name, value in ramp.begin.items() if name not in inputs}
        if tunable:
            self.set(tunable)
        rates = [(ramp.end[name] - ramp.begin[name]) / ramp.duration for name in inputs]
        self._open.set_ramps(self._open.reals(inputs), [ramp.begin[name] for name in inputs], rates)
        self._open.step_to(origin + ramp.time)
        # An input without a rate is held: it continues from here.
        self.set({name: ramp.end[name] for name in inputs})
        self._read()

    @property
    def outputs(self) -> NDArray[Any]:
        """The recorded communication points as a record array: `outputs["time"]` in s, `outputs["primary.speed"]` in rad/s. Present values
        are those of `variator[name]`.

        Columns are those of `record`, by default the real inputs and outputs, stored and residual energy, `macroSlip` and `pastPeak` as 0 or 1. The
        value of an input is that at the end of the previous step. Without an interval a long run has a row at every second, fourth, …
        communication point only (`Record`).
        """
        return self._recording.table()

    def to_dataframe(self) -> pandas.DataFrame:
        """`outputs` as a table over `time` (s). Needs `pushbelt[maps]`."""
        return dataframe(self.outputs).set_index("time")

    @property
    def _open(self) -> calls.Instance:
        if self._unit is None:
            raise UnitError("the variator is closed")
        return self._unit

    @property
    def _started(self) -> calls.Instance:
        unit = self._open
        self.start()
        return unit

    def _read(self) -> None:
        """Reads the outputs, records them, and issues the warnings of the FMU."""
        self._now = np.array([self.time, *self._open.get_reals(self._reals), *map(self._open.get, TRUTHS)])
        self._recording.add(self._now)
        self._warn()

    def _warn(self) -> None:
        """Issues the warnings of the FMU since the last call."""
        for said in self._open.warnings[self._warned :]:
            self._warned += 1
            warn(said)

    @property
    def _row(self) -> NDArray[np.float64]:
        assert self._now is not None, "the variator has started"
        return self._now

    def _outputs(self) -> dict[str, float]:
        return dict(zip(self._names, self._row.tolist(), strict=True))
