"""Checks of a working point before anything is solved: capacity of the clamping force, and speed of the belt.

The capacity is that of the secondary pulley, 2 μ r_P F_S/cosβ. The primary pulley carries κ times as much, so the capacity is an
upper bound of what the belt carries.
"""

import math
from collections.abc import Mapping
from typing import Any

from .closing import closing_at
from .data import curve_of, torque_capacity
from .enumerations import Axial, Drive
from .geometry import theta_of

BEYOND = 1.15
"""Ratio of torque and capacity above which a point is refused without solving it. Radial friction may raise the capacity by some percent."""
DRAG = 1.0  # Torque that is carried in any case, N·m: drag of a shaft
LARGE_FORCE = 300e3  # Largest clamping force that is chosen for a torque or may be meant, N. Variators for cars have up to 100 kN.
LARGE_BAR = 200.0  # Largest pressure that may be meant, bar: that of the FMU
BELT_SPEED = 60.0  # Speed of the belt above which a warning is issued, m/s. Belts of cars run at up to about 50 m/s.


def shortfall(parameters: Mapping[str, Any], ratio: float, torque: float, force: float) -> str | None:
    """Reason why the whole secondary force (N) cannot carry a primary torque (N·m), with a hint if a unit seems wrong; None if it may."""
    carried = torque_capacity(parameters, ratio, max(force, 0.0))
    if abs(torque) <= BEYOND * carried + DRAG:
        return None
    return f"the capacity is {carried:.3g} N·m at {force:g} N" + wrong_unit(torque, force, carried)


def slip_of_units(values: Mapping[str, Any]) -> str | None:
    """Reason and probable unit if the belt cannot carry the primary torque of start values under their secondary force, and a wrong unit
    explains it; None if they may be right."""
    torque, ratio, speed = (values[name] for name in ("primary.torque", "initial.ratio", "initial.primarySpeed"))
    if values["primary.drive"] != Drive.TORQUE or values["secondary.axial"] != Axial.FORCE or torque == 0.0:
        return None
    force = closing_at(values, "secondary", ratio, speed)
    carried = torque_capacity(values, ratio, force)
    # The torque of a utilisation is small with the force, so a force that carries less than the drag of a shaft is one in kN as well.
    if abs(torque) <= BEYOND * carried + DRAG and carried > DRAG:
        return None
    given, pressure = values["secondary.clampingForce"], values.get("secondary.pressure", 0.0)
    hint = wrong_unit(torque, given, torque_capacity(values, ratio, given)) or wrong_unit(torque, 0.0, carried)
    in_bar = torque_capacity(values, ratio, closing_at({**values, "secondary.pressure": 1e5 * pressure}, "secondary", ratio, speed))
    if 0.0 < pressure <= LARGE_BAR and abs(torque) <= BEYOND * in_bar:
        hint = f". Is the pressure in bar? {pressure:g} bar are {1e5 * pressure:g} Pa and carry {in_bar:.3g} N·m"
    return f"the capacity is {carried:.3g} N·m at {force:g} N{hint}" if hint else None


def wrong_unit(torque: float, force: float, carried: float) -> str:
    """A question for the unit that is meant if torque (N·m) or force (N) are larger or smaller by 1000 than a force that carries
    `carried` N·m allows; empty if they are not."""
    wanted = abs(torque)
    if 0.0 < 1e3 * force <= LARGE_FORCE and wanted <= 1e3 * BEYOND * carried:
        return f". Is the force in kN? {force:g} kN are {1e3 * force:g} N and carry {1e3 * carried:.3g} N·m"
    return _millimetres(wanted) if 1e-3 * wanted <= BEYOND * carried else ""


def _millimetres(torque: float) -> str:
    return f". Is the torque in N·mm? {torque:g} N·mm are {1e-3 * torque:g} N·m" if abs(torque) >= 2e3 else ""


def excessive_force(torque: float, force: float) -> str | None:
    """Reason why the force (N) that a torque (N·m) requires is not realistic; None if it is."""
    if force <= LARGE_FORCE:
        return None
    needed = f"a clamping force of {1e-3 * force:.4g} kN, above {1e-3 * LARGE_FORCE:g} kN"
    return f"{torque:g} N·m require {needed}{_millimetres(torque)}"


def excessive_speed(parameters: Mapping[str, Any], ratio: float, speed: float) -> str | None:
    """Reason why a primary speed (rad/s) is not realistic, with a hint if it seems to be in rpm; None if it is."""
    radius = curve_of(parameters, theta_of(ratio)).primary_radius
    belt = abs(speed) * radius
    if belt <= BELT_SPEED:
        return None
    why = f"{speed:g} rad/s at ratio {ratio:g} are a belt speed of {belt:.3g} m/s, above {BELT_SPEED:g} m/s"
    return f"{why}. Is the speed in rpm? {speed:g} rpm are {speed * math.pi / 30.0:.4g} rad/s"
