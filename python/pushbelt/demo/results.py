"""Results of the demo's simulations as plain data, in SI units. Keys of mappings are names of FMU variables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pushbelt.fmu.data import EfficiencyPoint
from pushbelt.fmu.results import LoadCaseResult, Profile, SteadyState, Trace


@dataclass(frozen=True)
class StrandForces:
    """Net forces of the strands (ring tension minus push force), means over the middle half, N."""

    upper: float
    lower: float


@dataclass(frozen=True)
class Variant:
    """The reference case with one change."""

    name: str
    thrust_ratio: float
    strands: StrandForces
    slip: float


@dataclass(frozen=True)
class ReferenceResult:
    """The published reference case: published values, its theory, and results of the FMU."""

    published: Mapping[str, float]
    theory: Mapping[str, float]
    """The published theory, evaluated in closed form."""
    computed: Mapping[str, float]
    without_flank_friction: Mapping[str, float]
    """Axial forces that the FMU's strand forces would require without friction along the flanks, by pulley, N."""
    steady: SteadyState
    variants: tuple[Variant, ...] = ()


@dataclass(frozen=True)
class MeasuredPoint:
    """A measured point of a transmission, and the FMU at the same ratio, speed and torque."""

    measured: EfficiencyPoint
    clamping_force: float
    """Secondary clamping force, N; that of the measurement is unknown."""
    efficiency: float
    """Efficiency of the FMU between the shafts."""
    spin: float
    """Loss of turning elements, an upper bound, over the power of the driving shaft."""

    @property
    def margin(self) -> float:
        """Efficiency of the FMU minus the measured one."""
        return self.efficiency - self.measured.efficiency

    @property
    def margin_without_spin(self) -> float:
        """The same without the loss of turning elements."""
        return self.margin + self.spin


@dataclass(frozen=True)
class ManoeuvreResult:
    """The manoeuvre."""

    trace: Trace
    wall_time: float
    """Wall-clock time of the run, including reading all outputs at every step, s."""
    step: float
    """Communication step, s."""
    snapshots: Mapping[float, Profile]
    """Fields along the belt, by time, s."""
    messages: tuple[str, ...] = ()
    """Warnings of the FMU."""


@dataclass(frozen=True)
class DemoResults:
    """All results of the demo."""

    fmu_version: str
    """Version in the model description."""
    cases: tuple[LoadCaseResult, ...]
    measured: tuple[MeasuredPoint, ...]
    """The FMU at the points of a measured transmission."""
    reference: ReferenceResult
    manoeuvre: ManoeuvreResult
    parameters: Mapping[str, float]
    """Parameters of the variator in the load cases and the manoeuvre."""
    units: Mapping[str, str]
    """Units of the FMU's variables by name."""
    variator: str
    """Name or file of the parameter set of the load cases and the manoeuvre."""
