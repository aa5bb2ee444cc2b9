"""The files of the maps for other tools: MATLAB and Simulink, Modelica, CSV."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pandas
from scipy.io import savemat

from pushbelt.fmu.geometry import Array
from pushbelt.maps.data import AXES, POINT, STATES, Maps
from pushbelt.report.style import RPM

OWN = ("maps.nc", "maps.npz", "maps.json")  # Files that `Maps.read` reads
MATLAB_NAME = 31  # Longest name that all versions of MATLAB accept
LOOKUP = ("ratio", "utilisation", "speed", "force")
"""Order of the dimensions of tables over points for lookup blocks: `tbl(ratio, utilisation, speed, force)`."""
COMBI = ("thrustRatio", "slip", "torqueLoss", "beltTorqueLoss", "efficiency", "bearingLoad", "valid")
"""Quantities of the Modelica tables."""


def _matlab(maps: Maps, path: Path) -> None:
    """MAT v5: breakpoints `bp_…` and tables `tbl_…`, as the n-D lookup blocks of Simulink take them."""
    arrays: dict[str, object] = {f"bp_{name}": maps.axes[name] for name in AXES}
    rows = []
    for name, quantity in maps.quantities.items():
        dimensions = sorted(quantity.axes, key=lambda axis: LOOKUP.index(axis) if axis in LOOKUP else 1)
        arrays[f"tbl_{name}"] = maps[name].transpose([quantity.axes.index(axis) for axis in dimensions])
        rows.append([f"tbl_{name}", ",".join(dimensions), quantity.unit])
    arrays["names"] = np.array(rows, dtype=object)
    assert all(len(name) <= MATLAB_NAME for name in arrays if name[4:] not in maps.added)
    savemat(path, arrays, format="5", do_compression=True, oned_as="row")


def combitables(maps: Maps) -> dict[str, Array]:
    """Matrices of Modelica's CombiTable2D by name, `quantity_f1_s1` for the first force and speed. Rows are ratios
    (`u1`), columns utilisations (`u2`); the first row and column hold their values. `forces` and `speeds` are the
    values of the numbers in the names."""
    found = {"forces": maps.axes["force"][None, :], "speeds": maps.axes["speed"][None, :]}
    for name in COMBI:
        for f, s in np.ndindex(maps[name].shape[:2]):
            matrix = np.zeros((len(maps.axes["ratio"]) + 1, len(maps.axes["utilisation"]) + 1))
            matrix[0, 1:], matrix[1:, 0] = maps.axes["utilisation"], maps.axes["ratio"]
            matrix[1:, 1:] = maps[name][f, s]
            found[f"{name}_f{f + 1}_s{s + 1}"] = matrix
    return found


def _combitable_text(maps: Maps, path: Path) -> None:
    with path.open("w", encoding="ascii", newline="\n") as file:
        file.write("#1\n")
        for letter, unit, axis in (("f", "N", "force"), ("s", "rad/s", "speed")):
            values = ", ".join(f"{letter}{k + 1} {value:g} {unit}" for k, value in enumerate(maps.axes[axis]))
            file.write(f"# {axis}: {values}\n")
        for name, matrix in combitables(maps).items():
            file.write(f"\ndouble {name}({matrix.shape[0]},{matrix.shape[1]})\n")
            file.writelines(" ".join(repr(float(value)) for value in row) + "\n" for row in matrix)


def _points(maps: Maps) -> pandas.DataFrame:
    """A row for each point: the axes, and all tables over points."""
    return maps.to_xarray()[[name for name, quantity in maps.quantities.items() if quantity.axes == POINT]].to_dataframe().reset_index()


def _csv(maps: Maps, path: Path) -> None:
    """A row for each point, with the reason for a missing steady state. Units are in the second row."""
    frame = _points(maps)
    units = {**{name: AXES[name].unit for name in POINT}, **{name: maps.quantities[name].unit for name in frame.columns[len(POINT) :]}}
    valid, state = (frame.pop(name).astype(int) for name in ("valid", "state"))
    texts = {f"{name} by": texts for name, texts in maps.by.items()} | {"reason": maps.reasons}
    places = ["/".join(map(str, place)) for place in np.ndindex(maps.valid.shape)]
    columns = {name: [texts.get(place, "") for place in places] for name, texts in texts.items()}
    frame = frame.assign(valid=valid, state=[STATES[k] for k in state], **columns)
    units |= dict.fromkeys(("valid", "state", *columns), "")
    frame.columns = pandas.MultiIndex.from_tuples((name, units[name]) for name in frame.columns)
    frame.to_csv(path, index=False, lineterminator="\r\n")


def _torque_loss(maps: Maps, path: Path) -> None:
    """Torque loss at the primary shaft over speed, ratio, force and torque, as vehicle simulations take it; gaps are left out."""
    frame = _points(maps)[maps.valid.ravel()]
    frame = frame.assign(speed=RPM * frame.speed)[["force", "ratio", "speed", "primaryTorque", "torqueLoss"]]
    header = ["force_N", "ratio_1", "speed_rpm", "torque_Nm", "torque_loss_Nm"]
    frame.to_csv(path, header=header, index=False, float_format="%.9g", lineterminator="\r\n")


WRITERS: Mapping[str, Callable[[Maps, Path], object]] = {
    "maps.mat": _matlab, "maps_combitable.txt": _combitable_text,
    "maps_combitable.mat": lambda maps, path: savemat(path, combitables(maps), format="4"),
    "maps.csv": _csv, "torque_loss.csv": _torque_loss,
}  # fmt: skip


def write(maps: Maps, folder: Path) -> list[Path]:
    """Writes all files and returns their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in OWN:
        maps.write(folder / name)
    for name, writer in WRITERS.items():
        writer(maps, folder / name)
    return [folder / name for name in (*OWN, *WRITERS)]
