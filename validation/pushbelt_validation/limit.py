"""The FMU beside the continuum theory at the FMU's radii, torque and force, and the parameters that lead to the theory's limit.

The theory has no ring friction, no play, no compression of contact, chain and ring, no oil, no losses of layers, turning elements and
shafts, and a constant friction coefficient. In the theory's limit the same holds for the FMU; its default parameters include all these
effects.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from pushbelt.fmu.enumerations import Axial, Drive
from pushbelt.fmu.steady import StartValues

from .bench import Bench
from .theory import cmm
from .theory.shifting import Belt

PULLEYS = ("primary", "secondary")


def _of_both(*names: str, value: float = 0.0) -> dict[str, float]:
    return {f"{pulley}.{name}": value for pulley in PULLEYS for name in names}


EFFECTS: Mapping[str, Mapping[str, float]] = {
    "ring friction": {"friction.ring": 0.0, "belt.pitchOffset": 1e-6},
    "stretch of ring and stack": {"ring.axialStiffness": 1e10, "belt.pushStiffness": 2e8},
    "flanks": {"contact.stiffness": 2e12},
    "tilt clearance": _of_both("tiltClearance"),
    "play": {"belt.play": 0.0},
    "oil": {"belt.filmDamping": 0.0, "belt.squeezeDamping": 0.0},
    "losses": {
        "friction.fall": 0.0, "friction.layers": 0.0, "belt.elementInertia": 0.0,
        **_of_both("drag.constant", "drag.viscous", "bearing.friction"),
    },
}  # fmt: skip
"""What the theory leaves out, with the parameters that switch it off. The ring has the elements' speed where its pitch line is theirs."""

OFF = {name: value for effect in EFFECTS.values() for name, value in effect.items()}
"""All of it. The tilt is then proportional to its moment."""
WITH_CLEARANCE = {name: value for name, value in OFF.items() if not name.endswith("tiltClearance")}
"""All but the clearance: without torque only the shape of the opening enters, not its size."""
QUICK = {"secondary.inertia": 3e-3, **_of_both("sheaveDamping", value=100.0)}
"""Nothing but the belt slows a shift: a light driven shaft and hardly damped sheaves."""

# ------------------------------------------------------------------------------------------------------ comparison


@dataclass(frozen=True)
class Deviation:
    """One steady state of the FMU and of the theory, and measures of the distance of the FMU from the theory's limit."""

    theory: cmm.Variator
    outputs: dict[str, float] = field(repr=False)
    compression: float
    """Mean compression of the contact relative to the sheave's opening psi R, larger of the two pulleys."""
    strain: float
    """Strain of the chain under F_1 - F_2 relative to the sliding, larger of the two pulleys."""
    regularisation: float
    """v_0 relative to the sliding speed."""
    theory_slip: float
    """Slip from the creep of both pulleys at the FMU's tilt, since slip and loss depend on the size of the opening."""
    theory_loss: float
    """Friction power on the sheaves, W."""
    tilt_error: float
    """Deviation of the FMU's tilt from moment over tilt stiffness, larger of the two pulleys; it is 0 without clearance."""

    @property
    def ratio(self) -> float:
        """Geometric ratio."""
        return self.outputs["ratio.geometric"]

    @property
    def thrust_ratio(self) -> float:
        """Thrust ratio of the FMU."""
        return self.outputs["thrustRatio"]

    @property
    def thrust_error(self) -> float:
        """Relative difference of the FMU's thrust ratio to the theory's."""
        return float(self.thrust_ratio / self.theory.thrust_ratio - 1.0)

    @property
    def slip_error(self) -> float:
        """Relative difference of the slip."""
        return self.outputs["slip"] / self.theory_slip - 1.0

    @property
    def loss_error(self) -> float:
        """Relative difference of the friction power on the sheaves."""
        return self.outputs["loss.sheaves"] / self.theory_loss - 1.0

    @property
    def residual(self) -> float:
        """Residual of the belt's power balance in the FMU's steady state, relative to the larger power of a pulley."""
        powers = self.outputs["primary.power"], self.outputs["secondary.power"]
        losses = self.outputs["loss.total"] - self.outputs["loss.shafts"]
        return (sum(powers) - losses) / max(abs(power) for power in powers)


def wraps(radius_p: float, radius_s: float, center_distance: float) -> tuple[float, float]:
    """Wrap angles of both pulleys, rad, at these radii, m."""
    lean = math.asin((radius_p - radius_s) / center_distance)
    return math.pi + 2.0 * lean, math.pi - 2.0 * lean


def compare(bench: Bench, values: StartValues, what: str = "") -> Deviation | None:
    """Starts the FMU and solves the theory at the FMU's state. Returns None if either has no solution."""
    out = bench.steady({**bench.parameters, **values}, what)
    if out is None:
        return None
    try:
        return deviation(bench, values, out)
    except ValueError as error:
        bench.failures.append(f"{what}, theory: {error}")
        return None


