"""Hosts that share no code with fmpy or this project: programs in C, for FMI 3.0 and for rigs, and `fmu-runner`, an importer in Rust. Then the
example of the FMI layer, a first-order lag, built, packed and simulated by fmpy in both versions of FMI."""

import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from conftest import ROOT, built, cargo
from fmpy.validation import validate_fmu

from pushbelt.fmu.unit import Archive, Instance

LOADS = ["smooth", "firing", "ripple", "noise", "slam", "launch", "flips", "stairs", "firing-and-noise", "hunting"]
INPUTS = {"primary.torque": 60.0, "secondary.torque": -58.0, "primary.clampingForce": 14e3, "secondary.clampingForce": 10e3}
STEPS = 60
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="the program needs Linux")
PLATFORM = {2: fmpy.platform, 3: fmpy.platform_tuple}  # The folder of the library in an archive of each version


@LINUX
@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc has the address sanitiser")
def test_a_host_in_c_finds_no_bad_access(fmu3: Path, tmp_path: Path) -> None:
    """With the address sanitiser, which also counts leaks: event mode, updates, rollback by way of bytes."""
    shutil.unpack_archive(fmu3, tmp_path, "zip")
    (library,) = (tmp_path / "binaries" / fmpy.platform_tuple).iterdir()
    program, source = tmp_path / "importer", ROOT / "examples" / "fmi3" / "importer.c"
    checks = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g", "-std=c11", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(["gcc", *checks, "-I", Path(fmpy.__file__).parent / "c-code", "-o", program, source, "-ldl", "-lm"], check=True)
    run = subprocess.run([program, library, fmpy.read_model_description(str(fmu3)).guid], capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "Sanitizer" not in run.stderr
    assert re.search(r"^slips at 0\.00\d+ s, event \w+ ?\w* at [\d.]+ s, push force up to \d+ N, \d+ own steps", run.stdout, re.M)


@LINUX
@pytest.mark.skipif(shutil.which("cc") is None, reason="the program needs a C compiler")
def test_the_program_for_rigs_runs_the_library_and_counts(fmu: Path, description: Any, tmp_path: Path) -> None:
    """In real time; a unit without a time reserve is not late."""
    shutil.unpack_archive(fmu, tmp_path, "zip")
    program, source = tmp_path / "hil", ROOT / "examples" / "hil" / "hil.c"
    subprocess.run(["cc", "-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "-o", program, source, "-ldl", "-lm"], check=True)
    command = [program, tmp_path / "binaries" / "linux64" / "PushbeltVariator.so", description.guid]
    run = subprocess.run([*command, "--seconds", "0.3", "--ring", "1", "--free"], check=True, capture_output=True, text=True)
    rows = re.findall(r"^([\w-]+): mean [\d.]+ ms, .*, 0 misses of 300, largest defect .*, (\d+) steps begun again, .* at most", run.stdout, re.M)
    assert [name for name, _ in rows] == LOADS, run.stdout
    # Of 15 000 steps.
    assert sum(int(again) for _, again in rows) <= 30, run.stdout
    assert sum(int(count) for count in re.findall(r"up to .* ms: (\d+)", run.stdout)) == 300 * len(rows)
    unknown = subprocess.run([*command, "--sideways"], capture_output=True, text=True)
    assert unknown.returncode == 2 and "--sideways" in unknown.stderr
    nothing = subprocess.run([*command, "--load", "surf"], capture_output=True, text=True)
    assert nothing.returncode == 1 and "surf" in nothing.stderr


def test_a_loop_in_the_initialisation_closes_by_substitution(fmu: Path) -> None:
    """With a load of 0.3 N.m.s, as tools.md has it. The primary speed depends on no torque."""
    with Archive.unpack(fmu) as archive, Instance(archive, {}) as unit:
        unit._call(unit._instance.enterInitializationMode)
        unit.set(INPUTS)
        speeds = [(unit.get("secondary.speed"), unit.get("primary.speed"))]
        for _ in range(5):
            unit.set({"secondary.torque": INPUTS["secondary.torque"] - 0.3 * (speeds[-1][0] - 209.0)})
            speeds.append((unit.get("secondary.speed"), unit.get("primary.speed")))
    rounds, primary = np.abs(np.diff(speeds, axis=0)).T
    assert rounds[0] > 1e-3 and rounds[3] < 1e-9 and not primary.any()


@pytest.mark.slow
def test_an_importer_in_rust_finds_what_fmpy_finds(fmu: Path) -> None:
    """The program is compiled in a folder of its own."""
    target = ROOT / "target" / "importer"
    command = [cargo(), "build", "--locked", f"--manifest-path={ROOT / 'tests' / 'importer' / 'Cargo.toml'}", f"--target-dir={target}"]
    subprocess.run(command, check=True)
    importer = target / "debug" / ("importer.exe" if os.name == "nt" else "importer")
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
    assert found["ratio.geometric"] != pytest.approx(1.0, abs=1e-4), "the inputs act"


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


def test_it_follows_the_exact_solution_and_a_limit_of_the_table_holds(lag: Path) -> None:
    """An input is held from one communication point to the next."""
    assert validate_fmu(lag) == []
    constant, start = 0.5, 3.0
    steps = np.array([(0.0, 1.0), (1.0, 1.0), (1.0, 2.0), (2.0, 2.0)], dtype=[("time", float), ("u", float)])
    result = fmpy.simulate_fmu(lag, stop_time=2.0, output_interval=0.25, start_values={"T": constant, "start": start}, input=steps, output=["y"])
    assert len(result) == 9
    first, second = (np.exp(-np.maximum(result["time"] - begin, 0.0) / constant) for begin in (0.0, 1.0))
    np.testing.assert_allclose(result["y"], 1.0 + (start - 1.0) * first + (1.0 - second), rtol=1e-12)
    with pytest.raises(fmpy.fmi1.FMICallException):
        fmpy.simulate_fmu(lag, stop_time=1.0, start_values={"T": 0.0})
