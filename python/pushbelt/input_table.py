"""A table of inputs over time: linear between its rows, with jumps where two rows have the same time."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .errors import ArgumentError
from .fmu.geometry import Array

if TYPE_CHECKING:
    import pandas


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
            raise ArgumentError(f"inputs are a pandas.DataFrame over time, not {type(inputs).__name__}")
        columns = {str(name): inputs[name].to_numpy() for name in inputs.columns}
        times = columns.pop("time", inputs.index.to_numpy())
        try:
            times = np.asarray(times, dtype=float)
            columns = {name: np.asarray(values, dtype=float) for name, values in columns.items()}
        except (TypeError, ValueError) as error:
            raise ArgumentError(f"time and inputs must be numbers: {error}") from error
        if len(times) < 2:
            raise ArgumentError(f"the table of inputs has {len(times)} rows: at least 2 are needed, for the begin and the end of the run")
        steps = np.diff(times)
        if not np.isfinite(times).all() or (steps < 0.0).any() or times[-1] == times[0]:
            raise ArgumentError("the times of the inputs must be finite and must ascend")
        if (thrice := np.flatnonzero((steps[1:] == 0.0) & (steps[:-1] == 0.0))).size:
            raise ArgumentError(f"more than two rows have the time {times[thrice[0]]:g} s: a jump has one before and one after it")
        return cls(times, columns)

    def row(self, k: int) -> dict[str, float]:
        """Values of a row."""
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
