"""Every ring that the unit offers, run by fmpy on the paper's test rig."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest

from pushbelt.fmu.enumerations import Axial, Drive, RingModel

RIG = {
    "primary.drive": Drive.SPEED,
    "primary.axial": Axial.HELD,
    "primary.clampingForce": 8e3,
    "secondary.clampingForce": 6.2e3,
    "secondary.torque": -48.5,
}
"""Ratio 1, 2000 rpm, about 50 N.m: the primary sheave held, its speed given, as in the load cases."""

MODELS = {
    "ALE0": {"ring.model": RingModel.ALE0},
    "ALE": {"ring.model": RingModel.ALE},
    "ALE, A_i = [t, n]": {"ring.model": RingModel.ALE, "ring.referenceDirections": True},
    "ALE in space, A_i = [t, n, b]": {
        "ring.model": RingModel.ALE,
        "ring.referenceDirections": True,
        "ring.spatial": True,
    },
    "RCM": {"ring.model": RingModel.RCM},
    "ANCF": {"ring.model": RingModel.ANCF},
}

OUTPUTS = ["thrustRatio", "efficiency", "slip", "ring.tensionMin", "pushForce.max", "energy.residual"]


def run(fmu: Path, model: str, stop: float) -> np.ndarray:
    return fmpy.simulate_fmu(
        fmu, stop_time=stop, output_interval=2e-4, start_values=RIG | MODELS[model], output=OUTPUTS
    )


@pytest.fixture(scope="module")
def ale(fmu: Path) -> np.ndarray:
    return run(fmu, "ALE", 1e-3)


OFF = dict(zip(MODELS, (0.15, 1e-9, 3e-3, 3e-3, 0.05, 0.1), strict=True))
"""Thrust ratio against ALE's."""


@pytest.mark.parametrize(("model", "off"), OFF.items())
def test_each_ring_model_runs(fmu: Path, ale: np.ndarray, model: str, off: float) -> None:
    found = run(fmu, model, 2e-3)
    assert found["time"][-1] == pytest.approx(2e-3)
    for name in OUTPUTS:
        assert np.all(np.isfinite(found[name])), name
    thrust = found["thrustRatio"][-5:].mean()
    assert thrust == pytest.approx(ale["thrustRatio"][-5:].mean(), rel=off)
    assert 0.9 < found["efficiency"][-1] < 1.0
    # 2e-3 of what moved, 10.5 kW in and out over 2 ms, and 1e-3 of some 1300 J.
    assert np.all(np.abs(found["energy.residual"]) < 1.4)
