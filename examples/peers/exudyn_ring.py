"""The free ring of `paper/examples/free_ring.rs` in Exudyn, as cables of absolute nodal coordinates (generalised-alpha).

pip install exudyn==1.11.0
python examples/peers/exudyn_ring.py

Prints frequency and processor time of the small oscillation over the step size, and the frequency of the large one from the two-arc shape. Steps are
fixed: with automatic step size the solver keeps halving the step where Newton's method converges slowly.
"""

import math
import sys
import time
from pathlib import Path

sys.exudynFast = True  # Disables range checks. Exudyn reads this variable when it is imported.
import exudyn
import numpy as np
from exudyn.utilities import Cable2D, NodePoint2DSlope1

sys.path.insert(0, str(Path(__file__).parents[2] / "python"))
from pushbelt.fmu.geometry import TwoPulleyCurve  # noqa: E402

LENGTH, ELEMENTS, DURATION = 0.70, 40, 0.5
RADIUS = LENGTH / math.tau
MODULUS, DENSITY, WIDTH, THICKNESS = 2.1e11, 7800.0, 9.5e-3, 0.185e-3
ANALYTIC = 9.534
"""First frequency of the thin ring, Hz."""


def velocity(angle: float) -> np.ndarray:
    """Initial velocity of the inextensible mode: radial a cos 2θ, tangential -½ a sin 2θ, with a deflection of 1e-3 R."""
    radial = np.array([math.cos(angle), math.sin(angle)])
    along = np.array([-math.sin(angle), math.cos(angle)])
    speed = 1e-3 * RADIUS * math.tau * ANALYTIC
    return speed * (math.cos(2 * angle) * radial - 0.5 * math.sin(2 * angle) * along)


def close(system: "exudyn.MainSystem", nodes: list, strain_free_as_placed: bool) -> None:
    """Joins nodes to a ring of cables. It is free of strain as it is placed, or where it is straight."""
    for k, node in enumerate(nodes):
        cable = Cable2D(
            physicsLength=LENGTH / len(nodes),
            physicsMassPerLength=DENSITY * WIDTH * THICKNESS,
            physicsBendingStiffness=MODULUS * WIDTH * THICKNESS**3 / 12.0,
            physicsAxialStiffness=MODULUS * WIDTH * THICKNESS,
            strainIsRelativeToReference=float(strain_free_as_placed),
            nodeNumbers=[node, nodes[(k + 1) % len(nodes)]],
        )
        system.AddObject(cable)
    system.Assemble()


def fixed_steps(duration: float, step: float) -> "exudyn.SimulationSettings":
    """Settings of a run with fixed steps, on one thread, without files."""
    settings = exudyn.SimulationSettings()
    settings.solutionSettings.writeSolutionToFile = False
    settings.linearSolverType = exudyn.LinearSolverType.EigenSparse
    settings.parallel.numberOfThreads = 1
    integration = settings.timeIntegration
    integration.endTime, integration.numberOfSteps = duration, round(duration / step)
    integration.automaticStepSize = False
    integration.verboseMode = 0
    return settings


def swing(step: float) -> tuple[float, float]:
    """Frequency, Hz, and processor time, s."""
    system = exudyn.SystemContainer().AddSystem()
    nodes = []
    for k in range(ELEMENTS):
        angle = math.tau * k / ELEMENTS
        place = [RADIUS * math.cos(angle), RADIUS * math.sin(angle)]
        slope = (velocity(angle + 1e-5) - velocity(angle - 1e-5)) / (2e-5 * RADIUS)
        node = NodePoint2DSlope1(
            referenceCoordinates=[*place, -math.sin(angle), math.cos(angle)],
            initialVelocities=[*velocity(angle), *slope],
        )
        nodes.append(system.AddNode(node))
    close(system, nodes, strain_free_as_placed=True)
    settings = fixed_steps(DURATION, step)
    integration = settings.timeIntegration
    integration.newton.useModifiedNewton = True
    integration.newton.relativeTolerance = 1e-5
    integration.generalizedAlpha.spectralRadius = 0.9
    seen = []

    def look(system: "exudyn.MainSystem", t: float) -> bool:
        seen.append((t, system.systemData.GetODE2Coordinates()[0]))
        return True

    system.SetPreStepUserFunction(look)
    start = time.process_time()
    system.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.GeneralizedAlpha)
    spent = time.process_time() - start
    t, x = np.array(seen[1:]).T
    at = np.flatnonzero(np.sign(x[1:]) != np.sign(x[:-1]))
    crossings = t[at] - x[at] * (t[at + 1] - t[at]) / (x[at + 1] - x[at])
    return 0.5 * (len(crossings) - 1) / (crossings[-1] - crossings[0]), spent


