"""Calls of the FMU through fmpy."""

from __future__ import annotations

import ctypes
import json
import os
import re
import shutil
import threading
from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import fmpy
import numpy as np
from fmpy import fmi2

from ..errors import PushbeltError
from .enumerations import StartState
from .geometry import Array
from .results import Profile, item
from .untrusted import InputFileError, described, named

try:
    # The module, since its function can't be sent to workers.
    from fmpy import logging
except OSError:
    # fmpy has no such library for Linux on ARM. A message without a per cent sign arrives whole without it.
    logging = None
TRUTHS = ("macroSlip", "pastPeak")  # Outputs that are true or false
PROFILE_POINTS = 72
PROFILE_FIELDS = {one.name: re.sub("_(.)", lambda found: found[1].upper(), one.name) for one in fields(Profile)}
"""Names of the fields along the belt in the FMU."""
CALLED = {"Enumeration": "Integer"}  # Type in the names of the functions, where it is not that of the variable


class UnitError(PushbeltError, RuntimeError):
    """A call of the FMU failed. The message contains the log of the FMU."""


@dataclass(frozen=True)
class Archive(AbstractContextManager["Archive"]):
    """An unpacked FMU. It is a context manager, which removes the directory at its end."""

    directory: Path
    description: Any

    @classmethod
    def unpack(cls, fmu: Path, directory: Path | None = None) -> Archive:
        """Unpacks an FMU to a directory, or a temporary one. Raises InputFileError for an unusable FMU, OSError if it cannot be read."""
        description = described(fmu)
        with named(fmu):
            return cls(Path(fmpy.extract(str(fmu), directory)), description)

    def __exit__(self, *_: object) -> None:
        shutil.rmtree(self.directory, ignore_errors=True)

    @property
    def version(self) -> str:
        return self.description.version or ""

    @property
    def variables(self) -> dict[str, Any]:
        return {variable.name: variable for variable in self.description.modelVariables}

    @property
    def units(self) -> dict[str, str]:
        """Units of all variables by name; 1 for those without one."""
        return {name: variable.unit or "1" for name, variable in self.variables.items()}


class Reals(NamedTuple):
    """Real variables that are repeatedly read or set together; `values` is the space to read them."""

    names: tuple[str, ...]
    references: ctypes.Array[ctypes.c_uint32]
    values: ctypes.Array[ctypes.c_double]


