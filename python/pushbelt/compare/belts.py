"""The belt of a run, from the fields along the belt in its file."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pushbelt.fmu.data import is_chain
from pushbelt.fmu.results import Profile, Trace
from pushbelt.fmu.unit import PROFILE_FIELDS, PROFILE_POINTS
from pushbelt.report.belt_view import OUTPUTS, SPEEDS, Motion, of_run

FIELD = "profile."  # Prefix of the names of fields along the belt
MOMENTS = 300  # Largest number of times of a run in the animation


def places(field: str) -> list[str]:
    """Names of the columns of a field along the belt."""
    return [f"{FIELD}{field}[{k + 1}]" for k in range(PROFILE_POINTS)]


def needed(parameters: Mapping[str, float]) -> list[str]:
    """Columns that the animation of the belt requires. Other fields are optional."""
    fields = ("position", "ringTension" if is_chain(parameters) else "pushForce", "radialDeviation")
    return [*OUTPUTS, *SPEEDS, *(name for field in fields for name in places(field))]


def shows_belt(run: Trace, parameters: Mapping[str, float]) -> bool:
    return all(name in run.columns for name in needed(parameters))


def belt_of(run: Trace, parameters: Mapping[str, float]) -> Motion:
    """The belt over the time of the run, at evenly spaced rows. `parameters` are those of the variator."""
    rows = np.unique(np.linspace(0, len(run.time) - 1, MOMENTS).round().astype(int))
    none = np.zeros((len(run.time), PROFILE_POINTS))
    tables = {
        name: np.column_stack([run[column] for column in places(field)]) if places(field)[0] in run.columns else none
        for name, field in PROFILE_FIELDS.items()
    }
    profiles = {float(run.time[k]): Profile(**{name: of[k] for name, of in tables.items()}) for k in rows}
    return of_run(run, profiles, parameters)
