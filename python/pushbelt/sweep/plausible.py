"""Checks of the points of a study before anything is solved: forces and torques in a wrong unit, excessive belt speeds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from pushbelt.errors import PushbeltError
from pushbelt.fmu import capacity
from pushbelt.fmu.data import torque_capacity
from pushbelt.fmu.enumerations import Axial, Drive

from .study import Study

MOST = 2000
"""Largest number of points that are checked, evenly spaced in the study."""


class WrongUnitError(PushbeltError, ValueError):
    """Forces or torques of all points look like a wrong unit."""


def check(study: Study) -> Iterator[str]:
    """Warnings about points.

    Raises WrongUnitError if no point carries its torque, and a wrong unit explains it at all of them.
    """
    points = study.grid.points()
    checked = [study.start_values(point) for point in points[:: -(-len(points) // MOST)]]
    for slips, values in ((wrong_unit, checked), (excessive_speed, checked)):
        found = [text for one in values if (text := slips(one))]
        if not found:
            continue
        if slips is wrong_unit and len(found) == len(checked):
            raise WrongUnitError(found[0])
        yield found[0] if len(found) == 1 else f"{found[0]} (and {len(found) - 1} more of {len(checked)} points)"


def wrong_unit(values: Mapping[str, float]) -> str | None:
    """The unit that is probably wrong in start values of a point; None if they may be right."""
    torque, force, ratio = values["primary.torque"], values["secondary.clampingForce"], values["initial.ratio"]
    if values["primary.drive"] != Drive.TORQUE or values["secondary.axial"] != Axial.FORCE:
        return None
    carried = torque_capacity(values, ratio, force)
    # The torque of a utilisation is small with the force, so a force that carries less than the drag of a shaft is one in kN as well.
    if abs(torque) <= capacity.BEYOND * carried + capacity.DRAG and carried > capacity.DRAG:
        return None
    hint = capacity.wrong_unit(torque, force, carried)
    return f"the capacity is {carried:.3g} N·m at {force:g} N. {hint}" if hint else None


def excessive_speed(values: Mapping[str, float]) -> str | None:
    """Reason why the speed of a point is not realistic; None if it is."""
    return capacity.excessive_speed(values, values["initial.ratio"], values["initial.primarySpeed"])
