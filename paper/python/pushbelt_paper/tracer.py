"""Path of one push element around the belt.

The pitch-line speed V of touching elements is the same all around the belt (to the strain of the stack, about 1e-4), so an
element's place on the pitch line moves by ∫V dt. A place on the ring's centre line follows from it by the pitch-line length
per dξ, λ = 1 − e κ: on an arc of radius r an element moves along the centre line faster by the factor r/(r − e).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pushbelt.fmu.geometry import Array, TwoPulleyCurve


@dataclass(frozen=True)
class Path:
    """Positions of an element over time."""

    time: Array
    """s, from the start on."""
    xi: Array
    """Place ξ on the ring's centre line, growing beyond its length, m."""


def pitch_line(curve: TwoPulleyCurve, offset: float) -> tuple[Array, Array]:
    """Arc borders ξ of the ring's centre line and their places on the pitch line, `offset` inside it, m."""
    borders = np.array(curve.borders)
    inside_s, inside_p = 1.0 - offset / curve.secondary_radius, 1.0 - offset / curve.primary_radius
    return borders, np.concatenate([[0.0], np.cumsum(np.diff(borders) * [inside_s, 1.0, inside_p, 1.0, inside_s])])


def follow(curve: TwoPulleyCurve, offset: float, time: Array, speed: Array, start: float) -> Path:
    """An element that is at ξ = `start` at the first time, with the belt's pitch-line speed over time, m/s."""
    borders, pitch = pitch_line(curve, offset)
    moved = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))])
    place = np.interp(start, borders, pitch) + moved
    turns, rest = np.divmod(place, pitch[-1])
    return Path(time - time[0], turns * curve.length + np.interp(rest, pitch, borders))


def along(path: Path, position: Array, field: Array, length: float) -> Array:
    """Values of a field at the element. `field` has one row per time and one column per place of `position`."""
    xi = np.mod(path.xi, length)
    closed = np.append(position, position[0] + length)
    return np.array(
        [np.interp(place, closed, np.append(row, row[0])) for place, row in zip(xi, field, strict=True)], dtype=float
    )
