"""Python around the pushbelt FMU.

- `variator`: a variator over time (`recording`) and its steady states (`points`); `linear`: linear models;
  `maps`: maps and variators from them; `study`: many tasks on this machine or a cluster; `errors`: the base class of all errors;
  `arguments`: checks of the arguments of public functions; `calls`: programs as functions.
- `fmu`: the FMU call by call, published data, geometry, load cases, results. `tables`: tables of rigs and of programs.
- `report`: common parts of the reports.
- `cli`: the command `pushbelt`, also `python -m pushbelt`, and the options of the programs. Each program is a package, run by `python -m pushbelt.…`.
"""

import importlib
import re
from pathlib import Path
from typing import Any

from ._version import __version__ as __version__

_STUB = Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
_MODULES = {name: module for module, name in re.findall(r"^from \.([\w.]+) import (\w+) as", _STUB, re.MULTILINE)}
_PROGRAMS = re.findall(r"^(\w+): Program", _STUB, re.MULTILINE)
"""Names of the stub, which are imported on first use, so that the processes of the programs start quickly."""
__all__ = sorted([*_MODULES, *_PROGRAMS])  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    if name in _PROGRAMS:
        return importlib.import_module(f".{name}", __name__)
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f".{_MODULES[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted(__all__)
