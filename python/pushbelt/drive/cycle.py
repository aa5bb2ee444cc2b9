"""The speed trace of a drive: WLTC class 3b (UN Global Technical Regulation No. 15), from the package `wltp`, NEDC, or a table of one's own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from pushbelt.errors import ArgumentError, MissingFileError, MissingPackageError
from pushbelt.fmu.geometry import Array

from .piecewise import interpolate


class Cycle:
    """A speed trace. Speed is linear between its points."""

    def __init__(self, time: Array, speed: Array, start: float = 0.0) -> None:
        """Times in s, ascending from 0, and speeds in m/s, at least 0; `start` is the time of this section within the whole cycle, s."""
        self.time, self.speed, self.start = time, speed, start
        self.duration, self.distance = float(time[-1]), float(np.trapezoid(speed, time))  # s and m
        self._points = time.tolist(), speed.tolist()

    def at(self, time: float) -> float:
        """Speed at a time, m/s. Times outside the trace give the speed of the nearest end point."""
        return interpolate(time, *self._points)

    def section(self, start: float, stop: float) -> Cycle:
        """A section of the trace, with time starting at 0. Raises ValueError if the section does not start at standstill: the
        simulated belt starts at rest."""
        if not self.time[0] <= start < stop <= self.time[-1]:
            raise ArgumentError(f"{start:g} to {stop:g} s is not within the cycle of {self.duration:g} s")
        if self.at(start) > 0.0:
            raise ArgumentError(f"the car moves at {start:g} s: a section must start at standstill")
        inside = (self.time > start) & (self.time < stop)
        time = np.concatenate([[start], self.time[inside], [stop]])
        return Cycle(time - start, np.interp(time, self.time, self.speed), self.start + start)


def wltc_class_3b() -> Cycle:
    """The whole cycle, 1800 s in steps of 1 s. Raises MissingPackageError if its table is not installed."""
    # Only the table is loaded. The package requires a version of `jsonschema` that is too old for other packages, hence --no-deps.
    try:
        from wltp.cycles import class3
    except ModuleNotFoundError as error:
        raise MissingPackageError(
            "the speed trace of the WLTC is in the package wltp (EUPL): pip install --no-deps wltp==0.1.2a0. "
            "The NEDC needs no package: --cycle nedc"
        ) from error

    speed = np.array(class3.class_data_b()["cycle"], dtype=float) / 3.6
    return Cycle(np.arange(len(speed), dtype=float), speed)


def nedc() -> Cycle:
    """The New European Driving Cycle, 1180 s: four urban cycles and the extra-urban one of UN Regulation No. 83, Annex 4, by their break points."""
    time, speed = np.loadtxt(Path(__file__).with_name("nedc.csv"), delimiter=",", skiprows=1, unpack=True)
    return Cycle(time, speed / 3.6)


def of_file(path: Path) -> Cycle:
    """A cycle from a table with the columns `time` and `speed [km/h]`. Raises ArgumentError, TableError or OSError if it cannot be used."""
    # Imported here, since units of a co-simulation have no tables.
    from pushbelt.tables import sheet as sheets
    from pushbelt.tables.names import Column

    columns = {
        "time": Column("time", 0.0, 1e5, "time", ("t", "Zeit"), "s"),
        "speed": Column("velocity", 0.0, 100.0, "speed of the car", ("v", "car speed", "vehicle speed", "Geschwindigkeit")),
    }
    sheet = sheets.read(path, columns)
    sheet.check()
    if missing := [f"{name} ({one.meaning})" for name, one in columns.items() if name not in sheet.taken]:
        raise ArgumentError(f"{path} has no column {' and no column '.join(missing)}, such as speed [km/h]")
    time, speed = sheet.values["time"], sheet.values["speed"]
    empty = np.isnan(time) | np.isnan(speed)
    wrong = empty | (np.diff(time, prepend=-1.0) <= 0.0) | ((np.arange(len(time)) == 0) & (time != 0.0))
    if sheet.left_out or wrong.any():
        row = int(np.argmax(wrong))
        what = f"time {time[row]:g} s, speed {speed[row]:g} m/s: times ascend from 0, and no cell is empty" if wrong.any() else ""
        raise ArgumentError(f"{path}, {sheet.left_out[0] if sheet.left_out else f'line {sheet.lines[row]}: {what}'}")
    if not speed.any() or speed[0]:
        raise ArgumentError(f"{path}: the car {'moves at 0 s' if speed.any() else 'never moves'}; a cycle starts at standstill")
    return Cycle(time, speed)


CYCLES: Mapping[str, tuple[str, Callable[[], Cycle]]] = {"wltc": ("WLTC class 3b", wltc_class_3b), "nedc": ("NEDC", nedc)}
"""Title and table by the name on the command line."""


def titled(trace: str) -> tuple[str, Cycle]:
    """Title and speed trace by a name in `CYCLES`, or of a file."""
    if trace in CYCLES:
        return CYCLES[trace][0], CYCLES[trace][1]()
    if not Path(trace).is_file():
        raise MissingFileError(f"no cycle and no file {trace}: cycles are {' and '.join(CYCLES)}, or a table of time [s] and speed [km/h]")
    return Path(trace).name, of_file(Path(trace))
