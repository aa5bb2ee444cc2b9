"""The belt of a run, as far as its file has fields along the belt."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pushbelt.belt_view import Motion, integrated, motion
from pushbelt.fmu.results import BeltState, Profile, Trace
from pushbelt.fmu.unit import PROFILE_FIELDS, PROFILE_POINTS

FIELD = "profile."
"""How the names of fields along the belt begin."""
SPEEDS = ("primary.speed", "secondary.speed", "belt.speed")
OUTPUTS = ("reference.theta", "primary.radius", "secondary.radius", *SPEEDS)
MOMENTS = 300
"""Moments that are shown of a run, at most."""


def places(field: str) -> list[str]:
    """Names of the columns of a field along the belt."""
    return [f"{FIELD}{field}[{k + 1}]" for k in range(PROFILE_POINTS)]


NEEDED = ("position", "pushForce", "radialDeviation")
"""Fields that the picture shows; the others may be missing."""


def shows_belt(run: Trace) -> bool:
    """Whether the file has all that the picture of its belt needs."""
    return all(name in run.columns for name in (*OUTPUTS, *(name for field in NEEDED for name in places(field))))


def belt_of(run: Trace, parameters: Mapping[str, float]) -> Motion:
    """The belt over the time of the run, at evenly spaced rows. `parameters` are those of the variator."""
    rows = np.unique(np.linspace(0, len(run.time) - 1, MOMENTS).round().astype(int))
    none = np.zeros((len(run.time), PROFILE_POINTS))
    tables = {
        name: np.column_stack([run[column] for column in places(field)]) if places(field)[0] in run.columns else none
        for name, field in PROFILE_FIELDS.items()
    }
    states = {
        float(run.time[k]): BeltState(
            {name: float(run[name][k]) for name in OUTPUTS}, Profile(**{name: of[k] for name, of in tables.items()})
        )
        for k in rows
    }
    turned = [integrated(run.time, run[name], run.time[rows]) for name in SPEEDS]
    return motion(states, parameters, turned)
