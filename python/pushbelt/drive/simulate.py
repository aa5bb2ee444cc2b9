"""The simulation loop: driver, car, controllers and hydraulics around the FMU, advanced by communication steps."""

import math
import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from pushbelt.fmu.data import parameter_set, slip_torque
from pushbelt.fmu.enumerations import RingModel
from pushbelt.fmu.geometry import Array
from pushbelt.fmu.results import BeltState, Trace
from pushbelt.fmu.unit import Archive, Instance, UnitError

from . import vehicle
from .control import Friction, Measured
from .cycle import Cycle
from .thrust_map import ThrustMap
from .transmission import RATIO_LIMITS, START_PRESSURE, PressureCircuit, TransmissionControl
from .vehicle import Car, Vehicle

STEP = 0.01  # Default communication and control step, s
COARSE = {"mesh.primaryArc": 12, "mesh.secondaryArc": 12, "mesh.strand": 6, "solver.tolerance": 1e-3}
MESHES: Mapping[str, Mapping[str, float]] = {"coarse": COARSE, "accurate": COARSE | {"solver.tolerance": 1e-4}, "default": {}}
"""Start values by name of mesh: a coarse one for long runs, the same with a smaller error in time, and the FMU's default."""
LOSSES = ("sheaves", "ring", "layers", "joints", "spin", "shafts", "seals", "other")
"""Parts of the variator's loss: names of the FMU's outputs without the prefix `loss.`. Their sum is `loss.total`."""
OUTPUTS = (
    *"primary.speed secondary.speed ratio.geometric slip primary.radius thrustRatio torqueUtilisation primary.shaftTorque".split(),
    *"primary.axialForce secondary.axialForce secondary.clampingForceTotal primary.power secondary.power loss.total".split(),
    *(f"loss.{part}" for part in LOSSES),
    *"stored.energy energy.residual reference.theta pushForce.max ring.speed ring.stressMax".split(),
    *(f"ring.{kind}.{pulley}" for pulley in ("primary", "secondary") for kind in ("stressAmplitude", "stressMean")),
    "secondary.radius",
)
"""FMU variables that are recorded."""
SIGNALS: Mapping[str, str] = {
    **{name: unit for name, unit in vehicle.SIGNALS.items() if name not in ("secondary.torque", "torque.estimated", "power.demand")},
    **dict.fromkeys(("ratio.target", "intervening", "utilisation.signed"), "1"),
    "distance": "m",
}
"""Units of the recorded signals that are no variables of the FMU."""
OF_STEPS = ("work.engine", "loss.clutch")  # Signals that are energies of one step
COLUMNS = (*OUTPUTS, "macroSlip", "primary.pressure", "secondary.pressure", *SIGNALS)
INPUTS = {"primary.torque": "clutch.torque", **{name: name for name in ("secondary.torque", "primary.pressure", "secondary.pressure")}}
"""Inputs of the FMU, and the signal of each."""
VARIATOR = "bench168"  # Parameter set of the drives


@dataclass(frozen=True)
class Setup:
    name: str
    strategy: str  # `safety` for the fixed safety factor or `slip` for slip control
    cycle: Cycle
    ring: str = "ALE"
    mesh: str = "coarse"
    snapshots: tuple[float, ...] = ()  # Times of the whole cycle at which the fields along the belt are recorded, s
    friction: float = 1.0  # Friction coefficient of the belt relative to the one assumed by the controllers
    variator: str = VARIATOR  # Name or file of the parameter set
    clamping: float = 1.0  # Factor on the secondary clamping force that the strategy demands
    step: float = STEP  # Communication and control step, s
    parallel: bool = False
    """Whether vehicle, control and FMU step in parallel (Jacobi scheme), as units in an importer do: each uses the signals of the
    previous step and holds them. Otherwise they step in sequence (Gauss-Seidel scheme), each with the latest signals, and torques
    and forces vary linearly to their new values at the end of the step."""


@dataclass(frozen=True, repr=False)
class Run(Trace):
    """Recorded signals by name, in SI units, over the time in the whole cycle, s."""

    setup: Setup
    snapshots: Mapping[float, BeltState]  # Fields along the belt by time in the whole cycle, s
    interventions: int
    processor_time: float  # Processor time of the run, s
    messages: tuple[str, ...] = field(default=())  # Warnings of the FMU

    def energies(self) -> dict[str, float]:
        """Work and losses over the run, J."""
        step, speed, engine = self.setup.step, self["speed.car"], self["work.engine"]
        losses = {part: step * float(self[f"loss.{part}"].sum()) for part in LOSSES}
        return {
            "engine, driving": float(engine[engine > 0.0].sum()), "engine, braking": float(-engine[engine < 0.0].sum()),
            "variator": sum(losses.values()),
            **{f"variator, {part}": loss for part, loss in losses.items()},
            "launch clutch": float(self["loss.clutch"].sum()),
            **{name: step * float((self[f"force.{force}"] * speed).sum()) for name, force in (("road load", "road"), ("brakes", "brake"))},
        }  # fmt: skip

    @property
    def loss(self) -> Array:
        """Loss of the variator over time, W, shape (n,)."""
        return np.sum([self[f"loss.{part}"] for part in LOSSES], axis=0)

    @property
    def variator_loss(self) -> float:
        return self.energies()["variator"]


