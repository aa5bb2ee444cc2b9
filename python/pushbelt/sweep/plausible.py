"""Checks of the points of a study before anything is solved: forces and torques in a wrong unit, excessive belt speeds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from pushbelt.errors import PushbeltError
from pushbelt.fmu import capacity

from .study import Study

MOST = 2000
"""Largest number of points that are checked, evenly spaced in the study."""


class WrongUnitError(PushbeltError, ValueError):
    """Forces or torques of all points look like a wrong unit."""


def check(study: Study) -> Iterator[str]:
    """Warnings about points. Raises WrongUnitError if no point carries its torque, and a wrong unit explains it at all
    of them."""
    points = study.grid.points()
    checked = [study.start_values(point) for point in points[:: -(-len(points) // MOST)]]
    for slips in (capacity.slip_of_units, excessive_speed):
        found = [text for one in checked if (text := slips(one))]
        if not found:
            continue
        if slips is capacity.slip_of_units and len(found) == len(checked):
            raise WrongUnitError(found[0])
        yield found[0] if len(found) == 1 else f"{found[0]} (and {len(found) - 1} more of {len(checked)} points)"


def excessive_speed(values: Mapping[str, float]) -> str | None:
    """Reason why the speed of a point is not realistic; None if it is."""
    return capacity.excessive_speed(values, values["initial.ratio"], values["initial.primarySpeed"])
