"""The folder of an FMU with the binaries of this machine."""

from __future__ import annotations

from pathlib import Path

import fmpy


def folder(binaries: Path) -> Path | None:
    """The folder below `binaries` for this processor and system; None if there is none.

    FMI 2.0.4 and later name it as FMI 3.0 does, such as `aarch64-linux`. The older names mean x86-64; only on macOS they had libraries
    of both processors.
    """
    names = [fmpy.platform_tuple]
    if fmpy.platform_tuple not in ("aarch64-linux", "aarch64-windows"):
        names.append(fmpy.platform)
    return next((path for name in names if (path := binaries / name).is_dir()), None)
