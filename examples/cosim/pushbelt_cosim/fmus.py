"""Builds FMUs from the units in `slaves/`."""

from __future__ import annotations

import ctypes
import platform
import shutil
import sys
import tempfile
import zipfile
from pathlib import Path

from pythonfmu import FmuBuilder

import pushbelt
from pushbelt.fmu.data import RESOURCES
from pushbelt.fmu.unit import UnitError
from pushbelt.maps.data import Maps

from .unit import MAP_FILE

PROGRAMS = ("belt", "calibrate", "demo", "sweep")
"""Parts of `pushbelt` that the units do not need."""

SLAVES = Path(__file__).parent / "slaves"


def build(folder: Path, maps: Maps) -> tuple[Path, Path]:
    """Writes the FMUs of vehicle and control to a folder and returns their paths.

    Raises UnitError if this Python cannot run FMUs of pythonfmu.
    """
    if not FmuBuilder.has_binary():
        raise UnitError(f"pythonfmu has no binary for {platform.system()} {platform.machine()}")
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        scratch = Path(name)
        maps.write(scratch / MAP_FILE)
        # The layout is that of the source tree, so that the package finds its data.
        files = [*_modules(scratch), scratch / MAP_FILE, RESOURCES / "variators.json", RESOURCES / "parameters"]
        vehicle, control = (
            Path(FmuBuilder.build_FMU(SLAVES / f"{unit}_unit.py", dest=folder, project_files=files))
            for unit in ("vehicle", "control")
        )
    _check(vehicle)
    return vehicle, control


def _modules(scratch: Path) -> list[Path]:
    """Copies what the units import: the core of `pushbelt` with `drive`, and this package."""
    packages = [Path(pushbelt.__file__).parent, Path(__file__).parent]
    without = shutil.ignore_patterns("__pycache__", SLAVES.name, *PROGRAMS)
    return [Path(shutil.copytree(package, scratch / package.name, ignore=without)) for package in packages]


def _check(fmu: Path) -> None:
    """Checks that the binary loads. It uses the Python of the process that loads it; without one an importer would crash later."""
    pattern = "win64/*.dll" if sys.platform == "win32" else "linux64/*.so"
    # The library stays loaded, so Windows cannot delete its file.
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as scratch, zipfile.ZipFile(fmu) as archive:
        archive.extractall(scratch)
        (binary,) = (Path(scratch) / "binaries").glob(pattern)
        try:
            ctypes.CDLL(str(binary))
        except OSError as error:
            raise UnitError(f"this Python can't run FMUs of pythonfmu: {error}") from error
