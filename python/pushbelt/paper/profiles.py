"""What the fields along the belt show: push force of one element, spiral running of an arc."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pushbelt.fmu.data import curve_of
from pushbelt.fmu.geometry import Array, TwoPulleyCurve

from . import tracer
from .results import CaseRun, Window

EDGE = 0.012
"""A strand's push force is judged this far from the arcs, m: pressure rises over some millimetres beside them."""


def curve(parameters: Mapping[str, float], window: Window) -> TwoPulleyCurve:
    """Reference curve at the mean ratio of a run."""
    return curve_of(parameters, window.mean("reference.theta"))


def element(parameters: Mapping[str, float], run: CaseRun) -> tuple[tracer.Path, Array]:
    """The way of an element that enters the primary arc at the start, and the push force on it, N."""
    window = run.window
    shape = curve(parameters, window)
    entry = shape.borders[2]
    trace = window.trace
    path = tracer.follow(shape, parameters["belt.pitchOffset"], trace.time, trace["belt.speed"], entry)
    return path, tracer.along(path, window.position, window.push_force, shape.length)


def strand_ripple(parameters: Mapping[str, float], run: CaseRun) -> float:
    """Standard deviation of the push force over time in the middle of the push strand, relative to its mean."""
    *_, start, end, _ = curve(parameters, run.window).borders
    middle = int(np.argmin(np.abs(run.window.position - 0.5 * (start + end))))
    force = run.window.push_force[:, middle]
    return float(force.std() / force.mean())


def push_force_gains(parameters: Mapping[str, float], run: CaseRun) -> tuple[float, float, float]:
    """Change of the mean push force over the primary arc, the push strand and the secondary arc, N."""
    shape = curve(parameters, run.window)
    _, upper_start, upper_end, lower_start, lower_end, _ = shape.borders
    places = [upper_end - EDGE, lower_start + EDGE, lower_end - EDGE, upper_start + EDGE]
    at = np.interp(places, run.window.position, run.window.push_force.mean(axis=0))
    return tuple(np.diff(at).tolist())


def arc(parameters: Mapping[str, float], run: CaseRun, pulley: str) -> tuple[Array, Array]:
    """Places on a pulley's arc as fractions of it, from entry to exit, and mean radius less the arc's mean there, m."""
    window = run.window
    shape = curve(parameters, window)
    _, s_end, p_start, p_end, s_start, length = shape.borders
    start, end = (p_start, p_end) if pulley == "primary" else (s_start, length + s_end)
    xi = np.concatenate([window.position, window.position + length])
    inside = (xi > start) & (xi < end)
    deviation = np.tile(window.radial_deviation.mean(axis=0), 2)
    return (xi[inside] - start) / (end - start), deviation[inside]
