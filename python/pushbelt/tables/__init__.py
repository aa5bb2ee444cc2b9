"""Tables. Here: CSV files that every program writes by `write`, with name and unit of each column in the one spelling
`primary.speed [rad/s]`. In the modules: tables of rigs and of other tools: files (bytes → cells), names, numerals, units → sheet (cells →
columns in SI) → series (plateaus) → points (what is measured where) → plausible."""

import csv
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ..errors import ArgumentError

SPELLING = re.compile(r"(?P<name>.+) \[(?P<unit>[^\[\]]+)\]")
OF_A_VARIABLE = "[SI]"  # End of the title of a column whose rows are values of different variables


def title(name: str, unit: str | None) -> str:
    """The title of a column of numbers; no unit is the unit 1, as in the FMU."""
    return f"{name} [{unit or '1'}]"


def titles(names: Iterable[str], units: Mapping[str, str | None]) -> list[str]:
    """Titles of columns of numbers. Raises KeyError for a name whose unit is unknown."""
    return [title(name, units[name]) for name in names]


def split(text: str) -> tuple[str, str | None]:
    """Name and unit of a title; the unit is None for a title without one. The index of `profile.pushForce[1]` is no unit."""
    found = SPELLING.fullmatch(text.strip())
    return (found["name"], found["unit"]) if found else (text.strip(), None)


def write(path: Path, header: Iterable[str], rows: Iterable[Iterable[Any]], digits: int | None = 9, remark: str | None = None) -> None:
    """Writes a table as CSV; a missing folder is made. `digits` is the number of significant digits of floating-point numbers; None writes
    all. A `remark` is the first line, after `#`. Raises ArgumentError if a column with floating-point numbers has no unit in its title."""
    header = list(header)
    without = {text for text in header if split(text)[1] is None}

    def cell(title: str, value: Any) -> Any:
        if not isinstance(value, float):
            return value
        if title in without:
            raise ArgumentError(f"{path.name}: the column {title} has no unit")
        return repr(float(value)) if digits is None else f"{value:.{digits}g}"

    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", encoding="utf-8", newline="") as file:
        if remark is not None:
            file.write(f"# {remark}\n")
        csv.writer(file).writerows([header, *([cell(*pair) for pair in zip(header, row, strict=True)] for row in rows)])


def write_frame(path: Path, header: Iterable[str], rows: Any) -> None:
    """Writes the columns of a pandas data frame under these titles; a cell without a value is empty."""
    write(path, header, rows.astype(object).where(rows.notna(), None).itertuples(index=False))


def read(path: Path) -> tuple[dict[str, str | None], list[list[str]]]:
    """Units by the names of the columns, and the rows of a file of `write` or of another tool. Lines that start with `#` are left out."""
    with path.open(encoding="utf-8", newline="") as file:
        header, *rows = [*csv.reader(line for line in file if not line.startswith("#"))] or [[]]
    return dict(map(split, header)), rows
