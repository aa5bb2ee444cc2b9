"""The choice between the library for all processors and its variant for AVX2, with the FMU of `crates/fmi/examples/lag.rs`."""

import os
import platform
import shutil
import struct
import subprocess
import sys
from collections.abc import Callable
from ctypes import CFUNCTYPE, c_char_p, c_int, c_void_p, cast
from pathlib import Path

import pytest
from conftest import ROOT, built
from fmpy import fmi2

CPU = Path("/proc/cpuinfo")
if platform.system() != "Linux" or platform.machine() != "x86_64":
    pytestmark = pytest.mark.skip(reason="libraries of Linux on x86-64")
elif " avx2 " not in CPU.read_text(encoding="ascii"):
    pytestmark = pytest.mark.skip(reason="the processor has no AVX2")
else:
    pytestmark = pytest.mark.slow
AFTER_STEP = 0.048770575499286
FAST = "the library for processors with AVX2 runs"
SLOW = "the slower library for all processors runs: "


class Library:
    """A library with one log for all of its instances. Each of them loads it."""

    def __init__(self, path: Path | str) -> None:
        self.path = path
        self.log: list[str] = []
        self.statuses: list[int] = []
        self.callbacks = fmi2.fmi2CallbackFunctions()
        # A message is the first of the values of its format.
        self.logger = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p, c_char_p)(self.add)
        self.callbacks.logger = cast(self.logger, fmi2.fmi2CallbackLoggerTYPE)
        unit = self.load("{0}")
        with pytest.raises(Exception, match="instantiate"):
            unit.instantiate(callbacks=self.callbacks, loggingOn=True)
        unit.freeLibrary()
        self.guid = self.log.pop().split("not that of this binary, ")[1].split(":")[0]

    def add(self, *arguments: object) -> None:
        self.statuses.append(arguments[2])
        self.log.append(arguments[5].decode())

    def load(self, guid: str) -> fmi2.FMU2Slave:
        """The loaded library, before its instance."""
        return fmi2.FMU2Slave(guid=guid, modelIdentifier="lag", unzipDirectory="/", libraryPath=str(self.path))

    def create(self, *, logging: bool = True) -> fmi2.FMU2Slave:
        unit = self.load(self.guid)
        unit.instantiate(callbacks=self.callbacks, loggingOn=logging)
        return unit


def step(unit: fmi2.FMU2Slave) -> float:
    """The output after a step of 0.1 s from 0 s."""
    unit.doStep(currentCommunicationPoint=0.0, communicationStepSize=0.1)
    return unit.getReal([1])[0]


def start(unit: fmi2.FMU2Slave) -> None:
    unit.setupExperiment()
    unit.enterInitializationMode()
    unit.exitInitializationMode()


def is_loaded(path: Path) -> bool:
    return str(path) in Path("/proc/self/maps").read_text()


def variant(path: Path) -> Path:
    return path.with_name("Lag-avx2.so")


def hash_of(content: bytes) -> str:
    """Length, and FNV-1a of words of 8 bytes, as `crates/fmi/src/hash.rs` has them."""
    found = 0x6C62272E07BB014262B821756295C58D
    full = len(content) // 8 * 8
    for (word,) in struct.iter_unpack("<Q", content[:full] + content[full:].ljust(8, b"\0")):
        found = (found ^ word) * 0x13B % 2**128 + ((found ^ word) << 88) % 2**128
        found %= 2**128
    return f"{len(content)}-{found:032x}"


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("built")
    # The variant is as `cargo fmu test --all` has compiled it, for AVX2.
    fast = Path(shutil.copy(built(["--workspace", "--exclude=fmu-build"], "lag")["lag"], folder / "Lag-avx2.so"))
    flags = {"CARGO_TARGET_DIR": str(ROOT / "target" / "variant"), "CARGO_ENCODED_RUSTFLAGS": "", "PUSHBELT_VARIANT": hash_of(fast.read_bytes())}
    return Path(shutil.copy(built(["--profile=tool", "--package=pushbelt-fmi"], "lag", **flags)["lag"], folder / "Lag.so")), fast


@pytest.fixture
def folder(pair: tuple[Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Path]:
    """Makes a folder with the library, and with its variant or this content under the name; returns the path of the library."""
    monkeypatch.delenv("PUSHBELT_AVX2", raising=False)

    def make(name: str = "place", content: bytes | None = None, *, with_variant: bool = True) -> Path:
        path = tmp_path / name / "Lag.so"
        path.parent.mkdir()
        shutil.copy(pair[0], path)
        if with_variant:
            variant(path).write_bytes(pair[1].read_bytes() if content is None else content)
        return path

    return make


def test_the_variant_is_open_from_the_first_instance_to_the_last(folder) -> None:
    path = folder()
    library = Library(path)
    # An attempt with another GUID has opened it, and closed it.
    assert not is_loaded(variant(path))
    first, second = library.create(), library.create()
    assert is_loaded(variant(path)) and library.log == [FAST, FAST]
    start(first)
    assert step(first) == pytest.approx(AFTER_STEP)
    first.fmi2FreeInstance(None)
    first.freeInstance()
    assert is_loaded(variant(path))
    start(second)
    step(second)
    second.freeInstance()
    assert not is_loaded(path) and not is_loaded(variant(path))
    third = library.create(logging=False)
    assert is_loaded(variant(path)) and len(library.log) == 2, "nothing is logged without logging"
    third.freeInstance()
    assert not is_loaded(path) and not is_loaded(variant(path))


def changed(content: bytes) -> bytes:
    """A library whose code has another bit."""
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]


