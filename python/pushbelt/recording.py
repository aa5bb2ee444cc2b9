"""What a run records: outputs over time, in bounded memory."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import ArgumentError
from .fmu.results import item

LARGEST = 40_000_000
"""Size of a recording without an interval, bytes, at which every second row is dropped. Reading it takes as much again, so both fit
in 100 MB. All outputs of 80 s in steps of 1 ms fit in it; an hour then has a row each 64 ms."""


@dataclass(frozen=True)
class Record:
    """What is recorded. Fewer columns make room for more rows."""

    columns: Sequence[str] | None = None
    """Inputs and outputs by name; None: all."""
    interval: float | None = None
    """Time between rows, s: all of them are kept. None: a row at each communication step, then at every second, fourth, … one, so that
    the recording stays below `LARGEST`."""

    def __post_init__(self) -> None:
        if self.columns is not None and (isinstance(self.columns, str) or not isinstance(self.columns, Iterable)):
            raise ArgumentError(f"columns = {self.columns!r} is no list of names")
        if self.interval is not None and not (math.isfinite(self.interval) and self.interval > 0.0):
            raise ArgumentError(f"interval = {self.interval!r} s is not a number above 0")


class Recording:
    """Rows of columns over time. The first row and the latest are always among them."""

    def __init__(self, names: Iterable[str], record: Record) -> None:
        """`names` are those of all values of a row."""
        places = {name: place for place, name in enumerate(names)}
        wanted = places if record.columns is None else record.columns
        columns = list(dict.fromkeys(name for name in wanted if name != "time"))
        self._chosen = [places["time"], *(item(places, name, "run", "column") for name in columns)]
        self._type = np.dtype([(name, float) for name in ("time", *columns)])
        self._interval = record.interval
        self._most = max(LARGEST // self._type.itemsize, 2) if self._interval is None else None
        self.clear()

    def clear(self) -> None:
        """Removes all rows."""
        self._values, self._stride, self._offered, self._due = array("d"), 1, 0, -math.inf
        self._latest: NDArray[np.float64] | None = None

    def add(self, row: NDArray[np.float64]) -> None:
        """Offers a row, which is kept if it is due. It must not change afterwards."""
        time, self._latest = float(row[0]), row
        if self._interval is None:
            due = self._offered % self._stride == 0
            self._offered += 1
        else:
            due = time >= self._due - 1e-9 * self._interval
            if due:
                begin = time if self._due == -math.inf else self._due
                self._due = begin + (math.floor((time - begin) / self._interval + 1e-9) + 1) * self._interval
        if due:
            self._values.frombytes(row[self._chosen].tobytes())
            if self._most is not None and self._kept > self._most:
                self._values = array("d", self._rows[::2].tobytes())
                self._stride *= 2

    def cut(self, time: float) -> None:
        """Removes the rows after a time, s, and at it."""
        count = int(np.searchsorted(self._rows[:, 0], time * (1.0 - 1e-12)))
        self._values = self._values[: count * len(self._chosen)]
        self._latest, self._offered, self._due = None, count * self._stride, min(self._due, time)

    @property
    def _kept(self) -> int:
        return len(self._values) // len(self._chosen)

    @property
    def _rows(self) -> NDArray[np.float64]:
        """The kept rows. No row can be added while this view exists."""
        return np.frombuffer(self._values).reshape(-1, len(self._chosen))

    def __len__(self) -> int:
        return self._kept + self._has_more()

    def _has_more(self) -> bool:
        """Whether the latest row is not among those that are kept."""
        return self._latest is not None and (not self._kept or self._values[-len(self._chosen)] < self._latest[0])

    def table(self) -> NDArray[Any]:
        """All rows as a record array."""
        rows = np.empty((len(self), len(self._chosen)))
        rows[: self._kept] = self._rows
        if self._has_more():
            rows[-1] = self._latest[self._chosen]
        return rows.view(self._type).reshape(-1)
