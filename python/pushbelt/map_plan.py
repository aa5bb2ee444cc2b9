"""What is solved: an FMU, parameters and axes, and an identity (hash) of everything that determines the results."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

from pushbelt.fmu import shift, starts, steady, working_points
from pushbelt.fmu.data import parameter_set, pitch_radius
from pushbelt.fmu.enumerations import RingModel
from pushbelt.fmu.start_values import checked
from pushbelt.fmu.untrusted import OfFmu
from pushbelt.fmu.working_points import Along, Line

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
            if one.name == "ratios":
                continue
            values = tuple(float(value) for value in getattr(self, one.name))
            object.__setattr__(self, one.name, values)
            if not values and one.name != "ratio" or any(low >= high for low, high in itertools.pairwise(values)):
                raise ValueError(f"the values of {one.name} must not be empty and must ascend: {values}")
            positive = one.name in ("force", "speed", "ratio")
            if not all(map(math.isfinite, values)) or (positive and values and values[0] <= 0.0):
                raise ValueError(f"the values of {one.name} must be {'positive' if positive else 'finite'}: {values}")
        if 0.0 not in self.excess:
            raise ValueError("0 must be among the values of excess")
        if (self.slip_share[0], self.slip_share[-1]) != (-1.0, 1.0) or 0.0 not in self.slip_share:
            raise ValueError("the values of slip_share must begin with -1, contain 0 and end with 1")


COARSE = Grid()
"""84 lines with 13 points each."""
SHORT = Grid(force=(6000.0, 15000.0), speed=(100.0, 300.0), ratios=3)
"""12 lines."""


def stops(parameters: Mapping[str, float]) -> tuple[float, float]:
    """Geometric ratios of the unloaded belt at the end stops that it reaches first, lowest and highest."""

    def at_stop(low: float, high: float, reached: Any) -> float:
        for _ in range(60):
            middle = math.sqrt(low * high)
            low, high = (low, middle) if reached(middle) else (middle, high)
        return math.sqrt(low * high)

    def secondary(ratio: float) -> float:
        return ratio * pitch_radius(parameters, ratio)

    limits = {name: parameters[name] for name in LIMITS}
    lowest = max(
        at_stop(0.05, 20.0, lambda i: pitch_radius(parameters, i) < limits["primary.maxRadius"]),
        at_stop(0.05, 20.0, lambda i: secondary(i) > limits["secondary.minRadius"]),
    )
    highest = min(
        at_stop(0.05, 20.0, lambda i: pitch_radius(parameters, i) < limits["primary.minRadius"]),
        at_stop(0.05, 20.0, lambda i: secondary(i) > limits["secondary.maxRadius"]),
    )
    return lowest, highest


LIMITS = ("primary.minRadius", "primary.maxRadius", "secondary.minRadius", "secondary.maxRadius")
"""Parameters of the end stops."""


@dataclass(frozen=True)
class Plan(OfFmu):
    """The lines of a grid, for an FMU and a variator."""

    fmu: Path
    parameters: Mapping[str, float]
    """Start values of the FMU by name."""
    grid: Grid = COARSE

    def __post_init__(self) -> None:
        object.__setattr__(self, "parameters", checked(self.variables, self.parameters, {"parameter"}))

    @cached_property
    def full(self) -> dict[str, float]:
        """All parameters of the FMU: those that are given, and the defaults of the others."""
        defaults = {
            name: variable.start
            for name, variable in self.variables.items()
            if variable.causality == "parameter" and not name.startswith(("initial.", "solver."))
        }
        return {**checked(self.variables, defaults, {"parameter"}), **self.parameters}

    @cached_property
    def ratios(self) -> tuple[float, ...]:
        """Geometric ratios: those of the grid, or evenly spaced in ln i between the end stops."""
        if self.grid.ratio:
            return self.grid.ratio
        low, high = stops(self.full)
        low, high = low * MARGIN, high / MARGIN
        step = (high / low) ** (1.0 / max(self.grid.ratios - 1, 1))
        return tuple(round(low * step**k, 6) for k in range(self.grid.ratios))

    @property
    def along(self) -> Along:
        """What is measured on a line."""
        return Along(
            self.grid.utilisation,
            self.grid.slip_share,
            self.grid.shift_utilisation,
            tuple(excess for excess in self.grid.excess if excess != 0.0),
        )

    @cached_property
    def lines(self) -> list[Line]:
        """All lines; the ratio varies fastest."""
        axes = (self.grid.force, self.grid.speed, self.ratios)
        return [Line(*values) for values in itertools.product(*axes)]

    @cached_property
    def identity(self) -> str:
        """A hash of the FMU, the parameters, the axes and the procedure."""
        document = {
            "fmu": hashlib.sha256(self.archive).hexdigest(),
            "procedure": [
                hashlib.sha256(Path(one.__file__).read_bytes()).hexdigest() for one in (working_points, shift, starts, steady)
            ],
            "parameters": dict(self.full),
            "grid": {**asdict(self.grid), "ratio": self.ratios},
        }
        return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()


def variator(name: str, model: str = "ALE", changes: Mapping[str, float] | None = None) -> dict[str, float]:
    """Parameters of a published variator (`bench168` or `belt155`) or of a file ….json, with changes."""
    return {**parameter_set(name), "ring.model": RingModel[model], **(changes or {})}
