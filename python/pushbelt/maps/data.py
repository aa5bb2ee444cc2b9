"""A data set of maps: quantities of steady states over axes, with units, and its files `.nc`, `.npz` and `.json`.

Gaps, which are points without a steady state, have the nearest value along the utilisation. The table `state` marks them.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from zipfile import BadZipFile
from zlib import error

import numpy as np

from ..arguments import checks, mapping, text
from ..arguments import path as a_path
from ..errors import PushbeltError, package
from ..fmu.geometry import Array
from ..fmu.results import item

if TYPE_CHECKING:
    import xarray

VERSION = 2  # Version of the files' content
STATES = ("steady", "slips_through", "beyond_capacity", "not_found")
"""Meaning of the numbers of the table `state`, as in `tables.json`. The first two are steady states."""


class MapError(PushbeltError, ValueError):
    """A file is not a data set of maps, or its values are not usable."""


class Quantity(NamedTuple):
    """An axis, or a table with its axes."""

    unit: str
    description: str
    axes: tuple[str, ...] = ()


_ABOUT = json.loads(Path(__file__).with_name("tables.json").read_text(encoding="utf-8"))
AXES: Mapping[str, Quantity] = {name: Quantity(**about) for name, about in _ABOUT["axes"].items()}
TABLES: Mapping[str, Quantity] = {name: Quantity(**{**about, "axes": tuple(about["axes"])}) for name, about in _ABOUT["tables"].items()}
POINT = ("force", "speed", "ratio", "utilisation")
AT_SHARES = {f"{name}AtShare": name for name in ("thrustRatio", "beltTorqueLoss", "bearingLoad")}
"""Tables of the FMU over the share of the torque at capacity, and the results at each share that they are of."""
TEXTS = ("source", "parameters", "reasons", "by", "added")  # Parts of a data set that are no numbers


@dataclass(frozen=True)
class Maps:
    """A data set of maps."""

    axes: Mapping[str, Array]  # Ascending values of each axis
    tables: Mapping[str, Array]
    parameters: Mapping[str, float]  # Parameters of the variator, by names of FMU variables
    source: Mapping[str, str] = field(default_factory=dict)
    """What the maps are from: model, version and GUID of the FMU."""
    reasons: Mapping[str, str] = field(default_factory=dict)
    """Why a point has no steady state, by its indices `force/speed/ratio/utilisation`."""
    by: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    """Parameters that make most of a table's standard deviation at a point, by the table and these indices."""
    added: Mapping[str, Quantity] = field(default_factory=dict)
    """Tables of standard deviations and derivatives over the points, NaN where there is none."""

    def __post_init__(self) -> None:
        for one in fields(self):
            mapping(one.name, getattr(self, one.name))
        arrays = (*self.axes.values(), *self.tables.values())
        if not all(isinstance(array, np.ndarray) and array.dtype.kind in "iuf" for array in arrays):
            raise MapError("axes and tables are arrays of numbers")
        if missing := AXES.keys() - self.axes.keys() | self.quantities.keys() - self.tables.keys():
            raise MapError(f"the maps lack {', '.join(sorted(missing))}")
        for name, axis in self.axes.items():
            if axis.ndim != 1 or not np.all(np.isfinite(axis)) or not np.all(np.diff(axis) > 0.0):
                raise MapError(f"the axis {name} does not ascend")
        for name, quantity in self.quantities.items():
            shape = tuple(len(self.axes[axis]) for axis in quantity.axes)
            if self.tables[name].shape != shape:
                raise MapError(f"the table {name} has the shape {self.tables[name].shape} instead of {shape}")
            if name in TABLES and not np.all(np.isfinite(self.tables[name])):
                raise MapError(f"the table {name} has values that are not finite")

    @checks(name=text)
    def __getitem__(self, name: str) -> Array:
        return item(self.tables, name, "data set", "table")

    @property
    def quantities(self) -> dict[str, Quantity]:
        """Units, descriptions and axes of all tables."""
        return {**TABLES, **self.added}

    @cached_property
    def valid(self) -> np.ndarray:
        """Mask of the points with a steady state."""
        return self.tables["valid"] > 0.0

    def masked(self, name: str) -> Array:
        """A table over the points, NaN in gaps."""
        if self[name].shape[: len(POINT)] != self.valid.shape:
            raise MapError(f"the table {name} is not over the points")
        return np.where(self.valid, self[name], np.nan)

    def to_xarray(self) -> xarray.Dataset:
        """The tables as an xarray data set with `units` and `long_name`. Needs `pushbelt[maps]`."""
        dataset = package("xarray", "to_xarray needs xarray", "maps").Dataset
        about: dict[str, dict[str, Any]] = {name: {"units": one.unit, "long_name": one.description} for name, one in {**AXES, **self.quantities}.items()}
        tables = {name: (one.axes, self[name], about[name]) for name, one in self.quantities.items()}
        about["state"] |= {"flag_values": np.arange(len(STATES), dtype=float), "flag_meanings": " ".join(STATES)}
        return dataset(tables, {name: (name, values, about[name]) for name, values in self.axes.items()}, self.source)

    @checks(name=text)
    def plot(self, name: str = "thrustRatio", **options: Any) -> Any:
        """Draws a table over the points with the axes of `options`, by default over ratio and utilisation for each force and speed. Needs
        `pushbelt[plots]`."""
        package("matplotlib", "figures need matplotlib", "plots")
        values = self.masked(name)
        return self.to_xarray()[name].copy(data=values).plot(**{"x": "utilisation", "y": "ratio", "row": "force", "col": "speed", **options})

    @cached_property
    def identity(self) -> str:
        """Hash of axes, tables and parameters."""
        found = hashlib.sha256(json.dumps(dict(sorted(self.parameters.items()))).encode())
        for values in (self.axes, self.tables):
            for name in sorted(values):
                found.update(name.encode() + np.ascontiguousarray(values[name], dtype="<f8").tobytes())
        return found.hexdigest()

    def document(self) -> dict[str, Any]:
        """Everything as JSON values, null for NaN."""
        values = {name: np.where(np.isnan(table), np.array(None), table).tolist() for name, table in self.tables.items()}
        return {
            "format": "pushbelt maps", "version": VERSION, "source": dict(self.source), "parameters": dict(self.parameters),
            "axes": {name: {**axis._asdict(), "values": self.axes[name].tolist()} for name, axis in AXES.items()},
            "tables": {name: {**table._asdict(), "values": values[name]} for name, table in self.quantities.items()},
            "reasons": dict(self.reasons), "by": dict(self.by), "added": dict(self.added),
        }  # fmt: skip

    @classmethod
    def of_document(cls, document: Any) -> Maps:
        """The maps of JSON values. Raises MapError if they are none."""
        try:
            if document["format"] != "pushbelt maps" or document["version"] != VERSION:
                raise MapError(f"these are not pushbelt maps of version {VERSION}")
            axes, tables = arrays_of(document)
            parameters = {name: float(value) for name, value in document["parameters"].items()}
            source, reasons, by = (dict(document.get(name, {})) for name in ("source", "reasons", "by"))
            added = {name: Quantity(unit, description, POINT) for name, (unit, description, _) in document.get("added", {}).items()}
            return cls(axes, tables, parameters, source, reasons, by, added)
        except MapError:
            raise
        except (LookupError, TypeError, ValueError, AttributeError) as error:
            raise MapError(f"these are not pushbelt maps: {error!r}") from error

    @checks(path=a_path)
    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes `.json`, `.npz` or `.nc`."""
        path = Path(path)
        write = _of_suffix(path, {".json": self._write_json, ".npz": self._write_npz, ".nc": self._write_netcdf})
        path.parent.mkdir(parents=True, exist_ok=True)
        write(path)

    @classmethod
    @checks(path=a_path)
    def read(cls, path: str | os.PathLike[str]) -> Maps:
        """Reads a file of `write`. Raises MapError for another or damaged file, MissingFileError or FileError if it cannot be read."""
        path = Path(path)
        read = _of_suffix(path, {".json": lambda one: json.loads(one.read_bytes()), ".npz": _read_npz, ".nc": _read_netcdf})
        path.open("rb").close()
        try:
            return cls.of_document(read(path))
        except MapError as why:
            raise MapError(f"{path}: {why}") from why
        # Readers of damaged files raise any of these.
        except (ValueError, LookupError, TypeError, AttributeError, EOFError, OSError, RecursionError, BadZipFile, error) as why:
            raise MapError(f"{path} is damaged or no file of maps: {why}") from why

    def _about(self) -> dict[str, str]:
        """What is not numbers, as JSON texts."""
        return {name: json.dumps(dict(getattr(self, name))) for name in TEXTS}

    def _write_json(self, path: Path) -> None:
        path.write_text(json.dumps(self.document(), allow_nan=False), encoding="utf-8")

    def _write_npz(self, path: Path) -> None:
        arrays = {f"axis_{name}": values for name, values in self.axes.items()}
        texts = {name: np.array(text) for name, text in self._about().items()}
        np.savez_compressed(path, version=np.array(VERSION), **arrays, **texts, **self.tables)  # type: ignore[arg-type]

    def _write_netcdf(self, path: Path) -> None:
        """NetCDF-3 with coordinate variables, units and CF flag attributes."""
        title = "Steady states and shift rates of a pushbelt variator"
        about = {"title": title, "format_version": np.int32(VERSION), **self._about()}
        self.to_xarray().assign_attrs(about).to_netcdf(path, format="NETCDF3_64BIT", engine="scipy")


def _of_suffix(path: Path, functions: Mapping[str, Callable[[Path], Any]]) -> Callable[[Path], Any]:
    if path.suffix not in functions:
        raise MapError(f"{path.name} is none of maps.nc, maps.npz and maps.json")
    return functions[path.suffix]


def arrays_of(document: Mapping[str, Any]) -> tuple[dict[str, Array], ...]:
    """Axes and tables of JSON values."""
    parts = (document[part].items() for part in ("axes", "tables"))
    return tuple({name: np.array(entry["values"], dtype=float) for name, entry in part} for part in parts)


def _read_npz(path: Path) -> Any:
    with np.load(path, allow_pickle=False) as file:
        return _of_arrays(int(file["version"]), {name: str(file[name]) for name in TEXTS if name in file}, file, "axis_")


def _read_netcdf(path: Path) -> Any:
    with package("scipy.io", ".nc files need scipy", "maps").netcdf_file(path, "r", mmap=False) as file:
        arrays = {name: np.array(variable[:], dtype=float) for name, variable in file.variables.items()}
        return _of_arrays(int(file.format_version), {name: getattr(file, name).decode() for name in TEXTS if hasattr(file, name)}, arrays)


def _of_arrays(version: int, texts: Mapping[str, str], arrays: Mapping[str, Array], prefix: str = "") -> Any:
    about = {name: json.loads(text) for name, text in texts.items()}
    parts = (AXES, prefix), ({**TABLES, **about.get("added", {})}, "")
    axes, tables = ({name: {"values": arrays[start + name]} for name in names} for names, start in parts)
    return {"format": "pushbelt maps", "version": version, "axes": axes, "tables": tables, **about}
