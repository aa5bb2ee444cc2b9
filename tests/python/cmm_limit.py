"""Runs the FMU against the continuum theory (cmm.py), in the theory's limit and at the default parameters.

    python -m cmm_limit            the nine reference load cases at default parameters
    python -m cmm_limit limit      the theory's limit over ratio and traction
    python -m cmm_limit ladder     convergence over stiffness and mesh

The FMU is the file named by PUSHBELT_FMU, else target/PushbeltVariator.fmu.
"""

from __future__ import annotations

import math
import os
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import cmm

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "python"))

from pushbelt.fmu.data import load_case_force  # noqa: E402
from pushbelt.fmu.enumerations import Axial, Drive  # noqa: E402
from pushbelt.fmu.load_cases import held_primary  # noqa: E402
from pushbelt.fmu.unit import Archive, Variator  # noqa: E402


class Unit:
    """The unpacked FMU: start values by name, and one steady start after another."""

    def __init__(self, archive: Archive) -> None:
        self.archive = archive
        self.variables = {v.name: v for v in self.archive.description.modelVariables}
        self._reals = [
            v.name for v in self.variables.values() if v.type == "Real" and v.causality in ("output", "local")
        ]

    def start(self, name: str) -> float:
        return float(self.variables[name].start)

    def steady(self, values: Mapping[str, float]) -> dict[str, float]:
        """All real outputs and locals of the steady start."""
        with Variator(self.archive, values) as started:
            started.initialise()
            return dict(zip(self._reals, started.get_reals(started.reals(self._reals)).tolist(), strict=True))


@contextmanager
def unit(path: Path) -> Iterator[Unit]:
    with Archive.unpack(path) as archive:
        yield Unit(archive)


# ------------------------------------------------------------------------------------------------------ comparison


@dataclass(frozen=True)
class Deviation:
    """One steady state of the FMU and of the theory, and how far the FMU is from the theory's limit."""

    ratio: float
    wanted_traction: float
    theory: cmm.Variator
    outputs: dict[str, float] = field(repr=False)
    seconds: float
    compression: float
    """Mean compression of the contact against the sheave's opening psi R, larger of the two pulleys."""
    strain: float
    """Strain of the chain under F_1 - F_2 against the sliding, larger of the two pulleys."""
    regularisation: float
    """v_0 against the sliding."""
    theory_slip: float
    """Slip from the creep of both pulleys: here, and in the loss, the size of the opening matters."""
    theory_loss: float
    """Friction power on the sheaves, W."""

    @property
    def thrust_ratio(self) -> float:
        return self.outputs["thrustRatio"]

    @property
    def thrust_error(self) -> float:
        return self.thrust_ratio / self.theory.thrust_ratio - 1.0

    @property
    def slip_error(self) -> float:
        return self.outputs["slip"] / self.theory_slip - 1.0

    @property
    def loss_error(self) -> float:
        return self.outputs["loss.sheaves"] / self.theory_loss - 1.0

    @property
    def residual(self) -> float:
        """Power balance of the FMU's steady state against the larger shaft power."""
        powers = self.outputs["primary.power"], self.outputs["secondary.power"]
        return (sum(powers) - self.outputs["loss.total"]) / max(abs(power) for power in powers)


def strand_traction(out: Mapping[str, float], length: float, mass: float) -> float:
    """r from the FMU's own strand forces F = T - Q at the middle of both strands."""

    def force(xi: float) -> float:
        k = round(xi / length * 72) % 72 + 1
        return out[f"profile.ringTension[{k}]"] - out[f"profile.pushForce[{k}]"]

    centrifugal = mass * out["belt.speed"] ** 2
    # From xi = 0 to the middle of the upper strand: half the wrap of S and half a strand.
    radius_p, radius_s = out["primary.radius"], out["secondary.radius"]
    wrap_p, wrap_s = _wraps(out, radius_p, radius_s)
    half_arc = radius_s * wrap_s / 2.0
    middle = half_arc + (length - radius_s * wrap_s - radius_p * wrap_p) / 4.0
    upper, lower = force(middle) - centrifugal, force(length - middle) - centrifugal
    return (upper - lower) / (upper + lower)


def _wraps(out: Mapping[str, float], radius_p: float, radius_s: float) -> tuple[float, float]:
    lean = math.asin((radius_p - radius_s) / out["geometry.centerDistance"])
    return math.pi + 2.0 * lean, math.pi - 2.0 * lean


