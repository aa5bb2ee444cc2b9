"""Spiral running by the law of tilt and contact: what its checks find, on fields that are made up."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pushbelt.fmu import data
from pushbelt.fmu.results import BeltState, Profile
from pushbelt_validation.outcome import Verdict
from pushbelt_validation.sections.default_belt import _spiral_checks, spiral_running
from pushbelt_validation.tilt import tilt_under

BENCH = data.parameter_set("bench168")


def belt_on_tilted_sheaves(
    stiffness: float = 1.0, clearance: float = 1.0, turned: float = 0.0, skewed: float = 0.0, reported: float = 1.0
) -> BeltState:
    """Fields by the law of tilt and contact, integrated on a fine grid, at points 10 mm apart; the pressure rises.

    Stiffness, clearance and the reported tilt are relative to those of the parameters. The tilt is turned from its moment by an angle, rad;
    the groove is skewed by a second harmonic, relative.
    """
    stiffness, clearance = stiffness * BENCH["primary.tiltStiffness"], clearance * BENCH["primary.tiltClearance"]
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
        outputs |= {f"{pulley}.axialForce": force[pulley], f"{pulley}.radius": radius, f"{pulley}.tilt": reported * psi}
    deviation -= pressure / (BENCH["contact.stiffness"] * np.cos(beta) * np.tan(beta))
    points = slice(None, None, 100)
    none = np.zeros(72)
    profile = Profile(fine[points], none, none, pressure[points], deviation[points], none, none)
    return BeltState(outputs, profile)


@pytest.mark.parametrize(
    ("of_state", "expected"),
    [
        ({}, set()),
        ({"stiffness": 1.0 / 0.9, "clearance": 0.9}, {"spiral-spread", "spiral-tilt"}),
        ({"stiffness": 1.0 / 1.1, "clearance": 1.1}, {"spiral-spread", "spiral-tilt"}),
        ({"reported": 1.05}, {"spiral-tilt"}),
        ({"turned": math.radians(10.0)}, {"spiral-turn"}),
        ({"turned": math.radians(-10.0)}, {"spiral-turn"}),
        ({"skewed": 0.05}, {"spiral-shape"}),
    ],
)
def test_spiral_running_misses_what_is_not_the_law_of_tilt(of_state: dict[str, float], expected: set[str]) -> None:
    state = belt_on_tilted_sheaves(**of_state)
    found = spiral_running(state, BENCH, "primary")
    checks = {check.key for check in _spiral_checks([("case", found)]) if check.verdict is Verdict.MISSED}
    assert expected <= checks and (checks == expected or {"turned", "skewed"} & of_state.keys())
    assert math.degrees(found.turn) == pytest.approx(math.degrees(of_state.get("turned", 0.0)), abs=2.0)
    if not of_state:
        assert abs(found.error) < 0.02
