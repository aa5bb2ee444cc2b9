"""A copy with own start values in several masters, and the checkers' verdicts. `test_cosim` compares runs in the same masters."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import fmpy
import masters
import numpy as np
import pytest
from conftest import needs

from pushbelt import cli

OUTPUTS = (
    "thrustRatio", "belt.speed", "ring.speed", "primary.speed", "secondary.speed", "ratio.geometric", "slip", "loss.total",
    "primary.axialForce", "secondary.shaftTorque", "pushForce.max", "spiral.secondary",
)  # fmt: skip

OTHERS = [
    pytest.param("libcosimpy", masters.with_libcosim, id="libcosim"),
    pytest.param("ecospy", masters.with_ecos, id="ecos"),
]


OWN = {"ring.model": 1, "friction.pulley": 0.085, "initial.ratio": 1.4, "primary.clampingForce": 15e3}


@pytest.fixture(scope="module")
def own(fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy with user-defined start values."""
    copy = tmp_path_factory.mktemp("own") / "own.fmu"
    words = [word for name, value in OWN.items() for word in ("--set", f"{name}={value}")]
    assert cli.main(["fmu", str(copy), "--fmu", str(fmu), *words]) == 0
    return copy


@pytest.mark.parametrize(("package", "run"), [pytest.param("fmpy", None, id="simulate_fmu"), *OTHERS])
def test_start_values_of_a_copy_hold_in_masters_that_pass_none_on(
    fmu: Path, own: Path, package: str, run: masters.Run | None
) -> None:
    """fmpy.simulate_fmu, libcosim and ecos do not set the start values of the model description."""
    needs(package)
    expected = masters.with_fmpy(fmu, OWN, lambda _: {}, 20, OUTPUTS)
    if run is None:
        result = fmpy.simulate_fmu(
            str(own), stop_time=0.02, step_size=masters.STEP, output_interval=masters.STEP, output=OUTPUTS
        )
        found = np.array([result[name] for name in OUTPUTS]).T
    else:
        found = run(own, {}, lambda _: {}, 20, OUTPUTS)
    assert found[-1] == pytest.approx(expected[-1], rel=1e-9)
    default = masters.with_fmpy(fmu, {}, lambda _: {}, 20, OUTPUTS)
    assert abs(found[-1][5] - default[-1][5]) > 0.3, "the ratio is another"


@pytest.mark.parametrize(("file", "version"), [("fmu", "2.0"), ("fmu3", "3.0")])
def test_the_checker_of_the_manipulation_toolbox_finds_nothing(
    request: pytest.FixtureRequest, file: str, version: str
) -> None:
    pytest.importorskip("fmu_manipulation_toolbox")
    tool = Path(sys.executable).with_name("fmutool")
    words = [tool, "-input", request.getfixturevalue(file), "-check"]
    checked = subprocess.run(words, capture_output=True, text=True, check=True)
    said = checked.stdout + checked.stderr
    assert f"compliant with FMI-{version}" in said
    assert "No semantic error" in said
    assert "ERROR" not in said and "WARNING" not in said, said
