"""The example of the FMI layer: a first-order lag, built, packed and simulated in both versions of FMI."""

from __future__ import annotations

import subprocess
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from conftest import built
from fmpy.validation import validate_fmu

pytestmark = pytest.mark.slow
PLATFORM = {2: fmpy.platform, 3: fmpy.platform_tuple}  # The folder of the library in an archive of each version


@pytest.fixture(scope="module")
def artifacts() -> dict[str, Path]:
    # As `cargo fmu test --all` has compiled the package.
    return built(["--workspace", "--exclude=fmu-build"], "lag", "lag_description")


@pytest.fixture(params=[2, 3])
def lag(request: pytest.FixtureRequest, artifacts: dict[str, Path], tmp_path: Path) -> Path:
    version, fmu = request.param, tmp_path / "Lag.fmu"
    command = [artifacts["lag_description"], str(version)]
    with zipfile.ZipFile(fmu, "w") as archive:
        archive.writestr("modelDescription.xml", subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        archive.write(artifacts["lag"], f"binaries/{PLATFORM[version]}/Lag{fmpy.sharedLibraryExtension}")
    return fmu


def test_it_follows_the_exact_solution(lag: Path) -> None:
    """An input is held from one communication point to the next."""
    assert validate_fmu(lag) == []
    constant, start = 0.5, 3.0
    steps = np.array([(0.0, 1.0), (1.0, 1.0), (1.0, 2.0), (2.0, 2.0)], dtype=[("time", float), ("u", float)])
    result = fmpy.simulate_fmu(lag, stop_time=2.0, output_interval=0.25, start_values={"T": constant, "start": start}, input=steps, output=["y"])
    assert len(result) == 9
    first, second = (np.exp(-np.maximum(result["time"] - begin, 0.0) / constant) for begin in (0.0, 1.0))
    np.testing.assert_allclose(result["y"], 1.0 + (start - 1.0) * first + (1.0 - second), rtol=1e-12)


def test_a_limit_of_the_table_holds(lag: Path) -> None:
    with pytest.raises(fmpy.fmi1.FMICallException):
        fmpy.simulate_fmu(lag, stop_time=1.0, start_values={"T": 0.0})
