"""The libraries of the portable FMU: requirements and content, then the win64 ones in wine: every call, and stored states from and to Linux,
with AVX2 and without; each belt through the manoeuvre. `cargo fmu test --windows` runs it. The program that loads the libraries is
`tests/windows/host.c`, compiled by zig for both systems."""

import os
import re
import shutil
import subprocess
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT

from pushbelt.demo.simulate import START_VALUES, STEP
from pushbelt.fmu.data import manoeuvre_inputs, parameter_set
from pushbelt.fmu.enumerations import BeltKind, RingModel

SOURCE = ROOT / "tests" / "windows" / "host.c"
GLIBC = (2, 17)  # Oldest C library that the Linux libraries load with
WINDOWS = re.compile(r"(kernel32|ntdll|userenv|ws2_32|advapi32|bcrypt|msvcrt|ucrtbase|api-ms-win-[a-z0-9-]+)\.dll")
"""Libraries that come with Windows. Wine 8 lacks bcryptprimitives, which the linker removes with unused parts of Rust's standard library."""
OF_WINDOWS = "binaries/win64/PushbeltVariator.dll"
OF_LINUX = "binaries/linux64/PushbeltVariator.so"
ASKED = "PUSHBELT_ZIG" in os.environ  # Set by `cargo fmu test --windows`: a Python with the package ziglang, and the library of this machine

BUILDS = {
    "windows": (OF_WINDOWS, False), "linux, AVX2": (OF_LINUX, True), "windows, AVX2": (OF_WINDOWS, True), "linux": (OF_LINUX, False),
    "this machine": (os.environ.get("PUSHBELT_LIBRARY", ""), False),
}  # fmt: skip
"""Libraries, and whether they may open their variant for AVX2. Each differs in system or in the width of its packs from the one before, and the
first one from the last."""
NAMES = tuple(BUILDS)
Host = Callable[..., np.ndarray]  # Runs the program: build, name of the readings' file, files between references and readings → a row of readings a stop
BELTS = {"ALE": {"ring.model": RingModel.ALE}, "ALE0": {"ring.model": RingModel.ALE0}, "pull chain": {"belt.kind": BeltKind.PULL_CHAIN}}
SAME = 1e-10  # Systems have different implementations of the sine; the portable builds agree in everything else. The effect is 2e-11.
ROUNDING = 1e-9  # Effect of a change of rounding in one build: one in the last bit of a clamping force or a torque grows to 1e-10 at most
OTHER_LANES = 1e-6
"""Effect of the width of the packs. Which cells keep their derivatives depends on it, so Newton's method ends elsewhere within its own
tolerance, and a step whose error is near the bound of the error control may be accepted by one build alone. So the effect is no rounding,
and falls with that tolerance (`TOLERANCE` in host.c): 1e-3 at 1e-5, 2e-6 at 1e-6, 6e-8 at 1e-7, all of the radial deviation, in µm."""


def wine() -> str | None:
    """The program that runs Windows programs. Debian's package wine64 has it beside the search path."""
    candidates = [shutil.which(name) for name in ("wine64", "wine", "wine64-stable")] + ["/usr/lib/wine/wine64"]
    return next((path for path in candidates if path and Path(path).exists()), None)


if not ASKED:
    pytestmark = pytest.mark.skip(reason="the Windows library is tested by `cargo fmu test --windows`")
elif wine() is None:
    if os.environ.get("CI"):
        pytest.fail("wine is missing: install it from the distribution (Debian: wine64)", pytrace=False)
    pytestmark = pytest.mark.skip(reason="wine is missing: install it from the distribution (Debian: wine64)")


@pytest.mark.parametrize("name", [f"{start}{end}" for start in (OF_LINUX[:-3], OF_WINDOWS[:-4]) for end in ("", "-avx2")])
def test_a_library_has_the_listed_functions_and_needs_no_more_than_its_system(place: Path, name: str) -> None:
    """By binutils, which read libraries of both systems. A library with more functions is refused when the FMU is packed."""
    windows = "win64" in name
    path = place / f"{name}{'.dll' if windows else '.so'}"
    library, said = path.read_bytes(), subprocess.run(["objdump", "-p", path], capture_output=True, text=True, check=True).stdout
    functions = [line.strip() for line in (ROOT / "fmu-build" / "exports.def").read_text(encoding="utf-8").splitlines() if line.startswith("    ")]
    assert len(functions) == 124 and all(b"\0" + function.encode() + b"\0" in library for function in functions)
    needed = [one.lower() for one in re.findall(r"DLL Name: (\S+)" if windows else r"GLIBC_([\d.]+)", said)]
    assert needed, "it does need some"
    if windows:
        assert "kernel32.dll" in needed and all(WINDOWS.fullmatch(one) for one in needed), needed
    else:
        assert max(tuple(map(int, one.split("."))) for one in needed)[:2] <= GLIBC, needed
    for text in (b"\0.symtab\0", b"\0.debug_info\0", b"/.cargo/registry", str(Path.home()).encode() + b"/"):
        assert text not in library, "symbols, or a path of the builder"


def readings_of(description) -> list:
    """All real outputs and locals except those that consist of rounding errors."""
    real = (v for v in description.modelVariables if v.type == "Real" and v.causality in ("output", "local"))
    return [variable for variable in real if variable.name != "solver.defect"]


