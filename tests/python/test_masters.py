"""A copy with own start values in a master that passes none on, and the checkers' verdicts. `test_cosim` has libcosim and ecos."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import fmpy
import numpy as np
import pytest

from pushbelt import cli

OUTPUTS = ["thrustRatio", "belt.speed", "ratio.geometric", "loss.total", "primary.axialForce", "spiral.secondary"]
OWN = {"ring.model": 1, "friction.pulley": 0.085, "initial.ratio": 1.4, "primary.clampingForce": 15e3}


def test_start_values_of_a_copy_hold_in_a_master_that_passes_none_on(fmu: Path, tmp_path: Path) -> None:
    """`fmpy.simulate_fmu`, libcosim and ecos do not set the start values of the model description."""
    words = [f"--set={name}={value}" for name, value in OWN.items()]
    assert cli.main(["fmu", str(tmp_path / "own.fmu"), "--fmu", str(fmu), *words]) == 0
    runs = ((tmp_path / "own.fmu", {}), (fmu, OWN), (fmu, {}))
    steps = {"stop_time": 0.02, "step_size": 1e-3, "output_interval": 1e-3}
    results = [fmpy.simulate_fmu(str(file), start_values=start, output=OUTPUTS, **steps) for file, start in runs]
    found, expected, default = (np.array([result[name] for name in OUTPUTS]) for result in results)
    assert np.array_equal(found, expected)
    assert np.abs(found[2] - default[2]).min() > 0.3, "the ratio is another"


@pytest.mark.parametrize(("file", "version"), [("fmu", "2.0"), ("fmu3", "3.0")])
def test_the_checker_of_the_manipulation_toolbox_finds_nothing(request: pytest.FixtureRequest, file: str, version: str) -> None:
    pytest.importorskip("fmu_manipulation_toolbox")
    words = [Path(sys.executable).with_name("fmutool"), "-input", request.getfixturevalue(file), "-check"]
    checked = subprocess.run(words, capture_output=True, text=True, check=True)
    said = checked.stdout + checked.stderr
    assert f"compliant with FMI-{version}" in said and "No semantic error" in said
    assert "ERROR" not in said and "WARNING" not in said, said
