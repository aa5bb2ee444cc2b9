"""Importers that load the package: ecos and libcosim. All units step in parallel (Jacobi scheme); then outputs are copied to inputs."""

from __future__ import annotations

import ctypes
import importlib.util
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NoReturn

import numpy as np

from pushbelt.fmu.geometry import Array
from pushbelt.fmu.unit import UnitError

from .package import PARAMETER_SET

Progress = Callable[[float], None]
Importer = Callable[[Path, float, int, Sequence[str], Progress], Array]
"""Arguments: package, communication step in s, number of steps, variables of the variator, and a function that is called with the
simulated time of each step. Returns the variables after each step, one row per step. Raises UnitError if the importer is not
installed or reports an error."""


def with_ecos(ssp: Path, step: float, count: int, names: Sequence[str], progress: Progress) -> Array:
    """Runs the package in ecos."""
    _find("ecospy")
    load_tbb()
    from ecospy import EcosSimulation

    rows = []
    with EcosSimulation(step_size=step, ssp_path=str(ssp)) as simulation:
        if not simulation.init(parameter_set=PARAMETER_SET):
            raise UnitError(f"ecos cannot initialise {ssp.name}")
        for _ in range(count):
            simulation.step(1)
            rows.append([simulation.get_real(f"variator::{name}") for name in names])
            progress(step)
        simulation.terminate()
    return np.array(rows)


def with_libcosim(ssp: Path, step: float, count: int, names: Sequence[str], progress: Progress) -> Array:
    """Runs the package in libcosim."""
    _find("libcosimpy")
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_ssp_file(ssp_path=str(ssp), step_size=round(1e9 * step))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer=observer)
    variator = execution.slave_index_from_instance_name("variator")
    found = {v.name.decode(): v.reference for v in execution.slave_variables(slave_index=variator)}
    references = [found[name] for name in names]
    rows = []
    for _ in range(count):
        if not execution.step():
            raise UnitError(f"libcosim cannot advance {ssp.name}")
        rows.append(observer.last_real_values(variator, references))
        progress(step)
    return np.array(rows)


def leave(code: int) -> NoReturn:
    """Ends the process without exit handlers. Units of PythonFMU 0.7 use freed memory in them, which aborts some programs."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def load_tbb() -> None:
    """Loads the library of the package tbb. ecos needs it, and the dynamic loader does not find it."""
    if sys.platform == "linux":
        ctypes.CDLL(str(Path(sys.prefix) / "lib" / "libtbb.so.12"), mode=ctypes.RTLD_GLOBAL)


IMPORTERS: dict[str, Importer] = {"ecos": with_ecos, "libcosim": with_libcosim}


def _find(package: str) -> None:
    if importlib.util.find_spec(package) is None:
        raise UnitError(f"the package {package} is not installed: it has no wheel for this Python and machine")
