"""Python around the pushbelt FMU.

- `variator`: a variator over time (`recording`) and its steady states (`points`); `linear`: linear models;
  `maps`: maps and variators from them; `study`: many tasks on this machine or a cluster; `errors`: the base class of all errors;
  `arguments`: checks of the arguments of public functions; `calls`: programs as functions.
- `fmu`: the FMU call by call, published data, geometry, load cases, results. `tables`: tables of rigs and of programs.
- `report`: common parts of the reports.
- `cli`: the command `pushbelt`, also `python -m pushbelt`, and the options of the programs. Each program is a package, run by `python -m pushbelt.…`.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from ._version import __version__ as __version__

if TYPE_CHECKING:
    from .calls import Program
    from .errors import ArgumentError as ArgumentError
    from .errors import FileError as FileError
    from .errors import MissingFileError as MissingFileError
    from .errors import MissingPackageError as MissingPackageError
    from .errors import PushbeltError as PushbeltError
    from .errors import UnknownNameError as UnknownNameError
    from .errors import VariatorWarning as VariatorWarning
    from .fmu.data import parameter_deviations as parameter_deviations
    from .fmu.data import parameter_set as parameter_set
    from .fmu.data import variators as variators
    from .fmu.files import default_fmu as default_fmu
    from .fmu.results import Bands as Bands
    from .fmu.results import Profile as Profile
    from .fmu.results import SteadyState as SteadyState
    from .fmu.start_values import StartValueError as StartValueError
    from .fmu.unit import UnitError as UnitError
    from .fmu.untrusted import InputFileError as InputFileError
    from .linear.grid import LinearGrid as LinearGrid
    from .linear.grid import load_linear as load_linear
    from .linear.model import LinearModel as LinearModel
    from .linear.model import LinearPointError as LinearPointError
    from .linear.physical import NotPhysicalError as NotPhysicalError
    from .maps.data import MapError as MapError
    from .maps.data import Maps as Maps
    from .maps.variator import MapVariator as MapVariator
    from .points import SteadyStateError as SteadyStateError
    from .recording import Record as Record
    from .variator import Snapshot as Snapshot
    from .variator import Variator as Variator

    calibrate: Program
    drive: Program
    maps: Program
    sweep: Program

_NAMES = {
    "errors": "ArgumentError FileError MissingFileError MissingPackageError PushbeltError UnknownNameError VariatorWarning",
    "fmu.data": "parameter_deviations parameter_set variators", "fmu.files": "default_fmu", "fmu.results": "Bands Profile SteadyState",
    "fmu.start_values": "StartValueError", "fmu.unit": "UnitError",
    "fmu.untrusted": "InputFileError", "linear.grid": "LinearGrid load_linear", "linear.model": "LinearModel LinearPointError",
    "linear.physical": "NotPhysicalError", "maps.data": "MapError Maps", "maps.variator": "MapVariator", "points": "SteadyStateError",
    "recording": "Record", "variator": "Snapshot Variator", "calibrate": "calibrate", "drive": "drive", "maps": "maps", "sweep": "sweep",
}  # fmt: skip
_MODULES = {name: module for module, names in _NAMES.items() for name in names.split()}
"""Names that are imported on first use, so that the processes of the programs start quickly."""
__all__ = sorted(["__version__", *_MODULES])  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = importlib.import_module(f".{_MODULES[name]}", __name__)
    return module if name == _MODULES[name] else getattr(module, name)


def __dir__() -> list[str]:
    return sorted(__all__)
