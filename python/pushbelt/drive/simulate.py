"""The loop: driver, car, controllers and hydraulics around the FMU, a communication step at a time."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from pushbelt.fmu.data import parameter_set, slip_torque
from pushbelt.fmu.enumerations import RingModel
from pushbelt.fmu.geometry import Array
from pushbelt.fmu.results import BeltState
from pushbelt.fmu.unit import Archive, UnitError, Variator

from .car import Car
from .control import Friction, Measured
from .cycle import Cycle
from .hydraulics import PressureCircuit
from .thrust_map import ThrustMap
from .transmission import RATIO_LIMITS, START_PRESSURE, ClampingSignals, TransmissionControl
from .vehicle import Vehicle, VehicleSignals

STEP = 0.01
"""Communication and control step unless a set-up has its own, s."""
MESHES: Mapping[str, Mapping[str, float]] = {
    "coarse": {"mesh.primaryArc": 12, "mesh.secondaryArc": 12, "mesh.strand": 6, "solver.tolerance": 1e-3},
    "default": {},
}
"""Start values by name: for long runs, and the FMU's own."""

LOSSES = ("sheaves", "ring", "layers", "spin", "shafts", "other")
"""Parts of the variator's loss, by the names of the FMU's outputs without their `loss.`; together they are `loss.total`."""

OUTPUTS = (
    "primary.speed",
    "secondary.speed",
    "ratio.geometric",
    "slip",
    "primary.radius",
    "thrustRatio",
    "torqueUtilisation",
    "primary.shaftTorque",
    "primary.axialForce",
    "secondary.axialForce",
    "primary.power",
    "secondary.power",
    "loss.total",
    *(f"loss.{part}" for part in LOSSES),
    "stored.energy",
    "energy.residual",
    "reference.theta",
    "pushForce.max",
)
"""FMU variables that are recorded."""

INPUTS = ("primary.torque", "secondary.torque", "primary.clampingForce", "secondary.clampingForce")
"""Inputs of the FMU."""

VARIATOR = "bench168"
"""Parameter set of the drives."""

Outputs = Mapping[str, float]


@dataclass(frozen=True)
class Setup:
    """What to run."""

    name: str
    strategy: str
    """`safety` for the fixed safety factor or `slip` for slip control."""
    cycle: Cycle
    ring: str = "ALE"
    mesh: str = "coarse"
    snapshots: tuple[float, ...] = ()
    """Times of the whole cycle at which the fields along the belt are recorded, s."""
    friction: float = 1.0
    """Friction of the belt as a share of what the controllers assume."""
    variator: str = VARIATOR
    """Parameter set, or its file."""
    step: float = STEP
    """Communication and control step, s."""
    parallel: bool = False
    """Whether vehicle, control and FMU step side by side, as units in a master do: each gets the others' signals of the
    step before, and holds them. Otherwise they step one after the other, each with the latest signals, and torques and
    forces reach their new values at the end of the step, in proportion to time."""


@dataclass(frozen=True)
class Run:
    """What came out."""

    setup: Setup
    time: Array
    """Of the whole cycle, s, shape (n,)."""
    columns: Mapping[str, Array]
    """By name, each of shape (n,), SI units."""
    snapshots: Mapping[float, BeltState]
    """By time of the whole cycle, s."""
    interventions: int
    processor_time: float
    """Of the run, s."""
    messages: tuple[str, ...] = field(default=())
    """Warnings of the FMU."""

    def __getitem__(self, name: str) -> Array:
        return self.columns[name]

    def energies(self) -> dict[str, float]:
        """Work and losses over the run, J: where the engine's work went."""
        step, speed = self.setup.step, self["speed.car"]
        engine = self["work.engine"]
        losses = {part: step * float(self[f"loss.{part}"].sum()) for part in LOSSES}
        return {
            "engine, driving": float(engine[engine > 0.0].sum()),
            "engine, braking": float(-engine[engine < 0.0].sum()),
            "variator": sum(losses.values()),
            **{f"variator, {part}": loss for part, loss in losses.items()},
            "launch clutch": float(self["loss.clutch"].sum()),
            "road load": step * float((self["force.road"] * speed).sum()),
            "brakes": step * float((self["force.brake"] * speed).sum()),
        }

    @property
    def loss(self) -> Array:
        """Loss of the variator over time, W, shape (n,)."""
        return np.sum([self[f"loss.{part}"] for part in LOSSES], axis=0)

    @property
    def variator_loss(self) -> float:
        """J."""
        return self.energies()["variator"]


def unit_parameters(car: Car, ring: str, mesh: str, variator: str = VARIATOR) -> dict[str, float]:
    """Start values of the FMU: a parameter set with the car's inertia on the secondary shaft; the ring model by name."""
    parameters = parameter_set(variator)
    parameters["secondary.inertia"] += car.inertia
    model = RingModel[ring]
    chosen = dict(MESHES[mesh])
    if model == RingModel.ALE0:
        # One cell an element instead of two: the same cells.
        chosen |= {name: 2 * count for name, count in chosen.items() if name.startswith("mesh.")}
    return {**parameters, "ring.model": model, **chosen}


