"""Evaluation of the fields along the belt: push force of one element, spiral running of an arc.

The pitch-line speed V of touching elements is the same all around the belt (to the strain of the stack, about 1e-4), so an
element's place on the pitch line moves by ∫V dt. A place on the ring's centre line follows from it by the pitch-line length
per dξ, λ = 1 − e κ: on an arc of radius r an element moves along the centre line faster by the factor r/(r − e).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pushbelt.fmu.data import curve_of
from pushbelt.fmu.geometry import Array, TwoPulleyCurve

from .results import CaseRun, Window


class Path(NamedTuple):
    """Positions of an element over time, s from the start on: places ξ on the ring's centre line, growing beyond its length, m."""

    time: Array
    xi: Array


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


def curve(parameters: Mapping[str, float], window: Window) -> TwoPulleyCurve:
    """Reference curve at the mean ratio of a run."""
    return curve_of(parameters, window.mean("reference.theta"))


def element(parameters: Mapping[str, float], run: CaseRun) -> tuple[Path, Array]:
    """Path of an element that enters the primary arc at the start, and the push force on it, N."""
    window = run.window
    shape = curve(parameters, window)
    entry = shape.borders[2]
    trace = window.trace
    path = follow(shape, parameters["belt.pitchOffset"], trace.time, trace["belt.speed"], entry)
    return path, along(path, window.position, window.push_force, shape.length)


def strand_ripple(parameters: Mapping[str, float], run: CaseRun) -> float:
    """Standard deviation of the push force over time in the middle of the push strand, relative to its mean."""
    *_, start, end, _ = curve(parameters, run.window).borders
    middle = int(np.argmin(np.abs(run.window.position - 0.5 * (start + end))))
    force = run.window.push_force[:, middle]
    return float(force.std() / force.mean())


def push_force_gains(parameters: Mapping[str, float], run: CaseRun) -> tuple[float, float, float]:
    """Change of the mean push force over the primary arc, the push strand and the secondary arc, N."""
    window = run.window
    return curve(parameters, window).push_force_gains(window.position, window.push_force.mean(axis=0))


def arc(parameters: Mapping[str, float], run: CaseRun, pulley: str) -> tuple[Array, Array]:
    """Places on a pulley's arc as fractions of it, from entry to exit, and the radius there relative to the arc's mean radius, averaged
    over time, m."""
    window = run.window
    shape = curve(parameters, window)
    fraction = 0.5 + shape.from_middle(pulley, window.position) / shape.arc_length(pulley)
    order = np.argsort(fraction)
    inside = order[(fraction[order] > 0.0) & (fraction[order] < 1.0)]
    return fraction[inside], window.radial_deviation.mean(axis=0)[inside]