def compare(unit: Unit, values: Mapping[str, float], wanted_traction: float = math.nan) -> Deviation:
    """Starts the FMU and solves the theory at the FMU's own radii, torque and secondary axial force."""

    def given(name: str) -> float:
        return float(values[name]) if name in values else unit.start(name)

    began = time.perf_counter()
    out = unit.steady(values)
    seconds = time.perf_counter() - began
    out["geometry.centerDistance"] = given("geometry.centerDistance")
    beta, mu = given("geometry.wedgeAngle"), given("friction.pulley")
    radius_p, radius_s = out["primary.radius"], out["secondary.radius"]
    wrap_p, wrap_s = _wraps(out, radius_p, radius_s)
    thrust_s = out["secondary.axialForce"]
    # Torque of the belt on the pulleys; both pulleys give the same F_1 - F_2 but for the spread of the radii.
    pull = (-out["primary.shaftTorque"] / radius_p + out["secondary.shaftTorque"] / radius_s) / 2.0
    theory = cmm.variator_at_torque(wrap_p, wrap_s, beta, mu, radius_p, pull * radius_p, thrust_s)
    mean = theory.mean_force(thrust_s)

    amplitudes, compressions = [], []
    for name, arc, radius in (("primary", theory.primary, radius_p), ("secondary", theory.secondary, radius_s)):
        tilt = arc.thrust * mean * arc.moment * radius / given(f"{name}.tiltStiffness")
        amplitudes.append(tilt / math.tan(beta))  # a Delta
        load = arc.thrust * mean / (radius * arc.wrap * math.cos(beta))
        compressions.append(load / (given("contact.stiffness") * math.cos(beta)) / (tilt * radius))
    arcs = (theory.primary, theory.secondary)
    speed = out["belt.speed"]
    sliding = [amplitude * _typical_sliding(arc) for amplitude, arc in zip(amplitudes, arcs)]
    slip = amplitudes[1] * arcs[1].mean_sliding - amplitudes[0] * arcs[0].mean_sliding
    loss = speed * mean * sum(amplitude * arc.dissipation for amplitude, arc in zip(amplitudes, arcs))
    return Deviation(
        ratio=out["ratio.geometric"],
        wanted_traction=wanted_traction,
        theory=theory,
        outputs=out,
        seconds=seconds,
        compression=max(compressions),
        strain=abs(pull) / given("belt.pushStiffness") / min(sliding),
        regularisation=given("friction.velocity") / (abs(speed) * min(sliding)),
        theory_slip=slip,
        theory_loss=loss,
    )


def _typical_sliding(arc: cmm.Arc) -> float:
    """Root mean square of the sliding speed over the arc, in units of omega R a Delta."""
    v_r, v_t = cmm.sliding(arc.theta, arc.centre, arc.creep)
    return math.sqrt(float((v_r**2 + v_t**2).mean()))


# --------------------------------------------------------------------------------------------- parameters and cases


@dataclass(frozen=True)
class Level:
    """How far to go towards the theory's limit."""

    tilt: float = 3.0e-3
    """Tilt of both sheaves, rad: large against compression, chain strain and v_0, small against 1."""
    contact: float = 8.0e11
    chain: float = 2.0e8
    ring: float = 1.0e10
    pitch_offset: float = 1.0e-6
    arc: int = 24
    strand: int = 8
    cells: int = 2


LIMIT = Level()

LADDER = (
    Level(contact=2.0e10, chain=2.0e7, ring=1.0e9, arc=12, strand=6),
    Level(contact=6.0e10, chain=5.0e7, ring=3.0e9, arc=16, strand=8),
    Level(contact=2.0e11, chain=1.0e8, ring=1.0e10, arc=20, strand=8),
    Level(contact=8.0e11, chain=2.0e8, ring=1.0e10, arc=24, strand=8),
)
"""Stiffness and mesh grow together."""

CLAMPING = 40_000.0
"""Secondary clamping force of the limit cases, N."""

RATIOS = (0.45, 0.7, 1.0, 1.5, 2.2)
TRACTIONS = (-0.5, -0.35, -0.2, 0.2, 0.35, 0.5, 0.7)
LARGEST_SHARE = 0.85
"""Largest share of the theory's capacity that is compared."""


def cases(unit: Unit) -> list[tuple[float, float]]:
    """Ratio and traction: |r| from 0.2 to 0.7, at most 85 % of the theory's capacity at that ratio and sign.

    Where a traction exceeds that share, the share itself takes its place, once.
    """
    beta, mu = unit.start("geometry.wedgeAngle"), unit.start("friction.pulley")
    found: list[tuple[float, float]] = []
    for ratio in RATIOS:
        wrap_p, wrap_s, _, _ = _geometry(unit, ratio)
        for traction in TRACTIONS:
            limit = LARGEST_SHARE * cmm.capacity(wrap_p, wrap_s, beta, mu, traction > 0.0)
            if abs(traction) > limit:
                traction = math.copysign(math.floor(1e3 * limit) / 1e3, traction)
            if all(i != ratio or abs(traction - r) > 0.02 for i, r in found):
                found.append((ratio, traction))
    return found


def _geometry(unit: Unit, ratio: float) -> tuple[float, float, float, float]:
    return cmm.wrap_angles(ratio, unit.start("geometry.centerDistance"), unit.start("geometry.beltLength"))


