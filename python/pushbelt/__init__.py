"""Python around the pushbelt FMU.

- `variator`: a variator over time (`input_table`, `recording`) and its steady states (`points`); `linear`: linear models;
  `maps`: maps and variators from them; `study`: many tasks on this machine or a cluster; `errors`: the base class of all errors.
- `fmu`: the FMU call by call, published data, geometry, load cases, results. `rig`, `tables`: tables of rigs and of programs.
- `report`: common parts of the reports.
- `cli`: the command `pushbelt` and the options of the programs. Each program is a package, run by `python -m pushbelt.…`.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from ._version import __version__

if TYPE_CHECKING:
    from .errors import (
        ArgumentError,
        MissingFileError,
        MissingPackageError,
        PushbeltError,
        UnknownNameError,
        VariatorWarning,
    )
    from .fmu.data import parameter_set
    from .fmu.files import default_fmu
    from .fmu.start_values import StartValueError
    from .fmu.unit import UnitError
    from .fmu.untrusted import InputFileError
    from .linear.model import LinearModel, LinearPointError
    from .linear.grid import LinearGrid, load_linear
    from .linear.physical import NotPhysicalError
    from .maps.data import MapError, Maps
    from .maps.variator import MapVariator
    from .points import SteadyStateError
    from .recording import Record
    from .variator import Snapshot, Variator

__all__ = [
    "ArgumentError",
    "InputFileError",
    "LinearGrid",
    "LinearModel",
    "LinearPointError",
    "MapError",
    "MapVariator",
    "Maps",
    "MissingFileError",
    "MissingPackageError",
    "NotPhysicalError",
    "PushbeltError",
    "Record",
    "Snapshot",
    "StartValueError",
    "SteadyStateError",
    "UnitError",
    "UnknownNameError",
    "Variator",
    "VariatorWarning",
    "__version__",
    "default_fmu",
    "load_linear",
    "parameter_set",
]

_MODULES = {
    "ArgumentError": "errors",
    "InputFileError": "fmu.untrusted",
    "LinearGrid": "linear.grid",
    "LinearModel": "linear.model",
    "LinearPointError": "linear.model",
    "MapError": "maps.data",
    "MapVariator": "maps.variator",
    "Maps": "maps.data",
    "MissingFileError": "errors",
    "MissingPackageError": "errors",
    "NotPhysicalError": "linear.physical",
    "PushbeltError": "errors",
    "Record": "recording",
    "Snapshot": "variator",
    "StartValueError": "fmu.start_values",
    "SteadyStateError": "points",
    "UnitError": "fmu.unit",
    "UnknownNameError": "errors",
    "Variator": "variator",
    "VariatorWarning": "errors",
    "default_fmu": "fmu.files",
    "load_linear": "linear.grid",
    "parameter_set": "fmu.data",
}
"""Names that are imported on first use, so that the processes of the programs start quickly."""


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f".{_MODULES[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted(__all__)
