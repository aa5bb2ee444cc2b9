"""Tests of the continuum theory: limit cases, symmetry, convergence, published results."""

from __future__ import annotations

from math import atan2, atanh, cos, exp, log, pi, radians, sin, tan, tanh

import numpy as np
import pytest
from scipy.integrate import solve_ivp

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


def test_the_belt_does_not_stretch() -> None:
    theta = np.linspace(0.0, 3.0, 4001)
    for shift in (0.0, 0.4):
        v_r, v_t = cmm.sliding(theta, 1.7, -0.8, shift)
        assert np.gradient(v_t, theta, edge_order=2) == pytest.approx(-v_r, abs=1e-6)


# ----------------------------------------------------------------------------------------------------- limit cases


@pytest.mark.parametrize("wrap", WRAPS)
def test_without_friction(wrap: float) -> None:
    """S = F' alpha/(2 tan beta); the groove opens in the middle. The thrust deviates in the second order."""
    deviations = []
    for mu in (0.02, 0.01, 0.005):
        arc = cmm.arc_at_traction(wrap, BETA, mu, 0.0)
        deviations.append(abs(arc.thrust / (wrap / (2.0 * tan(BETA))) - 1.0))
        assert arc.centre == pytest.approx(wrap / 2.0, abs=10.0 * mu)
    assert deviations[-1] < 1e-3
    assert deviations[0] / deviations[1] == pytest.approx(4.0, rel=0.1)
    assert deviations[1] / deviations[2] == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("ratio", RATIOS)
def test_frictionless_thrust_ratio_is_that_of_the_wrap_angles(ratio: float) -> None:
    wrap_p, wrap_s, _, _ = cmm.wrap_angles(ratio, *BENCH)
    assert bench(ratio, 0.0, mu=1e-6).thrust_ratio == pytest.approx(wrap_p / wrap_s, rel=1e-4)


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


@pytest.mark.slow
@pytest.mark.parametrize("ratio", (0.45, 0.7, 2.2))
@pytest.mark.parametrize("torque", (-60.0, 0.0, 60.0))
def test_torque_and_clamping_force(ratio: float, torque: float) -> None:
    """T_P = (F_1 - F_2) R_P; sigma V^2 shifts both strand forces alike and drops out."""
    wrap_p, wrap_s, radius_p, _ = cmm.wrap_angles(ratio, *BENCH)
    thrust = 20_000.0
    result = cmm.variator_at_torque(wrap_p, wrap_s, BETA, MU, radius_p, torque, thrust)
    assert 2.0 * result.traction * result.mean_force(thrust) * radius_p == pytest.approx(torque, abs=1e-5)
    assert result.torque_number * thrust * radius_p == pytest.approx(torque, abs=1e-5)
    with pytest.raises(ValueError, match="capacity"):
        cmm.variator_at_torque(wrap_p, wrap_s, BETA, MU, radius_p, 600.0, thrust)


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


@pytest.mark.parametrize("wrap", WRAPS)
def test_driving_and_driven_pulley(wrap: float) -> None:
    """A driving pulley runs ahead of the belt and F falls; a driven one lags and F rises. Friction never feeds power."""
    driving = cmm.arc_at_traction(wrap, BETA, MU, -0.4)
    driven = cmm.arc_at_traction(wrap, BETA, MU, 0.4)
    assert driving.tension[-1] < driving.tension[0] and driven.tension[-1] > driven.tension[0]
    assert driving.creep < -0.9 < driven.creep
    for arc in (driving, driven):
        # Mean tangential speed of the belt against the pulley, weighted by the friction it meets, has the friction's
        # sign; the power of friction on the belt is negative at every place by (3) to (5).
        v_r, v_t = cmm.sliding(arc.theta, arc.centre, arc.creep)
        beta_s = np.arctan(tan(BETA) * np.cos(arc.psi))
        power = -MU * (np.cos(beta_s) * np.sin(arc.psi) * v_t + np.cos(beta_s) * np.cos(arc.psi) * v_r / cos(BETA) ** 2)
        assert (power <= 0.0).all()


