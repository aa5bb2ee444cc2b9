"""The runs of the report, in parallel processes with a progress bar, and the standard deviation of their losses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from pushbelt.errors import ArgumentError
from pushbelt.fmu.data import known_deviations
from pushbelt.fmu.files import default_fmu
from pushbelt.fmu.results import largest
from pushbelt.fmu.unit import Archive, refuse_others
from pushbelt.maps.data import Maps
from pushbelt.points import SteadyStateError
from pushbelt.report import side_by_side
from pushbelt.report.side_by_side import tick
from pushbelt.variator import Variator

from . import simulate
from .cycle import CYCLES, titled
from .measure import measure
from .simulate import Run, Setup
from .thrust_map import ThrustMap
from .vehicle import Car, demo_car

LOW_FRICTION = 0.7  # Friction in the runs with low friction, relative to the coefficient that the controllers assume
FRAMES = 600  # Largest number of times in a drive at which the belt is recorded
STATES = 16  # Number of times of a run whose steady states are changed; each has the same share of the losses


def moments(start: float, stop: float) -> tuple[float, ...]:
    """Evenly spaced communication points of a drive."""
    steps = round((stop - start) / simulate.STEP)
    return tuple(start + k * simulate.STEP for k in range(0, steps, -(-steps // FRAMES)))


@dataclass(frozen=True)
class Plan:
    cycle: tuple[float, float]  # Section of the cycle for both clamping strategies, s
    close_up: tuple[float, float]  # Section that is repeated on the FMU's default mesh, s
    ring: str = "ALE"  # Ring model of the runs on the coarse mesh
    low_friction: tuple[float, float] = (10.0, 20.0)
    """Section for both strategies with less friction than they assume, s."""
    trace: str = "wltc"  # The cycle, a name in `CYCLES` or a file
    car: Car = field(default_factory=demo_car)
    variator: str = simulate.VARIATOR  # Name or file of the parameter set
    clamping: float = 1.0  # Factor on the secondary clamping force that the strategies demand
    maps: Path | None = None  # File of maps from which the controllers take their map; None to measure it on the FMU

    @property
    def title(self) -> str:
        return titled(self.trace)[0]

    def setups(self, belt: bool = True) -> tuple[Setup, ...]:
        """Fixed safety factor, slip control, close-up of a `belt` with slip control, both strategies with low friction."""
        whole = titled(self.trace)[1]
        cycle, slippery = whole.section(*self.cycle), whole.section(*self.low_friction)
        setups = (
            Setup("fixed safety factor", "safety", cycle, self.ring, "coarse"),
            Setup("slip control", "slip", cycle, self.ring, "coarse", moments(*self.cycle) if belt else ()),
            *[Setup("close-up", "slip", whole.section(*self.close_up), "ALE", "default")] * belt,
            *(Setup(f"low friction, {strategy}", strategy, slippery, friction=LOW_FRICTION) for strategy in ("safety", "slip")),
        )
        return tuple(replace(setup, variator=self.variator, clamping=self.clamping) for setup in setups)


FULL = {"wltc": Plan((0.0, 1800.0), (1478.0, 1598.0)), "nedc": Plan((0.0, 1180.0), (780.0, 900.0), trace="nedc")}
"""The whole cycle; the first 120 s of its last part as close-up, with the launch and the largest torques."""
SHORT = {"wltc": Plan((10.0, 40.0), (10.0, 20.0)), "nedc": Plan((10.0, 40.0), (10.0, 20.0), trace="nedc")}


def plan(trace: str, short: bool = False) -> Plan:
    """The plan of a cycle. That of a file begins where the car first moves, but for the whole cycle."""
    if trace in CYCLES:
        return (SHORT if short else FULL)[trace]
    whole = titled(trace)[1]
    end = round(whole.duration // simulate.STEP * simulate.STEP, 9)
    start = float(np.floor(whole.time[np.argmax(whole.speed > 0.0) - 1]))
    section, close_up, low_friction = ((start, min(start + length, end)) for length in (30.0, 10.0 if short else 120.0, 10.0))
    return Plan(section if short else (0.0, end), close_up, low_friction=low_friction, trace=trace)


@dataclass(frozen=True)
class Results:
    plan: Plan
    version: str
    units: Mapping[str, str]  # Units of the columns of the runs by name
    thrust_map: ThrustMap
    runs: Sequence[Run]  # In the order of `Plan.setups`


def run_all(fmu: Path, plan: Plan, cache: Path) -> Results:
    """Runs a plan with an FMU of the belt or of maps; the controllers' maps are stored in the folder `cache`."""
    with Archive.unpack(fmu) as archive:
        refuse_others(fmu, archive.description)
        belt = "ring.model" in archive.variables
        setups = plan.setups(belt)
        # An FMU of maps has no shift rates to measure: its belt is that of the package's FMU.
        maps = {ring: _map(fmu if belt else default_fmu(), plan, ring, cache) for ring in {setup.ring for setup in setups}}
        calls = [(simulate.run, (archive, plan.car, maps[setup.ring], setup, tick)) for setup in setups]
        done = side_by_side.run_all(calls, round(sum(setup.cycle.duration for setup in setups)), "driving", len(setups))
        units = {**dict.fromkeys(map("loss.{}".format, simulate.LOSSES), "W"), **archive.units, **simulate.SIGNALS}
        return Results(plan, archive.version, units, maps[plan.ring], done)


def _map(fmu: Path, plan: Plan, ring: str, cache: Path) -> ThrustMap:
    if plan.maps is not None:
        return ThrustMap.of_maps(Maps.read(plan.maps))
    parameters = simulate.unit_parameters(demo_car(), ring, "coarse", plan.variator)
    return ThrustMap.of_maps(measure(fmu, parameters, cache))


def band_of_losses(fmu: Path, run: Run) -> tuple[float, list[str]]:
    """Relative standard deviation of the variator's lost energy under the forces of the run, and the three parameters of most of it."""
    deviations = known_deviations(run.setup.variator)
    energy, found = np.cumsum(run["loss.total"]), []
    rows = np.searchsorted(energy, energy[-1] * (np.arange(STATES) + 0.5) / STATES)
    with Variator(run.setup.variator, fmu=fmu) as belt:
        for row in rows:
            torque, speed, force = (float(run[name][row]) for name in ("primary.shaftTorque", "primary.speed", "secondary.clampingForceTotal"))
            try:
                one = belt.bands(float(run["ratio.geometric"][row]), -torque, deviations, speed=speed, force=force)
            except SteadyStateError:
                continue
            found.append(one.chords["loss.total"] / one.outputs["loss.total"])
    if not found:
        raise ArgumentError(f"--bands: {run.setup.name} has no steady states near its {STATES} times")
    chords = np.mean(found, axis=0)
    return float(np.linalg.norm(chords)), largest(deviations, np.abs(chords))
