"""Comparison with Exudyn: a belt on two pulleys under engine firing and under impacts into macro-slip, and the free ring.

pip install exudyn==1.11.0
python examples/peers/exudyn_belt_drive.py

It takes some minutes. Times are processor times of one thread, the least of `--runs`, measured alternately for both programs. The
variator runs in `examples/belt_drive.rs`, which cargo builds first, under the loads b and e of `cargo fmu bench -- --loads` at ratio 1.

The belt of Exudyn is flat: cables of absolute nodal coordinates in the Eulerian view (`--cable ale`), or travelling ones (`--cable ancf`), with the
mass of ring and elements, the stiffness of the ring and the mesh of the variator. It transmits tension instead of pressure. Friction is that of the wedge,
μ/sin β. By the Euler-Eytelwein equation, the pretension gives the same slip torque as the variator's clamping force.
"""

import argparse
import math
import subprocess
import sys
import time
from dataclasses import dataclass

sys.exudynFast = True  # Disables range checks. Exudyn reads this variable when it is imported.
import exudyn
import numpy as np
from exudyn.utilities import (
    ALECable2D,
    Cable2D,
    CoordinateConstraint,
    CoordinateSpringDamper,
    CreateSymbolicUserFunction,
    LoadCoordinate,
    MarkerBodyCable2DShape,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    NodeGenericData,
    NodeGenericODE2,
    NodePoint2DSlope1,
    NodePointGround,
    NodeRigidBody2D,
    ObjectContactFrictionCircleCable2D,
    ObjectRigidBody2D,
    SensorBody,
    SensorNode,
)

import exudyn_ring

# The variator `bench168` at ratio 1; SI units.
DISTANCE, LENGTH = 0.168, 0.703
RADIUS = (LENGTH - 2.0 * DISTANCE) / math.tau
ARC, STRAND = 16, 10
"""Number of elements on an arc and on a strand."""
AXIAL_STIFFNESS, BENDING_STIFFNESS, DAMPING = 5.57e6, 0.0159, 2.0e-5
MASS = 0.24 + 1.33
"""Mass of ring and elements, kg/m."""
FRICTION = 0.09 / math.sin(math.radians(11.0))
INERTIAS = (0.03, 4.0)
OF_SPEED = 2.0
"""Gain of the speed control of the vehicle, N·m·s/rad."""
SPEED = 209.44
# Assumptions for the penalty parameters of Exudyn.
SEGMENTS = 2
"""Number of contact segments per element."""
PENETRATION = 8.0e-5
"""Contact penetration under the pretension, m, similar to the radial displacement due to tilting sheaves."""
SETTLING, RISE, SETTLING_STEP = 0.2, 0.05, 5.0e-5
"""Time before the load starts, s, in which the mean torque rises and the belt reaches its speed."""
SAMPLE = 1.0e-3


def firing(t, sym):
    return 80.0 + 30.0 * sym.sin(math.tau * 70.0 * t)


def slam(t, sym):
    """Load that rises and falls over 1 ms, like the variator's inputs."""
    within = sym.mod(t, 1.0)
    up, down = (sym.max(0.0, sym.min((within - start) / 1.0e-3, 1.0)) for start in (0.0, 0.15))
    return 50.0 + 100.0 * (up - down)


@dataclass(frozen=True)
class Load:
    """Torque on the first pulley, its mean, and the capacity of the belt, N·m."""

    torque: object
    mean: float
    capacity: float


# In `e` the variator is clamped for 100 N·m. Because of its compliant contacts this belt carries one ninth more than by the
# Euler-Eytelwein equation.
LOADS = {"b": Load(firing, 80.0, 1.3 * 110.0), "e": Load(slam, 50.0, 90.0)}


