"""Results of simulations as plain data, in SI units. Keys of mappings are names of FMU variables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .geometry import Array


@dataclass(frozen=True)
class Profile:
    """Fields along the belt, one value per place."""

    position: Array
    """Place ξ on the ring's centre line, m."""
    push_force: Array
    """Push force between the elements, N."""
    ring_tension: Array
    """Tension of the ring, N."""
    normal_force: Array
    """Normal force per flank and unit of length, N/m."""
    radial_deviation: Array
    """Radius minus the mean radius of the arc; on strands the distance from the tangent line, outward positive, m."""
    sliding_speed: Array
    """Tangential sliding speed of the flanks, m/s; 0 off the pulleys."""
    gap: Array
    """Gap between neighbouring elements, m; 0 in contact."""


@dataclass(frozen=True)
class BeltState:
    """Outputs and fields of the FMU at one time."""

    outputs: Mapping[str, float]
    profile: Profile

    def __getitem__(self, name: str) -> float:
        return self.outputs[name]


@dataclass(frozen=True)
class SteadyState(BeltState):
    """A steady state of the FMU at a specified belt torque."""

    load_torque: float
    """Secondary torque of the steady state, N·m."""


@dataclass(frozen=True)
class LoadCase:
    """One of the nine load cases."""

    ratio_name: str
    """`overdrive`, `medium` or `underdrive`."""
    theta: float
    """Ratio coordinate."""
    torque: float
    """Steady belt torque on the primary pulley, N·m."""
    clamping_force: float
    """Secondary clamping force, N."""

    @property
    def name(self) -> str:
        """E.g. `overdrive-30`."""
        return f"{self.ratio_name}-{self.torque:g}"


@dataclass(frozen=True)
class LoadCaseResult:
    """A load case and its steady state."""

    case: LoadCase
    steady: SteadyState
    drift: float
    """Relative change of the thrust ratio when the simulation continues from the steady state."""


@dataclass(frozen=True)
class Trace:
    """A simulated run: time and one column per variable, Booleans as 0 and 1."""

    time: Array
    columns: Mapping[str, Array]

    def __getitem__(self, name: str) -> Array:
        return self.columns[name]
