"""The choice between the library for all processors and its variant for AVX2, with the FMU of `crates/fmi/examples/lag.rs`."""

from __future__ import annotations

import ctypes
import os
import platform
import shutil
import struct
import subprocess
import sys
from collections.abc import Callable, Iterator
from ctypes import CFUNCTYPE, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path

import pytest
from conftest import ROOT

CPU = Path("/proc/cpuinfo")
if platform.system() != "Linux" or platform.machine() != "x86_64":
    pytestmark = pytest.mark.skip(reason="libraries of Linux on x86-64")
elif " avx2 " not in CPU.read_text(encoding="ascii"):
    pytestmark = pytest.mark.skip(reason="the processor has no AVX2")
else:
    pytestmark = pytest.mark.slow

LOGGER = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p, c_char_p)
OUTPUT = c_uint(1)


class Callbacks(ctypes.Structure):
    """fmi2CallbackFunctions."""

    _fields_ = [("logger", LOGGER)] + [(name, c_void_p) for name in ("allocate", "free", "finished", "environment")]


class Library:
    """A loaded library with one log for all of its instances."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.log: list[str] = []
        self.functions = ctypes.CDLL(str(path), mode=os.RTLD_LOCAL)
        for name in ("fmi2Instantiate", "fmi2FreeInstance"):
            getattr(self.functions, name).restype = c_void_p
        self.statuses: list[int] = []
        self.callbacks = Callbacks(LOGGER(self.add))
        assert self.create("{0}") is None
        self.guid = self.log.pop().split("not that of this binary, ")[1].split(":")[0]

    def add(self, *arguments: object) -> None:
        """Takes a message."""
        self.statuses.append(arguments[2])
        self.log.append(arguments[-1].decode())

    def create(self, guid: str | None = None, *, logging: bool = True) -> int | None:
        """A new instance."""
        words = [b"lag", 1, (guid or self.guid).encode(), None, byref(self.callbacks), 0, int(logging)]
        return self.functions.fmi2Instantiate(*words)

    def call(self, name: str, instance: int, *arguments: object) -> None:
        """Calls a function that must succeed."""
        assert getattr(self.functions, name)(c_void_p(instance), *arguments) == 0, (name, self.log)

    def free(self, instance: int | None) -> None:
        """Frees an instance."""
        self.functions.fmi2FreeInstance(c_void_p(instance))

    def start(self, instance: int) -> None:
        """Ends initialisation at 0 s."""
        self.call("fmi2SetupExperiment", instance, 0, c_double(), c_double(), 0, c_double())
        self.call("fmi2EnterInitializationMode", instance)
        self.call("fmi2ExitInitializationMode", instance)

    def step(self, instance: int, number: int) -> float:
        """A step of 0.1 s, and the output after it."""
        self.call("fmi2DoStep", instance, c_double(0.1 * number), c_double(0.1), 1)
        value = c_double()
        self.call("fmi2GetReal", instance, byref(OUTPUT), c_size_t(1), byref(value))
        return value.value

    def state(self, instance: int) -> bytes:
        """The serialised state."""
        state, size = c_void_p(), c_size_t()
        self.call("fmi2GetFMUstate", instance, byref(state))
        self.call("fmi2SerializedFMUstateSize", instance, state, byref(size))
        data = ctypes.create_string_buffer(size.value)
        self.call("fmi2SerializeFMUstate", instance, state, data, size)
        self.call("fmi2FreeFMUstate", instance, byref(state))
        return data.raw

    def resume(self, instance: int, data: bytes) -> None:
        """Continues from a serialised state."""
        state = c_void_p()
        self.call("fmi2DeSerializeFMUstate", instance, data, c_size_t(len(data)), byref(state))
        self.call("fmi2SetFMUstate", instance, state)
        self.call("fmi2FreeFMUstate", instance, byref(state))

    def unload(self) -> None:
        """Unloads the library."""
        close = ctypes.CDLL(None).dlclose
        close.argtypes = [c_void_p]
        assert close(self.functions._handle) == 0


def is_loaded(path: Path) -> bool:
    """Whether a library is in this process."""
    return str(path) in Path("/proc/self/maps").read_text()


def variant(path: Path) -> Path:
    """The variant of a library."""
    return path.with_name("Lag-avx2.so")


@pytest.fixture(scope="module")
def built() -> Callable[[Path | None], Path]:
    """Compiles the library for a variant, or the variant, and returns its path, where the next one replaces it."""
    cargo = os.environ.get("CARGO") or shutil.which("cargo")
    if cargo is None:
        pytest.skip("cargo is not on the path: the library can't be built")

    def build(of: Path | None) -> Path:
        folder = ROOT / "target" / "variant" / ("all" if of else "avx2")
        environment = {
            **os.environ,
            "CARGO_TARGET_DIR": str(folder),
            "CARGO_ENCODED_RUSTFLAGS": "" if of else "-Ctarget-feature=+avx2",
        }
        if of:
            environment["PUSHBELT_VARIANT"] = hash_of(of.read_bytes())
        command = [cargo, "build", "--release", "--package", "pushbelt-fmi", "--example", "lag"]
        subprocess.run(command, cwd=ROOT, env=environment, check=True, capture_output=True)
        return folder / "release" / "examples" / "liblag.so"

    return build


def hash_of(content: bytes) -> str:
    """Length, and FNV-1a of words of 8 bytes, as `crates/fmi/src/hash.rs` has them."""
    found = 0x6C62272E07BB014262B821756295C58D
    full = len(content) // 8 * 8
    for (word,) in struct.iter_unpack("<Q", content[:full] + content[full:].ljust(8, b"\0")):
        found = (found ^ word) * 0x13B % 2**128 + ((found ^ word) << 88) % 2**128
        found %= 2**128
    return f"{len(content)}-{found:032x}"


@pytest.fixture(scope="module")
def pair(built, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A library and its variant."""
    folder = tmp_path_factory.mktemp("built")
    fast = Path(shutil.copy(built(None), folder / "Lag-avx2.so"))
    return Path(shutil.copy(built(fast), folder / "Lag.so")), fast


