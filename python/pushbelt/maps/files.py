"""The files of the maps for other tools: MATLAB and Simulink, Modelica, CSV."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from pushbelt.fmu.geometry import Array
from pushbelt.maps.data import AXES, POINT, STATES, TABLES, Maps

OWN = ("maps.nc", "maps.npz", "maps.json")
"""Files that `Maps.read` reads."""
MATLAB_NAME = 31
"""Longest name that all versions of MATLAB accept."""
LOOKUP = ("ratio", "utilisation", "speed", "force")
"""Order of the dimensions of tables over points for lookup blocks: `tbl(ratio, utilisation, speed, force)`."""
COMBI = (
    "thrustRatio",
    "slip",
    "torqueLoss",
    "beltTorqueLoss",
    "efficiency",
    "bearingLoad",
    "valid",
)
"""Quantities of the Modelica tables."""
RPM = 30.0 / np.pi


def write(maps: Maps, folder: Path) -> list[Path]:
    """Writes all files and returns their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in OWN:
        maps.write(folder / name)
    writers = {
        "maps.mat": _matlab,
        "maps_combitable.txt": _combitable_text,
        "maps_combitable.mat": _combitable_matlab,
        "maps.csv": _csv,
        "torque_loss.csv": _torque_loss,
    }
    for name, writer in writers.items():
        writer(maps, folder / name)
    return [folder / name for name in (*OWN, *writers)]


def _matlab(maps: Maps, path: Path) -> None:
    """MAT v5: breakpoints `bp_…` and tables `tbl_…`, as the n-D lookup blocks of Simulink take them."""
    from scipy.io import savemat

    arrays: dict[str, object] = {f"bp_{name}": maps.axes[name] for name in AXES}
    for name, quantity in TABLES.items():
        order = sorted(range(len(quantity.axes)), key=lambda k: _place(quantity.axes[k]))
        arrays[f"tbl_{name}"] = maps[name].transpose(order)
    arrays["names"] = np.array([[f"tbl_{name}", _dimensions(name), TABLES[name].unit] for name in TABLES], dtype=object)
    assert all(len(name) <= MATLAB_NAME for name in arrays)
    savemat(path, arrays, format="5", do_compression=True, oned_as="row")


def _place(axis: str) -> int:
    """Place of an axis among the dimensions of a lookup table."""
    return LOOKUP.index(axis) if axis in LOOKUP else 1


def _dimensions(name: str) -> str:
    return ",".join(sorted(TABLES[name].axes, key=_place))


def combitables(maps: Maps) -> dict[str, Array]:
    """Matrices of Modelica's CombiTable2D by name, `quantity_f1_s1` for the first force and speed.

    Rows are ratios (`u1`), columns utilisations (`u2`); the first row and column hold their values. `forces` and `speeds` are the
    values of the numbers in the names.
    """
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


def _combitable_matlab(maps: Maps, path: Path) -> None:
    from scipy.io import savemat

    savemat(path, combitables(maps), format="4")


def _csv(maps: Maps, path: Path) -> None:
    """A row for each point, with the reason for a missing steady state. Units are in the second row."""
    names = [name for name, quantity in TABLES.items() if quantity.axes == POINT and name not in ("state", "valid")]
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow([*POINT, *names, "valid", "state", "reason"])
        writer.writerow([*(AXES[name].unit for name in POINT), *(TABLES[name].unit for name in names), "", "", ""])
        for place in np.ndindex(maps["state"].shape):
            at = [maps.axes[name][k] for name, k in zip(POINT, place, strict=True)]
            values = [repr(float(value)) for value in (*at, *(maps[name][place] for name in names))]
            state = STATES[int(maps["state"][place])]
            writer.writerow(
                [*values, int(maps["valid"][place]), state, maps.reasons.get("/".join(map(str, place)), "")]
            )


def _torque_loss(maps: Maps, path: Path) -> None:
    """Torque loss at the primary shaft over speed, ratio, force and torque, as vehicle simulations take it; gaps are left out."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["force_N", "ratio_1", "speed_rpm", "torque_Nm", "torque_loss_Nm"])
        for place in np.argwhere(maps.valid):
            f, s, r, _ = place = tuple(place)
            row = [maps.axes["force"][f], maps.axes["ratio"][r], RPM * maps.axes["speed"][s]]
            writer.writerow(
                [f"{value:.9g}" for value in (*row, maps["primaryTorque"][place], maps["torqueLoss"][place])]
            )
