"""The wheel: its content, and its installation, use and removal in an environment without Rust."""

import ast
import os
import re
import subprocess
import sys
import zipfile
from collections.abc import Iterable
from pathlib import Path

import pytest
from conftest import ROOT, cargo, pip_of
from packaging.requirements import Requirement

PACKAGE = ROOT / "python" / "pushbelt"
LOCK = ROOT / "python" / "requirements.txt"
EXTRA_OF = {
    **dict.fromkeys(("belt", "compare", "demo", "drive", "linearize"), "reports"),
    "calibrate": "tables", "durability": "durability", "maps": "sweep", "sweep": "sweep",
}  # fmt: skip
OPTIONAL = {"dask_jobqueue": ("dask-jobqueue", "slurm")}  # Modules that an option of a program imports: their packages, and the extras that install them
BY_HAND = {"wltp", "pythonfmu", "ecospy", "libcosimpy", "tbb"}
"""Packages that the book describes separately: the WLTC's table, and the co-simulation of the source tree."""
ON_DEMAND = {"pandas"}  # Packages that `to_dataframe` imports when it is called. Without them its error names the extra.


@pytest.fixture(scope="module")
def wheel(fmu: Path, fmu3: Path, map_fmu: Path, map_fmu3: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel with the FMU under test, and those beside it: the portable one takes minutes to build."""
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run([cargo(), "fmu", "wheel", "--fmu", fmu, "--output", folder], cwd=ROOT, check=True, capture_output=True)
    (path,) = folder.glob("*.whl")
    return path


def test_the_wheel_holds_fmu_data_types_and_licences(wheel: Path, fmu: Path) -> None:
    version = re.search('"(.*)"', (PACKAGE / "_version.py").read_text(encoding="utf-8").split("=")[1])[1]
    assert wheel.name == f"pushbelt-{version}-py3-none-any.whl"
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        for path in (fmu, *(fmu.with_name(name) for name in ("PushbeltVariator3.fmu", "PushbeltMap.fmu", "PushbeltMap3.fmu"))):
            assert archive.read(f"pushbelt/data/{path.name}") == path.read_bytes()
        assert "License-Expression: MIT OR Apache-2.0" in archive.read(f"pushbelt-{version}.dist-info/METADATA").decode()
        for path in (path for path in (ROOT / "resources").rglob("*") if path.is_file()):
            assert archive.read(f"pushbelt/data/{path.relative_to(ROOT).as_posix()}") == path.read_bytes()
        licences = {Path(name).name: name for name in names if "/licenses/" in name}
        assert licences.keys() == {"LICENSE-MIT", "LICENSE-APACHE", "LICENSE-third-party.txt"}
        assert "\nfaer " in archive.read(licences["LICENSE-third-party.txt"]).decode()
    expected = {f"pushbelt/data/docs/{path.name}" for path in (ROOT / "docs").iterdir() if path.is_file()}
    expected.add("pushbelt/data/docs/theory.html")
    files = (path for path in PACKAGE.rglob("*") if path.is_file() and "__pycache__" not in path.parts)
    expected |= {path.relative_to(PACKAGE.parent).as_posix() for path in files}
    assert {"pushbelt/py.typed", *expected} <= names, sorted(expected - names)
    assert not [name for name in names if "__pycache__" in name]


def imported(paths: Iterable[Path]) -> set[str]:
    """Packages that modules import, except those of Python and of this project."""
    found = set()
    for path in paths:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                found.add(node.module.partition(".")[0])
    return found - set(sys.stdlib_module_names) - {"pushbelt"}


@pytest.fixture(scope="module")
def declared() -> dict[str, set[str]]:
    """Requirements of the package by extra, and those without extra as `base`. Extras of extras are resolved."""
    tomllib = pytest.importorskip("tomllib", reason="Python 3.10 has no tomllib")
    project = tomllib.loads((ROOT / "python" / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lists = {"base": project["dependencies"], **project["optional-dependencies"]}

    def resolved(name: str) -> set[str]:
        found = set()
        for text in lists[name]:
            needed = Requirement(text)
            found |= set().union(*map(resolved, needed.extras)) if needed.name == "pushbelt" else {needed.name}
        return found

    return {name: resolved(name) | resolved("base") for name in lists}


def locked(file: Path) -> set[str]:
    return {Requirement(line).name for line in file.read_text(encoding="utf-8").splitlines() if line[0] != "#"}


def test_what_is_declared_is_tested(declared: dict[str, set[str]]) -> None:
    """The lock file of the demo is enough for it."""
    assert declared["all"] == set().union(*declared.values())
    assert declared["all"] <= locked(LOCK)
    assert declared[EXTRA_OF["demo"]] <= locked(ROOT / "python" / "requirements-demo.txt")


@pytest.mark.parametrize("program", EXTRA_OF)
def test_what_a_program_imports_is_in_its_extra(program: str, declared: dict[str, set[str]]) -> None:
    shared = [*(PACKAGE / "report").glob("*.py"), *(path for path in PACKAGE.glob("*.py") if path.name != "points.py")]
    if EXTRA_OF[program] == "sweep":
        shared += [*(PACKAGE / "study").glob("*.py"), *(PACKAGE / "maps").glob("*.py")]
    needed = imported([*shared, *(PACKAGE / "cli").glob("*.py"), *(PACKAGE / "fmu").rglob("*.py")]) - ON_DEMAND
    needed |= imported((PACKAGE / program).rglob("*.py"))
    assert {OPTIONAL[name][0] for name in needed & OPTIONAL.keys()} <= {
        package for extra in {extra for _, extra in OPTIONAL.values()} for package in declared[extra]
    }
    assert needed - declared[EXTRA_OF[program]] - BY_HAND - OPTIONAL.keys() == set()


# In an environment without Rust


@pytest.fixture(scope="module")
def place(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with an environment that has the wheel and its requirements in the tested versions, and a separate home."""
    folder = tmp_path_factory.mktemp("installed")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder / "venv"], check=True)
    pip(folder, "install", str(wheel))
    return folder


