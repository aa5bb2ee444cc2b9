"""The default belt: radial motion of elements along an arc against the law of tilt and contact, and the error of the mesh.

The axial pressure p_ax of the belt tilts a sheave by ψ under the moment ∫p_ax ϱ (cos θ, sin θ), first by its clearance, then by
bending, and so opens the groove by w = ϱ (ψ_x cos θ + ψ_y sin θ). A flank under the normal force p per length is pressed in by
g = p/(k_c cos β). An element runs further in by the sum of both over the slope of the groove,

    Δϱ = −(w + g)/tan β.

The points of the profile contain Δϱ and p. A least-squares fit gives the tilt that opens the groove; the remainder shows whether the
groove is that of a tilted cone. The magnitude of the tilt follows from the moment of the normal forces at the points, scaled to the axial
force. Its direction is compared separately: the pressure has peaks of some millimetres at the borders of an arc, the points are 10 mm
apart, and friction along the flank has an axial share.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pushbelt.fmu.data import curve_of, load_case_speed, load_cases
from pushbelt.fmu.geometry import EDGE, ratio_of
from pushbelt.fmu.results import BeltState
from pushbelt.fmu.steady import driven_by_torque

from ..bench import Bench, Plan
from ..measured import OWN
from ..outcome import PERCENT, Check, Column, Part, Section, Table, Unit, share, table, within
from ..tilt import tilt_under

TOLERANCE = 0.05
"""Relative tolerance of the predicted spread. The normal forces at the points do not represent the whole axial force."""

TILT_TOLERANCE = 0.02
"""Relative tolerance of the tilt that the FMU reports, compared with the law under the moment of the points and with the fitted groove.
An error of the force has little influence beyond the clearance, since most of the tilt is the clearance."""

MISSING, TURN_TOLERANCE = 0.05, 5.0 * np.pi / 180.0
"""Largest angle between the direction of the tilt and that of the moment of the points, rad, where the points have the axial force within
`MISSING`. If 5 % of it are missing at the border of an arc, a moment with a lever of 0.65 ϱ turns by 4.4°. The axial share of friction,
μ tan β, adds up to 1°."""

SHAPE_TOLERANCE = 0.02
"""Largest remainder of the fit, relative to the spread."""


@dataclass(frozen=True)
class SpiralRunning:
    """Spread of the running radius between the points of the profile on one arc."""

    axial_force: float
    """N."""
    missing: float
    """Share of it that the points do not have."""
    tilt: float
    """|ψ| by the law under the moment of the points, rad."""
    tilt_reported: float
    """|ψ| reported by the FMU, rad."""
    tilt_found: float
    """|ψ| of the groove fitted to the profile, rad."""
    turn: float
    """Direction of the fitted tilt minus that of the moment of the points, rad."""
    shape: float
    """Largest distance of the profile from the groove of the fitted tilt, m."""
    predicted: float
    """Spread by the law in the fitted direction, m."""
    found: float
    """Spread in the profile, m."""

    @property
    def error(self) -> float:
        """Relative error of the predicted spread."""
        return self.found / self.predicted - 1.0

    @property
    def tilts(self) -> bool:
        """Whether the sheave tilts. The tilt of a rigid one has no direction."""
        return self.tilt > 1e-6

    @property
    def tilt_errors(self) -> tuple[float, float]:
        """Relative differences to the FMU's tilt: of the law under the moment of the points, and of the fitted groove."""
        return self.tilt / self.tilt_reported - 1.0, self.tilt_found / self.tilt_reported - 1.0


def spiral_running(state: BeltState, parameters: Mapping[str, float], pulley: str) -> SpiralRunning:
    """Spread on the arc of a pulley, simulated and predicted."""
    curve, profile = curve_of(parameters, state["reference.theta"]), state.profile
    beta = parameters["geometry.wedgeAngle"]
    sheave = parameters[f"{pulley}.tiltStiffness"], parameters[f"{pulley}.tiltClearance"]
    force, radius = state[f"{pulley}.axialForce"], state[f"{pulley}.radius"]
    distance, half_arc = curve.from_middle(pulley, profile.position), 0.5 * curve.arc_length(pulley)
    angle = distance / curve.radius(pulley)

    pressing = np.where(np.abs(distance) < half_arc + EDGE, profile.normal_force, 0.0)
    share = pressing / pressing.sum()
    moment = force * radius * np.array([share @ np.cos(angle), share @ np.sin(angle)])
    tilt = tilt_under(float(np.hypot(*moment)), *sheave)
    penetration = profile.normal_force / (parameters["contact.stiffness"] * np.cos(beta))

    on_arc = np.abs(distance) <= half_arc
    deviation = profile.radial_deviation[on_arc]
    opening = -(deviation * np.tan(beta) + penetration[on_arc])
    groove = np.column_stack((radius * np.cos(angle), radius * np.sin(angle), np.ones_like(angle)))[on_arc]
    fitted, *_ = np.linalg.lstsq(groove, opening, rcond=None)
    psi, amount = fitted[:2], float(np.hypot(*fitted[:2]))
    turn = float(np.arctan2(moment[0] * psi[1] - moment[1] * psi[0], moment @ psi))
    by_law = groove[:, :2] @ (psi * (tilt / amount)) if amount > 0.0 else np.zeros_like(opening)

    spacing, lead = profile.position[1] - profile.position[0], 1.0 - parameters["belt.pitchOffset"] / radius
    return SpiralRunning(
        force,
        1.0 - float(pressing.sum()) * spacing * lead * np.cos(beta) / force,
        tilt,
        state[f"{pulley}.tilt"],
        amount,
        turn,
        float(np.abs(opening - groove @ fitted).max() / np.tan(beta)),
        float(np.ptp(by_law + penetration[on_arc]) / np.tan(beta)),
        float(np.ptp(deviation)),
    )


