"""The interface with the lowest versions that `pyproject.toml` declares: of Python, numpy, pandas and the others with a bound. Then every line of
the book in an installed wheel, with these and on the newest Python. `.ci/full` runs the latter, since it takes many minutes; `SHORTER` cuts long
runs short."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
import reports
from conftest import ROOT, pip_of
from test_docs_commands import lines, reference
from test_wheel import PACKAGE, wheel  # noqa: F401

pytestmark = pytest.mark.slow
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
SHORTER = {"demo": "--short", "drive": "--short --until 5", "maps": "--short", "sweep": "--short"}
DESIGNS = ("--vary", "--points", "--ratio")  # Options of `sweep` that exclude --short, or make few points
LEFT_OUT = {"--scheduler": "it needs the scheduler of a cluster", "--arm": "it needs an FMU with a library for ARM, which test_arm.py has", **dict.fromkeys(("…", "COMMAND", "WORD", "PAGE"), "it is not whole")}
OTHER = ["pushbelt variables slip", "pushbelt docs linear", "pushbelt cache --clear"]  # Commands without a line in the book
CODES = {"calibrate": (0, 3), "belt": (0, 3)}  # Exit codes; the example table need not fit
RUN = "time [s],ring.speed [m/s],distance [m],ring.stressAmplitude.primary [MPa],ring.stressMean.primary [MPa]," \
    "ring.stressAmplitude.secondary [MPa],ring.stressMean.secondary [MPa],primary.torque [N.m]\n" \
    + "".join(f"{k},10,{10 * k},200,300,150,300,50\n" for k in range(9))  # fmt: skip


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


@pytest.fixture
def lowest(python: Path, fmu: Path) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Runs the lowest Python with the package of the source tree."""
    known = {**os.environ, "PYTHONPATH": str(ROOT / "python"), "PUSHBELT_FMU": str(fmu), "PYTHONDONTWRITEBYTECODE": "1"}
    return lambda *words: subprocess.run([python, *words], env=known, capture_output=True, text=True)


def test_the_interface_runs_on_the_lowest_versions(lowest, tmp_path: Path) -> None:
    done = lowest("-W", "error", "-c", SMOKE, tmp_path / "models.npz")
    assert done.returncode == 0, done.stderr
    for name in ("numpy", "pandas"):
        assert re.search(rf"(?<![\d.]){re.escape(BOUND[name])}(\.0)*(?![\d.])", done.stdout), done.stdout


@pytest.mark.parametrize("words", ["demo --short", "linearize initial.ratio=1 ring.model=ALE0", "sweep --short --ring ALE0"], ids=lambda words: words.split()[0])
def test_programs_run_on_the_lowest_versions(words: str, lowest, tmp_path: Path) -> None:
    """`.ci/full` runs all of them."""
    done = lowest("-m", "pushbelt", *words.split(), "--output", tmp_path)
    assert done.returncode == 0 and "Traceback" not in done.stderr, done.stderr
    reports.look_at(tmp_path / "report.html")


def test_the_source_needs_no_later_python(python: Path) -> None:
    """Syntax, and the standard library's modules, functions and arguments."""
    command = [python.with_name("vermin"), f"--target={PYTHON}-", "--no-tips", "--violations", "--quiet", PACKAGE]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def newest_python() -> str:
    """The newest Python of pyenv, the path or the tests."""
    found = {sys.version_info[:2]: sys.executable}
    for path in [*Path("/usr/bin").glob("python3.*"), *Path.home().glob(".pyenv/versions/3.*/bin/python3.*")]:
        if (version := re.fullmatch(r"python3\.(\d+)", path.name)) and subprocess.run([path, "-m", "venv", "-h"], capture_output=True).returncode == 0:
            found[3, int(version[1])] = str(path)
    return found[max(found)]


def book() -> list[tuple[str, str]]:
    """Pages and lines in their order, without repeated ones, those that are left out, and names of commands that need more words."""
    found = [(page, line) for page, line in dict.fromkeys(lines()) if re.match(r"pushbelt ([a-z-]+ |(demo|drive|linearize|maps|sweep)$)", line)]
    return [(page, line) for page, line in found if not any(word in line for word in LEFT_OUT)] + [("introduction.md", line) for line in OTHER]


