"""The loop: driver, car, controllers and hydraulics around the FMU, a communication step at a time."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from pushbelt.fmu.data import parameter_set, slip_torque
from pushbelt.fmu.geometry import Array
from pushbelt.fmu.results import Profile, SteadyState
from pushbelt.fmu.unit import RING_MODELS, Archive, UnitError, Variator

from .car import Car
from .control import Friction, Measured
from .cycle import Cycle
from .hydraulics import PressureCircuit
from .thrust_map import ThrustMap
from .transmission import RATIO_LIMITS, START_PRESSURE, ClampingSignals, TransmissionControl
from .vehicle import Vehicle, VehicleSignals

STEP = 0.01
"""Communication and control step unless a set-up says otherwise, s."""
MESHES: Mapping[str, Mapping[str, float]] = {
    "coarse": {"mesh.primaryArc": 12, "mesh.secondaryArc": 12, "mesh.strand": 6, "solver.tolerance": 1e-3},
    "default": {},
}
"""Start values by name: for long runs, and the FMU's own."""

READ = (
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
    "loss.sheaves",
    "loss.ring",
    "loss.other",
    "stored.energy",
    "energy.residual",
    "reference.theta",
    "pushForce.max",
)
"""FMU variables that are kept over time."""

STEERED = ("primary.torque", "secondary.torque", "primary.clampingForce", "secondary.clampingForce")
"""Inputs of the FMU."""

ADDED = (
    "speed.target",
    "speed.car",
    "ratio.target",
    "engine.speed",
    "engine.torque",
    "clutch.torque",
    "clutch.locked",
    "force.brake",
    "force.road",
    "primary.clampingForce",
    "secondary.clampingForce",
    "macroSlip",
    "intervening",
    "utilisation.signed",
    "work.engine",
    "loss.clutch",
)
"""What is kept beside them; `work.` and `loss.clutch` in J per step."""


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
    """Times of the whole cycle at which the fields along the belt are kept, s."""
    friction: float = 1.0
    """Friction of the belt as a share of what the controllers believe."""
    step: float = STEP
    """Communication and control step, s."""
    parallel: bool = False
    """Whether vehicle, control and FMU step side by side, each with what the others gave a step before and holds, as units
    in a master do; otherwise one after the other, each with what is known by then, and torques and forces reach what was
    decided at the end of the step, in proportion to time."""


@dataclass(frozen=True)
class Run:
    """What came out."""

    setup: Setup
    time: Array
    """Of the whole cycle, s, shape (n,)."""
    columns: Mapping[str, Array]
    """By name, each of shape (n,), SI units."""
    snapshots: Mapping[float, SteadyState]
    """By time of the whole cycle, s."""
    interventions: int
    processor_time: float
    """That it took, s."""
    messages: tuple[str, ...] = field(default=())
    """Warnings of the FMU."""

    def __getitem__(self, name: str) -> Array:
        return self.columns[name]

    def energies(self) -> dict[str, float]:
        """Work and losses over the run, J: where the engine's work went."""
        step, speed = self.setup.step, self["speed.car"]
        engine = self["work.engine"]
        losses = {part: step * float(self[f"loss.{part}"].sum()) for part in ("sheaves", "ring", "other")}
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
    def variator_loss(self) -> float:
        """J."""
        return self.energies()["variator"]


def unit_parameters(car: Car, ring: str, mesh: str) -> dict[str, float]:
    """Start values of the FMU: `bench168` with the car's inertia on the secondary shaft."""
    parameters = parameter_set("bench168")
    parameters["secondary.inertia"] += car.inertia
    chosen = dict(MESHES[mesh])
    if ring == "ALE0":
        # One cell an element instead of two: the same cells.
        chosen |= {name: 2 * count for name, count in chosen.items() if name.startswith("mesh.")}
    return {**parameters, "ring.model": RING_MODELS[ring], **chosen}