# The section


MESH = ("mesh.primaryArc", "mesh.secondaryArc", "mesh.strand")
THRUST_TOLERANCE, SLIP_TOLERANCE = 0.007, 0.03
DEGREES = Unit("°", 1, 180.0 / np.pi)


def run(bench: Bench, plan: Plan) -> Section:
    """Solves the load cases, also on twice the mesh, and evaluates the checks."""
    running: list[tuple[str, SpiralRunning]] = []
    finer: dict[str, list[tuple[str, float | None]]] = {"thrustRatio": [], "slip": []}
    for case in plan.thin(load_cases(bench.parameters), 2):
        ratio = ratio_of(case.theta)
        values = driven_by_torque(bench.parameters, ratio, load_case_speed(), case.torque, case.clamping_force)
        out = bench.steady(values, f"load case {case.name}")
        if out:
            state = BeltState(out, bench.states.unit.profile())
            running += [(f"{case.name}, {pulley}", spiral_running(state, bench.parameters, pulley)) for pulley in ("primary", "secondary")]
        fine = bench.steady({**values, **{name: round(2.0 * bench.given(name)) for name in MESH}}, f"load case {case.name}, twice the mesh")
        for name, found in finer.items():
            found.append((case.name, fine[name] / out[name] - 1.0 if out and fine else None))
    return Section(
        "default-belt",
        Part.VERIFICATION,
        "Spiral running and mesh",
        "The nine load cases at default parameters. A sheave tilts under the moment of the belt's pressure, and a flank is pressed in; the "
        "radius along an arc follows from both. Twice the elements of the mesh hardly change the result.",
        (*_spiral_checks(running), *_mesh_checks(finer)),
        (_table(running),),
    )


def _mesh_checks(finer: Mapping[str, list[tuple[str, float | None]]]) -> list[Check]:
    return [
        within("mesh-thrust", "Twice the mesh: thrust ratio", OWN, finer["thrustRatio"], -THRUST_TOLERANCE, THRUST_TOLERANCE, PERCENT),
        within("mesh-slip", "Twice the mesh: slip", OWN, finer["slip"], -SLIP_TOLERANCE, SLIP_TOLERANCE, PERCENT),
    ]


def _spiral_checks(running: list[tuple[str, SpiralRunning]]) -> list[Check]:
    spread = [(name, one.error) for name, one in running]
    tilts = [(name, error) for name, one in running for error in one.tilt_errors if one.tilts]
    turns = [(name, one.turn) for name, one in running if one.tilts and abs(one.missing) <= MISSING]
    shapes = [(name, one.shape / one.found) for name, one in running]
    return [
        within("spiral-spread", "Spread of the running radius on an arc, by the law", OWN, spread, -TOLERANCE, TOLERANCE, PERCENT),
        within("spiral-tilt", "Tilt, by the law and by the shape of the groove", OWN, tilts, -TILT_TOLERANCE, TILT_TOLERANCE, PERCENT),
        within("spiral-turn", "Direction of the tilt, where the points have the axial force within 5 %", OWN, turns, -TURN_TOLERANCE, TURN_TOLERANCE, DEGREES),
        within("spiral-shape", "Distance from the groove of a tilted cone over the spread", OWN, shapes, None, SHAPE_TOLERANCE, PERCENT),
    ]


def _table(running: list[tuple[str, SpiralRunning]]) -> Table:
    columns = (
        Column("Case"), Column("Axial force", "kN", 2, 1e-3), Column("Tilt by the law", "mrad", 3, 1e3), Column("of the FMU", "mrad", 3, 1e3),
        Column("of the groove", "mrad", 3, 1e3), Column("Direction", "°", 1, 180.0 / np.pi, signed=True),
        Column("Spread by the law", "mm", 3, 1e3), Column("found", "mm", 3, 1e3), share("Difference"),
    )  # fmt: skip
    rows = [
        [name, r.axial_force, r.tilt, r.tilt_reported, r.tilt_found, r.turn, r.predicted, r.found, r.error] for name, r in running
    ]
    return table("spiral", "Spiral running in the load cases", columns, rows, "2000 rpm.")