REFUSALS = {
    "missing": (None, "Lag-avx2.so: there is no such file"),
    "empty": (lambda base, fast: b"", "Lag-avx2.so: it has 0 bytes"),
    "without its last page": (lambda base, fast: fast[:-4096], "is not the file of this build"),
    "the library itself": (lambda base, fast: base, "is not the file of this build"),
    "longer": (lambda base, fast: fast + b"x", "is not the file of this build"),
    "damaged": (lambda base, fast: changed(fast), "its content is not that of this build"),
    "switched off": (lambda base, fast: fast, "PUSHBELT_AVX2 is 0"),
}


@pytest.mark.parametrize("case", REFUSALS)
def test_the_library_runs_by_itself(folder, pair, monkeypatch: pytest.MonkeyPatch, case: str) -> None:
    """A warning says why, also without debug logging, and the strange file is not opened."""
    content, message = REFUSALS[case]
    base, fast = (path.read_bytes() for path in pair)
    path = folder(content=content(base, fast)) if content else folder(with_variant=False)
    if case == "switched off":
        monkeypatch.setenv("PUSHBELT_AVX2", "0")
    library = Library(path)
    unit = library.create(logging=False)
    assert not is_loaded(variant(path))
    assert len(library.log) == 1 and library.log[0].startswith(SLOW) and message in library.log[0]
    assert library.statuses[-1] == fmi2.fmi2Warning
    start(unit)
    assert step(unit) == pytest.approx(AFTER_STEP)
    unit.freeInstance()
    assert not is_loaded(path)


def log_of(folder: Path, given: Path | str, use: str, **variables: str) -> str:
    """What a library logs that a process of its own loads in a folder by this path."""
    code = f"import os, sys, test_variant\nlibrary = test_variant.Library(sys.argv[1])\n{use}\nprint(*library.log)"
    known = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]), **variables}
    return subprocess.run([sys.executable, "-c", code, given], cwd=folder, env=known, check=True, capture_output=True, text=True).stdout


def test_only_the_folder_of_the_library_itself_counts(folder, tmp_path: Path) -> None:
    """Neither that of a link to it, nor the working directory if the host has a relative path and has changed it."""
    path, planted = folder(with_variant=False), folder("planted")
    (tmp_path / "links").mkdir()
    link = tmp_path / "links" / "Lag.so"
    link.symlink_to(path)
    shutil.copy(variant(planted), variant(link))
    use = f"""
unit = library.load(library.guid)
os.chdir({str(planted.parent)!r})
unit.instantiate(callbacks=library.callbacks, loggingOn=True)"""
    for given in (str(link), "./Lag.so"):
        log = log_of(path.parent, given, use)
        assert log.startswith(SLOW) and f"{variant(path)}: there is no such file" in log, given
    shutil.copy(variant(planted), variant(path))
    library = Library(link)
    library.create().freeInstance()
    assert library.log == [FAST]


@pytest.mark.skipif(shutil.which("cc") is None, reason="the test needs a C compiler")
def test_the_variant_is_found_without_proc(folder, tmp_path: Path) -> None:
    """By the path that the host gave, if that is absolute."""
    path, shim = folder(), tmp_path / "shim.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-o", shim, Path(__file__).with_name("no_proc.c"), "-ldl"], check=True)
    for given, message in ((path, FAST), ("./Lag.so", f"{SLOW}the path of this library is unknown")):
        assert log_of(path.parent, given, "library.create().freeInstance()", LD_PRELOAD=str(shim)).strip() == message


def test_without_a_free_descriptor_the_library_runs_by_itself(folder) -> None:
    """But not beside instances in the variant, which the next one joins."""
    import resource

    library = Library(folder())
    units = [library.load(library.guid) for _ in range(3)]
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)

    def create(unit: fmi2.FMU2Slave, descriptors: int) -> None:
        resource.setrlimit(resource.RLIMIT_NOFILE, (descriptors, limits[1]))
        try:
            unit.instantiate(callbacks=library.callbacks, loggingOn=True)
        finally:
            resource.setrlimit(resource.RLIMIT_NOFILE, limits)

    create(units[0], 3)
    assert len(library.log) == 1 and library.log[0].startswith(SLOW)
    units[0].freeInstance()
    create(units[1], limits[0])
    create(units[2], 3)
    assert library.log[1:] == [FAST, FAST]
    for unit in units[1:]:
        start(unit)
        assert step(unit) == pytest.approx(AFTER_STEP)
        unit.freeInstance()
    assert not is_loaded(variant(Path(library.path)))


def test_an_instance_stays_in_its_library(folder, monkeypatch: pytest.MonkeyPatch) -> None:
    """While an instance of the library itself exists, the variant is not opened."""
    path = folder()
    monkeypatch.setenv("PUSHBELT_AVX2", "0")
    library = Library(path)
    first = library.create()
    monkeypatch.delenv("PUSHBELT_AVX2")
    second = library.create()
    assert not is_loaded(variant(path))
    first.freeInstance()
    second.freeInstance()
    third = library.create()
    assert is_loaded(variant(path)) and library.log[-1] == FAST
    third.freeInstance()


def test_states_pass_between_the_library_and_its_variant(folder) -> None:
    units = [Library(path).create() for path in (folder("a"), folder("b", with_variant=False))]
    for unit in units:
        start(unit)
    for writer, reader in (units, units[::-1]):
        data = writer.serializeFMUstate(writer.getFMUstate())
        expected = step(writer)
        for unit in (reader, writer):
            unit.setFMUstate(unit.deSerializeFMUstate(data))
        assert step(reader) == pytest.approx(expected, rel=1e-15)
        reader.setFMUstate(reader.deSerializeFMUstate(data))