def run(
    archive: Archive,
    car: Car,
    thrust_map: ThrustMap,
    setup: Setup,
    progress: Callable[[float], None] = lambda _: None,
) -> Run:
    """Runs a set-up from standstill to the end of its cycle; `progress` hears of simulated seconds as they pass.

    Raises UnitError if the FMU refuses a step, with the time.
    """
    parameters = unit_parameters(car, setup.ring, setup.mesh)
    friction = Friction(parameters["friction.pulley"], parameters["geometry.wedgeAngle"])
    vehicle = Vehicle(car, setup.cycle)
    control = TransmissionControl(car, setup.strategy, friction, thrust_map)
    step, count = setup.step, round(setup.cycle.duration / setup.step)
    table = np.empty((count, len(READ)))
    added = {name: np.zeros(count) for name in ADDED}
    kept = {round((moment - setup.cycle.start) / step): moment for moment in setup.snapshots}
    snapshots: dict[float, SteadyState] = {}
    begin = clock.process_time()
    start = {**parameters, **at_rest(), "friction.pulley": setup.friction * friction.coefficient}
    with Variator(archive, start) as unit:
        unit.initialise()
        reader, steered = unit.reader(READ), unit.reader(STEERED)
        given, clamped = VehicleSignals(), control.signals
        before = _steering(given, clamped)
        for k in range(count):
            time = k * step
            state = dict(zip(READ, unit.read(reader).tolist(), strict=True))
            macro_slip = unit.flag("macroSlip")
            earlier = given, clamped
            given = vehicle.advance(
                time, state["primary.speed"], state["secondary.speed"], state["ratio.geometric"], step
            )
            told = earlier[0] if setup.parallel else given
            measured = Measured(
                primary_speed=state["primary.speed"],
                ratio=state["ratio.geometric"],
                slip=state["slip"],
                macro_slip=macro_slip,
                pitch_radius=state["primary.radius"],
                torque=told.estimated_torque,
            )
            clamped = control.advance(told.power_demand, state["secondary.speed"], measured, step)
            acting, closing = earlier if setup.parallel else (given, clamped)

            table[k] = list(state.values())
            capacity = slip_torque(
                friction.coefficient, friction.wedge_angle, state["secondary.axialForce"], state["primary.radius"]
            )
            utilisation = -state["primary.shaftTorque"] / max(capacity, 1e-3)
            for name, value in _added(given, clamped, macro_slip, utilisation).items():
                added[name][k] = value
            if k in kept:
                snapshots[kept[k]] = _snapshot(unit)

            # Without jumps the FMU takes one step where it else takes several, with ten times the work.
            after = _steering(acting, closing)
            course = after if setup.parallel else before
            unit.set_along(steered, course, [(end - start) / step for start, end in zip(course, after, strict=True)])
            before = after
            try:
                unit.step_to((k + 1) * step)
            except UnitError as error:
                raise UnitError(f"{setup.name}, from {setup.cycle.start + time:.2f} s on: {error}") from error
            progress(step)
        messages = tuple(unit.warnings)
    return Run(
        setup=setup,
        time=setup.cycle.start + np.arange(count) * step,
        columns={**{name: table[:, k] for k, name in enumerate(READ)}, **added},
        snapshots=snapshots,
        interventions=control.interventions,
        processor_time=clock.process_time() - begin,
        messages=messages,
    )


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


def _steering(given: VehicleSignals, clamped: ClampingSignals) -> tuple[float, ...]:
    """Values of `STEERED`."""
    return given.primary_torque, given.secondary_torque, clamped.primary_force, clamped.secondary_force


def _added(given: VehicleSignals, clamped: ClampingSignals, macro_slip: bool, utilisation: float) -> dict[str, float]:
    """What is kept beside the FMU's variables, in the order of `ADDED`."""
    values = (
        given.target_speed,
        given.speed,
        clamped.target_ratio,
        given.engine_speed,
        given.engine_torque,
        given.primary_torque,
        given.clutch_locked,
        given.brake_force,
        given.road_load,
        clamped.primary_force,
        clamped.secondary_force,
        macro_slip,
        clamped.intervening,
        utilisation,
        given.engine_work,
        given.clutch_loss,
    )
    return dict(zip(ADDED, values, strict=True))


def _snapshot(unit: Variator) -> SteadyState:
    """Outputs and fields now, in the form that the demo draws."""
    profile: Profile = unit.profile()
    return SteadyState(unit.outputs(), profile, load_torque=math.nan, evaluations=0, solve_time=0.0)
