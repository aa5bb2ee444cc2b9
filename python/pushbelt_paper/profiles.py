"""What the fields along the belt show: push force of one element, spiral running of an arc."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pushbelt_demo.data import curve_of
from pushbelt_demo.geometry import Array, TwoPulleyCurve

from . import tracer
from .results import CaseRun, Revolution

EDGE = 0.012
"""A strand's push force is judged this far from the arcs, m: pressure rises over some millimetres beside them."""


def curve(parameters: Mapping[str, float], revolution: Revolution) -> TwoPulleyCurve:
    """Reference curve at the mean ratio of a revolution."""
    return curve_of(parameters, revolution.mean("reference.theta"))


def element(parameters: Mapping[str, float], run: CaseRun) -> tuple[tracer.Path, Array]:
    """The way of an element that enters the primary arc at the start, and the push force on it, N."""
    revolution = run.revolution
    shape = curve(parameters, revolution)
    entry = shape.borders[2]
    trace = revolution.trace
    path = tracer.follow(shape, parameters["belt.pitchOffset"], trace.time, trace["belt.speed"], entry)
    return path, tracer.along(path, revolution.position, revolution.push_force, shape.length)


def strand_ripple(parameters: Mapping[str, float], run: CaseRun) -> float:
    """Root mean square of one element's push force in the push strand about its straight line, relative to its mean."""
    path, force = element(parameters, run)
    *_, start, end, _ = curve(parameters, run.revolution).borders
    inside = (path.xi > start + EDGE) & (path.xi < end - EDGE)
    line = np.polynomial.Polynomial.fit(path.xi[inside], force[inside], 1)(path.xi[inside])
    return float(np.sqrt(np.mean((force[inside] - line) ** 2)) / force[inside].mean())


def push_force_gains(parameters: Mapping[str, float], run: CaseRun) -> tuple[float, float, float]:
    """Change of one element's push force over the primary arc, the push strand and the secondary arc, N."""
    path, force = element(parameters, run)
    shape = curve(parameters, run.revolution)
    _, upper_start, upper_end, lower_start, lower_end, _ = shape.borders
    places = [upper_end - EDGE, lower_start + EDGE, lower_end - EDGE, shape.length + upper_start + EDGE]
    at = np.interp(places, np.concatenate([[upper_end - 2.0 * EDGE], path.xi]), np.concatenate([[force[-1]], force]))
    return tuple(np.diff(at).tolist())


def arc(parameters: Mapping[str, float], run: CaseRun, pulley: str) -> tuple[Array, Array]:
    """Places on a pulley's arc as fractions of it, from entry to exit, and mean radius less the arc's mean there, m."""
    revolution = run.revolution
    shape = curve(parameters, revolution)
    _, s_end, p_start, p_end, s_start, length = shape.borders
    start, end = (p_start, p_end) if pulley == "primary" else (s_start, length + s_end)
    xi = np.concatenate([revolution.position, revolution.position + length])
    inside = (xi > start) & (xi < end)
    deviation = np.tile(revolution.radial_deviation.mean(axis=0), 2)
    return (xi[inside] - start) / (end - start), deviation[inside]
