"""The FMU, driven call by call through fmpy."""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy import fmi2, logging

from .geometry import Array
from .results import Profile

TORQUE_DRIVE, SPEED_DRIVE = 1, 2
"""Values of `primary.drive` and `secondary.drive`."""
CLAMPED, HELD = 1, 2
"""Values of `primary.axial` and `secondary.axial`."""
STEADY = 2
"""Value of `initial.found` where the run started from the steady state that was asked for."""
RING_MODELS = {"ALE0": 1, "ALE": 2}
"""Values of `ring.model`."""

PROFILE_POINTS = 72
PROFILE_FIELDS = {
    "position": "position",
    "push_force": "pushForce",
    "ring_tension": "ringTension",
    "normal_force": "normalForce",
    "radial_deviation": "radialDeviation",
    "sliding_speed": "slidingSpeed",
}


class UnitError(RuntimeError):
    """The FMU refused a call; the text holds what it logged."""


@dataclass(frozen=True)
class Archive:
    """An unpacked FMU."""

    directory: Path
    description: Any

    @classmethod
    def unpack(cls, fmu: Path, directory: Path | None = None) -> Archive:
        """Unpacks an FMU to a directory, or to a temporary one."""
        return cls(Path(fmpy.extract(str(fmu), directory)), fmpy.read_model_description(str(fmu)))

    def remove(self) -> None:
        """Removes the directory."""
        shutil.rmtree(self.directory, ignore_errors=True)


class Reader:
    """Real variables that are read, or set, together again and again."""

    def __init__(self, names: Iterable[str], references: Iterable[int]) -> None:
        self.names = tuple(names)
        references = list(references)
        self.references = (ctypes.c_uint32 * len(references))(*references)
        self.values = (ctypes.c_double * len(references))()


class Variator:
    """One instance of the FMU. A context manager: the instance is freed at its end."""

    def __init__(self, archive: Archive, start_values: Mapping[str, float], name: str = "variator") -> None:
        description = archive.description
        self.variables = {variable.name: variable for variable in description.modelVariables}
        self.warnings: list[str] = []
        self.time = 0.0
        self._freed = False
        self._errors: list[str] = []
        self._callbacks = fmi2.fmi2CallbackFunctions()
        self._callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(self._hear)
        # fmpy hands messages to the logger that was registered last, whoever speaks: none may ever be freed.
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(self._callbacks))
        logging.addLoggerProxy(ctypes.byref(self._callbacks))
        self._slave = fmi2.FMU2Slave(
            guid=description.guid,
            unzipDirectory=str(archive.directory),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self._call(self._slave.instantiate, callbacks=self._callbacks)
        try:
            self._set_up(start_values)
        except UnitError:
            self.free()
            raise

    def __enter__(self) -> Variator:
        return self

    def __exit__(self, *_: object) -> None:
        self.free()

    def restart(self, start_values: Mapping[str, float]) -> None:
        """Back to where a new instance with these start values stands: nothing else of the past is left."""
        self._call(self._slave.reset)
        self.warnings.clear()
        self.time = 0.0
        self._set_up(start_values)

    def _set_up(self, start_values: Mapping[str, float]) -> None:
        self._call(self._slave.setupExperiment, startTime=0.0)
        self.set(start_values)

    def initialise(self) -> None:
        """Finds the state to start from."""
        self._call(self._slave.enterInitializationMode)
        self._call(self._slave.exitInitializationMode)

    @property
    def not_steady(self) -> str | None:
        """Why the FMU did not start from the steady state that was asked for; none if it did."""
        reference = self.variables["initial.found"].valueReference
        if self._call(self._slave.getInteger, [reference])[0] == STEADY:
            return None
        return "; ".join(self.warnings) or "none was asked for"

    def step_to(self, time: float) -> None:
        """Advances to a time, s, with the inputs as last set."""
        self._call(
            self._slave.doStep,
            currentCommunicationPoint=self.time,
            communicationStepSize=time - self.time,
        )
        self.time = time

    @contextmanager
    def kept(self) -> Iterator[Callable[[], None]]:
        """Keeps the state; what it gives goes back there, any number of times."""
        state, time = self._call(self._slave.getFMUState), self.time

        def back() -> None:
            self._call(self._slave.setFMUState, state)
            self.time = time

        try:
            yield back
        finally:
            self._call(self._slave.freeFMUState, state)

    def set(self, values: Mapping[str, float]) -> None:
        """Sets variables of any type by name."""
        setters = {
            "Real": self._slave.setReal,
            "Integer": self._slave.setInteger,
            "Enumeration": self._slave.setInteger,
            "Boolean": self._slave.setBoolean,
        }
        for name, value in values.items():
            variable = self.variables[name]
            self._call(setters[variable.type], [variable.valueReference], [value])

    def set_along(self, inputs: Reader, values: Iterable[float], rates: Iterable[float]) -> None:
        """Sets real inputs that change in proportion to time over the next step: values now and rates, 1/s."""
        count = len(inputs.names)
        array = ctypes.c_double * count
        slave = self._slave
        self._call(slave.fmi2SetReal, slave.component, inputs.references, count, array(*values))
        orders = (ctypes.c_int32 * count)(*[1] * count)
        self._call(slave.fmi2SetRealInputDerivatives, slave.component, inputs.references, count, orders, array(*rates))

    def reader(self, names: Iterable[str]) -> Reader:
        """Prepares real variables to be read together."""
        names = list(names)
        return Reader(names, (self.variables[name].valueReference for name in names))

    def read(self, reader: Reader) -> Array:
        """Values of the variables of a reader."""
        count = len(reader.names)
        self._call(self._slave.fmi2GetReal, self._slave.component, reader.references, count, reader.values)
        return np.array(reader.values)

    def flag(self, name: str) -> bool:
        """Value of a Boolean variable."""
        return bool(self._call(self._slave.getBoolean, [self.variables[name].valueReference])[0])

    def outputs(self) -> dict[str, float]:
        """All outputs and the energies at the present time."""
        reader = self.reader(output_names(self.variables.values()))
        values = dict(zip(reader.names, self.read(reader).tolist(), strict=True))
        values["macroSlip"] = float(self.flag("macroSlip"))
        return values

    def profile(self) -> Profile:
        """Fields along the belt at the present time."""
        fields = {}
        for field, variable in PROFILE_FIELDS.items():
            names = [f"profile.{variable}[{k + 1}]" for k in range(PROFILE_POINTS)]
            fields[field] = self.read(self.reader(names))
        return Profile(**fields)

    def _call(self, function: Any, *arguments: Any, **keywords: Any) -> Any:
        # The library would read memory that is no longer its own.
        if self._freed:
            raise UnitError("the instance is freed already")
        self._errors.clear()
        try:
            return function(*arguments, **keywords)
        except Exception as error:
            raise UnitError("; ".join(self._errors) or str(error)) from error

    def _hear(self, _environment: Any, _instance: Any, status: int, _category: Any, message: bytes) -> None:
        text = message.decode("utf-8", errors="replace")
        if status == fmi2.fmi2Warning:
            self.warnings.append(text)
        elif status > fmi2.fmi2Warning:
            self._errors.append(text)

    def free(self) -> None:
        """Frees the instance; it can't be used any more."""
        self._slave.freeInstance()
        self._freed = True


def output_names(variables: Iterable[Any]) -> list[str]:
    """Real outputs and the locals that are no fields along the belt."""
    return [
        variable.name
        for variable in variables
        if variable.type == "Real"
        and variable.causality in ("output", "local")
        and not variable.name.startswith("profile.")
    ]