@pytest.mark.parametrize("wrap", WRAPS)
@pytest.mark.parametrize("traction", (-0.45, -0.1, 0.0, 0.2, 0.45))
def test_power_balance(wrap: float, traction: float) -> None:
    """Friction power integrated along the arc equals the power of the belt minus the power transmitted to the pulley."""
    arc = cmm.arc_at_traction(wrap, BETA, MU, traction, points=20_001)
    v_r, v_t = cmm.sliding(arc.theta, arc.centre, arc.creep)
    speed = np.sqrt(v_t**2 + (v_r / cos(BETA)) ** 2)
    assert np.trapezoid(2.0 * MU * arc.pressure * speed, arc.theta) == pytest.approx(arc.dissipation, rel=1e-4)
    mean = np.trapezoid(arc.axial_pressure * v_t, arc.theta) / arc.thrust
    assert mean == pytest.approx(arc.mean_sliding, abs=1e-4)


def test_pressure_is_high_where_the_belt_slides_outward() -> None:
    """Radial friction: inward sliding before theta_c unloads the flanks, outward sliding after it loads them."""
    arc = cmm.arc_at_traction(pi, BETA, MU, 0.0)
    quasi_free = arc.tension / (2.0 * sin(BETA))
    assert (arc.pressure[arc.theta < arc.centre - 0.3] < quasi_free[arc.theta < arc.centre - 0.3]).all()
    assert (arc.pressure[arc.theta > arc.centre + 0.3] > quasi_free[arc.theta > arc.centre + 0.3]).all()
    assert arc.centre > pi / 2.0


# -------------------------------------------------------------------------------------------- symmetry, uniqueness


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("traction", (-0.35, -0.1, 0.0, 0.3))
def test_mirror_symmetry(ratio: float, traction: float) -> None:
    """With the roles of the pulleys swapped the strands swap too: i_F(i; r) i_F(1/i; -r) = 1."""
    assert bench(ratio, traction).thrust_ratio * bench(1.0 / ratio, -traction).thrust_ratio == pytest.approx(
        1.0, rel=1e-9
    )


@pytest.mark.parametrize("ratio", RATIOS)
def test_capacity_is_mirrored(ratio: float) -> None:
    wraps = cmm.wrap_angles(ratio, *BENCH)[:2]
    assert cmm.capacity(*wraps, BETA, MU, True) == pytest.approx(
        cmm.capacity(wraps[1], wraps[0], BETA, MU, False), rel=1e-9
    )


@pytest.mark.parametrize("wrap", WRAPS)
def test_one_centre_for_each_creep(wrap: float) -> None:
    """Equation (7) has a single root between entry and exit."""
    for creep in (-20.0, -3.0, -1.3, -1.01, -0.95, -0.7, 0.0, 1.0, 20.0):
        centres = np.linspace(1e-6, wrap - 1e-6, 120)
        excess = np.array([c - cmm._integrate(wrap, BETA, MU, creep, c).direction for c in centres])
        assert np.count_nonzero(np.diff(np.sign(excess))) == 1


@pytest.mark.parametrize("wrap", WRAPS)
def test_force_ratio_grows_with_creep(wrap: float) -> None:
    """On the branch with the smaller creep ln F'_out/F'_in is monotone, so the solution is the only one there."""
    low, high = cmm._creep_range(wrap, BETA, MU)
    values = [cmm.log_ratio(wrap, BETA, MU, cmm.creep_of(u)) for u in np.linspace(low, high, 60)]
    assert (np.diff(values) > 0.0).all()


# ----------------------------------------------------------------------------------------------------- convergence


@pytest.mark.parametrize("creep", (-3.0, -1.02, -1.0001, -0.9, -0.5, 0.3, 1.0, 4.0))
@pytest.mark.parametrize("shift", (0.0, -0.3, 0.5))
def test_own_integration_has_converged(creep: float, shift: float) -> None:
    coarse = cmm.arc_at_creep(3.0, BETA, MU, creep, shift)
    fine = cmm.arc_at_creep(3.0, BETA, MU, creep, shift, refinement=3)
    assert coarse.centre == pytest.approx(fine.centre, abs=1e-8)
    assert coarse.log_ratio == pytest.approx(fine.log_ratio, abs=1e-8)
    assert coarse.thrust == pytest.approx(fine.thrust, rel=1e-8)


