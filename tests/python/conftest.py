"""What the tests of the FMU share: where it is, and an instance of it driven call by call."""

from __future__ import annotations

import ctypes
import os
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "python"))

CHEAP = {
    "ring.model": 1,
    "mesh.primaryArc": 4,
    "mesh.secondaryArc": 4,
    "mesh.strand": 4,
    "initial.steady": False,
}
"""A coarse reference ring that starts unloaded, for tests of the interface."""


@pytest.fixture(scope="session")
def fmu() -> Path:
    """The FMU under test: `PUSHBELT_FMU`, or what the build leaves in `target`."""
    path = Path(os.environ.get("PUSHBELT_FMU", ROOT / "target" / "PushbeltVariator.fmu"))
    assert path.is_file(), f"{path} is missing: build it by `cargo fmu build`, or set PUSHBELT_FMU"
    return path


@pytest.fixture(scope="session")
def description(fmu: Path):
    """The model description as fmpy reads it."""
    import fmpy

    return fmpy.read_model_description(fmu)


@pytest.fixture(scope="session")
def unzipped(fmu: Path) -> Iterator[str]:
    """The unpacked archive."""
    import fmpy

    directory = fmpy.extract(fmu)
    yield directory
    shutil.rmtree(directory, ignore_errors=True)


@pytest.fixture(scope="session")
def drive_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where drives keep their thrust-ratio map, so that it is solved for once."""
    return tmp_path_factory.mktemp("drive")


LOGGERS: list = []
"""fmpy hands messages to the logger that was registered last, whoever speaks, so none may ever be freed."""


class Slave:
    """One instance. Variables are called by name; messages are kept in `log` as (status, category, text)."""

    def __init__(self, description, directory: str, name: str) -> None:
        from fmpy import fmi2
        from fmpy.logging import addLoggerProxy

        self.variables = {variable.name: variable for variable in description.modelVariables}
        self.log: list[tuple[int, str, str]] = []

        def hear(_environment, _instance, status, category, message) -> None:
            self.log.append((status, category.decode(), message.decode()))

        self.callbacks = fmi2.fmi2CallbackFunctions()
        self.callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(hear)
        LOGGERS.append(self.callbacks)
        addLoggerProxy(ctypes.byref(self.callbacks))
        self.fmu = fmi2.FMU2Slave(
            guid=description.guid,
            unzipDirectory=directory,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.fmu.instantiate(callbacks=self.callbacks)

    def set(self, **values: float) -> None:
        self.set_all(values)

    def set_all(self, values: dict[str, float]) -> None:
        for name, value in values.items():
            variable = self.variables[name]
            put = {
                "Real": self.fmu.setReal,
                "Integer": self.fmu.setInteger,
                "Enumeration": self.fmu.setInteger,
                "Boolean": self.fmu.setBoolean,
            }[variable.type]
            put([variable.valueReference], [value])

    def get(self, *names: str) -> list[float]:
        return self.fmu.getReal([self.variables[name].valueReference for name in names])

    def readings(self) -> list[float]:
        """All real outputs and locals."""
        return self.get(*(v.name for v in self.variables.values() if v.type == "Real" and v.initial == "calculated"))

    def start(self, values: dict[str, float] | None = None) -> None:
        self.fmu.setupExperiment(startTime=0.0)
        self.set_all(values or {})
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def run(self, steps: int = 20, step: float = 1e-3) -> list[list[float]]:
        """Steps with a load that grows; the readings after each."""
        return [self.step(k, step) for k in range(steps)]

    def step(self, k: int, step: float = 1e-3) -> list[float]:
        """Step number `k`; the readings after it."""
        self.set_all({"secondary.torque": -49.0 - k})
        self.fmu.doStep(currentCommunicationPoint=k * step, communicationStepSize=step)
        return self.readings()


@pytest.fixture
def slave(description, unzipped):
    """Makes instances, and frees them when the test is over."""
    made: list[Slave] = []

    def make(name: str = "variator") -> Slave:
        made.append(Slave(description, unzipped, name))
        return made[-1]

    yield make
    for one in made:
        one.fmu.fmi2FreeInstance(one.fmu.component)
