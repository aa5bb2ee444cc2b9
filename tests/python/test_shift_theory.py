"""Tests of the theory's shift law: limits, symmetry, closure of the belt, the published linearity."""

from __future__ import annotations

from math import exp, log, pi, radians

import numpy as np
import pytest

from pushbelt_validation.theory import cmm
from pushbelt_validation.theory.shifting import SMALL, Belt, ShiftLaw, idle_arc

BETA, MU = radians(11.0), 0.09
BENCH = Belt(BETA, MU, 0.168, 0.703)
"""The laboratory variator."""
PLACES = (0.6, 1.0, 1.8)
WRAPS = (2.617, pi, 3.666)


@pytest.fixture(scope="module")
def law() -> ShiftLaw:
    return ShiftLaw(BENCH, (0.5, 0.7, 1.0, 1.4, 2.0))


@pytest.mark.parametrize("wrap", WRAPS)
def test_without_shifting_it_is_the_steady_arc(wrap: float) -> None:
    """A → 0: the solution converges to that of the steady theory, with a difference proportional to A."""
    steady = cmm.arc_at_traction(wrap, BETA, MU, 0.0)
    assert idle_arc(wrap, BETA, MU, 0.0).thrust == pytest.approx(steady.thrust, rel=1e-9)
    off = [idle_arc(wrap, BETA, MU, shift).thrust - steady.thrust for shift in (0.02, 0.01)]
    assert off[0] / off[1] == pytest.approx(2.0, rel=0.05)


@pytest.mark.parametrize("s", PLACES)
def test_swapping_the_pulleys_mirrors_the_law(s: float) -> None:
    """With the pulleys' roles swapped ln(F_P/F_S) changes its sign, and d(ln s)/dt per speed of the faster shaft too."""
    forward = BENCH.shift(s, 0.3)
    wrap_p, wrap_s, _, _ = cmm.wrap_angles(1.0 / s, 0.168, 0.703)
    backward = BENCH.shift(1.0 / s, -0.3 * wrap_p / wrap_s)
    assert forward.log_thrust_ratio == pytest.approx(-backward.log_thrust_ratio, abs=1e-9)
    # d ln s/dt = rate/s in units of ω_P; the other pulley turns s times as fast.
    assert forward.rate / s == pytest.approx(-backward.rate * s * s, rel=1e-9)


@pytest.mark.parametrize("s", PLACES)
def test_the_belt_keeps_its_length(s: float) -> None:
    """The radii of closed belts follow the rates of both pulleys."""
    shift = BENCH.shift(s, SMALL)
    dlog_s = 1e-5
    ratios = [cmm.wrap_angles(1.0 / (s * exp(sign * dlog_s)), 0.168, 0.703)[2:] for sign in (-0.5, 0.5)]
    (p_before, s_before), (p_after, s_after) = ratios
    # dR_P/dt = A_P ω_P R_P a Δ and dR_S/dt = A_S ω_S R_S a Δ with ω_S = ω_P s.
    primary = log(p_after / p_before) / dlog_s
    secondary = log(s_after / s_before) / dlog_s
    rate = shift.rate / s
    assert primary * rate == pytest.approx(shift.primary.shift, rel=1e-4)
    assert secondary * rate == pytest.approx(shift.secondary.shift * s, rel=1e-4)


@pytest.mark.parametrize("s", PLACES)
def test_the_rate_is_linear_in_the_logarithm_of_the_forces(s: float) -> None:
    """The published statement, for steps of up to ±0.4 within 6 % of the slope at rest."""
    rest, slope = BENCH.equilibrium(s), BENCH.gain(s)
    for shift in (-0.3, -0.2, 0.2, 0.3):
        found = BENCH.shift(s, shift)
        assert abs(found.log_thrust_ratio - rest) < 0.42
        assert found.rate / (found.log_thrust_ratio - rest) == pytest.approx(slope, rel=0.06)


def test_splines_meet_the_theory_between_their_places(law: ShiftLaw) -> None:
    for s in (0.6, 0.85, 1.2, 1.7):
        assert law.gain(s) == pytest.approx(BENCH.gain(s), rel=5e-3)
        assert law.equilibrium(s) == pytest.approx(BENCH.equilibrium(s), abs=2e-3)


def test_a_run_begins_with_the_law_and_ends_in_equilibrium(law: ShiftLaw) -> None:
    step, speed, opening = 0.1, 100.0, 1e-3
    factor = speed * opening * cmm.deformation_factor(BETA)
    start = law.run(1.0, step, speed, opening, np.array([1e-4]))
    assert (start[0] - 1.0) / 1e-4 == pytest.approx(factor * law.gain(1.0) * step, rel=1e-3)
    end = float(law.run(1.0, step, speed, opening, np.arange(0.05, 30.0, 0.05))[-1])
    assert law.equilibrium(end) == pytest.approx(step, abs=1e-3)