@pytest.mark.parametrize("creep", (-1.3, -0.9, 0.4))
@pytest.mark.parametrize("shift", (0.0, 0.3))
def test_against_an_ordinary_differential_equation(creep: float, shift: float) -> None:
    """The same equations marched along the arc by a general integrator."""
    wrap = 2.9
    arc = cmm.arc_at_creep(wrap, BETA, MU, creep, shift)

    def slope(theta: float, y: np.ndarray) -> list[float]:
        v_r = shift + sin(theta - arc.centre)
        v_t = creep + cos(theta - arc.centre) - shift * theta
        psi = atan2(v_t, v_r)
        beta_s = np.arctan(tan(BETA) * cos(psi))
        p = y[0] / (2.0 * (sin(BETA) - MU * cos(beta_s) * cos(psi)))
        p_ax = p * (cos(BETA) + MU * sin(beta_s))
        return [2.0 * p * MU * cos(beta_s) * sin(psi), p_ax, p_ax * sin(theta), p_ax * cos(theta)]

    end = solve_ivp(slope, (0.0, wrap), [arc.tension[0], 0.0, 0.0, 0.0], rtol=1e-10, atol=1e-12, max_step=0.01)
    force, thrust, sine, cosine = end.y[:, -1]
    assert force == pytest.approx(arc.tension[-1], rel=1e-7)
    assert thrust == pytest.approx(arc.thrust, rel=1e-7)
    assert atan2(sine, cosine) == pytest.approx(arc.centre, abs=1e-7)


# -------------------------------------------------------------------------------------------------------- capacity


def test_capacity_grows_with_wrap_and_friction() -> None:
    for driving in (0, 1):
        by_wrap = [abs(cmm.arc_capacity(wrap, BETA, MU)[driving]) for wrap in (2.0, 2.6, pi, 3.6)]
        by_friction = [abs(cmm.arc_capacity(pi, BETA, mu)[driving]) for mu in (0.03, 0.06, 0.09, 0.12)]
        assert (np.diff(by_wrap) > 0.0).all() and (np.diff(by_friction) > 0.0).all()


@pytest.mark.parametrize("wrap", WRAPS)
def test_capacity_is_near_full_slip(wrap: float) -> None:
    full_slip = MU * wrap / sin(BETA)
    low, high = cmm.arc_capacity(wrap, BETA, MU)
    assert -1.04 * full_slip < low <= -full_slip
    assert high == pytest.approx(full_slip, rel=1e-3)


def test_beyond_capacity_is_refused() -> None:
    wraps = cmm.wrap_angles(0.45, *BENCH)[:2]
    limit = cmm.capacity(*wraps, BETA, MU)
    cmm.variator(*wraps, BETA, MU, 0.999 * limit)
    with pytest.raises(ValueError, match="capacity"):
        cmm.variator(*wraps, BETA, MU, 1.01 * limit)


def test_self_locking_is_refused() -> None:
    with pytest.raises(ValueError, match="self-locking"):
        cmm.arc_at_creep(pi, BETA, 0.2, 0.0)


# ------------------------------------------------------------------------------------------------- published facts


def test_thrust_ratio_is_one_at_ratio_one_without_torque() -> None:
    assert bench(1.0, 0.0).thrust_ratio == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("ratio", RATIOS)
def test_thrust_ratio_grows_with_torque_up_to_half_the_capacity(ratio: float) -> None:
    limit = cmm.capacity(*cmm.wrap_angles(ratio, *BENCH)[:2], BETA, MU)
    values = [bench(ratio, share * limit).thrust_ratio for share in np.linspace(0.0, 0.5, 6)]
    assert (np.diff(values) > 0.0).all()


@pytest.mark.parametrize("traction", (-0.3, 0.0, 0.3))
def test_underdrive_medium_overdrive(traction: float) -> None:
    """The more the belt wraps the primary pulley, the more thrust it needs there."""
    assert (np.diff([bench(ratio, traction).thrust_ratio for ratio in (2.2, 1.5, 1.0, 0.7, 0.45)]) > 0.0).all()


def test_thrust_ratio_at_half_load_and_ratio_one() -> None:
    """Measured and published thrust ratios of pushbelts at ratio 1 under drive lie at 1.2 to 1.5."""
    assert 1.2 < bench(1.0, 0.3).thrust_ratio < 1.5


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


def test_both_theories_agree_on_full_slip() -> None:
    wrap_p, wrap_s, _, _ = cmm.wrap_angles(1.0, *BENCH)
    traction = tanh(0.999999 * MU * wrap_p / sin(BETA) / 2.0)
    ratio, slip_arc, thrust_p, _ = cmm.rest_and_slip_arc(wrap_p, wrap_s, BETA, MU, traction)
    assert slip_arc == pytest.approx(wrap_p, rel=1e-5)
    slipping = cmm.arc_at_creep(wrap_p, BETA, MU, -1e7)
    assert thrust_p == pytest.approx(slipping.thrust, rel=1e-4)
    assert ratio == pytest.approx(1.0, rel=1e-4)
    assert 2.0 * atanh(traction) == pytest.approx(log((1.0 + traction) / (1.0 - traction)))
