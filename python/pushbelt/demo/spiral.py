"""Spiral running: radial motion of elements along an arc, by the law of tilt and contact.

The axial pressure p_ax of the belt tilts a sheave by ψ under the moment ∫p_ax ϱ (cos θ, sin θ), first by its clearance, then by
bending, and so opens the groove by w = ϱ (ψ_x cos θ + ψ_y sin θ). A flank under the normal force p per length is pressed in by g = p/(k_c cos β). An element
runs further in by the sum of both over the slope of the groove,

    Δϱ = −(w + g)/tan β.

The points of the profile contain Δϱ and p. A least-squares fit determines from them the tilt that opens the groove (two unknowns) and the
arc's mean. The remainder shows whether the groove opens like that of a tilted cone.

The moment is computed from the normal force at the points, scaled to the axial force. Its magnitude gives |ψ| by the law of the
tilt. Its direction is less accurate: the pressure has peaks of some millimetres at the borders of the arc, the points are 10 mm apart, and
friction along the flank has an axial share that the normal force does not include. The direction is therefore compared separately, and the
spread is predicted with |ψ| by the law in the fitted direction. On a small arc 4° of direction change the spread by 10 %.

With a uniform pressure and no g the spread over an arc of angle α would be (ϱ ψ/tan β) (1 − cos(α/2)), with the tilt ψ under
F ϱ sin(α/2)/(α/2). This is not a good estimate, because the pressure rises towards the exit and turns the tilt by up to 45°.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from pushbelt.fmu.data import curve_at
from pushbelt.fmu.fields import EDGE
from pushbelt.fmu.results import BeltState, LoadCaseResult
from pushbelt.fmu.tilt import tilt_under

TOLERANCE = 0.05
"""Relative tolerance of the predicted spread. The normal forces at the points do not represent the whole axial force."""

TILT_TOLERANCE = 0.02
"""Relative tolerance of the tilt that the FMU reports, compared with the law under the moment of the points and with the fitted groove.
An error of the force has little influence beyond the clearance, since most of the tilt is the clearance."""

TURN_TOLERANCE = 5.0 * np.pi / 180.0
"""Largest angle between the direction of the tilt and that of the moment of the points, rad. If 5 % of the axial force are missing at
the border of an arc, a moment with a lever of 0.65 ϱ turns by 4.4°. The axial share of friction, μ tan β, adds up to 1°."""

SHAPE_TOLERANCE = 0.02
"""Largest remainder of the fit, relative to the spread."""


@dataclass(frozen=True)
class SpiralRunning:
    """Spread of the running radius between the points of the profile on one arc."""

    pulley: str
    axial_force: float
    """N."""
    axial_force_at_points: float
    """Sum of the normal forces at the points of the profile, along the axis, N."""
    wrap_angle: float
    """rad."""
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
    uniform: float
    """Spread due to tilt under a uniform pressure, m."""
    predicted: float
    """Spread by the law in the fitted direction, m."""
    found: float
    """Spread in the profile, m."""

    @property
    def left_out(self) -> float:
        """Magnitude of the relative difference between the axial force and the sum of the normal forces at the points."""
        return abs(self.axial_force_at_points / self.axial_force - 1.0)

    @property
    def error(self) -> float:
        """Relative error of the predicted spread."""
        return self.found / self.predicted - 1.0

    @property
    def tilts(self) -> bool:
        """Whether the sheave tilts. The tilt of a rigid one has no direction."""
        return self.tilt > 1e-6

    @property
    def follows(self) -> bool:
        """Whether spread, tilt, direction and shape agree with the law."""
        tilts = not self.tilts or (
            abs(self.tilt / self.tilt_reported - 1.0) <= TILT_TOLERANCE
            and abs(self.tilt_found / self.tilt_reported - 1.0) <= TILT_TOLERANCE
            and abs(self.turn) <= TURN_TOLERANCE
        )
        return tilts and abs(self.error) <= TOLERANCE and self.shape <= SHAPE_TOLERANCE * self.found


def spiral_running(state: BeltState, parameters: Mapping[str, float], pulley: str) -> SpiralRunning:
    """Spread on the arc of a pulley, simulated and predicted."""
    curve, profile = curve_at(parameters, state), state.profile
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

    on_arc, half_angle = np.abs(distance) <= half_arc, half_arc / curve.radius(pulley)
    deviation = profile.radial_deviation[on_arc]
    opening = -(deviation * np.tan(beta) + penetration[on_arc])
    groove = np.column_stack((radius * np.cos(angle), radius * np.sin(angle), np.ones_like(angle)))[on_arc]
    fitted, *_ = np.linalg.lstsq(groove, opening, rcond=None)
    psi, amount = fitted[:2], float(np.hypot(*fitted[:2]))
    turn = float(np.arctan2(moment[0] * psi[1] - moment[1] * psi[0], moment @ psi))
    by_law = groove[:, :2] @ (psi * (tilt / amount)) if amount > 0.0 else np.zeros_like(opening)

    lever = radius * np.sin(half_angle) / half_angle
    return SpiralRunning(
        pulley,
        force,
        float(pressing.sum() * np.cos(beta) * curve.length / len(profile.position) * radius / curve.radius(pulley)),
        2.0 * half_angle,
        tilt,
        state[f"{pulley}.tilt"],
        amount,
        turn,
        float(np.abs(opening - groove @ fitted).max() / np.tan(beta)),
        tilt_under(force * lever, *sheave) * radius * (1.0 - np.cos(half_angle)) / np.tan(beta),
        float(np.ptp(by_law + penetration[on_arc]) / np.tan(beta)),
        float(np.ptp(deviation)),
    )


def spiral_rows(
    cases: Iterable[LoadCaseResult], parameters: Mapping[str, float]
) -> list[tuple[LoadCaseResult, SpiralRunning]]:
    """All load cases on both pulleys."""
    return [
        (result, spiral_running(result.steady, parameters, pulley))
        for result in cases
        for pulley in ("primary", "secondary")
    ]