def unit_parameters(car: Car, ring: str, mesh: str, variator: str = VARIATOR) -> dict[str, float]:
    """Start values of the FMU: a parameter set with the car's inertia on the secondary shaft, pistons of the circuits and a ring model."""
    areas = {f"{pulley}.cylinder.area": PressureCircuit.area for pulley in ("primary", "secondary")}
    parameters = {**parameter_set(variator), **areas}
    parameters["secondary.inertia"] += car.inertia
    chosen = dict(MESHES[mesh])
    if RingModel[ring] == RingModel.ALE0:
        # One cell per element instead of two, so that the number of cells is the same.
        chosen |= {name: 2 * count for name, count in chosen.items() if name.startswith("mesh.")}
    return {**parameters, "ring.model": RingModel[ring], **chosen}


def run(archive: Archive, car: Car, thrust_map: ThrustMap, setup: Setup, progress: Callable[[float], None] = lambda _: None) -> Run:
    """Runs a set-up from standstill to the end of its cycle. `progress` is called with the simulated time of each step, s.
    Raises UnitError with the time if the FMU rejects a step."""
    parameters = unit_parameters(car, setup.ring, setup.mesh, setup.variator)
    friction = Friction(parameters["friction.pulley"], parameters["geometry.wedgeAngle"])
    control = TransmissionControl(car, setup.strategy, friction, thrust_map, setup.clamping)
    begin = clock.process_time()
    start = {**parameters, **at_rest(), "friction.pulley": setup.friction * friction.coefficient}
    known = archive.variables
    with Instance(archive, {name: value for name, value in start.items() if name in known}) as unit:
        unit.initialise()
        rows, snapshots = _advance(unit, Vehicle(car, setup.cycle), control, friction, setup, progress)
        messages = tuple(unit.warnings)
    columns = dict(zip(COLUMNS, rows.T, strict=True))
    driven = np.abs(columns["speed.car"])
    columns["distance"] = setup.step * (np.cumsum(driven) - driven)
    time = setup.cycle.start + np.arange(len(rows)) * setup.step
    return Run(time, columns, setup, snapshots, control.clamping.interventions, clock.process_time() - begin, messages)


def _advance(
    unit: Instance, car: Vehicle, control: TransmissionControl, friction: Friction, setup: Setup, progress: Callable[[float], None]
) -> tuple[Array, dict[float, BeltState]]:
    """The loop of communication steps from standstill on: `COLUMNS` at each point or over its step, and the belt at the set-up's times."""
    step, count, start = setup.step, round(setup.cycle.duration / setup.step), setup.cycle.start
    moments = {round((moment - start) / step): moment for moment in setup.snapshots}
    rows, snapshots = np.empty((count, len(COLUMNS))), {}
    outputs, inputs = unit.reals(name for name in OUTPUTS if name in unit.variables), unit.reals(INPUTS)
    signals = dict.fromkeys(vehicle.SIGNALS, 0.0) | control.signals
    before = [signals[name] for name in INPUTS.values()]
    for k in range(count):
        time = k * step
        state = dict(zip(outputs.names, unit.get_reals(outputs).tolist(), strict=True))
        state |= {"macroSlip": unit.get("macroSlip"), **_rest(state)}
        earlier = signals
        driving = car.advance(time, state["primary.speed"], state["secondary.speed"], state["ratio.geometric"], step)
        known = earlier if setup.parallel else driving
        measured = Measured.from_signals(state, known["torque.estimated"])
        signals = driving | control.advance(known["power.demand"], state["secondary.speed"], measured, step)
        # Utilisation for the friction that the controllers assume. A variator from maps has fewer outputs.
        capacity = slip_torque(friction.coefficient, friction.wedge_angle, state["secondary.axialForce"], state["primary.radius"])
        row = {**signals, **state, "utilisation.signed": -state["primary.shaftTorque"] / max(capacity, 1e-3)}
        rows[k] = [row.get(name, math.nan) for name in COLUMNS]
        if k in moments:
            snapshots[moments[k]] = BeltState(unit.outputs(), unit.profile())

        # A ramp takes one internal step of the FMU. A jump takes several, with ten times the work.
        held = earlier if setup.parallel else signals
        after = [held[name] for name in INPUTS.values()]
        course = after if setup.parallel else before
        unit.set_ramps(inputs, course, [(end - begin) / step for begin, end in zip(course, after, strict=True)])
        before = after
        try:
            unit.step_to((k + 1) * step)
        except UnitError as error:
            raise UnitError(f"{setup.name}, from {start + time:.2f} s on: {error}") from error
        progress(step)
    return rows, snapshots


def _rest(state: Mapping[str, float]) -> dict[str, float]:
    """Parts of the loss that a variator from maps does not have; `other` is what its total has beyond the rest."""
    names = [f"loss.{part}" for part in LOSSES]
    missing = dict.fromkeys((name for name in names if name not in state), 0.0)
    if missing:
        missing["loss.other"] = state["loss.total"] - sum(state.get(name, 0.0) for name in names)
    return missing


def at_rest() -> dict[str, float]:
    """Start values of the FMU in the standing car."""
    still = ("initial.primarySpeed", "primary.torque", "secondary.torque", "primary.clampingForce", "secondary.clampingForce")
    pressures = dict.fromkeys(("primary.pressure", "secondary.pressure"), START_PRESSURE)
    return {"initial.ratio": RATIO_LIMITS[1], **dict.fromkeys(still, 0.0), **pressures}
