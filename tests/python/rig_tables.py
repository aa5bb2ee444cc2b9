"""A table of steady points, computed with the FMU, in the notations of rigs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest

from pushbelt.tables.points import Rig

RPM = np.pi / 30.0
COLUMNS = ("i_geo", "n_P", "n_S", "T_P", "T_S", "F_S", "F_P")
UNITS = ("-", "rpm", "rpm", "Nm", "Nm", "kN", "kN")
TITLES = [f"{name} [{unit}]" for name, unit in zip(COLUMNS, UNITS, strict=True)]
POINTS = np.array(
    [
        (0.5, 1425.8, 2865.1, -29.98, 16.01, 8.0, 8.476),
        (0.5, 1435.1, 2864.2, 24.98, -11.33, 8.0, 12.704),
        (0.5, 2493.8, 4966.2, 59.96, -28.46, 8.0, 14.419),
        (0.5, 2490.0, 4965.1, 49.97, -22.6, 16.0, 26.67),
        (0.8, 2473.3, 3103.5, -25.51, 21.62, 8.0, 6.964),
        (0.8, 1435.5, 1790.7, 21.26, -15.88, 8.0, 10.917),
        (0.8, 2502.4, 3103.0, 102.04, -79.48, 16.0, 23.133),
        (1.2, 2474.3, 2069.2, -20.89, 26.32, 8.0, 5.583),
        (1.2, 2499.3, 2067.9, 41.78, -48.72, 8.0, 9.654),
        (2.0, 2476.5, 1241.4, -12.74, 27.15, 8.0, 4.698),
        (2.0, 2501.6, 1241.5, 25.48, -49.09, 8.0, 7.635),
        (2.0, 1439.2, 716.6, 21.24, -39.67, 16.0, 14.604),
    ]
)
"""Ratio, rpm, N·m, kN."""
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
