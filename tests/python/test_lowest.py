"""The interface with the lowest versions that `pyproject.toml` declares: of Python, numpy, pandas and the others with a bound."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import reports
from conftest import ROOT, pip_of

PACKAGE = ROOT / "python" / "pushbelt"
PROJECT = (ROOT / "python" / "pyproject.toml").read_text(encoding="utf-8")
PYTHON = re.search(r'requires-python = ">=([\d.]+)"', PROJECT)[1]
BOUND = {name: version for name, version in re.findall(r'"([\w-]+)>=([\d.]+)"', PROJECT) if name != "setuptools"}
SMOKE = """
import sys, numpy, pandas, pushbelt
with pushbelt.Variator("bench168", {"ring.model": "ALE0"}, record=pushbelt.Record(interval=2e-3)) as variator:
    inputs = pandas.DataFrame({"primary.torque": [40.0, 60.0, 50.0]}, index=[0.0, 0.01, 0.01]).iloc[:2]
    assert len(variator.simulate(inputs, step=1e-3)) == 6 == len(variator.to_dataframe())
    variator.restore(variator.snapshot())
    assert variator.variables.to_dataframe().loc["primary.torque", "unit"] == "N.m"
    assert variator.steady(1.0, 50.0).profile.to_dataframe().shape == (72, 7)
    assert variator.thrust_map([1.0], [20.0, 900.0], force=9e3)["reason"].item(1)
    variator.linear_grid([1.0], [40.0]).save(sys.argv[1])
    assert len(pushbelt.load_linear(sys.argv[1]).to_dataframe()) == 1
pushbelt.MapVariator().start(1.0, 200.0)
print(sys.version_info[:2], numpy.__version__, pandas.__version__)
"""

def lowest_python() -> str:
    """The lowest Python: on the path, or of pyenv. Without it that of the tests."""
    name = f"python{PYTHON}"
    there = [shutil.which(name), *sorted(Path.home().glob(f".pyenv/versions/{PYTHON}.*/bin/{name}"))]
    # A command of pyenv can be on the path without its version.
    runs = (str(one) for one in there if one and subprocess.run([one, "-V"], capture_output=True).returncode == 0)
    return next(runs, sys.executable)


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lowest")
    subprocess.run([lowest_python(), "-m", "venv", "--without-pip", folder], check=True)
    found = folder / ("Scripts" if os.name == "nt" else "bin") / "python"
    packages = [*(f"{name}=={version}" for name, version in BOUND.items()), "vermin==1.9.2"]
    subprocess.run([*pip_of(found), "install", "--no-compile", "--only-binary=:all:", *packages], check=True, capture_output=True, text=True)
    return found


@pytest.mark.slow
def test_the_interface_runs_on_the_lowest_versions(python: Path, fmu: Path, tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "python"), "PUSHBELT_FMU": str(fmu), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run([python, "-W", "error", "-c", SMOKE, tmp_path / "models.npz"], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for name in ("numpy", "pandas"):
        assert re.search(rf"(?<![\d.]){re.escape(BOUND[name])}(\.0)*(?![\d.])", done.stdout), done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("words", ["demo --short", "linearize initial.ratio=1 ring.model=ALE0", "sweep --short --ring ALE0"], ids=lambda words: words.split()[0])
def test_programs_run_on_the_lowest_versions(words: str, python: Path, fmu: Path, tmp_path: Path) -> None:
    """`.ci/full` runs all of them."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "python"), "PUSHBELT_FMU": str(fmu), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run([python, "-m", "pushbelt", *words.split(), "--output", tmp_path], env=environment, capture_output=True, text=True)
    assert done.returncode == 0 and "Traceback" not in done.stderr, done.stderr
    reports.look_at(tmp_path / "report.html")


@pytest.mark.slow
def test_the_source_needs_no_later_python(python: Path) -> None:
    """Syntax, and the standard library's modules, functions and arguments."""
    command = [python.with_name("vermin"), f"--target={PYTHON}-", "--no-tips", "--violations", "--quiet", PACKAGE]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