class Instance(AbstractContextManager["Instance"]):
    """One instance of the FMU. It is a context manager, which frees the instance at its end."""

    _logs: ClassVar[dict[int, list[tuple[int, str]]]] = {}
    """Logs of the existing instances, `fmi2Status` and text of each message, by the environment that their messages contain."""

    def __init__(self, archive: Archive, start_values: Mapping[str, float]) -> None:
        self._instance = _instance(archive)
        self.variables = archive.variables
        self.log: list[tuple[int, str]] = []
        self.time = 0.0
        self._freed = False
        self._callbacks = fmi2.fmi2CallbackFunctions()
        self._callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(self._record)
        # fmpy passes the messages of all instances to the logger that was registered last. So no logger may be freed, and
        # the environment identifies the instance of a message.
        self._callbacks.componentEnvironment = id(self.log)
        self._logs[id(self.log)] = self.log
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(self._callbacks))
        if logging is not None:
            logging.addLoggerProxy(ctypes.byref(self._callbacks))
        self._call(self._instance.instantiate, callbacks=self._callbacks)
        try:
            self._set_up(start_values)
        except PushbeltError:
            self.free()
            raise

    def __exit__(self, *_: object) -> None:
        self.free()

    def free(self) -> None:
        """Frees the instance. It cannot be used afterwards."""
        self._instance.freeInstance()
        self._freed = True
        self._logs.pop(id(self.log), None)

    def restart(self, start_values: Mapping[str, float], near: bool = False) -> None:
        """Resets to the state of a new instance. With `near` a steady start is first sought from the one before, if the FMU can."""
        self._call(self._reset_near if near and hasattr(self._instance.dll, "pushbeltResetNear") else self._instance.reset)
        self.log.clear()
        self.time = 0.0
        self._set_up(start_values)

    def _set_up(self, start_values: Mapping[str, float]) -> None:
        self._call(self._instance.setupExperiment, startTime=0.0)
        self.set(start_values)

    def initialise(self) -> None:
        self._call(self._instance.enterInitializationMode)
        self._call(self._instance.exitInitializationMode)

    @property
    def warnings(self) -> list[str]:
        return [text for status, text in self.log if status == fmi2.fmi2Warning]

    @property
    def not_steady(self) -> str | None:
        """Reason why the FMU did not start from the requested steady state; None if it did."""
        if self.get("initial.found") == StartState.STEADY:
            return None
        return "; ".join(self.warnings) or "no steady state was requested"

    def step_to(self, time: float) -> None:
        """Advances to a time, s."""
        self._call(self._instance.doStep, currentCommunicationPoint=self.time, communicationStepSize=time - self.time)
        self.time = time

    def state(self) -> bytes:
        pointer = self._call(self._instance.getFMUState)
        try:
            return self._call(self._instance.serializeFMUstate, pointer)
        finally:
            self._call(self._instance.freeFMUState, pointer)

    def restore(self, state: bytes, time: float) -> None:
        """Returns to a state that this or another instance of the FMU had at a time, s."""
        pointer = self._call(self._instance.deSerializeFMUstate, state)
        try:
            self._call(self._instance.setFMUState, pointer)
        finally:
            self._call(self._instance.freeFMUState, pointer)
        self.time = time

    def set(self, values: Mapping[str, float]) -> None:
        for name, value in values.items():
            variable = item(self.variables, name, "FMU", "variable")
            self._call(getattr(self._instance, f"set{CALLED.get(variable.type, variable.type)}"), [variable.valueReference], [value])

    def get(self, name: str) -> float:
        variable = self.variables[name]
        (value,) = self._call(getattr(self._instance, f"get{CALLED.get(variable.type, variable.type)}"), [variable.valueReference])
        return bool(value) if variable.type == "Boolean" else value

    def reals(self, names: Iterable[str]) -> Reals:
        """Prepares real variables to be read or set together."""
        names = tuple(names)
        references = (self.variables[name].valueReference for name in names)
        return Reals(names, (ctypes.c_uint32 * len(names))(*references), (ctypes.c_double * len(names))())

    def get_reals(self, reals: Reals) -> Array:
        self._call(self._instance.fmi2GetReal, self._instance.component, reals.references, len(reals.names), reals.values)
        return np.array(reals.values)

    def set_ramps(self, inputs: Reals, values: Iterable[float], rates: Iterable[float]) -> None:
        """Sets real inputs that vary linearly in time over the next step: present values, and rates per second."""
        instance, count = self._instance, len(inputs.names)
        array, orders = ctypes.c_double * count, (ctypes.c_int32 * count)(*[1] * count)
        self._call(instance.fmi2SetReal, instance.component, inputs.references, count, array(*values))
        self._call(instance.fmi2SetRealInputDerivatives, instance.component, inputs.references, count, orders, array(*rates))

    def outputs(self) -> dict[str, float]:
        reals = self.reals(output_names(self.variables.values()))
        values = dict(zip(reals.names, self.get_reals(reals).tolist(), strict=True))
        return values | {name: float(self.get(name)) for name in TRUTHS}

    def profile(self) -> Profile:
        names = {name: [f"profile.{field}[{k + 1}]" for k in range(PROFILE_POINTS)] for name, field in PROFILE_FIELDS.items()}
        return Profile(**{name: self.get_reals(self.reals(places)) for name, places in names.items()})

    def _reset_near(self) -> None:
        function = self._instance.dll.pushbeltResetNear
        function.argtypes = [ctypes.c_void_p]
        if function(self._instance.component) > fmi2.fmi2Warning:
            raise UnitError("the FMU was not reset, and its log has no reason")

    def linearise(self, frequency: float) -> dict[str, Any]:
        """The linear model about the present state, as returned by `pushbeltLinearize`. Modes below a frequency (Hz)
        are states. Raises UnitError if there is none. `warnings` contains its warnings."""
        return self._query("pushbeltLinearize", ctypes.c_double(frequency))

    def gradient(self, names: Sequence[str]) -> dict[str, Any]:
        """Derivatives of the real outputs of a steady start with respect to parameters and inputs by name, before the first step, as
        returned by `pushbeltGradient`. Raises UnitError if there are none."""
        references = [self.variables[name].valueReference for name in names]
        return self._query("pushbeltGradient", (ctypes.c_uint32 * len(references))(*references), ctypes.c_size_t(len(references)))

    def _query(self, name: str, *arguments: Any) -> dict[str, Any]:
        """The JSON text of a function beyond the standard."""
        library, text = self._instance.dll, ctypes.c_void_p()
        if not hasattr(library, name):
            raise UnitError(f"this version of the FMU has no function {name}")
        function, free = library[name], library.pushbeltFreeText
        free.argtypes, free.restype = [ctypes.c_void_p], None

        def call() -> None:
            if function(ctypes.c_void_p(self._instance.component), *arguments, ctypes.byref(text)) > fmi2.fmi2Warning:
                raise UnitError(f"{name} returned nothing, and its log has no reason")

        try:
            self._call(call)
            return json.loads(ctypes.string_at(text))
        finally:
            free(text)

    def _call(self, function: Any, *arguments: Any, **keywords: Any) -> Any:
        # The library would read freed memory.
        if self._freed:
            raise UnitError("the instance has been freed")
        before = len(self.log)
        try:
            return function(*arguments, **keywords)
        except Exception as error:
            errors = [text for status, text in self.log[before:] if status > fmi2.fmi2Warning]
            raise UnitError("; ".join(errors) or str(error)) from error

    def _record(self, environment: int, _instance: Any, status: int, _category: bytes, message: bytes) -> None:
        log = self._logs.get(environment)
        if log is not None:
            log.append((status, message.decode("utf-8", errors="replace")))


