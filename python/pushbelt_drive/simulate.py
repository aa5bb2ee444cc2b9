"""The loop: driver, car, controllers and hydraulics around the FMU, a communication step at a time."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from pushbelt_demo.data import parameter_set
from pushbelt_demo.geometry import Array
from pushbelt_demo.results import Profile, SteadyState
from pushbelt_demo.unit import RING_MODELS, Archive, UnitError, Variator

from .car import Car, Powertrain
from .control import ClampingStrategy, Friction, Measured, RatioControl, SafetyFactor, SlipControl
from .cycle import Cycle
from .driver import Driver
from .hydraulics import PressureCircuit
from .thrust_map import ThrustMap

STEP = 0.01
"""Communication and control step, s."""
RATIO_LIMITS = 0.46, 2.2
"""Ratios that the strategy asks for."""
MESHES: Mapping[str, Mapping[str, float]] = {
    "coarse": {"mesh.primaryArc": 8, "mesh.secondaryArc": 8, "mesh.strand": 4, "solver.tolerance": 1e-3},
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
    """Times at which the fields along the belt are kept, s."""
    friction: float = 1.0
    """Friction of the belt as a share of what the controllers believe."""


@dataclass(frozen=True)
class Run:
    """What came out."""

    setup: Setup
    time: Array
    """s, shape (n,)."""
    columns: Mapping[str, Array]
    """By name, each of shape (n,), SI units."""
    snapshots: Mapping[float, SteadyState]
    interventions: int
    wall_time: float
    """s."""
    messages: tuple[str, ...] = field(default=())
    """Warnings of the FMU."""

    def __getitem__(self, name: str) -> Array:
        return self.columns[name]

    def energies(self) -> dict[str, float]:
        """Work and losses over the run, J: where the engine's work went."""
        step, speed = STEP, self["speed.car"]
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
    return {**parameters, "ring.model": RING_MODELS[ring], **MESHES[mesh]}


def ratio_target(engine_speed: float, secondary_speed: float, before: float, step: float) -> float:
    """Target ratio that lets the engine run at a wanted speed; it moves by at most 120 % a second."""
    wanted = engine_speed / max(secondary_speed, 1.0)
    change = float(np.clip(math.log(np.clip(wanted, *RATIO_LIMITS) / before), -1.2 * step, 1.2 * step))
    return before * math.exp(change)


def strategy_of(name: str, friction: Friction, thrust_map: ThrustMap) -> ClampingStrategy:
    """The clamping strategy of a set-up."""
    if name == "slip":
        return SlipControl(friction, thrust_map)
    return SafetyFactor(friction)


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
    clamping = strategy_of(setup.strategy, friction, thrust_map)
    hydraulics = {"primary": PressureCircuit(pressure=8e5), "secondary": PressureCircuit(pressure=8e5)}
    shifting = RatioControl(friction, thrust_map, hydraulics["primary"].limits)
    powertrain, driver = Powertrain(car), Driver(car, setup.cycle)
    steps = round(setup.cycle.duration / STEP)
    table = np.empty((steps, len(READ)))
    added = {name: np.zeros(steps) for name in ADDED}
    kept = {round(moment / STEP): moment for moment in setup.snapshots}
    snapshots: dict[float, SteadyState] = {}
    target, power = RATIO_LIMITS[1], 0.0
    begin = clock.perf_counter()
    start = {
        **parameters,
        "friction.pulley": setup.friction * friction.coefficient,
        "initial.ratio": target,
        "initial.primarySpeed": 0.0,
        "primary.torque": 0.0,
        "secondary.torque": 0.0,
        **{f"{pulley}.clampingForce": circuit.force for pulley, circuit in hydraulics.items()},
    }
    with Variator(archive, start) as unit:
        unit.initialise()
        reader = unit.reader(READ)
        for step in range(steps):
            time = step * STEP
            state = dict(zip(READ, unit.read(reader).tolist(), strict=True))
            macro_slip = unit.flag("macroSlip")
            pulley, ratio = state["primary.speed"], state["ratio.geometric"]
            speed = car.lever * state["secondary.speed"]

            demand = driver.demand(time, speed, STEP)
            wanted_torque = demand.force * car.lever / ratio
            clutch = powertrain.advance(wanted_torque, pulley, STEP)
            overrun = car.drag_torque(powertrain.speed) * ratio / car.lever if powertrain.locked else 0.0
            brake = car.brake_force(max(-demand.force + overrun, 0.0), speed, STEP)
            road = car.road_load(speed)

            power += (demand.power - power) * STEP / (0.3 if demand.power > power else 1.5)
            target = ratio_target(car.engine_speed_for(power), state["secondary.speed"], target, STEP)
            expected = min(max(wanted_torque, 0.0), car.full_load(powertrain.speed)) if pulley > 20.0 else 0.0
            measured = Measured(
                primary_speed=pulley,
                ratio=ratio,
                slip=state["slip"],
                macro_slip=macro_slip,
                pitch_radius=state["primary.radius"],
                torque=math.copysign(max(abs(clutch), expected), clutch),
            )
            secondary = clamping.force(measured, STEP)
            demands = dict(
                zip(("primary", "secondary"), shifting.forces(target, measured, secondary, STEP), strict=True)
            )
            forces = {pulley: circuit.advance(demands[pulley], STEP) for pulley, circuit in hydraulics.items()}

            table[step] = list(state.values())
            capacity = max(2.0 * friction.coefficient * state["secondary.axialForce"] * state["primary.radius"], 1e-3)
            values = (
                setup.cycle.at(time),
                speed,
                target,
                powertrain.speed,
                powertrain.torque,
                clutch,
                powertrain.locked,
                brake,
                road,
                forces["primary"],
                forces["secondary"],
                macro_slip,
                clamping.intervening,
                -state["primary.shaftTorque"] * math.cos(friction.wedge_angle) / capacity,
                powertrain.engine_work,
                powertrain.clutch_loss,
            )
            for name, value in zip(ADDED, values, strict=True):
                added[name][step] = value
            if step in kept:
                snapshots[kept[step]] = _snapshot(unit)

            unit.set(
                {
                    "primary.torque": clutch,
                    "secondary.torque": -car.lever * (road + brake),
                    **{f"{pulley}.clampingForce": force for pulley, force in forces.items()},
                }
            )
            try:
                unit.step_to((step + 1) * STEP)
            except UnitError as error:
                raise UnitError(f"{setup.name}, from {time:.2f} s on: {error}") from error
            progress(STEP)
        messages = tuple(unit.warnings)
    return Run(
        setup=setup,
        time=np.arange(steps) * STEP,
        columns={**{name: table[:, k] for k, name in enumerate(READ)}, **added},
        snapshots=snapshots,
        interventions=getattr(clamping, "interventions", 0),
        wall_time=clock.perf_counter() - begin,
        messages=messages,
    )


def _snapshot(unit: Variator) -> SteadyState:
    """Outputs and fields now, in the form that the demo draws."""
    profile: Profile = unit.profile()
    return SteadyState(unit.outputs(), profile, load_torque=math.nan, evaluations=0, solve_time=0.0)
