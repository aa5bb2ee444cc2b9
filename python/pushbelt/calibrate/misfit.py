"""Other readings of a table that does not fit: the inverse of a ratio, other signs, other units, exchanged forces."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pushbelt.rig import points, units
from pushbelt.rig.model import Model
from pushbelt.rig.parameters import Parameter, assign
from pushbelt.rig.points import Oil, Point, Reading, Rig, TableError

RATIOS = ("ratio.geometric", "ratio.speed", "thrustRatio")
SIGNED = ("primary.torque", "slip", "di/dt", "ds/dt")
SCALED = ("primary.speed", "primary.torque", "secondary.clampingForce", "primary.clampingForce", "slip", "efficiency")
LARGEST = 12
"""Largest number of points on which a reading is tried."""
BETTER = 0.5
"""A reading is named if its residuals are below this share of those of the table as it is."""
FRICTIONS = (0.8, 0.9, 1.0, 1.1, 1.25)
"""Factors of the start value of the friction at which each reading is tried."""


@dataclass(frozen=True)
class Alternative:
    """A reading that fits better."""

    text: str
    """What it changes."""
    renamed: Mapping[str, str]
    """Its `--map` options."""
    rms: tuple[float, float]
    """Root mean square of the residuals in standard deviations over a few points: as the table is, and with this reading."""

    @property
    def options(self) -> str:
        """Its options on the command line."""
        return " ".join(f'--map "{title}={name}"' for title, name in self.renamed.items())

    def __str__(self) -> str:
        first, last = self.rms
        return f"{self.text} fits better: {last:.3g} instead of {first:.3g} standard deviations; {self.options}"


def readings(rig: Rig) -> Iterator[tuple[str, dict[str, str]]]:
    """Other readings, each with its mapped names."""
    taken = rig.sheet.taken
    for name in RATIOS:
        if name in taken:
            one = taken[name]
            turned = "" if one.turned == "1/" else "1/"
            yield f"the inverse of {one.title}", {one.title: f"{turned}{name}"}
    for name in SIGNED:
        if name in taken:
            one = taken[name]
            turned = "" if one.turned == "-" else "-"
            yield f"{one.title} with the other sign", {one.title: f"{turned}{_with_unit(name, one.unit)}"}
    for name in SCALED:
        if name in taken and not taken[name].turned:
            one = taken[name]
            for unit in units.PREFERRED[one.column.dimension]:
                scale = units.find(unit, one.column.dimension)
                if scale is not None and scale != one.scale:
                    yield f"{one.title} in {unit}", {one.title: f"{name} [{unit}]"}
    forces = [taken.get(f"{pulley}.clampingForce") for pulley in ("primary", "secondary")]
    if all(forces):
        first, second = forces
        yield (
            f"{first.title} and {second.title} exchanged",
            {first.title: _with_unit(second.name, first.unit), second.title: _with_unit(first.name, second.unit)},
        )


def _with_unit(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def chosen(found: Sequence[Point]) -> list[Point]:
    """A few points, evenly spaced in the table."""
    places = np.unique(np.linspace(0, len(found) - 1, min(LARGEST, len(found))).round().astype(int))
    return [found[k] for k in places]


def alternatives(
    rig: Rig, reading: Reading, oil: Oil, parameters: Sequence[Parameter], opened: Callable[[Sequence[Point]], Model], path: Path
) -> list[Alternative]:
    """Readings that fit much better than the table as it is, best first. `opened` gives a model of points."""
    # Each reading has its points in one model, so that all are solved together.
    tried: list[tuple[str, dict[str, str], list[Point]]] = [("", {}, chosen(rig.points))]
    for text, renamed in readings(rig):
        try:
            other = points.read(path, replace(reading, renamed={**reading.renamed, **renamed}), oil)
        except TableError:
            continue
        tried.append((text, renamed, chosen(other.points)))
    found = []
    places = _places(parameters)
    everything = [point for *_, own in tried for point in own]
    model = opened(everything)
    states = model.states([assign(parameters, place) for place in places])
    start = 0
    for text, renamed, own in tried:
        part, end = Model(own, lambda jobs: []), start + len(own)
        rms = min(_rms(part, one[start:end]) for one in states)
        start = end
        found.append((rms, text, renamed))
    as_is = found[0][0]
    better = sorted((one for one in found[1:] if one[0] < BETTER * as_is), key=lambda one: one[0])
    # Only those that are about as good as the best one.
    return [Alternative(text, renamed, (as_is, rms)) for rms, text, renamed in better if rms <= 1.5 * better[0][0]]


def _places(parameters: Sequence[Parameter]) -> list[np.ndarray]:
    """Start values, with the friction at several values if it is fitted."""
    start = np.array([parameter.coordinate(parameter.start) for parameter in parameters])
    friction = next((k for k, parameter in enumerate(parameters) if parameter.name == "friction.pulley"), None)
    if friction is None:
        return [start]
    low, high = parameters[friction].bounds
    coordinates = [parameters[friction].coordinate(factor * parameters[friction].start) for factor in FRICTIONS]
    return [np.where(np.arange(len(start)) == friction, min(max(c, low), high), start) for c in coordinates]


def _rms(model: Model, states: Sequence) -> float:
    """Root mean square over all values; those at points without a steady state count `FAR`."""
    return float(np.sqrt(model.distance(states, limited=False) / max(len(model.values), 1)))