def prepare(folder: Path, data: Path) -> None:
    """What a line reads and no line writes."""
    shutil.copy(data / "resources" / "parameters" / "belt155.ssv", folder / "SET.ssv")
    shutil.copy(data / "PushbeltMap.fmu", folder)
    for name in ("run.csv", "bench.csv"):
        (folder / name).write_text(RUN, encoding="utf-8")
    (folder / "own.csv").write_text("time [s],speed [km/h]\n0,0\n1,0\n4,10\n6,0\n", encoding="utf-8")
    for name in ("A", "B"):
        (folder / name).mkdir()
        (folder / name / "run.csv").write_text(RUN.replace("50\n", f"{ord(name)}\n"), encoding="utf-8")


def shortened(words: Sequence[str]) -> list[str]:
    """A line that takes seconds."""
    name, more = words[1], SHORTER.get(words[1], "").split()
    if name == "sweep" and {*words} & {*DESIGNS}:
        more = []
    return [*words[1:], *(["--print-job"] if "--slurm" in words else [] if "--short" in words and more == ["--short"] else more)]


@pytest.fixture(scope="module", params=["lowest", "newest"])
def place(request: pytest.FixtureRequest, wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:  # noqa: F811
    """A folder with an environment that has the wheel with all extras."""
    folder = tmp_path_factory.mktemp(request.param)
    interpreter = lowest_python() if request.param == "lowest" else newest_python()
    subprocess.run([interpreter, "-m", "venv", "--without-pip", folder / "venv"], check=True)
    pins = [f"{name}=={version}" for name, version in BOUND.items()] if request.param == "lowest" else []
    python = folder / "venv" / ("Scripts" if os.name == "nt" else "bin") / "python"
    clean = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONPYCACHEPREFIX")}
    command = [*pip_of(python), "install", "--no-compile", "--only-binary=:all:", f"{wheel}[all]", *pins]
    subprocess.run(command, env=clean, check=True, capture_output=True, text=True)
    return folder


@pytest.mark.full
def test_every_line_of_the_book_runs(place: Path) -> None:
    """Lines of a page run one after another in a folder of their own. The drives share their thrust-ratio map."""
    clean = {"PATH": os.environ["PATH"], "HOME": str(place), "LC_ALL": "C.UTF-8"}
    pushbelt = place / "venv" / "bin" / "pushbelt"
    version = subprocess.run([pushbelt.with_name("python"), "-VV"], env=clean, capture_output=True, text=True).stdout.split()[1]
    data = next((place / "venv").rglob("pushbelt/data"))
    todo, failed = book(), []
    assert {line.split()[1] for _, line in todo} >= {*reference.parsers()}, "a command without a line"
    for page, line in todo:
        folder = place / page.removesuffix(".md")
        if not folder.is_dir():
            folder.mkdir()
            prepare(folder, data)
        words = shortened(shlex.split(line))
        if "--points" in words:
            (folder / "points.csv").write_text("belt.play [m],utilisation\n1e-4,0.3\n2e-4,0.5\n", encoding="utf-8")
        elif words[0] == "calibrate" and not (folder / "points.csv").is_file():
            subprocess.run([pushbelt, "calibrate", "--template", "points.csv"], cwd=folder, env=clean, check=True, capture_output=True)
            shutil.copy(folder / "points.csv", folder / "others.csv")
        for option in ("--maps", "--beside"):
            if option in words:
                path = folder / words[words.index(option) + 1]
                path.parent.mkdir(parents=True, exist_ok=True)
                if not path.is_file():
                    shutil.copy(next(place.glob("*/pushbelt-maps/maps.nc")), path)
        done = subprocess.run([pushbelt, *words], cwd=folder, env=clean, capture_output=True, text=True)
        print(f"{version} {page}: pushbelt {shlex.join(words)}: {done.returncode}")
        if done.returncode not in CODES.get(words[0], (0,)) or "Traceback" in done.stderr:
            failed.append(f"{page}: pushbelt {shlex.join(words)}: {done.returncode} {done.stderr[-600:]}")
    assert not failed, "\n".join(failed)
    for word, why in LEFT_OUT.items():
        print(f"left out with {word}: {why}")
