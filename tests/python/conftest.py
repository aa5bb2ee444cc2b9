"""Common fixtures of the tests: paths of the FMUs, and instances."""

import importlib.util
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import fmpy
import pytest

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / folder) for folder in ("python", "validation", "paper/python", "examples/cosim", "benches")]

from pushbelt_cosim.importers import leave  # noqa: E402

from pushbelt.fmu import cache  # noqa: E402
from pushbelt.fmu.enumerations import RingModel  # noqa: E402
from pushbelt.fmu.unit import Archive  # noqa: E402
from pushbelt.variator import Variator  # noqa: E402

STATUS = pytest.StashKey[int]()
SLOW_FIXTURES = {"coupling", "lag", "paper_fmu", "place", "wheel"}
"""Fixtures that take about a minute. Tests that use one of them are in the second tier, like those marked as slow."""

CHEAP = {"ring.model": RingModel.ALE0, **dict.fromkeys(("mesh.primaryArc", "mesh.secondaryArc", "mesh.strand"), 4), "initial.steady": False}
"""A coarse ring model without load at the start, for tests of the interface."""
MESH = {"mesh.primaryArc": 8, "mesh.secondaryArc": 8, "mesh.strand": 4}
COARSE = {"ring.model": "ALE0", **MESH}  # A coarse mesh, for tests of what is made of the FMU's results
WORDS = tuple(f"{name}={value}" for name, value in COARSE.items())


def _under_test(fixture: str, file: str, option: str) -> Any:
    """A fixture: the path that an environment variable names, or that of the file in `target`."""
    variable = f"PUSHBELT_{fixture.upper()}"

    @pytest.fixture(scope="session", name=fixture)
    def path() -> Path:
        found = Path(os.environ.get(variable, ROOT / "target" / file))
        assert found.is_file(), f"{found} is missing: build it by `cargo fmu build{option}`, or set {variable}"
        return found

    return path


fmu = _under_test("fmu", "PushbeltVariator.fmu", "")
fmu3 = _under_test("fmu3", "PushbeltVariator3.fmu", " --fmi3")
paper_fmu = _under_test("paper_fmu", "PushbeltPaper.fmu", " --paper")
map_fmu = _under_test("map_fmu", "PushbeltMap.fmu", " --map")
map_fmu3 = _under_test("map_fmu3", "PushbeltMap3.fmu", " --map --fmi3")


@pytest.fixture
def belt(fmu: Path) -> Iterator[Variator]:
    with Variator("bench168", COARSE, fmu=fmu) as opened:
        yield opened


@pytest.fixture(scope="session")
def coarse(fmu: Path) -> Iterator[Variator]:
    """A variator on a coarse mesh for steady states and linear models, which no test steps."""
    with Variator("bench168", COARSE, fmu=fmu) as opened:
        yield opened


def module_of(path: Path) -> ModuleType:
    """A program beside the package, such as an example, as a module."""
    specification = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def cargo() -> str:
    """Cargo. Without it the test is skipped."""
    return os.environ.get("CARGO") or shutil.which("cargo") or pytest.skip("cargo is not on the path")


def built(options: Sequence[str], *examples: str, **environment: str) -> dict[str, Path]:
    """What cargo builds for examples: libraries or programs."""
    command = [cargo(), "build", *options, "--message-format=json", *(f"--example={one}" for one in examples)]
    output = subprocess.run(command, cwd=ROOT, env={**os.environ, **environment}, check=True, capture_output=True, text=True).stdout
    found = [message for message in map(json.loads, output.splitlines()) if message["reason"] == "compiler-artifact"]
    return {one["target"]["name"]: Path(one["executable"] or one["filenames"][0]) for one in found if one["target"]["name"] in examples}


def pip_of(python: Path) -> list[str | Path]:
    """The pip of the tests, for another environment, which needs none."""
    return [sys.executable, "-m", "pip", "--python", python, "--quiet", "--disable-pip-version-check"]


@pytest.fixture(scope="module")
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A cache of the tests of a module."""
    place = tmp_path_factory.mktemp("cache") / "pushbelt"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cache, "folder", lambda: place)
        yield place


@pytest.fixture(scope="session")
def variables(description: Any) -> dict[str, Any]:
    return {variable.name: variable for variable in description.modelVariables}


@pytest.fixture(scope="session")
def archive(fmu: Path) -> Iterator[Archive]:
    with Archive.unpack(fmu) as unpacked:
        yield unpacked


@pytest.fixture(scope="session")
def description(fmu: Path) -> Any:
    return fmpy.read_model_description(fmu)


@pytest.fixture(scope="session")
def drive_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder for the thrust-ratio map of the drives, so that it is solved once: that of all processes of a run of the tests."""
    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "drive"
    folder.mkdir(exist_ok=True)
    return folder


def pytest_addoption(parser: pytest.Parser) -> None:
    """`cargo fmu test` runs the first tier, `cargo fmu test --all` everything."""
    parser.addoption("--first-tier", action="store_true", help="leave out the second tier")
    parser.addoption("--full", action="store_true", help="run what `.ci/full` runs, too")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "slow: left to `cargo fmu test --all`")
    config.addinivalue_line("markers", "full: left to `.ci/full`")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Removes the second tier, and pytest prints how many tests that are; or runs files with such tests first, so that the processes end
    together."""
    second = [one for one in items if one.get_closest_marker("slow") or SLOW_FIXTURES.intersection(getattr(one, "fixturenames", ()))]
    long = {one.path for one in second}
    items.sort(key=lambda one: one.path not in long)
    left = second if config.getoption("--first-tier") else []
    left = left if config.getoption("--full") else [*left, *(one for one in items if one.get_closest_marker("full") and one not in left)]
    if left:
        config.hook.pytest_deselected(items=left)
        items[:] = [one for one in items if one not in left]


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    session.config.stash[STATUS] = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config: pytest.Config) -> None:
    """Ends without exit handlers, which may abort if units of PythonFMU have run."""
    if "ecospy" in sys.modules or "libcosimpy" in sys.modules:
        leave(config.stash.get(STATUS, 1))
