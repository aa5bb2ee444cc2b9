"""Results of simulations as plain data, in SI units. Keys of mappings are names of FMU variables."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from html import escape
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arguments import checks, text, whole
from ..arguments import names as a_list
from ..errors import ArgumentError, UnknownNameError, package, similar
from .geometry import Array

if TYPE_CHECKING:
    import pandas


def dataframe(content: Mapping[str, Any] | Sequence[Mapping[str, Any]] | Array) -> pandas.DataFrame:
    """A table of columns by name, of rows, or of a record array. Raises MissingPackageError with the extra that brings pandas."""
    return package("pandas", "tables need pandas", "maps").DataFrame(content)


def item(values: Mapping[str, Any], name: str, what: str, kind: str = "output") -> Any:
    """A value by name. Raises UnknownNameError with similar names."""
    if not isinstance(name, str) or name not in values:
        raise UnknownNameError(f"the {what} has no {kind} {name}{similar(name, values)}")
    return values[name]


class Drawn:
    """Results whose table can be drawn."""

    to_dataframe: Callable[[], pandas.DataFrame]

    def plot(self, *names: str, **options: Any) -> Any:
        """Draws columns of the table over time or position, by default all; `options` are those of `pandas.DataFrame.plot`. Returns axes of
        matplotlib. Needs `pushbelt[plots]`."""
        package("matplotlib", "figures need matplotlib", "plots")
        table = self.to_dataframe()
        for name in names:
            item(table, text("name", name), "table", "column")
        table = table.set_index("position") if "position" in table else table
        return table[list(names) or table.columns].plot(**{"subplots": True, **options})


def in_notebook(thing: object, table: Callable[[], pandas.DataFrame]) -> str | None:
    """What a notebook shows of an object: its line, and a table if pandas is installed."""
    return f"<p>{escape(repr(thing))}</p>{table().to_html(float_format='{:.5g}'.format)}" if importlib.util.find_spec("pandas") else None


@dataclass(frozen=True, repr=False)
class Profile(Drawn):
    """Fields along the belt, one value per place."""

    position: Array  # Place ξ on the ring's centre line, m
    push_force: Array  # Push force between the elements, N
    ring_tension: Array  # Tension of the ring, N
    normal_force: Array  # Normal force per flank and unit of length, N/m
    radial_deviation: Array
    """Radius minus the mean radius of the arc; on strands the distance from the tangent line, outward positive, m."""
    sliding_speed: Array  # Tangential sliding speed of the flanks, m/s; 0 off the pulleys
    gap: Array  # Gap between neighbouring elements, m; 0 in contact

    def __repr__(self) -> str:
        return (
            f"<Profile: {len(self.position)} places over {self.position[-1]:.4g} m, push force up to {self.push_force.max():.4g} N, "
            f"ring tension {self.ring_tension.min():.4g} to {self.ring_tension.max():.4g} N>"
        )

    def to_dataframe(self) -> pandas.DataFrame:
        """A table with a row for each place and a column for each field. Needs `pushbelt[maps]`."""
        return dataframe({field.name: getattr(self, field.name) for field in fields(self)})


@dataclass(frozen=True, repr=False)
class BeltState:
    """Outputs and fields of the FMU at one time."""

    outputs: Mapping[str, float]
    profile: Profile

    def __getitem__(self, name: str) -> float:
        return item(self.outputs, name, "state")

    def __repr__(self) -> str:
        found = self.outputs
        shown = {"ratio.geometric": "ratio", "thrustRatio": "thrust ratio", "slip": "slip", "efficiency": "efficiency"}
        texts = [f"{text} {found[name]:.4g}" for name, text in shown.items() if name in found]
        return f"<{type(self).__name__}: {', '.join(texts)}; {len(found)} outputs>"

    def to_dataframe(self) -> pandas.DataFrame:
        """A table with one row and a column for each output. Needs `pushbelt[maps]`."""
        return dataframe([self.outputs])

    def plot(self, *names: str, **options: Any) -> Any:
        """Draws the fields along the belt, as `Profile.plot`. Needs `pushbelt[plots]`."""
        return self.profile.plot(*names, **options)

    def _repr_html_(self) -> str | None:
        return in_notebook(self, lambda: dataframe({"value": self.outputs}))


@dataclass(frozen=True, repr=False)
class SteadyState(BeltState):
    """A steady state of the FMU at a specified belt torque."""

    load_torque: float  # Secondary torque of the steady state, N·m
    derivatives: Callable[[Iterable[str], str], pandas.DataFrame] | None = field(default=None, repr=False, compare=False)

    @checks(names=lambda name, value: (value,) if isinstance(value, str) else a_list(name, value), hold=text)
    def gradient(self, names: Iterable[str], *, hold: str = "ratio") -> pandas.DataFrame:
        """Derivatives of the outputs (rows) over real parameters, inputs, and `ratio`, `torque`, `speed` and `force` (columns), SI units.

        The changed states keep the geometric ratio, or with `hold` the `speed ratio` or both `forces`. An output without a derivative,
        such as an extreme along the belt, has NaN. `attrs` has the units. Raises UnknownNameError for a wrong name, UnitError if the belt
        slips through, and ArgumentError for a stored state. Needs `pushbelt[maps]`.
        """
        if self.derivatives is None:
            raise ArgumentError("a state that was stored or solved by a program has no gradient: use that of Variator.steady")
        return self.derivatives(names, hold)

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "derivatives": None}


def largest(names: Iterable[str], sizes: Array, count: int = 3) -> list[str]:
    """The names with the largest sizes."""
    known = list(names)
    return [known[k] for k in np.argsort(-sizes)[:count]]


@dataclass(frozen=True, repr=False)
class Bands:
    """Outputs of a steady state, and their standard deviations by independent ones of parameters."""

    outputs: Mapping[str, float]
    deviations: Mapping[str, float]  # Standard deviations of parameters, and of conditions of the state
    chords: Mapping[str, Array]  # For each output half of its difference between plus and minus one deviation, for each of these
    spread: Mapping[str, float]  # Standard deviation of each output
    lost: float  # Share of samples without a steady state; NaN without samples

    def __getitem__(self, name: str) -> float:
        """Standard deviation of an output."""
        return float(item(self.spread, name, "state"))

    @checks(name=text, count=whole)
    def largest(self, name: str, count: int = 3) -> dict[str, float]:
        """Parameters with the largest shares of the variance of an output, and these shares."""
        shares = item(self.chords, name, "state") ** 2
        found = dict(zip(self.deviations, (shares / (shares.sum() or 1.0)).tolist(), strict=True))
        return {name: found[name] for name in largest(self.deviations, shares, count)}

    def __repr__(self) -> str:
        shown = ", ".join(f"{name} {self.outputs[name]:.4g} ± {self[name]:.2g}" for name in ("thrustRatio", "slip", "efficiency"))
        return f"<Bands by {len(self.deviations)} parameters: {shown}>"

    def to_dataframe(self) -> pandas.DataFrame:
        """A row for each output: its value, its standard deviation, and the chord of each parameter. Needs `pushbelt[maps]`."""
        rows = {name: [self.outputs[name], self[name], *chords] for name, chords in self.chords.items()}
        return dataframe(rows).T.set_axis(["value", "deviation", *self.deviations], axis="columns")

    def _repr_html_(self) -> str | None:
        return in_notebook(self, self.to_dataframe)


class LoadCase(NamedTuple):
    ratio_name: str  # `overdrive`, `medium` or `underdrive`
    theta: float  # Ratio coordinate
    torque: float  # Steady belt torque on the primary pulley, N·m
    clamping_force: float  # Secondary clamping force, N

    @property
    def name(self) -> str:
        """E.g. `overdrive-30`."""
        return f"{self.ratio_name}-{self.torque:g}"


class LoadCaseResult(NamedTuple):
    case: LoadCase
    steady: SteadyState
    drift: float  # Relative change of the thrust ratio when the simulation continues from the steady state


@dataclass(frozen=True, repr=False)
class Trace(Drawn):
    """A simulated run: time and one column per variable, Booleans as 0 and 1."""

    time: Array
    columns: Mapping[str, Array]

    def __getitem__(self, name: str) -> Array:
        return item(self.columns, name, "run")

    def at(self, time: float) -> dict[str, float]:
        """Values at a time, linear between the times."""
        return {name: float(np.interp(time, self.time, values)) for name, values in self.columns.items()}

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {len(self.time)} times, {self.time[0]:.4g} to {self.time[-1]:.4g} s; {len(self.columns)} variables>"

    def to_dataframe(self) -> pandas.DataFrame:
        """A table over `time` (s) with a column for each variable. Needs `pushbelt[maps]`."""
        return dataframe({"time": self.time, **self.columns}).set_index("time")


def intervals(time: Array, flag: Array, gap: float = 0.0) -> list[tuple[float, float]]:
    """Time intervals in which a flag is true. Intervals less than `gap` seconds apart are merged."""
    steps = np.diff(np.concatenate([[0], np.asarray(flag) > 0.5, [0]]))
    starts, ends = time[np.flatnonzero(steps > 0)], time[np.flatnonzero(steps < 0) - 1]
    if not len(starts):
        return []
    apart = starts[1:] - ends[:-1] > gap
    return list(zip(starts[[True, *apart]].tolist(), ends[[*apart, True]].tolist(), strict=True))
