"""What the tests check of the CSV files of runs."""

from __future__ import annotations

import csv
from pathlib import Path

from pushbelt.fmu.untrusted import described
from pushbelt.tables import read, sheet, split, units
from pushbelt.tables.names import Column


def by_name(path: Path) -> list[dict[str, str]]:
    """Rows by the names of the columns without their units."""
    names, rows = read(path)
    return [dict(zip(names, row, strict=True)) for row in rows]


def units_are_those_of(fmu: Path, *paths: Path) -> None:
    """Every column of numbers has a unit, and that of a variable is the FMU's. Readers of tables take all titles."""
    known = {one.name: one.unit or "1" for one in described(fmu).modelVariables}
    for path in paths:
        with path.open(encoding="utf-8", newline="") as file:
            titles = next(csv.reader(file))
        found = [split(title) for title in titles]
        texts = {"case", "run", "name"}
        assert all(unit is not None for name, unit in found if name not in texts), titles
        assert {name: unit for name, unit in found if name in known} == {name: known[name] for name, _ in found if name in known}
        columns = {name: Column(units.OF_FMU[unit], -1e99, 1e99, "") for name, unit in found if unit is not None}
        found = sheet.read(path, columns, misspelled=False)
        assert set(found.taken) == set(columns), path