def tool(folder: Path, name: str) -> Path:
    return folder / "venv" / ("Scripts" if os.name == "nt" else "bin") / name


def pip(folder: Path, *arguments: str) -> None:
    """Runs the pip of the tests there, with the versions of the lock file. Only modules that are imported are compiled, there."""
    more = ["--no-compile", f"--constraint={LOCK}"] if arguments[0] == "install" else []
    clean = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONPYCACHEPREFIX", "PUSHBELT_FMU")}
    subprocess.run([*pip_of(tool(folder, "python")), *arguments, *more], env=clean, check=True, capture_output=True, text=True)


def run(folder: Path, name: str, *arguments: str, code: int = 0) -> subprocess.CompletedProcess[str]:
    """Runs a program of the environment with an empty search path and a separate home; it ends with this code."""
    home = folder / "home"
    home.mkdir(exist_ok=True)
    clean = {name: os.environ[name] for name in ("SYSTEMROOT", "TEMP") if name in os.environ}
    clean |= {"PATH": "", "HOME": str(home), "LOCALAPPDATA": str(home)}
    done = subprocess.run([tool(folder, name), *arguments], cwd=folder, env=clean, capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    return done


def test_a_plain_installation_steps_the_variator_and_writes_an_fmu(place: Path) -> None:
    code = """
import pathlib, pushbelt
with pushbelt.Variator("bench168", {"initial.ratio": 1.5}) as variator:
    for step in range(20):
        state = variator.step(1e-3, {"primary.clampingForce": 9e3})
    model = variator.linearize(1.5, 40.0)
    variator.linear_grid([1.5], [40.0]).save("plain.npz")
print(pathlib.Path(pushbelt.__file__).parts[-2], variator.outputs["ratio.geometric"][0], state["ratio.geometric"], len(model.poles))
"""
    folder, first, last, poles = run(place, "python", "-c", code).stdout.split()
    assert folder == "pushbelt" and int(poles) >= 2 and (place / "plain.npz").is_file()
    assert float(last) > float(first) == pytest.approx(1.5, abs=1e-6)
    run(place, "pushbelt", "fmu", "own.fmu", "--variator", "belt155", "--set", "ring.model=ALE0")
    run(place, "pushbelt", "map-fmu", "map.fmu", "--set", "initial.ratio=1.5")
    text = zipfile.Path(place / "own.fmu", "modelDescription.xml").read_text(encoding="utf-8")
    assert re.search(r'name="geometry.centerDistance".*?<Real[^>]*start="0.155"', text, re.DOTALL)


def test_what_is_missing_is_named_and_then_the_demo_runs(place: Path, wheel: Path) -> None:
    done = run(place, "pushbelt", "demo", "--short", code=1)
    assert re.fullmatch(r"pushbelt demo: the package \w+ is missing: pip install 'pushbelt\[reports\]'\n", done.stderr)
    pip(place, "install", f"{wheel}[reports]")
    for words in (["demo", "--short"], ["linearize", "initial.ratio=1,2", "ring.model=ALE0"]):
        run(place, "pushbelt", *words)
    assert (place / "pushbelt-demo" / "report.html").is_file()
    assert {path.suffix for path in (place / "pushbelt-linearize").iterdir()} == {".npz", ".mat", ".json", ".html"}


def test_nothing_is_left_after_its_removal(place: Path) -> None:
    def left(folder: Path) -> list[Path]:
        return [path for path in folder.rglob("*pushbelt*") if not {"pushbelt-demo", "pushbelt-linearize"} & set(path.parts)]

    run(place, "pushbelt", "fmu", "own.fmu")
    assert left(place / "home") and left(place / "venv")
    assert run(place, "pushbelt", "cache").stdout.startswith(str(place / "home"))
    for _ in range(2):
        run(place, "pushbelt", "cache", "--clear")
        assert not left(place / "home")
    pip(place, "uninstall", "--yes", "pushbelt")
    assert not left(place / "venv")
