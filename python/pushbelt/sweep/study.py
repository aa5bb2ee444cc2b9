"""A study: an FMU, parameters, a grid of working points, and an identity (hash) of everything that determines the results."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from pathlib import Path

from pushbelt.fmu import starts, steady
from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.enumerations import RingModel
from pushbelt.fmu.start_values import checked
from pushbelt.fmu.untrusted import OfFmu

from . import design as design_law
from . import point as law
from .design import Design, DesignPoint, full_values
from .point import Point, start_values


@dataclass(frozen=True)
class Axis:
    """Column of the results for a field of the grid."""

    column: str
    unit: str
    description: str


AXES: Mapping[str, Axis] = {
    "force": Axis("secondary.clampingForce", "N", "Secondary clamping force"),
    "friction": Axis("friction.pulley", "1", "Friction coefficient between element and sheave"),
    "speed": Axis("initial.primarySpeed", "rad/s", "Primary speed without slip"),
    "ratio": Axis("initial.ratio", "1", "Geometric ratio secondary radius / primary radius"),
    "utilisation": Axis("utilisation", "1", "Primary torque / 2 mu r_P F_S / cos(beta)"),
}
"""Axes, from the slowest to the fastest varying one."""


def rpm(*speeds: float) -> tuple[float, ...]:
    """Speeds in rad/s from rpm, to 1e-6 rad/s."""
    return tuple(round(speed * math.pi / 30.0, 6) for speed in speeds)


def spread(low: float, high: float, count: int) -> tuple[float, ...]:
    """Values evenly spaced in their logarithm, to 1e-6."""
    step = (high / low) ** (1.0 / (count - 1))
    return tuple(round(low * step**k, 6) for k in range(count))


@dataclass(frozen=True)
class Grid:
    """All combinations of the values of the axes. Each axis is ascending."""

    force: tuple[float, ...] = (12e3,)
    """Secondary clamping force, N, above 0."""
    friction: tuple[float, ...] = (0.05, 0.07, 0.09, 0.11)
    """Friction coefficient between element and sheave, above 0."""
    speed: tuple[float, ...] = rpm(500, 1000, 2000, 4000)
    """Primary speed, rad/s, above 0."""
    ratio: tuple[float, ...] = spread(0.45, 1.0 / 0.45, 13)
    """Geometric ratio r_S/r_P, above 0."""
    utilisation: tuple[float, ...] = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0)
    """Torque utilisation; negative where the secondary pulley drives."""

    def __post_init__(self) -> None:
        for field in fields(self):
            values = tuple(float(value) for value in getattr(self, field.name))
            object.__setattr__(self, field.name, values)
            if not values or any(low >= high for low, high in itertools.pairwise(values)):
                raise ValueError(f"the values of {field.name} must not be empty and must ascend: {values}")
            if not all(map(math.isfinite, values)) or (field.name != "utilisation" and values[0] <= 0.0):
                raise ValueError(f"the values of {field.name} must be positive: {values}")

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of values in the order of `AXES`."""
        return tuple(len(getattr(self, name)) for name in AXES)

    def __len__(self) -> int:
        return math.prod(self.shape)

    def points(self) -> list[Point]:
        """All points by index. The utilisation varies fastest."""
        combinations = itertools.product(*(getattr(self, name) for name in AXES))
        return [Point(index, **dict(zip(AXES, values, strict=True))) for index, values in enumerate(combinations)]


DEFAULT = Grid()
"""2288 points."""
SHORT = Grid(
    friction=(0.07, 0.09), speed=rpm(2000), ratio=(0.5, 0.7, 1.0, 1.4, 2.0), utilisation=(0.2, 0.4, 0.6, 0.8, 0.9, 1.0)
)
"""60 points."""


@dataclass(frozen=True)
class Study(OfFmu):
    """A grid or another design of points, with an FMU and common parameters."""

    fmu: Path
    parameters: Mapping[str, float]
    """Start values of the FMU by name; the geometry and `belt.pitchOffset` must be among them."""
    grid: Grid | Design = DEFAULT

    def __post_init__(self) -> None:
        parameters = checked(self.variables, self.parameters, {"parameter"})
        if isinstance(self.grid, Design):
            self.grid.check(self.variables)
            taken = parameters.keys() & {*self.grid.columns, "initial.steady", "initial.equilibrium"}
        else:
            taken = self.parameters.keys() & start_values(self.parameters, self.grid.points()[0]).keys()
        if taken:
            raise ValueError(f"these variables are set by the points of the study: {', '.join(sorted(taken))}")
        object.__setattr__(self, "parameters", parameters)

    @cached_property
    def identity(self) -> str:
        """A hash of the FMU, the parameters, the grid and the procedure that solves the points."""
        document = {
            "fmu": hashlib.sha256(self.archive).hexdigest(),
            "law": [hashlib.sha256(Path(file).read_bytes()).hexdigest() for file in self._laws],
            "parameters": dict(self.parameters),
            "grid": asdict(self.grid),
        }
        return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()

    @property
    def _laws(self) -> tuple[str, ...]:
        """Files with the procedure that solves the points."""
        laws = (law, starts, steady, *([design_law] if isinstance(self.grid, Design) else []))
        return tuple(str(one.__file__) for one in laws)

    def start_values(self, point: Point | DesignPoint) -> dict[str, float]:
        """All start values of a point."""
        if isinstance(point, DesignPoint):
            values = {name: value for name, value in point.values.items() if name in self.variables}
            typed = {**point.values, **checked(self.variables, values)}
            return full_values(self.parameters, DesignPoint(point.index, typed))
        return {**self.parameters, **start_values(self.parameters, point)}


def variator(
    name: str,
    model: str = "ALE",
    changes: Mapping[str, float] | None = None,
    varied: Collection[str] = (AXES["friction"].column,),
) -> dict[str, float]:
    """Parameters of a published variator (`bench168` or `belt155`) for a study, with changes and without the varied ones."""
    values = {**parameter_set(name), "ring.model": RingModel[model], **(changes or {})}
    return {parameter: value for parameter, value in values.items() if parameter not in varied or parameter in (changes or {})}
