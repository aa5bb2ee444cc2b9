"""What is solved: an FMU, parameters and axes, and an identity (hash) of everything that determines the results."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields
from functools import cached_property, partial
from typing import Any

from pushbelt.errors import ArgumentError
from pushbelt.fmu import steady, working_points
from pushbelt.fmu.data import pitch_radius
from pushbelt.fmu.start_values import checked
from pushbelt.fmu.steady import SteadyStates
from pushbelt.fmu.working_points import SHAFTS, Along, Line
from pushbelt.study.tasks import Row, Tasks, ascending, spread

MARGIN = 1.06
"""Factor between the ratios of the end stops and the outermost ratios. A loaded belt rests within it of the stops."""


@dataclass(frozen=True)
class Grid:
    """Axes of the maps, each ascending."""

    force: tuple[float, ...] = (2500.0, 6000.0, 15000.0, 40000.0)
    """Secondary clamping force, N."""
    speed: tuple[float, ...] = (60.0, 200.0, 450.0)
    """Primary speed, rad/s."""
    ratio: tuple[float, ...] = ()
    """Geometric ratio; empty for `ratios` values between the end stops."""
    ratios: int = 7
    utilisation: tuple[float, ...] = (-0.9, -0.75, -0.6, -0.45, -0.3, -0.15, 0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9)
    """Torque utilisation; negative where the secondary pulley drives."""
    slip_share: tuple[float, ...] = (-1.0, -0.6, -0.35, -0.15, -0.05, 0.0, 0.05, 0.15, 0.35, 0.6, 1.0)
    """Slips of the traction, divided by the slip at capacity."""
    shift_utilisation: tuple[float, ...] = (-0.3, 0.3)
    """Torque utilisations at which shifts are measured."""
    excess: tuple[float, ...] = (-0.9, -0.5, -0.25, -0.1, 0.0, 0.1, 0.25, 0.5, 0.9)
    """ln(F_P/(κ F_S)) of the shifts, with 0."""

    def __post_init__(self) -> None:
        for one in fields(self):
            values = getattr(self, one.name)
            if one.name != "ratios" and (values or one.name != "ratio"):
                values = ascending(one.name, values, positive=one.name in ("force", "speed", "ratio"))
                object.__setattr__(self, one.name, values)
        if 0.0 not in self.excess:
            raise ArgumentError("0 must be among the values of excess")
        if (self.slip_share[0], self.slip_share[-1]) != (-1.0, 1.0) or 0.0 not in self.slip_share:
            raise ArgumentError("the values of slip_share must begin with -1, contain 0 and end with 1")


COARSE = Grid()  # 84 lines with 13 points each
SHORT = Grid(force=(6000.0, 15000.0), speed=(100.0, 300.0), ratios=3)  # 12 lines


def stops(parameters: Mapping[str, float]) -> tuple[float, float]:
    """Geometric ratios of the unloaded belt at the end stops that it reaches first, lowest and highest."""

    def at(name: str) -> float:
        """Where a radius is at its limit. That of the primary pulley falls with the ratio, that of the secondary one rises."""
        low, high = 0.05, 20.0
        for _ in range(60):
            middle = math.sqrt(low * high)
            radius = pitch_radius(parameters, middle)
            beyond = radius < parameters[name] if name.startswith("primary") else middle * radius > parameters[name]
            low, high = (low, middle) if beyond else (middle, high)
        return math.sqrt(low * high)

    lowest = max(at("primary.maxRadius"), at("secondary.minRadius"))
    return lowest, min(at("primary.minRadius"), at("secondary.maxRadius"))


@dataclass(frozen=True)
class Plan(Tasks):
    """The lines of a grid, for an FMU and a variator."""

    grid: Grid = COARSE

    def __post_init__(self) -> None:
        object.__setattr__(self, "parameters", checked(self.variables, self.parameters, {"parameter"}))

    @cached_property
    def full(self) -> dict[str, float]:
        """All parameters of the FMU: those that are given, and the defaults of the others."""
        parameters = {name: one.start for name, one in self.variables.items() if one.causality == "parameter"}
        defaults = {name: start for name, start in parameters.items() if not name.startswith(("initial.", "solver."))}
        return {**checked(self.variables, defaults, {"parameter"}), **self.parameters}

    @cached_property
    def ratios(self) -> tuple[float, ...]:
        """Geometric ratios: those of the grid, or evenly spaced in ln i between the end stops."""
        if self.grid.ratio:
            return self.grid.ratio
        low, high = stops(self.full)
        return spread(low * MARGIN, high / MARGIN, self.grid.ratios)

    procedure = (working_points, steady)

    @property
    def measure(self) -> Callable[[SteadyStates, Line], Row]:
        excesses = tuple(excess for excess in self.grid.excess if excess != 0.0)
        along = Along(self.grid.utilisation, self.grid.slip_share, self.grid.shift_utilisation, excesses)
        return partial(working_points.measure, along=along)

    @property
    def common(self) -> Mapping[str, float]:
        return {**self.full, **SHAFTS}

    def tasks(self) -> list[Line]:
        """All lines; the ratio varies fastest."""
        return [Line(*values) for values in itertools.product(self.grid.force, self.grid.speed, self.ratios)]

    def document(self) -> dict[str, Any]:
        return {"parameters": dict(self.full), "grid": {**asdict(self.grid), "ratio": self.ratios}}
