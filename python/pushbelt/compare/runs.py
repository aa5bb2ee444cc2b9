"""Result files, their pairs, and differences of two runs."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pushbelt import tables
from pushbelt.errors import ArgumentError
from pushbelt.fmu.geometry import Array
from pushbelt.fmu.results import Trace

TIME = "time"
SAME = 1e-9  # Tolerance relative to the range, within which runs are equal. Files have nine digits.


class Difference(NamedTuple):
    name: str
    span: float  # Largest minus least value of both runs
    root_mean_square: float
    largest: float
    when: float  # Time of the largest difference, s

    @property
    def share(self) -> float:
        return self.largest / self.span if self.span > 0.0 else 0.0


@dataclass(frozen=True)
class Pair:
    name: str
    paths: tuple[Path, Path]
    runs: tuple[Trace, Trace]
    units: Mapping[str, str]  # Units of columns that have one other than 1

    @cached_property
    def names(self) -> list[str]:
        return [name for name in self.runs[0].columns if name in self.runs[1].columns]

    @cached_property
    def differences(self) -> list[Difference]:
        """Differences in all common columns at the times of A within the range of B, largest relative difference first."""
        a, b = self.runs
        time = a.time[(a.time >= b.time[0]) & (a.time <= b.time[-1])]
        if not len(time):
            raise ArgumentError(f"{self.paths[0]} and {self.paths[1]} have no time in common")
        found = [_difference(name, time, a, b) for name in self.names]
        return sorted(found, key=lambda difference: -difference.share)

    @property
    def differing(self) -> list[Difference]:
        return [difference for difference in self.differences if difference.share > SAME]

    @property
    def equal(self) -> bool:
        """Whether the runs have the same columns, times and gaps, and no column differs."""
        a, b = self.runs
        same = a.columns.keys() == b.columns.keys() and np.array_equal(a.time, b.time)
        return same and all(np.array_equal(np.isfinite(a[name]), np.isfinite(b[name])) for name in self.names) and not self.differing


def _difference(name: str, time: Array, a: Trace, b: Trace) -> Difference:
    values = [np.interp(time, run.time, run[name]) for run in (a, b)]
    apart = np.abs(values[1] - values[0])
    known = np.isfinite(apart)
    if not known.any():
        return Difference(name, 0.0, 0.0, 0.0, float(time[0]))
    apart, both = np.where(known, apart, 0.0), np.concatenate([value[known] for value in values])
    largest = int(np.argmax(apart))
    mean_square = float(np.sqrt(np.mean(apart[known] ** 2)))
    return Difference(name, float(np.ptp(both)), mean_square, float(apart[largest]), float(time[largest]))


def pairs(a: Path, b: Path, units: Mapping[str, str] | None = None) -> list[Pair]:
    """Pairs of runs: two files, or files of the same name in two folders. `units` are those of columns without one in the files."""
    files = [_files(path) for path in (a, b)]
    if a.is_file() and b.is_file():
        both = {f"{a.stem} and {b.stem}" if a.stem != b.stem else a.stem: (a, b)}
    elif a.is_dir() and b.is_dir():
        both = {name: (path, files[1][name]) for name, path in files[0].items() if name in files[1]}
    else:
        raise ArgumentError(f"{a} and {b} are a file and a folder: specify two files or two folders")
    if not both:
        names = [", ".join(sorted(found)) or "none" for found in files]
        raise ArgumentError(f"no run has the same name in both folders: {a} has {names[0]}, {b} has {names[1]}")
    return [_pair(name, *paths, units or {}) for name, paths in both.items()]


def _pair(name: str, a: Path, b: Path, known: Mapping[str, str]) -> Pair:
    """Raises ArgumentError if the files have different units in their headers."""
    units: dict[str, str] = {}
    runs = []
    for path in (a, b):
        run, own = read(path)
        runs.append(run)
        for column, unit in own.items():
            if unit is not None and units.setdefault(column, unit) != unit:
                raise ArgumentError(f"{column} is in {units[column]} in {a}, and in {unit} in {path}")
    return Pair(name, (a, b), (runs[0], runs[1]), {column: unit for column, unit in {**known, **units}.items() if unit != "1"})


def _files(path: Path) -> Mapping[str, Path]:
    """Result files of a folder, or the file itself, by name."""
    if path.is_dir():
        return {file.stem: file for file in sorted(path.glob("*.csv")) if next(iter(tables.read(file)[0]), "") == TIME}
    if not path.is_file():
        raise ArgumentError(f"{path} does not exist")
    return {path.stem: path}


def read(path: Path) -> tuple[Trace, dict[str, str | None]]:
    """A result file, and the units in its header. Columns that are not numeric are skipped."""
    units, rows = tables.read(path)
    if TIME not in units:
        raise ArgumentError(f"{path} is not a run: it has no column `{TIME}`")
    if not rows:
        raise ArgumentError(f"{path} has no rows below its header")
    if wrong := next((k for k, row in enumerate(rows, 2) if len(row) != len(units)), None):
        raise ArgumentError(f"{path} is not a table of numbers: line {wrong} has not {len(units)} cells, as its header has")
    # A cell that is no number is NaN.
    values = np.genfromtxt(["\t".join(row) for row in rows], delimiter="\t", comments="\0").reshape(len(rows), -1)
    columns = {name: values[:, k] for k, name in enumerate(units) if np.isfinite(values[:, k]).any()}
    time = columns.pop(TIME, None)
    if time is None or not np.isfinite(time).all() or not (np.diff(time) > 0.0).all():
        raise ArgumentError(f"the times of {path} do not ascend")
    return Trace(time, columns), units
