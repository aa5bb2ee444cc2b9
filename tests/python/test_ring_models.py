"""Every ring that the two FMUs offer, run by fmpy on the paper's test rig."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest
from pushbelt_paper.cases import RingModel

from pushbelt.fmu.enumerations import Axial, Drive
from pushbelt.fmu.unit import Archive, Instance, UnitError

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
    "ALE in space, A_i = [t, n, b]": {"ring.model": RingModel.ALE, "ring.referenceDirections": True, "ring.spatial": True},
    "RCM": {"ring.model": RingModel.RCM},
    "ANCF": {"ring.model": RingModel.ANCF},
}

OUTPUTS = ["thrustRatio", "efficiency", "slip", "ring.tensionMin", "pushForce.max", "energy.residual"]


def run(fmu: Path, model: str, stop: float) -> np.ndarray:
    """A run of one of the models on the FMU."""
    return fmpy.simulate_fmu(
        fmu, stop_time=stop, output_interval=2e-4, start_values=RIG | MODELS[model], output=OUTPUTS
    )


@pytest.fixture(scope="module")
def ale(fmu: Path) -> np.ndarray:
    return run(fmu, "ALE", 1e-3)


OF_FMU = ("ALE0", "ALE")  # Models of PushbeltVariator.fmu; the others are those of PushbeltPaper.fmu


@pytest.mark.parametrize(("model", "off"), list(zip(MODELS, (0.15, 1e-9, 3e-3, 3e-3, 0.05, 0.1), strict=True)))
def test_each_ring_model_runs(fmu: Path, paper_fmu: Path, ale: np.ndarray, model: str, off: float) -> None:
    """`off` is the tolerance of the thrust ratio, relative to that of ALE."""
    found = run(fmu if model in OF_FMU else paper_fmu, model, 2e-3)
    assert found["time"][-1] == pytest.approx(2e-3)
    assert all(np.all(np.isfinite(found[name])) for name in OUTPUTS)
    assert found["thrustRatio"][-5:].mean() == pytest.approx(ale["thrustRatio"][-5:].mean(), rel=off)
    assert 0.9 < found["efficiency"][-1] < 1.0
    # 2e-3 of what moved, 10.5 kW in and out over 2 ms, and 1e-3 of some 1300 J.
    assert np.all(np.abs(found["energy.residual"]) < 1.4)


def test_both_fmus_have_the_same_standard_rings(paper_fmu: Path, ale: np.ndarray) -> None:
    found = run(paper_fmu, "ALE", 1e-3)
    for name in OUTPUTS:
        assert np.array_equal(found[name], ale[name]), name


def test_enumerations_are_those_of_the_papers_fmu(paper_fmu: Path) -> None:
    description = fmpy.read_model_description(str(paper_fmu))
    (ring,) = (kind for kind in description.typeDefinitions if kind.name == "RingModel")
    assert {item.name: int(item.value) for item in ring.items} == {item.name: item.value for item in RingModel}


@pytest.mark.parametrize(
    ("ring", "name", "value"),
    [
        (RingModel.RCM, "mesh.aligned", False),
        (RingModel.ANCF, "ring.elements", 5),
        (RingModel.ALE0, "ring.referenceDirections", True),
        (RingModel.RCM, "ring.spatial", True),
        (RingModel.RCM, "solver.mode", 2),
    ],
)
def test_parameters_that_do_not_fit_a_ring_are_refused(paper_fmu: Path, ring: RingModel, name: str, value: float) -> None:
    with Archive.unpack(paper_fmu) as archive, pytest.raises(UnitError, match=name), Instance(archive, {"ring.model": ring, name: value}) as unit:
        unit.initialise()