def limit_case(unit: Unit, ratio: float, traction: float, level: Level = LIMIT) -> dict[str, float]:
    """Settings of a steady start in the theory's limit, with the shaft torque that the theory asks for."""
    beta, mu = unit.start("geometry.wedgeAngle"), unit.start("friction.pulley")
    wrap_p, wrap_s, radius_p, radius_s = _geometry(unit, ratio)
    theory = cmm.variator(wrap_p, wrap_s, beta, mu, traction)
    pull = 2.0 * traction * theory.mean_force(CLAMPING)

    def tilt_stiffness(arc: cmm.Arc, radius: float) -> float:
        return arc.thrust * theory.mean_force(CLAMPING) * arc.moment * radius / level.tilt

    return {
        "primary.drive": Drive.SPEED,
        "secondary.drive": Drive.TORQUE,
        "primary.axial": Axial.HELD,
        "secondary.axial": Axial.FORCE,
        "initial.steady": True,
        "initial.ratio": ratio,
        "friction.ring": 0.0,
        "belt.play": 0.0,
        "belt.pitchOffset": level.pitch_offset,
        "belt.pushStiffness": level.chain,
        "ring.axialStiffness": level.ring,
        "contact.stiffness": level.contact,
        "primary.tiltStiffness": tilt_stiffness(theory.primary, radius_p),
        "secondary.tiltStiffness": tilt_stiffness(theory.secondary, radius_s),
        "mesh.primaryArc": level.arc,
        "mesh.secondaryArc": level.arc,
        "mesh.strand": level.strand,
        "mesh.cellsPerElement": level.cells,
        "secondary.clampingForce": CLAMPING,
        "secondary.torque": -pull * radius_s,
        "primary.torque": pull * radius_p,
    }


THETAS = {"overdrive": 0.4, "medium": 0.0, "underdrive": -0.4}


def load_case(unit: Unit, shape: str, torque: float, ring_friction: bool = True) -> dict[str, float]:
    """One of the nine reference load cases: 2000 rpm and primary sheave held, the demo's clamping force."""
    theta = THETAS[shape]
    ratio = (1.0 - theta) / (1.0 + theta)
    speed = 2000.0 * math.pi / 30.0
    _, _, radius_p, _ = _geometry(unit, ratio)
    radius_p -= unit.start("belt.pitchOffset")
    beta, mu = unit.start("geometry.wedgeAngle"), unit.start("friction.pulley")
    held = held_primary({}, ratio, speed, load_case_force(torque, radius_p, mu, beta))
    loads = {"secondary.torque": -torque * ratio, "primary.torque": torque}
    return held | loads | ({} if ring_friction else {"friction.ring": 0.0})


# ---------------------------------------------------------------------------------------------------------- reports

HEADER = (
    "| case | i_g | r | thrust ratio | theory | difference | slip | loss | compression | strain | v_0 | balance | s |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|---|---|"
)


def row(name: str, d: Deviation) -> str:
    return (
        f"| {name} | {d.ratio:.3f} | {d.theory.traction:+.3f} | {d.thrust_ratio:.4f} | {d.theory.thrust_ratio:.4f} "
        f"| {d.thrust_error:+.2%} | {d.slip_error:+.1%} | {d.loss_error:+.1%} | {d.compression:.1%} | {d.strain:.1%} "
        f"| {d.regularisation:.1%} | {d.residual:+.1e} | {d.seconds:.1f} |"
    )


def attempt(unit: Unit, name: str, values: Mapping[str, float], traction: float = math.nan) -> None:
    try:
        print(row(name, compare(unit, values, traction)), flush=True)
    except Exception as error:  # a report goes on to the next case
        print(f"| {name} | {error} |", flush=True)


def report_default(unit: Unit) -> None:
    print("Default parameters; slip and loss: difference from the theory.\n\n" + HEADER)
    for ring_friction in (True, False):
        for torque in (30.0, 50.0, 100.0):
            for shape in THETAS:
                name = f"{shape}-{torque:.0f}" + ("" if ring_friction else ", no ring friction")
                attempt(unit, name, load_case(unit, shape, torque, ring_friction))


def report_limit(unit: Unit) -> None:
    print(f"{LIMIT}\n\n" + HEADER)
    for ratio, traction in cases(unit):
        attempt(unit, "limit", limit_case(unit, ratio, traction), traction)


def report_ladder(unit: Unit) -> None:
    print(HEADER)
    for ratio, traction in ((0.45, 0.35), (1.0, 0.35), (1.0, -0.35), (2.2, 0.35)):
        for k, level in enumerate(LADDER):
            attempt(unit, f"level {k}", limit_case(unit, ratio, traction, level), traction)


def main() -> None:
    wanted = sys.argv[1] if len(sys.argv) > 1 else "default"
    fmu = Path(os.environ.get("PUSHBELT_FMU", ROOT / "target" / "PushbeltVariator.fmu"))
    with unit(fmu) as opened:
        {"default": report_default, "limit": report_limit, "ladder": report_ladder}[wanted](opened)


if __name__ == "__main__":
    main()
