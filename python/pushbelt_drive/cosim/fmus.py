"""Makes FMUs of the units in `slaves/`."""

from __future__ import annotations

import ctypes
import platform
import shutil
import sys
import tempfile
import zipfile
from pathlib import Path

import pushbelt_demo
from pushbelt_demo.data import RESOURCES
from pushbelt_demo.unit import UnitError

from ..thrust_map import ThrustMap

SLAVES = Path(__file__).parent / "slaves"
MAP = "thrust-ratio-map.csv"
"""Where the control unit finds its map, in its resources."""


def build(folder: Path, thrust_map: ThrustMap) -> tuple[Path, Path]:
    """Writes the FMUs of vehicle and control to a folder and returns their paths.

    Raises UnitError if this Python can't load such FMUs.
    """
    from pythonfmu import FmuBuilder

    if not FmuBuilder.has_binary():
        raise UnitError(f"pythonfmu has no binary for {platform.system()} {platform.machine()}")
    with tempfile.TemporaryDirectory() as scratch:
        map_file = Path(scratch) / MAP
        thrust_map.write(map_file, "")
        # Laid out as in the source tree, so that the packages find their data.
        packages = [_modules(Path(package.__file__).parent, Path(scratch)) for package in (pushbelt_demo, _own())]
        files = [*packages, RESOURCES / "variators.json", RESOURCES / "parameters", map_file]
        built = [
            Path(FmuBuilder.build_FMU(SLAVES / f"{name}_unit.py", dest=folder, project_files=files))
            for name in ("vehicle", "control")
        ]
    for fmu in built:
        _check_loads(fmu)
    return built[0], built[1]


def _own():
    import pushbelt_drive

    return pushbelt_drive


def _modules(package: Path, scratch: Path) -> Path:
    """A copy of a package without what Python has left in it."""
    copy = scratch / package.name
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("__pycache__", "slaves"))
    return copy


def _check_loads(fmu: Path) -> None:
    """A binary of pythonfmu takes Python from the process that loads it; a master would die of one that doesn't fit."""
    ending = {"win32": "win64/*.dll", "darwin": "darwin64/*.dylib"}.get(sys.platform, "linux64/*.so")
    with tempfile.TemporaryDirectory() as scratch, zipfile.ZipFile(fmu) as archive:
        archive.extractall(scratch)
        (binary,) = Path(scratch).glob(f"binaries/{ending}")
        try:
            library = ctypes.CDLL(str(binary))
            _unload(library)
        except OSError as error:
            raise UnitError(f"this Python can't load FMUs of pythonfmu: {error}") from error


def _unload(library: ctypes.CDLL) -> None:
    if sys.platform == "win32":
        import _ctypes

        _ctypes.FreeLibrary(library._handle)
