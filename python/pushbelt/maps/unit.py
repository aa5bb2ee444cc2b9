"""`PushbeltMap.fmu`, a variator from maps: its tables as a file in the resources, and copies of the FMU with other maps.

The FMU's token is the exclusive or of a hash of its description and a hash of its tables, so a copy with other tables needs no compiler.
"""

from __future__ import annotations

import codecs
import json
import re
import uuid
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..fmu.files import RESOURCES, found
from ..fmu.start_values import DESCRIPTION, checked, write_copy
from ..fmu.untrusted import described
from ..whole_file import copy_archive
from .data import AT_SHARES, AXES, TABLES, MapError, Maps

TABLES_FILE = "resources/maps.json"  # The tables in the archive
FORMAT, VERSION = "pushbelt map unit", 2
USED = (*AT_SHARES, "capacity", "capacitySlip", "traction", "shiftRate")
"""Tables of the FMU."""
GEOMETRY = (
    "geometry.centerDistance", "geometry.beltLength", "geometry.wedgeAngle", "belt.pitchOffset", "friction.fall", "friction.fallSpeed",
)  # fmt: skip
"""Parameters of the variator that the tables contain."""
OF_PULLEYS = ("inertia", "minRadius", "maxRadius", "drag.constant", "drag.viscous", "bearing.friction", "bearing.radius")
VARIABLES = ("friction.pulley", *(f"{side}.{name}" for side in ("primary", "secondary") for name in OF_PULLEYS))
"""Parameters of the variator that the FMU has as variables."""
DIGITS = 9  # Significant digits of the tables
TOKENS = re.compile(r'\b(guid|instantiationToken)="\{([0-9a-f-]{36})\}"')
_START = 0x6C62272E07BB014262B821756295C58D
_PRIME = 0x0000000001000000000000000000013B


def default_fmu() -> Path:
    """The FMU that the environment variable `PUSHBELT_MAP_FMU` names, or the one in the wheel, or that in `target`.
    Raises MissingFileError if it is missing."""
    return found("PUSHBELT_MAP_FMU", "PushbeltMap.fmu", "cargo fmu build --map")


def default_maps() -> Path:
    """Tables of `bench168`, from `cargo fmu maps -- --ratios 8`."""
    return RESOURCES / "maps" / "maps.json"


def tables_of(maps: Maps) -> bytes:
    """The content of `resources/maps.json` for maps."""
    tables = {name: maps[name] for name in USED}
    # The equations rely on a traction that rises, which holds but for the noise of the solver.
    tables["traction"] = np.maximum.accumulate(tables["traction"], axis=-1)
    rounded = np.vectorize(lambda value: float(f"{value:.{DIGITS}g}"))
    document = {
        "format": FORMAT, "version": VERSION, "source": dict(maps.source), "maps": maps.identity,
        "parameters": {name: maps.parameters[name] for name in GEOMETRY},
        "startValues": {name: maps.parameters[name] for name in VARIABLES},
        "axes": {name: {"unit": axis.unit, "values": maps.axes[name].tolist()} for name, axis in AXES.items() if name != "utilisation"},
        "tables": {
            name: {"axes": TABLES[name].axes, "unit": TABLES[name].unit, "values": rounded(values).tolist()}
            for name, values in tables.items()
        },
    }  # fmt: skip
    # Only the numbers of tables are nested lists, so the file is compact without being one line.
    return (json.dumps(document, separators=(",", ":"), allow_nan=False) + "\n").encode()


def hash_of(content: bytes) -> int:
    """The hash of the tables in the token, without a byte-order mark: FNV-1a with 128 bits (Fowler, Noll, Vo)."""
    found = _START
    for byte in content.removeprefix(codecs.BOM_UTF8):
        found = ((found ^ byte) * _PRIME) % (1 << 128)
    return found


def with_tables(description: str, before: bytes | None, after: bytes) -> str:
    """A model description whose token is that of other tables; `before` are the present ones, None for none."""
    change = hash_of(after) ^ (hash_of(before) if before is not None else 0)

    def token(match: re.Match[str]) -> str:
        return f'{match[1]}="{{{uuid.UUID(int=uuid.UUID(match[2]).int ^ change)}}}"'

    found, count = TOKENS.subn(token, description, count=1)
    if not count:
        raise MapError("the model description has no token")
    return found


def write_tables(fmu: Path, copy: Path, tables: bytes) -> None:
    """Writes a copy of the FMU with other tables. The file is written completely or not at all."""
    with zipfile.ZipFile(fmu) as source:
        before = source.read(TABLES_FILE) if TABLES_FILE in source.namelist() else None
    changed = {DESCRIPTION: lambda xml: with_tables(xml.decode("utf-8"), before, tables).encode("utf-8")}
    copy_archive(fmu, copy, changed, {TABLES_FILE: tables})


def write_fmu(copy: Path, maps: Maps | bytes, fmu: Path | None = None, values: Mapping[str, Any] | None = None) -> None:
    """Writes an FMU with these maps, with the parameters of their variator as start values, and with other start values."""
    fmu, tables = fmu or default_fmu(), maps if isinstance(maps, bytes) else tables_of(maps)
    given = {**json.loads(tables)["startValues"], **(values or {})}
    # An FMU of FMI 3.0 has the variables of that of FMI 2.0, with other types.
    description = described(fmu)
    description = described(default_fmu()) if description.fmiVersion == "3.0" else description
    own = checked({one.name: one for one in description.modelVariables}, given)
    write_tables(fmu, copy, tables)
    write_copy(copy, copy, own)
