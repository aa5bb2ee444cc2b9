"""A run over time: a table of inputs, linear between its rows, with jumps where two have the same time; and outputs in bounded memory."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .arguments import names, number, optional
from .errors import ArgumentError
from .fmu.geometry import Array
from .fmu.results import item

if TYPE_CHECKING:
    import pandas

OF_ARRAY = 112  # Size of a numpy array beside its numbers, bytes
LARGEST = 40_000_000
"""Size of a recording without an interval, bytes, at which every second row is dropped. Reading it takes as much again, so both fit
in 100 MB. All outputs of 60 s in steps of 1 ms fit in it; an hour then has a row each 64 ms."""


class Ramp(NamedTuple):
    """A step in which all values are linear in time."""

    begin: dict[str, float]
    end: dict[str, float]
    time: float  # End of the step, s
    duration: float  # s


@dataclass(frozen=True)
class InputTable:
    """Times, s, and values by name."""

    times: Array
    columns: Mapping[str, Array]

    @classmethod
    def of(cls, inputs: pandas.DataFrame) -> InputTable:
        """The table of a data frame, whose index or column `time` is time. Raises ArgumentError if it is not usable."""
        if not hasattr(inputs, "columns") or not hasattr(inputs, "index"):
            raise ArgumentError(f"inputs are a pandas.DataFrame over time, not {type(inputs).__name__}; run() takes a duration")
        columns = {str(name): inputs[name].to_numpy() for name in inputs.columns}
        times = columns.pop("time", inputs.index.to_numpy())
        if inputs.columns.has_duplicates:
            raise ArgumentError("a column is twice among the inputs")
        times = np.atleast_1d(number("s", several=True)("time", times))
        try:
            columns = {name: np.asarray(values, dtype=float) for name, values in columns.items()}
        except (TypeError, ValueError) as error:
            raise ArgumentError(f"inputs must be numbers: {error}") from error
        if len(times) < 2:
            raise ArgumentError(f"the table of inputs has {len(times)} rows: at least 2 are needed, for the begin and the end of the run")
        steps = np.diff(times)
        if (steps < 0.0).any() or times[-1] == times[0]:
            raise ArgumentError("the times of the inputs must ascend")
        if (thrice := np.flatnonzero((steps[1:] == 0.0) & (steps[:-1] == 0.0))).size:
            raise ArgumentError(f"more than two rows have the time {times[thrice[0]]:g} s: a jump has one before and one after it")
        return cls(times, columns)

    def row(self, k: int) -> dict[str, float]:
        return {name: float(values[k]) for name, values in self.columns.items()}

    def ramps(self, step: float) -> Iterator[Ramp]:
        """Steps of at most `step`, s, that end at each row."""
        for k, (begin, end) in enumerate(pairwise(self.times.tolist())):
            first, last = self.row(k), self.row(k + 1)
            count = math.ceil((end - begin) / step - 1e-9)
            # The values of rows are exact, so that a constant input has the rate 0.
            places = [{name: first[name] + (last[name] - first[name]) * (j / count) for name in first} for j in range(count)] + [last]
            for j, (before, after) in enumerate(pairwise(places), 1):
                yield Ramp(before, after, begin + (end - begin) * (j / count), (end - begin) / count)


@dataclass(frozen=True)
class Record:
    """What is recorded. Fewer columns make room for more rows."""

    columns: Sequence[str] | None = None  # Inputs and outputs by name; None: all
    interval: float | None = None
    """Time between rows, s: all of them are kept. None: a row at each communication step, then at every second, fourth, … one, so that
    the recording stays below `LARGEST`."""

    def __post_init__(self) -> None:
        for name, rule in (("columns", names), ("interval", number("s", above=0.0))):
            object.__setattr__(self, name, optional(rule)(name, getattr(self, name)))


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
        self._most = max(LARGEST // (self._type.itemsize + OF_ARRAY), 2) if self._interval is None else None
        self.clear()

    def clear(self) -> None:
        self._rows: list[Array] = []
        self._stride, self._offered, self._due = 1, 0, -math.inf
        self._latest: Array | None = None

    def add(self, row: Array) -> None:
        """Offers a row, which is kept if it is due. It must not change afterwards."""
        time, self._latest = float(row[0]), row
        if self._interval is None:
            due = self._offered % self._stride == 0
            self._offered += 1
        elif due := time >= self._due - 1e-9 * self._interval:
            begin = time if self._due == -math.inf else self._due
            self._due = begin + (math.floor((time - begin) / self._interval + 1e-9) + 1) * self._interval
        if due:
            self._rows.append(row[self._chosen])
            if self._most is not None and len(self._rows) > self._most:
                self._rows, self._stride = self._rows[::2], 2 * self._stride

    def cut(self, time: float) -> None:
        """Removes the rows after a time, s, and at it."""
        self._rows = [row for row in self._rows if row[0] < time * (1.0 - 1e-12)]
        self._latest, self._offered, self._due = None, len(self._rows) * self._stride, min(self._due, time)

    def __len__(self) -> int:
        return len(self._rows) + len(self._more())

    def _more(self) -> list[Array]:
        """The latest row, if it is not among those that are kept."""
        late = self._latest is not None and (not self._rows or self._rows[-1][0] < self._latest[0])
        return [self._latest[self._chosen]] if late and self._latest is not None else []

    def table(self) -> NDArray[Any]:
        """All rows as a record array."""
        return np.array([*self._rows, *self._more()]).view(self._type).reshape(-1)