class _Lock:
    """A lock that does not prevent this module from being sent to the workers of a cluster."""

    def __init__(self) -> None:
        self.lock = threading.Lock()

    def __reduce__(self) -> tuple[type, tuple[()]]:
        return _Lock, ()


_LOADING = _Lock()
"""fmpy changes the folder of the process while it loads a library, and does not return from it after an error."""


def _instance(archive: Archive) -> fmi2.FMU2Slave:
    """The library of an FMU. Raises UnitError if it cannot be loaded."""
    description = archive.description
    refuse_others(description.modelName, description)
    identifier = description.coSimulation.modelIdentifier
    binaries = binaries_of(archive.directory)
    # Without it fmpy knows the older names of folders only.
    library = binaries and str((binaries / identifier).resolve()) + fmpy.sharedLibraryExtension
    given = {"guid": description.guid, "modelIdentifier": identifier, "instanceName": "variator"}
    with _LOADING.lock:
        here = os.getcwd()
        try:
            return fmi2.FMU2Slave(unzipDirectory=str(archive.directory), libraryPath=library, **given)
        except Exception as error:
            raise UnitError(f"the library of the FMU cannot be loaded: {str(error).strip()}") from error
        finally:
            os.chdir(here)


def binaries_of(directory: Path) -> Path | None:
    """The folder of an unpacked FMU with the binaries for this processor and system; None if there is none. FMI 2.0.4 and later name it as
    FMI 3.0 does, such as `aarch64-linux`. The older names mean x86-64; only on macOS they had libraries of both processors."""
    names = [fmpy.platform_tuple]
    if fmpy.platform_tuple not in ("aarch64-linux", "aarch64-windows"):
        names.append(fmpy.platform)
    return next((path for name in names if (path := directory / "binaries" / name).is_dir()), None)


def refuse_others(fmu: Path | str, description: Any) -> None:
    """Raises InputFileError for an FMU that this module cannot call."""
    if description.fmiVersion != "2.0" or description.coSimulation is None:
        raise InputFileError(f"{fmu} of FMI {description.fmiVersion} cannot be called: a unit for co-simulation of FMI 2.0 is needed")


def belt_described(fmu: Path) -> Any:
    """The model description of an FMU that runs the belt. Raises InputFileError for another one, such as `PushbeltMap.fmu`."""
    description = described(fmu)
    refuse_others(fmu, description)
    if all(one.name != "ring.model" for one in description.modelVariables):
        raise InputFileError(f"{fmu} has no ring.model: PushbeltVariator.fmu is needed, which runs the belt; only `drive` takes PushbeltMap.fmu")
    return description


def output_names(variables: Iterable[Any]) -> list[str]:
    """Real outputs, and the locals that are not fields along the belt."""
    found = (one.name for one in variables if one.type == "Real" and one.causality in ("output", "local"))
    return [name for name in found if not name.startswith("profile.")]
