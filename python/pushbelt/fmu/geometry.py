"""Geometry of a belt on two pulleys: the curve of the ring's centre line at a ratio coordinate Θ.

Signs and places are those of the FMU: the secondary pulley S is at the origin, the primary pulley P at (d, 0). ξ starts at
the leftmost point of S and runs over the upper strand to P and back along the lower strand. SI units.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ArgumentError

Array = NDArray[Any]
EDGE = 0.012
"""Least distance from the arcs at which a field on a strand is read, m. Pressure extends some millimetres beyond the arcs."""


def ratio_of(theta: float) -> float:
    """Geometric ratio i = r_S/r_P of a ratio coordinate: i = (1−Θ)/(1+Θ)."""
    return (1.0 - theta) / (1.0 + theta)


def theta_of(ratio: float) -> float:
    """Ratio coordinate of a geometric ratio: Θ = (1−i)/(1+i)."""
    return (1.0 - ratio) / (1.0 + ratio)


def primary_radius(theta: float, center_distance: float, length: float) -> float:
    """Radius of the ring's centre line on the primary pulley, m. Solves the closure of the belt, L = 2b + 2 r_P(π−φ) + 2 r_S φ with
    r_S = i r_P, φ = arccos((r_P−r_S)/d) and b = √(d²−(r_P−r_S)²), by Newton's method with its derivative 2(π−φ) + 2 i φ."""
    ratio = ratio_of(theta)
    if not ratio > 0.0:
        raise ArgumentError(f"the ratio coordinate must be between −1 and 1, not {theta}")
    if not length > 2.0 * center_distance:
        raise ArgumentError(f"a belt of {length} m is too short for two axes {center_distance} m apart")
    largest = np.inf if ratio == 1.0 else center_distance / abs(1.0 - ratio)
    radius = min((length - 2.0 * center_distance) / (np.pi * (1.0 + ratio)), 0.999 * largest)
    for _ in range(50):
        difference = (1.0 - ratio) * radius
        phi = np.arccos(difference / center_distance)
        strand = np.sqrt(center_distance**2 - difference**2)
        excess = 2.0 * strand + 2.0 * radius * (np.pi - phi) + 2.0 * ratio * radius * phi - length
        step = excess / (2.0 * (np.pi - phi) + 2.0 * ratio * phi)
        radius = min(radius - step, 0.5 * (radius + largest))
        if abs(step) < 1e-15:
            return float(radius)
    raise ArgumentError(f"no belt of {length} m closes at Θ = {theta} with the axes {center_distance} m apart")


@dataclass(frozen=True)
class TwoPulleyCurve:
    """The reference curve of the ring's centre line at one ratio."""

    center_distance: float  # Distance of the axes, m
    length: float  # Length of the ring's centre line, m
    theta: float  # Ratio coordinate Θ

    @cached_property
    def primary_radius(self) -> float:
        """Centre-line radius on P, m."""
        return primary_radius(self.theta, self.center_distance, self.length)

    @cached_property
    def secondary_radius(self) -> float:
        """Centre-line radius on S, m."""
        return ratio_of(self.theta) * self.primary_radius

    @cached_property
    def phi(self) -> float:
        """Half wrap angle of S, rad; that of P is π−φ."""
        return float(np.arccos((self.primary_radius - self.secondary_radius) / self.center_distance))

    @cached_property
    def strand(self) -> float:
        """Length of a strand, m."""
        return float(np.sqrt(self.center_distance**2 - (self.primary_radius - self.secondary_radius) ** 2))

    @cached_property
    def borders(self) -> tuple[float, float, float, float, float, float]:
        """Borders of the five segments in ξ: half S arc, upper strand, P arc, lower strand, half S arc, m."""
        half_arc = self.secondary_radius * self.phi
        upper_end = half_arc + self.strand
        return 0.0, half_arc, upper_end, self.length - upper_end, self.length - half_arc, self.length

    def radius(self, pulley: str) -> float:
        """Centre-line radius on `primary` or `secondary`, m."""
        return self.primary_radius if pulley == "primary" else self.secondary_radius

    def arc_length(self, pulley: str) -> float:
        """Length of the arc on `primary` or `secondary`, m."""
        half_angle = np.pi - self.phi if pulley == "primary" else self.phi
        return 2.0 * float(half_angle) * self.radius(pulley)

    def from_middle(self, pulley: str, xi: ArrayLike) -> Array:
        """Distances of places ξ from the middle of a pulley's arc, in the direction of ξ, −L/2 to L/2, m."""
        opposite = 0.0 if pulley == "primary" else 0.5 * self.length
        return np.mod(np.asarray(xi, dtype=float) - opposite, self.length) - 0.5 * self.length

    def push_force_gains(self, position: Array, push_force: Array) -> tuple[float, float, float]:
        """Change of the push force over the primary arc, the push strand and the secondary arc, N."""
        _, upper_start, upper_end, lower_start, lower_end, _ = self.borders
        places = [upper_end - EDGE, lower_start + EDGE, lower_end - EDGE, upper_start + EDGE]
        upper, between, lower = np.diff(np.interp(places, position, push_force)).tolist()
        return upper, between, lower
