"""Python around the pushbelt FMU.

- `Variator`: a variator over time (`input_table`, `recording`), its steady states (`points`) and linear models (`linear_points`, `linear`,
  `linear_grid`); `errors`: the base class of all errors; `cli`: the command `pushbelt`.
- `fmu`: the FMU call by call, published data, geometry, load cases, results.
- `page`, `charts`, `belt_view`, `style`, `checks`, `progress`, `side_by_side`: common parts of the reports; `cluster`: tasks on a
  cluster; `map_data`: data sets of maps; `map_unit`, `map_variator`: variators from maps, as an FMU and in numpy.
- `belt`, `calibrate`, `compare`, `demo`, `drive`, `durability`, `linearize`, `maps`, `sweep`: programs, each run
  by `python -m pushbelt.…`. They do not import each other.
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
    from .linear import LinearModel, LinearPointError
    from .linear_grid import LinearGrid, load_linear
    from .linear_physical import NotPhysicalError
    from .map_data import MapError, Maps
    from .map_variator import MapVariator
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
    "LinearGrid": "linear_grid",
    "LinearModel": "linear",
    "LinearPointError": "linear",
    "MapError": "map_data",
    "MapVariator": "map_variator",
    "Maps": "map_data",
    "MissingFileError": "errors",
    "MissingPackageError": "errors",
    "NotPhysicalError": "linear_physical",
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
    "load_linear": "linear_grid",
    "parameter_set": "fmu.data",
}
"""Names that are imported on first use, so that the processes of the programs start quickly."""


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f".{_MODULES[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted(__all__)
