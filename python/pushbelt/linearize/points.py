"""Working points as they are written on the command line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from pushbelt.errors import ArgumentError
from pushbelt.fmu.data import SAFETY_RANGE
from pushbelt.linear.grid import LinearGrid
from pushbelt.variator import Variator

AXES = {
    "initial.ratio": "ratio",
    "primary.torque": "torque",
    "initial.primarySpeed": "speed",
    "secondary.clampingForce": "force",
}
"""Names of the FMU's variables, and of the corresponding axes of a grid."""
REACTIONS = ("primary.clampingForce", "secondary.torque")
"""Loads that hold a point. A specified value is compared with the required one."""
SAME = 0.01  # Largest relative difference between a specified and a required load
SMALL = {"primary.clampingForce": 5e3, "secondary.torque": 50.0}
"""Smallest magnitude of a load in this comparison, N and N·m."""


class Asked(NamedTuple):
    """The specified points and parameters."""

    points: Mapping[str, list[float]]  # Values of `AXES`
    loads: Mapping[str, float]  # Values of `REACTIONS`
    parameters: Mapping[str, str]  # Parameters with one value
    changes: Mapping[str, list[str]]  # Parameters with several values
    safety: float | None

    def axes(self, variator: Variator) -> dict[str, Any]:
        """Arguments of `linear_grid`: the specified points, and start values of the variator for what is not specified. A single number
        of speed or force is not an axis."""
        found = {axis: self.points.get(name, [variator[name]]) for name, axis in AXES.items()}
        found |= {axis: found[axis][0] for axis in ("speed", "force") if len(found[axis]) == 1}
        found |= {"ratios": found.pop("ratio"), "torques": found.pop("torque")}
        return found | ({"force": None} if self.safety else {})


def read(settings: Sequence[str], safety: float | None = None) -> Asked:
    """Parses NAME=VALUE, NAME=VALUE,VALUE and NAME=FIRST:LAST:COUNT."""
    found: dict[str, list[Any]] = {}
    for setting in settings:
        name, _, text = setting.partition("=")
        if not (name and text):
            raise ArgumentError(f"`{setting}` is not of the form NAME=VALUE")
        if name in found:
            raise ArgumentError(f"{name} appears twice")
        found[name] = _values(name, text)
        if name in REACTIONS and len(found[name]) > 1:
            raise ArgumentError(f"{name} follows from the point: give at most one value, which is compared with the result")
    points = {name: found.pop(name) for name in AXES if name in found}
    loads = {name: found.pop(name)[0] for name in REACTIONS if name in found}
    parameters = {name: words[0] for name, words in found.items() if len(words) == 1}
    changes = {name: words for name, words in found.items() if len(words) > 1}
    if safety is not None and not SAFETY_RANGE[0] <= safety <= SAFETY_RANGE[1]:
        raise ArgumentError(f"--safety {safety:g} is not within {SAFETY_RANGE[0]:g} to {SAFETY_RANGE[1]:g}")
    if safety is not None and "secondary.clampingForce" in points:
        raise ArgumentError("--safety and secondary.clampingForce both determine the clamping force: give one of them")
    return Asked(points, loads, parameters, changes, safety)


def _values(name: str, text: str) -> list[Any]:
    """Numbers of a point, and texts of a parameter."""
    read, parts = (float if name in (*AXES, *REACTIONS) else lambda word: str(word).strip()), text.split(":")
    try:
        if len(parts) != 3:
            return [read(word) for word in text.split(",")]
        if 2 <= int(parts[2]) <= 1000:
            return [read(value) for value in np.linspace(float(parts[0]), float(parts[1]), int(parts[2])).tolist()]
    except ValueError:
        pass
    raise ArgumentError(f"{name} = {text!r} is not a number, A,B,C or FIRST:LAST:COUNT with a count of 2 to 1000")


def without_other_loads(grid: LinearGrid, loads: Mapping[str, float]) -> LinearGrid:
    """The grid without the points that require other loads than the specified ones."""
    models, reasons = grid.models.copy(), grid.reasons.copy()
    for place, model in np.ndenumerate(grid.models):
        held = {} if model is None else {name: (model.held.get(name, given), given) for name, given in loads.items()}
        if why := [
            f"this point requires {name} = {held:.6g} {model.units[name]}, but {given:g} {model.units[name]} is specified"
            for name, (held, given) in held.items()
            if not abs(held - given) <= SAME * max(abs(held), abs(given), SMALL[name])
        ]:
            at = ", ".join(f"{name} {value:g}" for name, value in grid.point(place).items())
            models[place], reasons[place] = None, f"no linear model at {at}: {'; '.join(why)}"
    return LinearGrid(grid.axes, models, reasons)