class Record:
    """What is recorded of a run, a row a communication step."""

    def __init__(self, setup: Setup, friction: Friction, count: int) -> None:
        self._friction = friction
        self._outputs = np.empty((count, len(OUTPUTS)))
        self._signals: list[Mapping[str, float]] = []
        start, step = setup.cycle.start, setup.step
        self._moments = {round((moment - start) / step): moment for moment in setup.snapshots}
        self.snapshots: dict[float, BeltState] = {}

    def add(self, unit: Variator, outputs: Outputs, vehicle: VehicleSignals, clamping: ClampingSignals) -> None:
        """Adds what holds at a communication point, and the signals over the step after it."""
        k = len(self._signals)
        self._outputs[k] = [outputs[name] for name in OUTPUTS]
        self._signals.append(
            {
                **_columns(vehicle, clamping),
                "macroSlip": outputs["macroSlip"],
                "utilisation.signed": self._utilisation(outputs),
            }
        )
        if k in self._moments:
            self.snapshots[self._moments[k]] = BeltState(unit.outputs(), unit.profile())

    def _utilisation(self, outputs: Outputs) -> float:
        """Torque utilisation with the sign of the torque, by the friction that the controllers assume."""
        belt = self._friction
        capacity = slip_torque(
            belt.coefficient, belt.wedge_angle, outputs["secondary.axialForce"], outputs["primary.radius"]
        )
        return -outputs["primary.shaftTorque"] / max(capacity, 1e-3)

    def columns(self) -> dict[str, Array]:
        """All columns by name."""
        columns = {name: self._outputs[:, k] for k, name in enumerate(OUTPUTS)}
        signals = {name: np.array([float(row[name]) for row in self._signals]) for name in self._signals[0]}
        return columns | signals


def _columns(vehicle: VehicleSignals, clamping: ClampingSignals) -> dict[str, float]:
    """Signals as they are recorded; `work.` and `loss.` in J per step."""
    return {
        "speed.target": vehicle.target_speed,
        "speed.car": vehicle.speed,
        "ratio.target": clamping.target_ratio,
        "engine.speed": vehicle.engine_speed,
        "engine.torque": vehicle.engine_torque,
        "clutch.torque": vehicle.primary_torque,
        "clutch.locked": vehicle.clutch_locked,
        "force.brake": vehicle.brake_force,
        "force.road": vehicle.road_load,
        "primary.clampingForce": clamping.primary_force,
        "secondary.clampingForce": clamping.secondary_force,
        "intervening": clamping.intervening,
        "work.engine": vehicle.engine_work,
        "loss.clutch": vehicle.clutch_loss,
    }


def run(
    archive: Archive,
    car: Car,
    thrust_map: ThrustMap,
    setup: Setup,
    progress: Callable[[float], None] = lambda _: None,
) -> Run:
    """Runs a set-up from standstill to the end of its cycle; `progress` gets simulated seconds as they pass.

    Raises UnitError if the FMU refuses a step, with the time.
    """
    parameters = unit_parameters(car, setup.ring, setup.mesh, setup.variator)
    friction = Friction(parameters["friction.pulley"], parameters["geometry.wedgeAngle"])
    vehicle = Vehicle(car, setup.cycle)
    control = TransmissionControl(car, setup.strategy, friction, thrust_map)
    count = round(setup.cycle.duration / setup.step)
    record = Record(setup, friction, count)
    begin = clock.process_time()
    start = {**parameters, **at_rest(), "friction.pulley": setup.friction * friction.coefficient}
    with Variator(archive, start) as unit:
        unit.initialise()
        _advance(unit, vehicle, control, setup, record, count, progress)
        messages = tuple(unit.warnings)
    return Run(
        setup=setup,
        time=setup.cycle.start + np.arange(count) * setup.step,
        columns=record.columns(),
        snapshots=record.snapshots,
        interventions=control.interventions,
        processor_time=clock.process_time() - begin,
        messages=messages,
    )


def _advance(
    unit: Variator,
    vehicle: Vehicle,
    control: TransmissionControl,
    setup: Setup,
    record: Record,
    count: int,
    progress: Callable[[float], None],
) -> None:
    """The loop: `count` communication steps from standstill on."""
    step = setup.step
    outputs, inputs = unit.reals(OUTPUTS), unit.reals(INPUTS)
    signals = VehicleSignals(), control.signals
    before = _input_values(*signals)
    for k in range(count):
        time = k * step
        state = dict(zip(OUTPUTS, unit.get_reals(outputs).tolist(), strict=True))
        state["macroSlip"] = unit.get("macroSlip")
        earlier = signals
        driving = vehicle.advance(
            time, state["primary.speed"], state["secondary.speed"], state["ratio.geometric"], step
        )
        known = earlier[0] if setup.parallel else driving
        measured = Measured.from_signals(state, known.estimated_torque)
        signals = driving, control.advance(known.power_demand, state["secondary.speed"], measured, step)
        record.add(unit, state, *signals)

        # Ramps need one step of the FMU, jumps several with ten times the work.
        after = _input_values(*(earlier if setup.parallel else signals))
        course = after if setup.parallel else before
        unit.set_ramps(inputs, course, [(end - start) / step for start, end in zip(course, after, strict=True)])
        before = after
        try:
            unit.step_to((k + 1) * step)
        except UnitError as error:
            raise UnitError(f"{setup.name}, from {setup.cycle.start + time:.2f} s on: {error}") from error
        progress(step)


def at_rest() -> dict[str, float]:
    """Start values of the FMU in the standing car."""
    signals = VehicleSignals()
    force = PressureCircuit(START_PRESSURE).force
    return {
        "initial.ratio": RATIO_LIMITS[1],
        "initial.primarySpeed": 0.0,
        "primary.torque": signals.primary_torque,
        "secondary.torque": signals.secondary_torque,
        "primary.clampingForce": force,
        "secondary.clampingForce": force,
    }


def _input_values(vehicle: VehicleSignals, clamping: ClampingSignals) -> tuple[float, ...]:
    """Values of `INPUTS`."""
    return vehicle.primary_torque, vehicle.secondary_torque, clamping.primary_force, clamping.secondary_force
