"""Tests of the continuum theory: limit cases, symmetry, convergence, published results."""

from __future__ import annotations

from math import atan2, cos, exp, pi, radians, sin, tan

import numpy as np
import pytest

from pushbelt_validation.theory import cmm

BETA = radians(11.0)
MU = 0.09
BENCH = (0.168, 0.703)
"""Pulley distance and belt length of the laboratory variator, m."""

WRAPS = (2.617, pi, 3.666)
RATIOS = (0.45, 0.7, 1.0, 1.5, 2.2)


def bench(ratio: float, traction: float, mu: float = MU) -> cmm.Variator:
    wrap_p, wrap_s, _, _ = cmm.wrap_angles(ratio, *BENCH)
    return cmm.variator(wrap_p, wrap_s, BETA, mu, traction)


# ------------------------------------------------------------------------------------------------ geometry, groove


def test_geometry_of_the_laboratory_variator() -> None:
    """Radii and wrap angles published for the speed ratio 2.25, and the radius at ratio 1."""
    assert cmm.wrap_angles(1.0, *BENCH)[2:] == pytest.approx((0.05841, 0.05841), abs=2e-5)
    wrap_p, wrap_s, radius_p, radius_s = cmm.wrap_angles(1.0 / 2.25, *BENCH)
    assert (radius_p, radius_s) == pytest.approx((0.07837, 0.03483), abs=2e-5)
    assert (wrap_p, wrap_s) == pytest.approx((3.666, 2.617), abs=1e-3)


def test_groove_of_sattler() -> None:
    """Angle beta + (Delta/2) cos and as much local widening let the belt run a Delta R cos deeper."""
    delta, radius = 1e-6, 0.06
    for phase in (0.0, 0.7, 2.0, pi):
        opening = delta / 2.0 * cos(phase)
        # The half width R tan(beta) + w at the belt's place stays that of the belt; the groove's line tilts by the
        # opening about its apex, and a rigid tilt of the sheave moves it apart by R * opening.
        half_width = radius * tan(BETA)
        deeper = radius - (half_width - radius * opening) / tan(BETA + opening)
        assert deeper / radius == pytest.approx(cmm.deformation_factor(BETA) * delta * cos(phase), rel=1e-4, abs=1e-12)


# ----------------------------------------------------------------------------------------------------- limit cases


@pytest.mark.parametrize("wrap", WRAPS)
@pytest.mark.parametrize("sign", (-1.0, 1.0))
def test_full_tangential_slip(wrap: float, sign: float) -> None:
    """psi = +-pi/2: F'_out/F'_in = exp(+-mu alpha/sin beta), T = 2 mu S R/cos beta, F' an exponential of theta."""
    arc = cmm.arc_at_creep(wrap, BETA, MU, sign * 1e7)
    assert arc.log_ratio == pytest.approx(sign * MU * wrap / sin(BETA), rel=1e-6)
    torque = arc.tension[-1] - arc.tension[0]  # on the pulley, per radius and mean reduced force
    assert torque == pytest.approx(sign * 2.0 * MU * arc.thrust / cos(BETA), rel=1e-6)
    growth = np.log(arc.tension / arc.tension[0])
    assert growth == pytest.approx(sign * MU * arc.theta / sin(BETA), abs=1e-6)
    # The thrust by the closed form of the same exponential, and its centre.
    k = sign * MU / sin(BETA)
    entry = 2.0 / (1.0 + exp(k * wrap))
    assert arc.thrust == pytest.approx(entry * (exp(k * wrap) - 1.0) / (2.0 * k * tan(BETA)), rel=1e-6)
    moment = (np.exp((k + 1j) * wrap) - 1.0) / (k + 1j)
    assert arc.centre == pytest.approx(atan2(moment.imag, moment.real) % (2.0 * pi), abs=1e-6)


# ---------------------------------------------------------------------------------------------- balances and signs