@pytest.fixture
def folder(pair: tuple[Path, Path], tmp_path: Path) -> Callable[..., Path]:
    """Makes a folder with the library, and with its variant or this content under the name; returns the path of the library."""

    def make(name: str = "place", content: bytes | None = None, *, with_variant: bool = True) -> Path:
        path = tmp_path / name / "Lag.so"
        path.parent.mkdir()
        shutil.copy(pair[0], path)
        if with_variant:
            variant(path).write_bytes(pair[1].read_bytes() if content is None else content)
        return path

    return make


@pytest.fixture(autouse=True)
def without_switch(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The environment of most users."""
    monkeypatch.delenv("PUSHBELT_AVX2", raising=False)
    yield


FAST = "the library for processors with AVX2 runs"
SLOW = "the slower library for all processors runs: "
WARNING = 1


def test_the_variant_is_open_from_the_first_instance_to_the_last(folder) -> None:
    path = folder()
    library = Library(path)
    # An attempt with another GUID has opened it, and closed it.
    assert not is_loaded(variant(path))
    first, second = library.create(), library.create()
    assert is_loaded(variant(path)) and library.log == [FAST, FAST]
    library.start(first)
    assert library.step(first, 0) == pytest.approx(0.048770575499286)
    library.free(first)
    library.free(None)
    assert is_loaded(variant(path))
    library.start(second)
    library.step(second, 0)
    library.free(second)
    assert not is_loaded(variant(path))
    third = library.create(logging=False)
    assert is_loaded(variant(path)) and len(library.log) == 2, "nothing is logged without logging"
    library.free(third)
    library.unload()
    assert not is_loaded(path) and not is_loaded(variant(path))


def changed(content: bytes) -> bytes:
    """A library whose code has another bit."""
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]


REFUSALS = {
    "missing": (None, "Lag-avx2.so: there is no such file"),
    "empty": (lambda base, fast: b"", "Lag-avx2.so: it has 0 bytes"),
    "truncated": (lambda base, fast: fast[: len(fast) // 2], "is not the file of this build"),
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
    instance = library.create(logging=False)
    assert not is_loaded(variant(path))
    assert len(library.log) == 1 and library.log[0].startswith(SLOW) and message in library.log[0]
    assert library.statuses[-1] == WARNING
    library.start(instance)
    assert library.step(instance, 0) == pytest.approx(0.048770575499286)
    library.free(instance)
    library.unload()
    assert not is_loaded(path)


def test_only_the_folder_of_the_library_itself_counts(folder, tmp_path: Path) -> None:
    """Neither that of a link to it, nor the working directory if the host has a relative path and has changed it."""
    path, planted = folder(with_variant=False), folder("planted")
    (tmp_path / "links").mkdir()
    link = tmp_path / "links" / "Lag.so"
    link.symlink_to(path)
    shutil.copy(variant(planted), variant(link))
    code = """if True:
        import os, sys, test_variant
        found = test_variant.Library(test_variant.Path(sys.argv[1]))
        os.chdir(sys.argv[2])
        found.free(found.create())
        print(*found.log)"""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])}
    for given in (str(link), "place/Lag.so"):
        command = [sys.executable, "-c", code, given, str(planted.parent)]
        log = subprocess.run(command, cwd=tmp_path, env=environment, check=True, capture_output=True, text=True).stdout
        assert log.startswith(SLOW) and f"{variant(path)}: there is no such file" in log, given
    link.unlink()
    shutil.copy(variant(planted), variant(path))
    link.symlink_to(path)
    library = Library(link)
    library.free(library.create())
    assert library.log == [FAST]


def test_an_instance_stays_in_its_library(folder, monkeypatch: pytest.MonkeyPatch) -> None:
    """While an instance of the library itself exists, the variant is not opened."""
    path = folder()
    monkeypatch.setenv("PUSHBELT_AVX2", "0")
    library = Library(path)
    first = library.create()
    monkeypatch.delenv("PUSHBELT_AVX2")
    second = library.create()
    assert not is_loaded(variant(path))
    library.free(first)
    library.free(second)
    third = library.create()
    assert is_loaded(variant(path)) and library.log[-1] == FAST
    library.free(third)


def test_states_pass_between_the_library_and_its_variant(folder) -> None:
    fast, slow = Library(folder("a")), Library(folder("b", with_variant=False))
    instances = {library: library.create() for library in (fast, slow)}
    for library, instance in instances.items():
        library.start(instance)
    for writer, reader in [(fast, slow), (slow, fast)]:
        data = writer.state(instances[writer])
        expected = writer.step(instances[writer], 0)
        reader.resume(instances[reader], data)
        assert reader.step(instances[reader], 0) == pytest.approx(expected, rel=1e-15)
        for library in (fast, slow):
            library.resume(instances[library], data)
