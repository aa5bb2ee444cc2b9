"""The fitted parameters of the FMU, with start value, bounds and the coordinate of the fit."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pushbelt.errors import ArgumentError, similar

DEFAULT = ("friction.pulley", "friction.ring", "belt.play")  # Parameters that are fitted by default
Pair = tuple[float, float]


@dataclass(frozen=True)
class Parameter:
    """A parameter, or a common parameter of both pulleys with one value. The fitted coordinate is ln(value/start) if the lower bound is
    above 0, else value/start, or value/scale."""

    name: str  # Name as specified
    variables: tuple[str, ...]  # Variables of the FMU that are set to the value; none for a size that the FMU does not have
    unit: str
    start: float
    low: float
    high: float
    prior: tuple[float, float] | None = None  # Value and standard deviation that are known without the table
    scale: float | None = None

    @property
    def logarithmic(self) -> bool:
        return self.low > 0.0

    def coordinate(self, value: float) -> float:
        return math.log(value / self.start) if self.logarithmic else value / (self.scale or self.start)

    def value(self, coordinate: float) -> float:
        """Value at a coordinate, within the bounds."""
        value = self.start * math.exp(coordinate) if self.logarithmic else (self.scale or self.start) * coordinate
        return min(max(value, self.low), self.high)

    @property
    def bounds(self) -> tuple[float, float]:
        """Lower and upper bound of the coordinate."""
        return tuple(sorted(map(self.coordinate, (self.low, self.high))))  # type: ignore[return-value]

    def interval(self, coordinate: float, half: float) -> tuple[float, float]:
        """Lower and upper value of an interval of the coordinate."""
        return tuple(sorted((self.value(coordinate - half), self.value(coordinate + half))))  # type: ignore[return-value]


def additional(name: str, unit: str, scale: float) -> Parameter:
    """A size that the FMU does not have and that starts at 0, such as an offset of a channel; at most its scale."""
    return Parameter(name, (), unit, 0.0, -scale, scale, scale=scale)


def choose(
    wanted: Mapping[str, float | None], limits: Mapping[str, Pair], variables: Mapping[str, Any], values: Mapping[str, float],
    priors: Mapping[str, Pair] | None = None,
) -> list[Parameter]:  # fmt: skip
    """Parameters by name. Start values are the specified ones, else those of `values`, else the FMU's. Bounds are `limits`,
    else the FMU's. A name without its pulley, such as `tiltStiffness`, means both pulleys."""
    priors = priors or {}
    for given, what in ((limits, "bounds are"), (priors, "a prior is")):
        if unknown := given.keys() - wanted.keys():
            raise ArgumentError(f"{what} specified for {', '.join(sorted(unknown))}, which is not fitted")
    found = [_parameter(name, start, limits.get(name), priors.get(name), variables, values) for name, start in wanted.items()]
    taken = [variable for parameter in found for variable in parameter.variables]
    if twice := sorted({variable for variable in taken if taken.count(variable) > 1}):
        raise ArgumentError(f"{', '.join(twice)} appears twice in --fit")
    return found


def _parameter(
    name: str, start: float | None, limits: Pair | None, prior: Pair | None, variables: Mapping[str, Any], values: Mapping[str, float]
) -> Parameter:
    known = {full: one for full, one in variables.items() if one.causality == "parameter" and one.type == "Real"}
    names = (name,) if name in variables else (f"primary.{name}", f"secondary.{name}")
    if not known.keys() >= set(names):
        raise ArgumentError(f"the FMU has no real parameter {name}{similar(name, known)}")
    first = known[names[0]]
    start = values.get(names[0], float(first.start)) if start is None else start
    low, high = (end if given is None else float(given) for end, given in ((-math.inf, first.min), (math.inf, first.max)))
    if name == "friction.pulley":
        # The FMU rejects a friction coefficient at which the belt is self-locking in the groove.
        high = min(high, 0.999 * math.tan(values.get("geometry.wedgeAngle", float(variables["geometry.wedgeAngle"].start))))
    if limits is not None:
        low, high = max(low, limits[0]), min(high, limits[1])
    for what, value in (("start value", start), ("prior", prior and prior[0])):
        if value is not None and not (low <= value <= high and low < high):
            raise ArgumentError(f"{name}: the {what}, {value:g}, is not within its bounds, {low:g} to {high:g}")
    if start == 0.0:
        raise ArgumentError(f"{name} starts at 0, which defines no scale: specify a start value by --fit {name}=VALUE")
    return Parameter(name, names, first.unit or "1", start, low, high, prior)


def assign(parameters: Sequence[Parameter], coordinates: Iterable[float]) -> dict[str, float]:
    """Values of the FMU's variables, and of sizes by name, at these coordinates."""
    pairs = zip(parameters, coordinates, strict=True)
    return {variable: one.value(float(coordinate)) for one, coordinate in pairs for variable in one.variables or (one.name,)}
