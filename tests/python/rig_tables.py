"""A table of steady points, computed with the FMU, in the notations of rigs."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest

from pushbelt.tables.points import Rig

RPM = np.pi / 30.0
COLUMNS = ("i_geo", "n_P", "n_S", "T_P", "T_S", "F_S", "F_P")
UNITS = ("-", "rpm", "rpm", "Nm", "Nm", "kN", "kN")
TITLES = [f"{name} [{unit}]" for name, unit in zip(COLUMNS, UNITS, strict=True)]
POINTS = np.loadtxt(Path(__file__).with_name("rig_points.csv"), delimiter=",")  # Ratio, rpm, N·m, kN
ROWS = POINTS.tolist()


def columns() -> dict[str, np.ndarray]:
    """The points by column, with slip and efficiency in per cent."""
    found = dict(zip(COLUMNS, POINTS.T, strict=True))
    found["slip"] = 100.0 * (1.0 - found["i_geo"] * found["n_S"] / found["n_P"])
    power = np.abs(found["T_S"] * found["n_S"] / (found["T_P"] * found["n_P"]))
    found["eta"] = 100.0 * np.where(found["T_P"] > 0.0, power, 1.0 / power)
    return found


def written(path: Path, rows: Sequence[Sequence[object]], separator: str = ",", encoding: str = "utf-8") -> Path:
    path.write_bytes("\n".join(separator.join(map(str, row)) for row in rows).encode(encoding))
    return path


def table(path: Path, some: Mapping[str, np.ndarray]) -> Path:
    """A file of columns by their full titles."""
    return written(path, [list(some), *map(list, np.column_stack(list(some.values())))])


def values(rig: Rig) -> np.ndarray:
    return np.array([[p.ratio or p.speed_ratio, p.speed, p.torque, p.force, *(m.value for m in p.measured)] for p in rig.points])


def is_right(rig: Rig, count: int = 12, rel: float = 1e-9) -> None:
    """The points with thrust ratio, slip and efficiency, which are those of the averages in a time series."""
    c = {name: column[:count] for name, column in columns().items()}
    assert [[m.quantity for m in p.measured] for p in rig.points] == [["thrustRatio", "slip", "efficiency"]] * count
    right = [c["i_geo"], RPM * c["n_P"], c["T_P"], 1e3 * c["F_S"], c["F_P"] / c["F_S"], c["slip"] / 100.0, c["eta"] / 100.0]
    some = slice(None) if rel < 1e-3 else slice(5)
    assert values(rig)[:, some] == pytest.approx(np.column_stack(right)[:, some], rel=rel)
