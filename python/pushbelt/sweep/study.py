"""A study: an FMU, parameters, and a grid or another design of working points."""

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property, partial
from typing import Any, NamedTuple

from pushbelt.errors import ArgumentError
from pushbelt.fmu import bands, capacity, closing, gradients, steady
from pushbelt.fmu.gradients import Asked
from pushbelt.fmu.start_values import checked
from pushbelt.study.tasks import Tasks, ascending, spread

from . import point
from .design import Design, Points
from .point import Point, start_values

CHUNK = 8
"""Points per chunk. A chunk takes some seconds, so that little is lost with a worker and the overhead is negligible."""
MOST = 2000  # Largest number of points that are checked for wrong units, evenly spaced in the study


class Axis(NamedTuple):
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


@dataclass(frozen=True)
class Grid(Points):
    """All combinations of the values of the axes, the utilisation fastest. Each axis is ascending."""

    force: tuple[float, ...] = (12e3,)  # Secondary clamping force, N, above 0
    friction: tuple[float, ...] = (0.05, 0.07, 0.09, 0.11)  # Friction coefficient between element and sheave, above 0
    speed: tuple[float, ...] = rpm(500, 1000, 2000, 4000)  # Primary speed, rad/s, above 0
    ratio: tuple[float, ...] = spread(0.45, 1.0 / 0.45, 13)  # Geometric ratio r_S/r_P, above 0
    utilisation: tuple[float, ...] = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0)
    """Torque utilisation; negative where the secondary pulley drives."""

    def __post_init__(self) -> None:
        for one in fields(self):
            values = ascending(one.name, getattr(self, one.name), positive=one.name != "utilisation")
            object.__setattr__(self, one.name, values)

    @property
    def columns(self) -> tuple[str, ...]:  # type: ignore[override]
        return tuple(axis.column for axis in AXES.values())

    @cached_property
    def rows(self) -> tuple[tuple[float, ...], ...]:  # type: ignore[override]
        """Values of the columns at all points."""
        return tuple(itertools.product(*(getattr(self, name) for name in AXES)))


DEFAULT = Grid()  # 2288 points
SHORT = Grid(  # 60 points
    friction=(0.07, 0.09), speed=rpm(2000), ratio=(0.5, 0.7, 1.0, 1.4, 2.0), utilisation=(0.2, 0.4, 0.6, 0.8, 0.9, 1.0)
)
MEASURED = Grid(friction=(0.07, 0.09), speed=rpm(1000, 2000), ratio=spread(0.5, 2.0, 5), utilisation=(0.2, 0.4, 0.5, 0.6, 0.8, 0.9))
"""120 points, for measurements of time."""


@dataclass(frozen=True)
class Study(Tasks):
    """A grid or another design of points, with an FMU and common parameters; the geometry and `belt.pitchOffset` must be among them."""

    grid: Grid | Design = DEFAULT
    deviations: Mapping[str, float] = field(default_factory=dict)  # Standard deviations of parameters, for bands
    asked: Asked = gradients.NOTHING  # Derivatives; points with a primary force keep the forces

    def __post_init__(self) -> None:
        parameters = checked(self.variables, self.parameters, {"parameter"})
        self.grid.check(self.variables)
        fixed = {"initial.equilibrium", *steady.driven_by_torque({}, 1.0, 1.0, 0.0, 1.0)}
        if taken := parameters.keys() & {*self.grid.columns, *fixed}:
            raise ArgumentError(f"these variables are set by the points of the study: {', '.join(sorted(taken))}")
        object.__setattr__(self, "parameters", parameters)
        given = any("initial.equilibrium" in point.ACTING.get(name, ()) for name in self.grid.columns)
        object.__setattr__(self, "asked", self.asked.checked(self.variables, ["forces"] if given else gradients.HELD))

    procedure = (point, steady, closing, bands, gradients)

    @property
    def measure(self) -> Any:
        return partial(point.solve, deviations=self.deviations, asked=self.asked)

    def document(self) -> dict[str, Any]:
        return {"parameters": dict(self.parameters), "grid": asdict(self.grid), "deviations": dict(self.deviations), "gradient": self.asked}

    def tasks(self) -> list[dict[str, float]]:
        return [self.start_values(point) for point in self.grid.points()]

    def start_values(self, point: Point) -> dict[str, float]:
        known = {name: value for name, value in point.items() if name in self.variables}
        return start_values(self.parameters, {**point, **checked(self.variables, known)})


def warnings_of(study: Study) -> Iterator[str]:
    """Warnings about forces and torques in a wrong unit and about excessive belt speeds, before anything is solved. Raises
    ArgumentError if no point carries its torque, and a wrong unit explains it at all of them."""
    points = study.grid.points()
    values = [study.start_values(point) for point in points[:: -(-len(points) // MOST)]]
    if "secondary.pressure" in study.grid.columns and "secondary.clampingForce" not in study.grid.columns:
        force = point.STANDARD["secondary.clampingForce"]
        yield f"secondary.clampingForce = {force:g} N acts beside secondary.pressure: --force 0 leaves the pressure alone"

    def excessive_speed(one: Mapping[str, float]) -> str | None:
        return capacity.excessive_speed(one, one["initial.ratio"], one["initial.primarySpeed"])

    for slips in (capacity.slip_of_units, excessive_speed):
        found = [text for one in values if (text := slips(one))]
        if slips is capacity.slip_of_units and len(found) == len(values):
            raise ArgumentError(found[0])
        if found:
            yield found[0] if len(found) == 1 else f"{found[0]} (and {len(found) - 1} more of {len(values)} points)"
