"""The FMU in `fmu-runner`, an importer in Rust that shares no code with fmpy or this project. `tests/importer` uses it."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from conftest import ROOT

from pushbelt.fmu.unit import Archive, Instance

INPUTS = {"primary.torque": 60.0, "secondary.torque": -58.0, "primary.clampingForce": 14e3, "secondary.clampingForce": 10e3}
STEPS = 40


@pytest.fixture(scope="module")
def importer() -> Path:
    """The program, compiled in a folder of its own."""
    cargo = os.environ.get("CARGO") or shutil.which("cargo")
    if cargo is None:
        pytest.skip("cargo is not on the path: the importer can't be compiled")
    target = ROOT / "target" / "importer"
    environment = {**os.environ, "CARGO_TARGET_DIR": str(target)}
    manifest = ROOT / "tests" / "importer" / "Cargo.toml"
    done = subprocess.run(
        [cargo, "build", "--locked", "--manifest-path", manifest], env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return target / "debug" / ("importer.exe" if os.name == "nt" else "importer")


@pytest.mark.slow
def test_an_importer_in_rust_finds_what_fmpy_finds(importer: Path, fmu: Path) -> None:
    done = subprocess.run([importer, fmu, str(STEPS)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    found = {name: float(value) for name, value in (line.split() for line in done.stdout.splitlines())}
    with Archive.unpack(fmu) as archive, Instance(archive, {}) as unit:
        unit.initialise()
        unit.set(INPUTS)
        for step in range(STEPS):
            unit.step_to((step + 1) * 1e-3)
        expected = dict(zip(found, unit.get_reals(unit.reals(found)), strict=True))
    assert len(found) == 6
    assert found == pytest.approx(expected, rel=1e-9)
    assert found["ratio.geometric"] != pytest.approx(1.0, abs=1e-3), "the inputs act"