def on_curve(s: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Point, tangent and curvature of the belt's line, counterclockwise from below the first pulley."""
    s, arc = s % LENGTH, math.pi * RADIUS
    half, s = divmod(s, DISTANCE + arc)
    turn = 1.0 - 2.0 * half
    middle = np.array([0.5 * DISTANCE, 0.0])
    if s < DISTANCE:
        place, tangent, curvature = np.array([s, -RADIUS]) - middle, np.array([1.0, 0.0]), 0.0
    else:
        angle = (s - DISTANCE) / RADIUS
        tangent = np.array([math.cos(angle), math.sin(angle)])
        place = middle + RADIUS * np.array([tangent[1], -tangent[0]])
        curvature = 1.0 / RADIUS
    return middle + turn * place, turn * tangent, curvature


def stations(ale: bool) -> np.ndarray:
    """Start points of the elements: those of the variator's mesh from the middle of a strand, or evenly spaced for a travelling belt."""
    if not ale:
        elements = 2 * (ARC + STRAND)
        return LENGTH * np.arange(elements) / elements
    half = np.append(DISTANCE * np.arange(STRAND) / STRAND, DISTANCE + math.pi * RADIUS * np.arange(ARC) / ARC)
    around = np.append(half, half + 0.5 * LENGTH)
    first = STRAND // 2
    return np.append(around[first:], around[:first] + LENGTH)


class Drive:
    """A belt on two pulleys in steady motion under the mean torque of a load."""

    def __init__(self, load: Load, ale: bool, creep: float, radius: float = 0.9):
        """`creep`: regularisation velocity of the friction, m/s. `radius`: spectral radius of generalised-α."""
        self.load, self.ale, self.creep, self.damped = load, ale, creep, radius
        self.container = exudyn.SystemContainer()
        self.system = self.container.AddSystem()
        grip = math.exp(FRICTION * math.pi)
        self.tension = 0.5 * load.capacity / RADIUS * (grip + 1.0) / (grip - 1.0)
        self.start = stations(ale)
        self.lengths = np.diff(np.append(self.start, self.start[0] + LENGTH))
        ground = self.system.AddNode(NodePointGround())
        self.ground = self.system.AddMarker(MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
        self.add_belt()
        self.add_pulleys()
        self.add_loads()
        self.add_sensors()
        self.tighten()
        self.set_in_motion()
        self.run(SETTLING_STEP, 0.0, SETTLING)

    def coordinate(self, node: int, coordinate: int) -> int:
        return self.system.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))

    def hold(self, node: int, coordinate: int) -> int:
        markers = [self.ground, self.coordinate(node, coordinate)]
        return self.system.AddObject(CoordinateConstraint(markerNumbers=markers))

    def add_belt(self) -> None:
        self.nodes = []
        for s in self.start:
            place, tangent, _ = on_curve(s)
            self.nodes.append(self.system.AddNode(NodePoint2DSlope1(referenceCoordinates=[*place, *tangent])))
        law = dict(
            physicsMassPerLength=MASS,
            physicsBendingStiffness=BENDING_STIFFNESS,
            physicsAxialStiffness=AXIAL_STIFFNESS,
            physicsBendingDamping=DAMPING * BENDING_STIFFNESS,
            physicsAxialDamping=DAMPING * AXIAL_STIFFNESS,
            useReducedOrderIntegration=1,
        )
        kind, shared, self.until_start = Cable2D, [], [self.hold(self.nodes[0], 0)]
        if self.ale:
            kind = ALECable2D
            self.flow = self.system.AddNode(
                NodeGenericODE2(
                    numberOfODE2Coordinates=1,
                    referenceCoordinates=[0],
                    initialCoordinates=[0],
                    initialCoordinates_t=[0],
                )
            )
            # The first node remains fixed along the strand, because the belt flows through the mesh.
            shared, self.until_start = [self.flow], [self.hold(self.flow, 0)]
            law["physicsAddALEvariation"] = False
        ends = self.nodes[1:] + self.nodes[:1]
        self.cables = [
            self.system.AddObject(kind(nodeNumbers=[a, b, *shared], physicsLength=length, **law))
            for a, b, length in zip(self.nodes, ends, self.lengths)
        ]

    def add_pulleys(self) -> None:
        self.pulleys, self.bearings, self.contacts = [], [], []
        for x, inertia in zip((0.0, DISTANCE), INERTIAS):
            node = self.system.AddNode(NodeRigidBody2D(referenceCoordinates=[x, 0.0, 0.0]))
            body = self.system.AddObject(ObjectRigidBody2D(physicsMass=1.0, physicsInertia=inertia, nodeNumber=node))
            self.bearings.append(self.hold(node, 0))
            self.hold(node, 1)
            self.until_start.append(self.hold(node, 2))
            self.pulleys.append(node)
            axle = self.system.AddMarker(MarkerBodyRigid(bodyNumber=body))
            for cable, start, length in zip(self.cables, self.start, self.lengths):
                place, _, curvature = on_curve(start + 0.5 * length)
                at_arc = curvature > 0.0 or abs(place[0] - x) < 2.0 * DISTANCE / STRAND
                if self.ale and not (at_arc and abs(place[0] - x) < 0.5 * DISTANCE):
                    continue
                self.add_contact(axle, cable, length / SEGMENTS)

    def add_contact(self, axle: int, cable: int, length: float) -> None:
        shape = self.system.AddMarker(MarkerBodyCable2DShape(bodyNumber=cable, numberOfSegments=SEGMENTS))
        unknown = [0.1] * SEGMENTS + [-2.0] * SEGMENTS + [0.0] * SEGMENTS
        memory = self.system.AddNode(NodeGenericData(initialCoordinates=unknown, numberOfDataCoordinates=3 * SEGMENTS))
        force = self.tension / RADIUS * length
        stiffness = force / PENETRATION
        contact = ObjectContactFrictionCircleCable2D(
            markerNumbers=[axle, shape],
            nodeNumber=memory,
            numberOfContactSegments=SEGMENTS,
            contactStiffness=stiffness,
            contactDamping=DAMPING * stiffness,
            frictionVelocityPenalty=FRICTION * force / self.creep,
            # The midpoints of the segments touch it when the belt is on the pitch line under its pretension.
            circleRadius=RADIUS * math.cos(0.5 * length / RADIUS) + PENETRATION,
            useSegmentNormals=False,
        )
        self.contacts.append(self.system.AddObject(contact))

    def add_loads(self) -> None:
        load, sym = self.load, exudyn.symbolic
        first, second = (self.coordinate(node, 2) for node in self.pulleys)

        def rise(t):
            return load.mean * sym.min(t / RISE, 1.0)

        def driving(system, t, value):
            return sym.IfThenElse(t < SETTLING, rise(t), load.torque(t - SETTLING, sym))

        def driven(system, t, value):
            return OF_SPEED * SPEED - rise(t)

        # Exudyn evaluates the expressions without calling Python in a step. They must exist during the whole run.
        self.functions = []
        for marker, law in ((first, driving), (second, driven)):
            law = CreateSymbolicUserFunction(self.system, law, "loadUserFunction", itemTypeName="LoadCoordinate")
            self.functions.append(law)
            self.system.AddLoad(LoadCoordinate(markerNumber=marker, loadUserFunction=law))
        self.system.AddObject(CoordinateSpringDamper(markerNumbers=[self.ground, second], damping=OF_SPEED))

    def add_sensors(self) -> None:
        """Speeds of the pulleys; in the Eulerian view also the belt's speed, tensions of the upper and the lower strand."""
        kind = exudyn.OutputVariableType
        add = self.system.AddSensor
        self.speeds = [
            add(SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=kind.AngularVelocity))
            for node in self.pulleys
        ]
        self.strands = []
        if self.ale:
            self.flowing = add(
                SensorNode(nodeNumber=self.flow, storeInternal=True, outputVariableType=kind.Coordinates_t)
            )
            lower, upper = self.cables[0], self.cables[len(self.cables) // 2]
            middle = [0.5 * self.lengths[0], 0.0, 0.0]
            self.strands = [
                add(
                    SensorBody(
                        bodyNumber=cable, localPosition=middle, storeInternal=True, outputVariableType=kind.ForceLocal
                    )
                )
                for cable in (upper, lower)
            ]

    def settings(self) -> "exudyn.SimulationSettings":
        settings = exudyn.SimulationSettings()
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = SAMPLE
        settings.linearSolverType = exudyn.LinearSolverType.EigenSparse
        settings.linearSolverSettings.reuseAnalyzedPattern = True
        settings.parallel.numberOfThreads = 1
        integration = settings.timeIntegration
        integration.automaticStepSize, integration.adaptiveStep = False, False
        integration.verboseMode = 0
        integration.newton.useModifiedNewton = True
        integration.newton.relativeTolerance, integration.newton.absoluteTolerance = 1e-3, 0.1
        integration.discontinuous.maxIterations = 3
        integration.generalizedAlpha.spectralRadius = self.damped
        static = settings.staticSolver
        static.numberOfLoadSteps, static.stabilizerODE2term, static.verboseMode = 5, 1e5, 0
        static.newton.relativeTolerance, static.newton.absoluteTolerance = 1e-7, 1e-5
        static.discontinuous.maxIterations = 20
        return settings

    def tighten(self) -> None:
        """Shortens the belt without friction until the force on a bearing is twice the pretension."""
        self.system.Assemble()
        strain, found = 0.0, 0.0
        for _ in range(10):
            strain += (self.tension - found) / AXIAL_STIFFNESS
            for cable in self.cables:
                self.system.SetObjectParameter(cable, "physicsReferenceAxialStrain", -strain)
            self.system.SolveStatic(self.settings(), updateInitialValues=True)
            found = 0.5 * abs(self.system.GetObjectOutput(self.bearings[0], exudyn.OutputVariableType.Force))
            if abs(found / self.tension - 1.0) < 1e-3:
                return
        raise RuntimeError(f"the pretension is {found:.0f} N instead of {self.tension:.0f} N")

    def set_in_motion(self) -> None:
        for contact in self.contacts:
            self.system.SetObjectParameter(contact, "frictionCoefficient", FRICTION)
        for constraint in self.until_start:
            self.system.SetObjectParameter(constraint, "activeConnector", False)
        rates = np.array(self.system.systemData.GetODE2Coordinates_t())
        place = self.system.GetNodeODE2Index
        for node in self.pulleys:
            rates[place(node) + 2] = SPEED
        if self.ale:
            rates[place(self.flow)] = SPEED * RADIUS
        else:
            for node, s in zip(self.nodes, self.start):
                _, tangent, curvature = on_curve(s)
                turning = curvature * np.array([-tangent[1], tangent[0]])
                rates[place(node) : place(node) + 4] = SPEED * RADIUS * np.append(tangent, turning)
        self.system.systemData.SetODE2Coordinates_t(rates, exudyn.ConfigurationType.Initial)

    def run(self, step: float, start: float, seconds: float) -> float:
        """Processor time, s. Raises RuntimeError if the solver fails."""
        settings = self.settings()
        integration = settings.timeIntegration
        integration.startTime, integration.endTime = start, start + seconds
        integration.numberOfSteps = round(seconds / step)
        clock = time.process_time()
        try:
            self.system.SolveDynamic(
                settings, solverType=exudyn.DynamicSolverType.GeneralizedAlpha, updateInitialValues=True
            )
        except ValueError as failed:
            raise RuntimeError("no convergence") from failed
        return time.process_time() - clock

    def stored(self, sensor: int, component: int) -> np.ndarray:
        return np.array(self.system.GetSensorStoredData(sensor))[:, 1 + component]


@dataclass
class Found:
    """Results of a run of a drive.

    Processor time, s; over time the speeds of both pulleys, rad/s, and the tensions of the upper and the lower strand, N (None
    for a travelling belt); counts; description of the motion.
    """

    spent: float
    speeds: np.ndarray
    strands: np.ndarray
    counts: str
    belt: str

    def error(self, finer: "Found") -> float:
        """Largest relative difference of a speed."""
        return float(np.max(np.abs(self.speeds / finer.speeds - 1.0)))

    def error_of_tension(self, finer: "Found") -> float:
        """Root mean square of the difference of tensions, relative to the range of both strands."""
        return float(np.sqrt(np.mean((self.strands - finer.strands) ** 2)) / np.ptp(finer.strands))


def drive(load: Load, cable: str, creep: float, step: float, seconds: float) -> Found:
    found = Drive(load, cable == "ale", creep)
    spent = found.run(step, SETTLING, seconds)
    samples = round(seconds / SAMPLE)
    speeds = np.array([found.stored(sensor, 2)[-samples:] for sensor in found.speeds])
    strands = np.array([found.stored(sensor, 0)[-samples:] for sensor in found.strands])
    it = found.system.sys["dynamicSolver"].it
    counts = f"{it.currentStepIndex - 1} steps, {it.newtonStepsCount} iterations, {it.newtonJacobiCount} Jacobians"
    return Found(spent, speeds, strands, counts, described(found, speeds, strands))


def described(found: Drive, speeds: np.ndarray, strands: np.ndarray) -> str:
    """Motion of the belt after an impact: means over the second half of the run."""
    half = speeds.shape[1] // 2
    first, second = speeds[:, half:].mean(axis=1)
    slip, fastest = 1.0 - second / first, speeds[0].max()
    text = f"pulleys {first:.2f} and {second:.2f} rad/s, slip {100 * slip:.2f} %, fastest {fastest:.0f} rad/s"
    if found.ale:
        flow = found.stored(found.flowing, 0)[-half:].mean()
        tight, slack = strands[:, half:].mean(axis=1)
        of_inertia = MASS * flow**2
        ratio = (tight - of_inertia) / (slack - of_inertia)
        text += (
            f"; belt {flow:.3f} m/s, strands {tight:.0f} and {slack:.0f} N, so {RADIUS * (tight - slack):.1f} N·m; "
            f"tensions less m v² as {ratio:.2f}, by Euler and Eytelwein at most {math.exp(FRICTION * math.pi):.2f}"
        )
    return text


def cargo(example: str, *arguments: str) -> str:
    package = "pushbelt-paper" if example == "free_ring" else "pushbelt"
    command = ["cargo", "run", "--release", "--quiet", "--package", package, "--example", example, "--", *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def value(text: str, before: str) -> float:
    """Parses the number after `before` in a text."""
    return float(text.split(before)[1].split()[0])


def belt_drives(letter: str, arguments: argparse.Namespace) -> None:
    load, seconds = LOADS[letter], arguments.seconds

    def of(step: float) -> Found:
        return drive(load, arguments.cable, arguments.creep, step, seconds)

    finer = f"steps of {250 * arguments.steps[-1]:g} ms"
    print(f"load {letter}, {seconds:g} s; Exudyn, {arguments.cable} cables; errors against {finer}:")
    finest = of(arguments.steps[-1] / 4.0)
    chosen = None
    for step in arguments.steps:
        try:
            found = of(step)
        except RuntimeError as failed:
            print(f"  step {1e3 * step:g} ms: {failed}")
            continue
        error = found.error(finest)
        tensions = f", tensions {100 * found.error_of_tension(finest):.2f} % (rms)" if found.strands.size else ""
        speeds = f"speeds within {100 * error:.2g} %"
        print(f"  step {1e3 * step:g} ms: {found.spent:.2f} s, {speeds}{tensions}; {found.counts}")
        if chosen is None and error < 0.01:
            chosen = step
    print(f"  {finest.belt}")
    if chosen is None:
        print("  no step is accurate enough: specify smaller --steps")
        return
    soft = f"regularisation velocity {arguments.creep:g} m/s"
    kinds = {
        f"{model}, {name}": ["--model", model, *more]
        for model in ("ale", "ale0")
        for name, more in (("default", []), (soft, ["--friction-velocity", str(arguments.creep)]))
    }
    peer, ours = math.inf, dict.fromkeys(kinds, math.inf)
    for _ in range(arguments.runs):
        peer = min(peer, of(chosen).spent)
        for name, kind in kinds.items():
            out = cargo("belt_drive", "--load", letter, "--seconds", str(seconds), *kind)
            ours[name] = min(ours[name], value(out, "CPU time "))
    print(f"  Exudyn, {1e3 * chosen:g} ms: {peer:.3f} s, {seconds / peer:.2f} x real time")
    for name, spent in ours.items():
        longer = f"Exudyn takes {peer / spent:.1f} times as long"
        print(f"  variator, {name}: {spent:.3f} s, {seconds / spent:.1f} x real time; {longer}")


def free_rings(runs: int) -> None:
    print("free ring, 40 elements, 0.5 s; in brackets the frequency's error:")
    for step in (4e-3, 2e-3, 1e-3):
        spent = {}
        for _ in range(runs):
            frequency, least = exudyn_ring.swing(step)
            spent["Exudyn"] = min(spent.get("Exudyn", (math.inf, 0.0)), (least, frequency))
            for model in ("ancf", "ale", "rcm"):
                common = f"--model {model} --elements 40 --time 0.5 --newton 1000 --interval {step}"
                out = cargo("free_ring", *common.split())
                now = 1e-3 * value(out, "CPU time "), value(out, "frequency ")
                spent[model] = min(spent.get(model, (math.inf, 0.0)), now)
        peer = spent["Exudyn"][0]
        parts = []
        for name, (least, frequency) in spent.items():
            times = "" if name == "Exudyn" else f", Exudyn takes {peer / least:.1f} times as long"
            parts.append(f"{name} {1e3 * least:.2f} ms ({100 * (frequency / exudyn_ring.ANALYTIC - 1):+.2f} %){times}")
        print(f"  step {1e3 * step:g} ms: {'; '.join(parts)}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--loads", default="be", help="letters of the loads")
    parser.add_argument(
        "--cable", choices=("ale", "ancf"), default="ale", help="belt that flows through a fixed mesh, or travels with its mesh"
    )
    parser.add_argument(
        "--creep", type=float, default=0.02, help="regularisation velocity of the friction in Exudyn, m/s"
    )
    parser.add_argument(
        "--steps", type=float, nargs="+", default=[1e-3, 5e-4, 2e-4, 1e-4], help="steps of Exudyn, s, in descending order"
    )
    parser.add_argument("--seconds", type=float, default=1.0, help="time to simulate, s")
    parser.add_argument("--runs", type=int, default=3, help="number of runs, of which the fastest is used")
    parser.add_argument("--no-rings", action="store_true", help="skip the free ring")
    arguments = parser.parse_args()
    exudyn.config.suppressWarnings = True
    sys.stdout.reconfigure(line_buffering=True)
    cargo("belt_drive", "--seconds", "0.01")
    for letter in arguments.loads:
        belt_drives(letter, arguments)
    if not arguments.no_rings:
        free_rings(arguments.runs)


if __name__ == "__main__":
    main()
