"""The published steady state of `belt155`: computed by the FMU under the assumptions of its theory, with variants that explain the difference."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from pushbelt.fmu.data import curve_at, curve_of, parameter_set, reference_case
from pushbelt.fmu.fields import mean_between
from pushbelt.fmu.geometry import TwoPulleyCurve, theta_of
from pushbelt.fmu.load_cases import steady_state
from pushbelt.fmu.results import SteadyState
from pushbelt.fmu.tilt import RIGID
from pushbelt.fmu.unit import Archive

from .results import ReferenceResult, StrandForces, Variant
from .theory import ContinuousBelt

ASSUMPTIONS: Mapping[str, float] = {
    "primary.tiltStiffness": RIGID,
    "secondary.tiltStiffness": RIGID,
    "friction.ring": 0.0,
    "friction.layers": 0.0,
    "belt.elementInertia": 0.0,
    "friction.fall": 0.0,
    "belt.play": 0.0,
    "belt.pitchOffset": 0.0,
}
"""Rigid sheaves, Coulomb friction, a ring without friction, no play, and the pitch line on the ring."""

MESH: Mapping[str, float] = {"mesh.primaryArc": 24, "mesh.secondaryArc": 24, "mesh.strand": 12}
"""Finer mesh, because with rigid sheaves the pressure rises more abruptly than the default mesh resolves."""

VARIANTS: Mapping[str, Mapping[str, float]] = {
    "sheaves that tilt as measured": {"primary.tiltStiffness": 1.79e6, "secondary.tiltStiffness": 1.79e6},
    "contact twice as stiff": {"contact.stiffness": 1.2e11},
    "contact half as stiff": {"contact.stiffness": 3e10},
    "ring friction 0.05": {"friction.ring": 0.05},
    "end play 0.2 mm": {"belt.play": 2e-4},
    "pitch line 1 mm inside the ring": {"belt.pitchOffset": 1e-3},
    "mesh twice as fine": {"mesh.primaryArc": 48, "mesh.secondaryArc": 48, "mesh.strand": 24},
}
"""Single changes that show the dependence of the difference to the theory."""

SOLVES = 1 + len(VARIANTS)
"""Number of steady states to solve."""


def strand_forces(state: SteadyState, curve: TwoPulleyCurve) -> StrandForces:
    """Net forces (ring tension minus push force) in the middle halves of the strands, N."""
    net = state.profile.ring_tension - state.profile.push_force

    def middle(start: float, stop: float) -> float:
        quarter = 0.25 * (stop - start)
        return mean_between(state.profile, net, start + quarter, stop - quarter)

    _, upper_start, upper_end, lower_start, lower_end, _ = curve.borders
    return StrandForces(middle(upper_start, upper_end), middle(lower_start, lower_end))


def continuous_belt(parameters: Mapping[str, float], curve: TwoPulleyCurve, belt_speed: float) -> ContinuousBelt:
    """The belt of the published theory; speed in m/s."""
    return ContinuousBelt(
        wrap_primary=2.0 * (np.pi - curve.phi),
        wrap_secondary=2.0 * curve.phi,
        wedge_angle=parameters["geometry.wedgeAngle"],
        friction=parameters["friction.pulley"],
        centrifugal=(parameters["belt.massPerLength"] + parameters["ring.massPerLength"]) * belt_speed**2,
    )


def run(archive: Archive, progress: Callable[[], None] = lambda: None) -> ReferenceResult:
    """Runs the reference case and its variants; `progress` is called after each."""
    published = reference_case()
    parameters = {**parameter_set("belt155"), **ASSUMPTIONS, **MESH}
    ratio, speed = published["geometricRatio"], published["primarySpeed"]
    torque, force = published["primaryTorque"], published["secondaryClampingForce"]
    curve = curve_of(parameters, theta_of(ratio))

    def solve(changes: Mapping[str, float], load_guess: float | None = None) -> SteadyState:
        found = steady_state(archive, {**parameters, **changes}, ratio, speed, torque, force, load_guess)
        progress()
        return found

    state = solve({})
    forces = strand_forces(state, curve_at(parameters, state))

    theory = continuous_belt(parameters, curve, speed * curve.primary_radius)
    theory_forces = theory.strand_forces(force, torque / curve.primary_radius)
    theory_primary, theory_secondary = theory.axial_forces(theory_forces)
    without_flank_friction = theory.axial_forces(forces)

    return ReferenceResult(
        published={
            "thrustRatio": published["thrustRatio"],
            "primary.axialForce": published["primaryClampingForce"],
            "secondary.speed": published["secondarySpeed"],
            "belt.speed": published["beltSpeed"],
            "upper strand": published["strandForces"]["upper"],
            "lower strand": published["strandForces"]["lower"],
            "slip arc": np.deg2rad(published["slipArcDeg"]),
        },
        theory={
            "thrustRatio": theory_primary / theory_secondary,
            "primary.axialForce": theory_primary,
            "secondary.speed": speed / ratio,
            "belt.speed": speed * curve.primary_radius,
            "upper strand": theory_forces.upper,
            "lower strand": theory_forces.lower,
            "slip arc": theory.slip_arc(theory_forces),
        },
        computed={
            "thrustRatio": state["thrustRatio"],
            "primary.axialForce": state["primary.axialForce"],
            "secondary.speed": state["secondary.speed"],
            "belt.speed": state["belt.speed"],
            "upper strand": forces.upper,
            "lower strand": forces.lower,
        },
        without_flank_friction={"primary": without_flank_friction[0], "secondary": without_flank_friction[1]},
        steady=state,
        variants=tuple(
            _variant(name, solve(changes, state.load_torque), parameters) for name, changes in VARIANTS.items()
        ),
    )


def _variant(name: str, state: SteadyState, parameters: Mapping[str, float]) -> Variant:
    return Variant(name, state["thrustRatio"], strand_forces(state, curve_at(parameters, state)), state["slip"])
