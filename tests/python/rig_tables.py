"""A table of steady points, computed with the FMU, in the notations of rigs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

COLUMNS = ("i_geo", "n_P", "n_S", "T_P", "T_S", "F_S", "F_P")
UNITS = ("-", "rpm", "rpm", "Nm", "Nm", "kN", "kN")
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


def titled() -> list[str]:
    return [f"{name} [{unit}]" for name, unit in zip(COLUMNS, UNITS, strict=True)]


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


def recorded(
    step: float = 0.01, length: float = 2.0, ramp: float = 0.0, noise: float = 0.005, points: int = 12
) -> np.ndarray:
    """A time series of the points with time in its first column; `ramp` is the time of the change between two of them."""
    held = [np.tile(point, (round(length / step), 1)) for point in POINTS[:points]]
    parts = [held[0]]
    for before, after in zip(held, held[1:], strict=False):
        parts += [np.linspace(before[0], after[0], round(ramp / step) + 2)[1:-1], after]
    values = np.concatenate(parts)
    scatter = noise * np.abs(POINTS).mean(axis=0) * np.random.default_rng(62).standard_normal(values.shape)
    scatter[:, 0] = 0.0
    return np.column_stack([step * np.arange(len(values)), values + scatter])
