"""The free ring of `paper/examples/free_ring.rs` in Exudyn, as cables of absolute nodal coordinates (generalised-alpha).

pip install exudyn==1.11.0
python examples/peers/exudyn_ring.py

Prints frequency and processor time over the step size. Steps are fixed: with automatic step size the solver keeps halving the step where Newton's method
converges slowly.
"""

import math
import sys
import time

sys.exudynFast = True  # Disables range checks. Exudyn reads this variable when it is imported.
import exudyn
import numpy as np
from exudyn.utilities import Cable2D, NodePoint2DSlope1

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
    for k in range(ELEMENTS):
        cable = Cable2D(
            physicsLength=LENGTH / ELEMENTS,
            physicsMassPerLength=DENSITY * WIDTH * THICKNESS,
            physicsBendingStiffness=MODULUS * WIDTH * THICKNESS**3 / 12.0,
            physicsAxialStiffness=MODULUS * WIDTH * THICKNESS,
            strainIsRelativeToReference=1.0,
            nodeNumbers=[nodes[k], nodes[(k + 1) % ELEMENTS]],
        )
        system.AddObject(cable)
    system.Assemble()
    settings = exudyn.SimulationSettings()
    settings.solutionSettings.writeSolutionToFile = False
    settings.linearSolverType = exudyn.LinearSolverType.EigenSparse
    settings.parallel.numberOfThreads = 1
    integration = settings.timeIntegration
    integration.endTime, integration.numberOfSteps = DURATION, round(DURATION / step)
    integration.automaticStepSize = False
    integration.verboseMode = 0
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


if __name__ == "__main__":
    for step in (4e-3, 2e-3, 1e-3, 5e-4):
        frequency, spent = min((swing(step) for _ in range(7)), key=lambda found: found[1])
        print(f"step {1e3 * step:g} ms: {frequency:.4f} Hz, {100 * (frequency / ANALYTIC - 1):+.2f} %, {spent:.3f} s")