@pytest.fixture(scope="module")
def place(fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The unpacked FMU, and the program for both systems."""
    folder = tmp_path_factory.mktemp("windows")
    with zipfile.ZipFile(fmu) as archive:
        assert {OF_WINDOWS, OF_LINUX} <= set(archive.namelist()), "not the portable FMU"
        archive.extractall(folder)
    for target, program in [("x86_64-windows-gnu", "host.exe"), ("x86_64-linux-gnu.2.17", "host")]:
        command = [os.environ["PUSHBELT_ZIG"], "-m", "ziglang", "cc", "-target", target, "-O2", "-Wall", "-Wextra"]
        subprocess.run([*command, "-Werror", "-o", folder / program, SOURCE, *([] if "win" in target else ["-ldl"])], check=True)
    return folder


@pytest.fixture(scope="module")
def host(place: Path, description) -> Host:
    real = readings_of(description)
    references = place / "references.txt"
    references.write_text("\n".join(str(variable.valueReference) for variable in real))
    # Neither .NET nor a browser is installed into the fresh folder.
    wine_only = {"WINEPREFIX": str(place / "wine"), "WINEDEBUG": "-all", "WINEDLLOVERRIDES": "mscoree=;mshtml="}

    def run(build: str, name: str, *files: Path | str) -> np.ndarray:
        library, avx2 = place / BUILDS[build][0], BUILDS[build][1]
        windows, readings = library.suffix == ".dll", place / f"{name}.txt"
        program = [wine(), place / "host.exe"] if windows else [place / "host"]
        known = {**os.environ, **wine_only, "PUSHBELT_AVX2": "1" if avx2 else "0"}
        words = [*program, library, description.guid, references, *files, readings]
        done = subprocess.run(words, env=known, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr
        assert re.search(r"^\d+ calls passed$", done.stdout, re.MULTILINE), done.stdout
        return np.frombuffer(bytes.fromhex(readings.read_text()), ">f8").reshape(-1, len(real))

    return run


@pytest.fixture(scope="module")
def first(host: Host, place: Path) -> dict[str, tuple[np.ndarray, Path]]:
    """The run of each library, and its stored state."""
    return {build: (host(build, build, "-", place / f"{build}.state"), place / f"{build}.state") for build in BUILDS}


@pytest.fixture(scope="module")
def sizes(description) -> np.ndarray:
    return np.array([float(variable.nominal) for variable in readings_of(description)])


def lanes(build: str) -> bool:
    """Whether a build has packs of four cells."""
    return build.endswith("AVX2") or build == "this machine"


@pytest.mark.parametrize(
    ("one", "other", "bound"),
    [
        ("windows", "linux", SAME), ("windows, AVX2", "this machine", SAME), ("linux, AVX2", "this machine", SAME),
        ("linux", "this machine", OTHER_LANES),
    ],
)  # fmt: skip
def test_builds_agree(first, sizes: np.ndarray, one: str, other: str, bound: float) -> None:
    assert np.max(np.abs(first[one][0] - first[other][0]) / sizes) < bound


@pytest.mark.parametrize("system", ["windows", "linux"])
def test_the_variant_for_avx2_runs_where_it_may(first, system: str) -> None:
    """It has other sums than the library for all processors, so other bits; without the variant both runs are the same."""
    assert not np.array_equal(first[f"{system}, AVX2"][0], first[system][0])


@pytest.mark.parametrize(("writer", "reader"), [(NAMES[other], one) for k, one in enumerate(NAMES) for other in (k, k - 1)])
def test_each_build_continues_from_its_own_state_and_from_that_of_another(host: Host, place: Path, first, sizes: np.ndarray, writer: str, reader: str) -> None:
    again = place / "again.state"
    found = host(reader, f"{reader} after {writer}", first[writer][1], again)
    expected = first[reader][0]
    assert np.max(np.abs(found - expected) / sizes) < (ROUNDING if lanes(reader) == lanes(writer) else OTHER_LANES)
    if reader == writer:
        assert np.array_equal(found, expected), "in the same build bit for bit"
        assert again.read_bytes() == first[writer][1].read_bytes()


@pytest.fixture(scope="module", params=BELTS)
def manoeuvres(request: pytest.FixtureRequest, host: Host, place: Path, description) -> dict[str, np.ndarray]:
    """Readings every 0.1 s of the demo's manoeuvre with a belt, by both libraries and by that of Windows for all processors."""
    variables, inputs = {one.name: one for one in description.modelVariables}, manoeuvre_inputs()

    def lines(values) -> list[str]:
        kinds = {"Real": "real", "Enumeration": "integer", "Integer": "integer"}
        return [f"{kinds[variables[name].type]} {variables[name].valueReference} {value:.17g}" for name, value in values.items()]

    calls = [*lines({**parameter_set("bench168"), **START_VALUES, **BELTS[request.param], **inputs.at(0.0)}), "start"]
    for step in range(round(inputs.time[-1] / STEP)):
        calls += [*lines(inputs.at(step * STEP)), f"step {step * STEP:.17g} {STEP}"]
        calls += ["read"] * (step % 100 == 99)
    run = place / "manoeuvre.run"
    run.write_text("\n".join(calls))
    return {build: host(build, "manoeuvre", run) for build in ("linux, AVX2", "linux", "windows")}


def test_each_build_runs_each_belt_through_the_manoeuvre(manoeuvres, description) -> None:
    """From standstill, with macro-slip in it, where rounding grows: what a drivetrain reads agrees to a share of its range."""
    names = [variable.name for variable in readings_of(description)]
    expected = manoeuvres["linux, AVX2"]
    for name in ("primary.speed", "secondary.speed", "ratio.geometric", "thrustRatio", "slip", "loss.total"):
        at = names.index(name)
        range_ = np.ptp(expected[:, at])
        assert len(expected) == 100 and range_ > 0.0
        for build, found in manoeuvres.items():
            assert np.max(np.abs(found[:, at] - expected[:, at])) < 1e-3 * range_, (name, build)
