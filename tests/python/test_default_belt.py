"""Spiral running by the law of tilt and contact: what its checks find, on fields that are made up."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pushbelt.fmu import data
from pushbelt.fmu.results import BeltState, Profile
from pushbelt_validation.outcome import Verdict
from pushbelt_validation.sections.default_belt import (
    TILT_TOLERANCE,
    TOLERANCE,
    SpiralRunning,
    _spiral_checks,
    spiral_running,
)
from pushbelt_validation.tilt import tilt_under

BENCH = data.parameter_set("bench168")


def missed(*running: SpiralRunning) -> set[str]:
    """Keys of the missed checks."""
    return {check.key for check in _spiral_checks([("case", one) for one in running]) if check.verdict is Verdict.MISSED}


def belt_on_tilted_sheaves(
    stiffness: float, clearance: float = BENCH["primary.tiltClearance"], turned: float = 0.0, skewed: float = 0.0
) -> BeltState:
    """Fields by the law of tilt and contact, integrated on a fine grid, at points 10 mm apart; the pressure rises.

    The tilt is turned from its moment by an angle, rad; the groove is skewed by a second harmonic, relative.
    """
    curve, force = data.curve_of(BENCH, 0.2), {"primary": 12e3, "secondary": 8e3}
    beta = BENCH["geometry.wedgeAngle"]
    fine = curve.length * (np.arange(7200) + 0.5) / 7200
    pressure, deviation = np.zeros(7200), np.zeros(7200)
    outputs = {"reference.theta": 0.2}
    for pulley in ("primary", "secondary"):
        radius = curve.radius(pulley) - BENCH["belt.pitchOffset"]
        angle = curve.from_middle(pulley, fine) / curve.radius(pulley)
        arc = np.abs(angle) < 0.5 * curve.arc_length(pulley) / curve.radius(pulley)
        rising = np.where(arc, np.exp(0.4 * angle), 0.0)
        share = rising / rising.sum()
        pressure += force[pulley] * share / (np.cos(beta) * curve.length / 7200 * radius / curve.radius(pulley))
        moment = force[pulley] * radius * np.array([share @ np.cos(angle), share @ np.sin(angle)])
        softness = tilt_under(float(np.hypot(*moment)), stiffness, clearance) / np.hypot(*moment)
        psi = softness * np.hypot(*moment)
        ahead = angle - math.atan2(moment[1], moment[0]) - turned
        opening = radius * psi * (np.cos(ahead) + skewed * np.cos(2.0 * ahead))
        deviation -= np.where(arc, opening, 0.0) / np.tan(beta)
        outputs |= {f"{pulley}.axialForce": force[pulley], f"{pulley}.radius": radius, f"{pulley}.tilt": psi}
    deviation -= pressure / (BENCH["contact.stiffness"] * np.cos(beta) * np.tan(beta))
    points = slice(None, None, 100)
    none = np.zeros(72)
    profile = Profile(fine[points], none, none, pressure[points], deviation[points], none, none)
    return BeltState(outputs, profile)


def test_spiral_running_follows_from_tilt_and_contact() -> None:
    state = belt_on_tilted_sheaves(BENCH["primary.tiltStiffness"])
    for pulley in ("primary", "secondary"):
        found = spiral_running(state, BENCH, pulley)
        assert missed(found) == set()
        assert abs(found.error) < 0.02


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_spiral_running_shows_sheaves_that_tilt_otherwise(share: float) -> None:
    state = belt_on_tilted_sheaves(BENCH["primary.tiltStiffness"] / share, share * BENCH["primary.tiltClearance"])
    found = spiral_running(state, BENCH, "primary")
    assert abs(found.error) > TOLERANCE
    assert abs(found.tilt / found.tilt_reported - 1.0) > TILT_TOLERANCE
    assert missed(found) == {"spiral-spread", "spiral-tilt"}


def test_spiral_running_shows_a_tilt_that_is_not_the_reported_one() -> None:
    state = belt_on_tilted_sheaves(BENCH["primary.tiltStiffness"])
    wrong = BeltState({**state.outputs, "primary.tilt": 1.05 * state["primary.tilt"]}, state.profile)
    assert missed(spiral_running(wrong, BENCH, "primary")) == {"spiral-tilt"}


@pytest.mark.parametrize("degrees", [-10.0, 10.0])
def test_spiral_running_shows_a_tilt_that_is_turned(degrees: float) -> None:
    state = belt_on_tilted_sheaves(BENCH["primary.tiltStiffness"], turned=math.radians(degrees))
    for pulley in ("primary", "secondary"):
        found = spiral_running(state, BENCH, pulley)
        assert math.degrees(found.turn) == pytest.approx(degrees, abs=2.0)
        assert "spiral-turn" in missed(found)


def test_spiral_running_shows_a_groove_that_no_tilt_opens() -> None:
    found = spiral_running(belt_on_tilted_sheaves(BENCH["primary.tiltStiffness"], skewed=0.05), BENCH, "primary")
    assert "spiral-shape" in missed(found)
