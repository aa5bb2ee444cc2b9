"""Evaluation of the fields along the belt: push force of one element, spiral running of an arc."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pushbelt.fmu import fields
from pushbelt.fmu.data import curve_of
from pushbelt.fmu.geometry import Array, TwoPulleyCurve

from . import tracer
from .results import CaseRun, Window


def curve(parameters: Mapping[str, float], window: Window) -> TwoPulleyCurve:
    """Reference curve at the mean ratio of a run."""
    return curve_of(parameters, window.mean("reference.theta"))


def element(parameters: Mapping[str, float], run: CaseRun) -> tuple[tracer.Path, Array]:
    """Path of an element that enters the primary arc at the start, and the push force on it, N."""
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
    window = run.window
    return fields.push_force_gains(curve(parameters, window), window.position, window.push_force.mean(axis=0))


def arc(parameters: Mapping[str, float], run: CaseRun, pulley: str) -> tuple[Array, Array]:
    """Places on a pulley's arc as fractions of it, from entry to exit, and the radius there relative to the arc's mean radius, averaged
    over time, m."""
    window = run.window
    shape = curve(parameters, window)
    fraction = 0.5 + shape.from_middle(pulley, window.position) / shape.arc_length(pulley)
    order = np.argsort(fraction)
    inside = order[(fraction[order] > 0.0) & (fraction[order] < 1.0)]
    return fraction[inside], window.radial_deviation.mean(axis=0)[inside]