def deviation(bench: Bench, values: StartValues, out: dict[str, float]) -> Deviation:
    """The theory at a steady state of the FMU. Raises ValueError if the torque is beyond the theory's capacity."""

    def given(name: str) -> float:
        return bench.given(name, values)

    beta, mu = given("geometry.wedgeAngle"), given("friction.pulley")
    radius_p, radius_s = out["primary.radius"], out["secondary.radius"]
    wrap_p, wrap_s = wraps(radius_p, radius_s, given("geometry.centerDistance"))
    thrust_s = out["secondary.axialForce"]
    # Torque of the belt on the pulleys; both pulleys give the same F_1 - F_2 except for the spread of the radii.
    pull = (-out["primary.shaftTorque"] / radius_p + out["secondary.shaftTorque"] / radius_s) / 2.0
    theory = cmm.variator_at_torque(wrap_p, wrap_s, beta, mu, radius_p, pull * radius_p, thrust_s)
    mean = theory.mean_force(thrust_s)

    amplitudes, compressions, tilt_errors = [], [], []
    for name, arc, radius in (("primary", theory.primary, radius_p), ("secondary", theory.secondary, radius_s)):
        tilt = out[f"{name}.tilt"]
        expected = arc.thrust * mean * arc.moment * radius / given(f"{name}.tiltStiffness")
        tilt_errors.append(tilt / expected - 1.0)
        amplitudes.append(tilt / math.tan(beta))  # a Delta
        load = arc.thrust * mean / (radius * arc.wrap * math.cos(beta))
        compressions.append(load / (given("contact.stiffness") * math.cos(beta)) / (tilt * radius))
    arcs = (theory.primary, theory.secondary)
    speed = out["belt.speed"]
    sliding = [amplitude * _typical_sliding(arc) for amplitude, arc in zip(amplitudes, arcs, strict=True)]
    return Deviation(
        theory=theory,
        outputs=out,
        compression=max(compressions),
        strain=abs(pull) / given("belt.pushStiffness") / min(sliding),
        regularisation=given("friction.velocity") / (abs(speed) * min(sliding)),
        theory_slip=amplitudes[1] * arcs[1].mean_sliding - amplitudes[0] * arcs[0].mean_sliding,
        theory_loss=speed * mean * sum(a * arc.dissipation for a, arc in zip(amplitudes, arcs, strict=True)),
        tilt_error=max(tilt_errors, key=abs),
    )


def _typical_sliding(arc: cmm.Arc) -> float:
    """Root mean square of the sliding speed over the arc, in units of omega R a Delta."""
    v_r, v_t = cmm.sliding(arc.theta, arc.centre, arc.creep)
    return math.sqrt(float((v_r**2 + v_t**2).mean()))


def belt_of(bench: Bench) -> Belt:
    """The variator's belt at its pitch line, for the theory."""
    length = bench.given("geometry.beltLength") - 2.0 * math.pi * bench.given("belt.pitchOffset")
    return Belt(*map(bench.given, ("geometry.wedgeAngle", "friction.pulley", "geometry.centerDistance")), length)


# --------------------------------------------------------------------------------------------- parameters and cases


TILT = 3.0e-3
"""Tilt of both sheaves in the limit under torque, rad: large compared with compression, chain strain and v_0, small compared with 1."""
FINE = {
    "contact.roughness": 5e-7, "mesh.primaryArc": 24, "mesh.secondaryArc": 24, "mesh.strand": 8, "mesh.cellsPerElement": 2,
}  # fmt: skip
"""Mesh there. The roughness of the flanks is small compared with the opening of 0.2 mm, and large enough for the solver."""
CLAMPING = 40_000.0
"""Secondary clamping force of the limit cases, N."""

RATIOS = (0.45, 0.7, 1.0, 1.5, 2.2)
TRACTIONS = (-0.5, -0.35, -0.2, 0.2, 0.35, 0.5, 0.7)
LARGEST_SHARE = 0.85
"""Largest traction of the comparison, relative to the theory's capacity."""


def _geometry(bench: Bench, ratio: float) -> tuple[float, float, float, float]:
    return cmm.wrap_angles(ratio, bench.given("geometry.centerDistance"), bench.given("geometry.beltLength"))


def cases(bench: Bench, ratios: Sequence[float] = RATIOS) -> list[tuple[float, float]]:
    """Ratio and traction: |r| from 0.2 to 0.7, at most 85 % of the theory's capacity at that ratio and sign. A larger
    traction is replaced by 85 % of the capacity, at most once."""
    beta, mu = bench.given("geometry.wedgeAngle"), bench.given("friction.pulley")
    found: list[tuple[float, float]] = []
    for ratio in ratios:
        wrap_p, wrap_s, _, _ = _geometry(bench, ratio)
        for traction in TRACTIONS:
            limit = LARGEST_SHARE * cmm.capacity(wrap_p, wrap_s, beta, mu, traction > 0.0)
            if abs(traction) > limit:
                traction = math.copysign(math.floor(1e3 * limit) / 1e3, traction)
            if all(i != ratio or abs(traction - r) > 0.02 for i, r in found):
                found.append((ratio, traction))
    return found


def limit_case(bench: Bench, ratio: float, traction: float) -> StartValues:
    """Settings of a steady start in the theory's limit, with the shaft torque of the theory."""
    beta, mu = bench.given("geometry.wedgeAngle"), bench.given("friction.pulley")
    wrap_p, wrap_s, radius_p, radius_s = _geometry(bench, ratio)
    theory = cmm.variator(wrap_p, wrap_s, beta, mu, traction)
    pull = 2.0 * traction * theory.mean_force(CLAMPING)

    def tilt_stiffness(arc: cmm.Arc, radius: float) -> float:
        return arc.thrust * theory.mean_force(CLAMPING) * arc.moment * radius / TILT

    return {
        **OFF,
        **FINE,
        "primary.drive": Drive.SPEED,
        "secondary.drive": Drive.TORQUE,
        "primary.axial": Axial.HELD,
        "secondary.axial": Axial.FORCE,
        "initial.steady": True,
        "initial.ratio": ratio,
        "primary.tiltStiffness": tilt_stiffness(theory.primary, radius_p),
        "secondary.tiltStiffness": tilt_stiffness(theory.secondary, radius_s),
        "secondary.clampingForce": CLAMPING,
        "secondary.torque": -pull * radius_s,
        "primary.torque": pull * radius_p,
    }