@pytest.mark.parametrize("wrap", WRAPS)
@pytest.mark.parametrize("traction", (-0.4, -0.1, 0.0, 0.2, 0.45))
def test_fields_close_the_balances(wrap: float, traction: float) -> None:
    """Equations (4) to (7) checked on the fields by another quadrature, from first principles in Cartesian axes."""
    arc = cmm.arc_at_traction(wrap, BETA, MU, traction, points=20_001)
    theta, p = arc.theta, arc.pressure
    beta_s = np.arctan(tan(BETA) * np.cos(arc.psi))
    # Force of both flanks on the belt, per angle: normal and friction against the sliding.
    radial = 2.0 * p * (sin(BETA) - MU * np.cos(beta_s) * np.cos(arc.psi))
    tangential = -2.0 * p * MU * np.cos(beta_s) * np.sin(arc.psi)
    # The arc as a free body: pulled backwards at the entry, forwards at the exit. Direction of motion at theta is
    # (-sin theta, cos theta), outward (cos theta, sin theta).
    entry, exit_ = arc.tension[0], arc.tension[-1]
    x = np.trapezoid(radial * np.cos(theta) - tangential * np.sin(theta), theta) - exit_ * sin(wrap)
    y = np.trapezoid(radial * np.sin(theta) + tangential * np.cos(theta), theta) + exit_ * cos(wrap) - entry
    assert (x, y) == pytest.approx((0.0, 0.0), abs=2e-4)
    # Moment about the axis.
    assert np.trapezoid(tangential, theta) + exit_ - entry == pytest.approx(0.0, abs=2e-4)
    # Thrust and centre.
    p_ax = p * (cos(BETA) + MU * np.sin(beta_s))
    assert np.trapezoid(p_ax, theta) == pytest.approx(arc.thrust, rel=1e-4)
    assert p_ax == pytest.approx(arc.axial_pressure, rel=1e-12)
    s, c = np.trapezoid(p_ax * np.sin(theta), theta), np.trapezoid(p_ax * np.cos(theta), theta)
    assert atan2(s, c) % (2.0 * pi) == pytest.approx(arc.centre, abs=1e-4)
    assert np.hypot(s, c) / arc.thrust == pytest.approx(arc.moment, rel=1e-4)
    assert arc.tension[0] + arc.tension[-1] == pytest.approx(2.0, rel=1e-8)


# -------------------------------------------------------------------------------------------- symmetry, uniqueness


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("traction", (-0.35, -0.1, 0.0, 0.3))
def test_mirror_symmetry(ratio: float, traction: float) -> None:
    """With the roles of the pulleys swapped the strands swap too: i_F(i; r) i_F(1/i; -r) = 1."""
    assert bench(ratio, traction).thrust_ratio * bench(1.0 / ratio, -traction).thrust_ratio == pytest.approx(
        1.0, rel=1e-9
    )


# -------------------------------------------------------------------------------------------------------- capacity


def test_beyond_capacity_is_refused() -> None:
    wraps = cmm.wrap_angles(0.45, *BENCH)[:2]
    limit = cmm.capacity(*wraps, BETA, MU)
    cmm.variator(*wraps, BETA, MU, 0.999 * limit)
    with pytest.raises(ValueError, match="capacity"):
        cmm.variator(*wraps, BETA, MU, 1.01 * limit)


# --------------------------------------------------------------------- rigid pulleys and elastic belt, for contrast


def test_rest_and_slip_arc_meets_the_published_reference_case() -> None:
    """The belt155 case: 25 N m at R_S/R_P = 2.5 and 20 kN gives a slip arc of 33.7 deg and a thrust ratio of 0.8916."""
    mu, case = 0.11, {"upper": 2966.588, "lower": 2151.913, "speed": 9.635874562}
    ring = 2 * 9 * 0.000185 * 0.00975 * 7700
    elements = 432 * 0.001858 / 0.661195
    centrifugal = (ring + elements) * case["speed"] ** 2
    upper, lower = case["upper"] - centrifugal, case["lower"] - centrifugal
    traction = (upper - lower) / (upper + lower)
    wrap_p, wrap_s, radius_p, _ = cmm.wrap_angles(2.5, 0.155, 0.661195)
    assert (upper - lower) * radius_p == pytest.approx(25.0, rel=2e-3)
    ratio, slip_arc, thrust_p, thrust_s = cmm.rest_and_slip_arc(wrap_p, wrap_s, BETA, mu, traction)
    assert np.degrees(slip_arc) == pytest.approx(33.7321, rel=2e-3)
    mean = (upper + lower) / 2.0
    assert thrust_s * mean == pytest.approx(20_000.0, rel=2e-3)
    assert thrust_p * mean == pytest.approx(17_831.7, rel=2e-3)
    assert ratio == pytest.approx(0.8916, rel=1e-3)
