"""Forces that close the pulleys at rest, by the law of the FMU (`docs/hydraulics.md`): F = F_clamp + p A + F₀ − k z + c ω²."""

import math
from collections.abc import Mapping
from typing import Any

from .data import needed, pitch_radius


def closing_force(values: Mapping[str, Any], pulley: str, position: Any, speed: Any) -> Any:
    """Whole force on the movable sheave of `primary` or `secondary`, N, by names of FMU variables; those that `values` lacks are 0.
    Position z (m), angular speed ω (rad/s), pressure and clamping force may be arrays."""
    clamp, pressure = (values.get(f"{pulley}.{name}", 0.0) for name in ("clampingForce", "pressure"))
    names = ("area", "springForce", "springStiffness", "centrifugal")
    area, force, stiffness, centrifugal = (values.get(f"{pulley}.cylinder.{name}", 0.0) for name in names)
    return clamp + pressure * area + force - stiffness * position + centrifugal * speed**2


def sheave_position(values: Mapping[str, float], pulley: str, ratio: float) -> float:
    """Position z of a movable sheave at a geometric ratio, 2 tanβ (r − r(1)), m; NaN for none."""
    if not ratio > 0.0:
        return math.nan
    radius = pitch_radius(values, ratio) * (ratio if pulley == "secondary" else 1.0)
    return 2.0 * math.tan(needed(values, "geometry.wedgeAngle")) * (radius - pitch_radius(values, 1.0))


def closing_at(values: Mapping[str, Any], pulley: str, ratio: float, speed: float) -> float:
    """The whole force in a steady state at a geometric ratio and a primary speed, rad/s; N."""
    # Only a stiff spring needs the geometry.
    place = sheave_position(values, pulley, ratio) if values.get(f"{pulley}.cylinder.springStiffness") else 0.0
    return float(closing_force(values, pulley, place, speed if pulley == "primary" else speed / ratio))


def closed_by(values: Mapping[str, Any], pulley: str, force: float, ratio: float, speed: float) -> dict[str, float]:
    """Inputs under which the whole force is `force`, N, at a ratio and a primary speed, rad/s: a pressure where the cylinder has an area,
    else the clamping force."""
    clamp, pressure = f"{pulley}.clampingForce", f"{pulley}.pressure"
    missing = force - closing_at({**values, clamp: 0.0, pressure: 0.0}, pulley, ratio, speed)
    area = values.get(f"{pulley}.cylinder.area", 0.0)
    return {clamp: 0.0, pressure: missing / area} if area else {clamp: missing}
