"""Results of the demo's simulations as plain data, in SI units. Keys of mappings are names of FMU variables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pushbelt.fmu.data import EfficiencyPoint
from pushbelt.fmu.results import LoadCaseResult, Profile, Trace


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
    manoeuvre: ManoeuvreResult
    parameters: Mapping[str, float]
    """Parameters of the variator in the load cases and the manoeuvre."""
    units: Mapping[str, str]
    """Units of the FMU's variables by name."""
    variator: str
    """Name or file of the parameter set of the load cases and the manoeuvre."""