def frame(curve: TwoPulleyCurve, xi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and outward unit normals of a curve at places ξ, each of shape (n, 2)."""
    lower = xi > 0.5 * curve.length
    upper_xi = np.where(lower, curve.length - xi, xi)
    _, arc_end, strand_end, *_ = curve.borders
    on_s, on_strand = upper_xi < arc_end, upper_xi < strand_end
    on_p = curve.phi + (upper_xi - strand_end) / curve.primary_radius
    angle = np.where(on_s, upper_xi / curve.secondary_radius, np.where(on_strand, curve.phi, on_p))
    normal = np.stack([-np.cos(angle), np.sin(angle)], axis=1)
    along = np.where(on_s, 0.0, upper_xi - arc_end)[:, None] * [np.sin(curve.phi), np.cos(curve.phi)]
    from_p = np.array([curve.center_distance, 0.0]) + curve.primary_radius * normal
    point = np.where((on_s | on_strand)[:, None], curve.secondary_radius * normal + along, from_p)
    mirror = np.stack([np.ones_like(xi), np.where(lower, -1.0, 1.0)], axis=1)
    return mirror * point, mirror * normal


def large_swing(elements: int, step: float) -> float:
    """Frequency from the two-arc shape at rest (Θ = 0.4, axes 0.155 m apart), Hz. The ring is free of stress where it is straight."""
    places, normals = frame(TwoPulleyCurve(0.155, LENGTH, 0.4), LENGTH * np.arange(elements) / elements)
    system = exudyn.SystemContainer().AddSystem()
    nodes = [
        system.AddNode(NodePoint2DSlope1(referenceCoordinates=[*place, normal[1], -normal[0]]))
        for place, normal in zip(places, normals, strict=True)
    ]
    close(system, nodes, strain_free_as_placed=False)
    settings = fixed_steps(0.2, step)
    integration = settings.timeIntegration
    integration.newton.relativeTolerance, integration.newton.absoluteTolerance = 1e-5, 1e-6
    integration.newton.maxIterations = 60
    integration.generalizedAlpha.spectralRadius = 0.6
    seen = []

    def look(system: "exudyn.MainSystem", t: float) -> bool:
        moved = places + system.systemData.GetODE2Coordinates().reshape(-1, 4)[:, :2]
        x, y = (moved - moved.mean(axis=0)).T
        seen.append((t, np.mean(x * x - y * y)))
        return True

    system.SetPreStepUserFunction(look)
    system.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.GeneralizedAlpha)
    t, ovality = np.array(seen).T
    at = np.flatnonzero(ovality[1:] * ovality[:-1] < 0.0)
    crossings = t[at] - ovality[at] * (t[at + 1] - t[at]) / (ovality[at + 1] - ovality[at])
    return 1.0 / (crossings[2] - crossings[0])


if __name__ == "__main__":
    for step in (4e-3, 2e-3, 1e-3, 5e-4):
        frequency, spent = min((swing(step) for _ in range(7)), key=lambda found: found[1])
        print(f"step {1e3 * step:g} ms: {frequency:.4f} Hz, {100 * (frequency / ANALYTIC - 1):+.2f} %, {spent:.3f} s")
    for elements in (40, 80):
        print(f"large oscillation, {elements} elements: {large_swing(elements, 2e-5):.3f} Hz")
