"""Paths of the FMU and the published data, in the installed package or in the source tree."""

import os
from pathlib import Path

from ..errors import MissingFileError

PACKAGE = Path(__file__).parents[1]
DATA = PACKAGE / "data"  # Folder of a wheel with the FMU and the published data. It does not exist in the source tree.
TREE = PACKAGE.parents[1]  # Top level of the source tree
RESOURCES = (DATA if DATA.is_dir() else TREE) / "resources"  # Parameter sets, published variators and the manoeuvre
DOCS = (DATA if DATA.is_dir() else TREE) / "docs"  # Pages of the documentation
EXAMPLES = (DATA if DATA.is_dir() else TREE) / "examples"
NAME = "PushbeltVariator.fmu"


def default_fmu() -> Path:
    """The FMU that the environment variable `PUSHBELT_FMU` names, or the one in the wheel, or that in `target`.
    Raises MissingFileError if it is missing."""
    return found("PUSHBELT_FMU", NAME, "cargo fmu build")


def found(variable: str, name: str, build: str) -> Path:
    """An FMU that an environment variable names, or the one of a name in the wheel or in `target`."""
    named = os.environ.get(variable)
    path = Path(named) if named else DATA / name if DATA.is_dir() else TREE / "target" / name
    if not path.is_file():
        why = f"the path is from the environment variable {variable}" if named else f"in the source tree it is built by `{build}`"
        raise MissingFileError(f"there is no FMU at {path}; {why}")
    return path
