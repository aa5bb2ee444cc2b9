"""The pull chain in the FMU and in the programs."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import MESH

import pushbelt
from pushbelt.demo.__main__ import main as demo
from pushbelt.fmu.data import is_chain, parameter_set

ABSENT = ("pushForce.max", "loss.ring", "loss.layers", "primary.idleArc", "secondary.idleArc", "ring.stressMax")


def test_a_chain_pulls(fmu: Path) -> None:
    with pushbelt.Variator("chain168", MESH, fmu=fmu) as variator:
        outputs = variator.start()
        profile = variator.profile()
    assert {name: outputs[name] for name in ABSENT} == dict.fromkeys(ABSENT, 0.0)
    assert outputs["loss.joints"] > 1.0
    assert not profile.push_force.any() and not profile.gap.any()
    assert profile.ring_tension.min() > 500.0


def test_the_pitch_line_of_a_chain_is_its_centre_line(tmp_path: Path) -> None:
    own = tmp_path / "own.json"
    own.write_text('{"parameters": {"belt.kind": {"value": 2}, "belt.pitchOffset": {"value": 1e-3}}}', encoding="utf-8")
    values = parameter_set(str(own))
    assert is_chain(values) and values["belt.pitchOffset"] == 0.0
    assert not is_chain(parameter_set("bench168"))


@pytest.mark.slow
def test_the_demo_draws_a_chain(fmu: Path, tmp_path: Path) -> None:
    assert demo(["--fmu", str(fmu), "--output", str(tmp_path), "--variator", "chain168", "--short"]) == 0
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "The pins of the chain are drawn." in page and "kN tension" in page
    assert "Push force" not in page and "polygon action" in page
