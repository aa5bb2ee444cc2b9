"""Where the FMU and the published data are: in the installed package, or in the source tree."""

from __future__ import annotations

import os
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
DATA = PACKAGE / "data"
"""What a wheel has beside the code: the FMU and the published data. The source tree has no such folder."""
TREE = PACKAGE.parents[1]
"""Top level of the source tree."""
RESOURCES = (DATA if DATA.is_dir() else TREE) / "resources"
"""Parameter sets, published variators and the manoeuvre."""
NAME = "PushbeltVariator.fmu"


def default_fmu() -> Path:
    """The FMU that the environment variable `PUSHBELT_FMU` names, or the one in the wheel, or that in `target`.

    Raises FileNotFoundError where it is missing.
    """
    named = os.environ.get("PUSHBELT_FMU")
    path = Path(named) if named else DATA / NAME if DATA.is_dir() else TREE / "target" / NAME
    if not path.is_file():
        why = (
            "the environment variable PUSHBELT_FMU names it"
            if named
            else "in the source tree `cargo fmu build` makes it"
        )
        raise FileNotFoundError(f"there is no FMU at {path}; {why}")
    return path
