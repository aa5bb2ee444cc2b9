"""Columns of a table in SI units, by known names. All faults of a file are in one error, with line and column.

A column has a title of name and unit; the unit may also be in the row below. Names are compared without case, blanks and points.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import numerals, text, units
from ..errors import PushbeltError
from .numerals import NumeralError, Percent
from .text import Cells
from .units import Unit

if TYPE_CHECKING:
    import pandas as pd

DEVIATION = ".sd"
"""Suffix of a column of standard deviations."""
CLOSE = 0.82
"""Similarity above which an unknown name is taken for a misspelled one."""
INDEX = frozenset({"", "#", "nr", "no", "index", "idx", "id", "row", "zeile", "unnamed0", "lfdnr", "point"})
"""Titles of columns that count the rows."""
SAMPLE = 500
"""Rows that suffice to settle the decimal sign if all their numbers agree."""
SHOWN = 12
"""Largest number of faults that an error lists in full."""


@dataclass(frozen=True)
class Column:
    """A column that a table may have."""

    dimension: str
    """Dimension of its unit, or `text`."""
    low: float
    """Least plausible value, SI."""
    high: float
    """Largest, SI."""
    meaning: str
    aliases: tuple[str, ...] = ()
    """Other common names."""
    default: str | None = None
    """Unit of a column without one; None if a unit is required. Ratios need none."""

    def without_unit(self) -> Unit | None:
        """The unit of a column whose title and row of units have none."""
        if self.dimension == "ratio":
            return Unit(1.0)
        return None if self.default is None else units.find(self.default, self.dimension)


@dataclass(frozen=True)
class Fault:
    """A fault of a table."""

    text: str
    line: int | None = None
    column: str | None = None

    def __str__(self) -> str:
        place = [f"line {self.line}"] if self.line is not None else []
        place += [f"column {self.column}"] if self.column is not None else []
        return f"{', '.join(place)}: {self.text}" if place else self.text


class TableError(PushbeltError, ValueError):
    """The table cannot be used. The message has every fault with line, column and value."""

    def __init__(self, faults: Sequence[Fault] | str, path: Path | None = None, found: Sheet | None = None) -> None:
        self.faults = (Fault(faults),) if isinstance(faults, str) else tuple(faults)
        self.found = found
        """What was understood in spite of the faults."""
        start = f"{path}: " if path is not None else ""
        if len(self.faults) == 1:
            super().__init__(f"{start}{self.faults[0]}")
        else:
            lines = [f"  {fault}" for fault in self.faults[:SHOWN]]
            if len(self.faults) > SHOWN:
                lines.append(f"  and {len(self.faults) - SHOWN} more of the same kinds")
            super().__init__("\n".join([f"{start}{len(self.faults)} faults", *lines]))


@dataclass(frozen=True)
class Reading:
    """Choices of the user."""

    decimal: str | None = None
    """`point` or `comma`; None: determined from the file."""
    renamed: Mapping[str, str] = field(default_factory=dict)
    """Known name, possibly with a unit, by the title of the file, or the other way round."""
    sheet: str | None = None
    """Sheet of a spreadsheet."""


@dataclass(frozen=True)
class Taken:
    """A column that is used."""

    title: str
    """Title in the file."""
    name: str
    """Known name, with `.sd` for standard deviations."""
    unit: str
    """Unit as written; empty without one."""
    place: int
    scale: Unit
    column: Column
    turned: str = ""
    """`1/` if the file has the inverse, `-` if it has the opposite sign."""

    def si(self, value: float, scale: Unit | None = None) -> float:
        """SI value of a number of the file; NaN for the inverse of 0."""
        found = (scale or self.scale).si(value)
        if self.turned == "-":
            return -found
        return found if not self.turned else 1.0 / found if found else np.nan


@dataclass
class Sheet:
    """A table in SI units."""

    path: Path
    source: str
    decimal: str
    taken: dict[str, Taken]
    """Columns by known name."""
    ignored: list[str]
    """Titles of unknown columns."""
    remarks: list[str]
    values: dict[str, np.ndarray[Any, Any]]
    """SI values by name; NaN where a cell is empty."""
    texts: dict[str, list[str]]
    """Columns of texts by name."""
    lines: np.ndarray[Any, Any]
    """Line of each row."""
    left_out: list[Fault]
    """Rows that are not used, and why."""
    faults: list[Fault]
    failed: set[str]
    """Known names of columns that have faults and are not in `taken`."""

    def __len__(self) -> int:
        return len(self.lines)

    def title(self, name: str) -> str:
        """The title in the file of a known name, or the name itself."""
        return self.taken[name].title if name in self.taken else name

    def keep(self, rows: np.ndarray[Any, Any]) -> None:
        """Removes the other rows."""
        self.values = {name: values[rows] for name, values in self.values.items()}
        self.texts = {name: [t for t, k in zip(texts, rows, strict=True) if k] for name, texts in self.texts.items()}
        self.lines = self.lines[rows]

    def check(self) -> None:
        """Raises TableError if there are faults."""
        if self.faults:
            raise TableError(self.faults, self.path, self)


class Names:
    """Known names and their other spellings."""

    def __init__(self, columns: Mapping[str, Column]) -> None:
        self.columns = columns
        self._known: dict[str, list[str]] = {}
        for name, column in columns.items():
            for spelled in (name, *column.aliases):
                self._known.setdefault(key(spelled), []).append(name)

    def find(self, written: str) -> list[str]:
        """Known names with this spelling."""
        return self._known.get(key(written), [])

    def close(self, written: str) -> str | None:
        """The known name that is probably meant by an unknown one."""
        spelled = key(written)
        if len(spelled) < 4:
            return None
        near = difflib.get_close_matches(spelled, [known for known in self._known if len(known) > 3], 1, CLOSE)
        return self._known[near[0]][0] if near else None

    def count(self, cells: Sequence[str]) -> int:
        """Number of known names among titles."""
        return sum(bool(self.split(cell)) for cell in cells if cell)

    def split(self, title: str) -> list[tuple[str, str | None]]:
        """Known names and units of a title, possibly several if the unit decides."""
        bracketed = title.rstrip()[-1:] in ("]", ")", "}")
        for written, unit in splits(title):
            base, deviation = without_deviation(written)
            found = self.find(written)
            end = ""
            if not found and deviation:
                found, end = self.find(base), DEVIATION
            # Without brackets the end of a title is a unit only if the column may have it.
            fitting = [name for name in found if unit is None or bracketed or units.find(unit, self.columns[name].dimension) is not None]
            if fitting:
                return [(name + end, unit) for name in fitting]
        return []


LETTERS = str.maketrans({"ω": "omega", "η": "eta", "ζ": "zeta", "ν": "nu", "σ": "sigma", "₁": "1", "₂": "2", "ₚ": "p", "ₛ": "s"})


def key(name: str) -> str:
    """A name without case, blanks and signs. The division stays."""
    name = name.strip().lower().translate(LETTERS)
    return re.sub(r"[^a-z0-9/äöüß]", "", name)


def without_deviation(name: str) -> tuple[str, bool]:
    """A name without the word for a standard deviation, and whether it has one."""
    found = re.fullmatch(r"(.+?)[.\s_-]*(?:sd|std|stddev|sigma)|(?:sd|std|sigma)[\s_.(]+(.+?)\)?", name.strip(), re.IGNORECASE)
    return (found.group(1) or found.group(2), True) if found else (name, False)


def splits(title: str) -> Iterable[tuple[str, str | None]]:
    """Possible pairs of name and unit of a title, the most explicit one first."""
    title = title.strip().strip("\"'").strip()
    bracketed = re.fullmatch(r"(.*?)[\s_,;:/-]*(?:\[([^\]]*)\]|\{([^}]*)\}|\((.*)\))\s*", title)
    if bracketed and bracketed.group(1):
        yield bracketed.group(1), next(group for group in bracketed.groups()[1:] if group is not None)
    for pattern in (r"(.+?)\s+/\s*(\S.*)", r"(.+)/(\S+)", r"(.+?)\s*,\s*(\S.*)", r"(.+?)\s+in\s+(\S.*)"):
        found = re.fullmatch(pattern, title)
        if found and units.dimensions(found.group(2)):
            yield found.group(1), found.group(2)
    for sign in re.finditer(r"[\s_.:]+", title):
        if sign.start() and units.dimensions(title[sign.end() :]):
            yield title[: sign.start()], title[sign.end() :]
    yield title, None


def _turned(wanted: str | None) -> tuple[str, str | None]:
    """The prefix `1/` or `-` of a name, and the name."""
    for prefix in ("1/", "-"):
        if wanted is not None and wanted.strip().startswith(prefix):
            return prefix, wanted.strip().removeprefix(prefix).strip()
    return "", wanted


def read(path: Path, columns: Mapping[str, Column], reading: Reading | None = None, misspelled: bool = True) -> Sheet:
    """Columns of a file. Faults are collected in the result; with `misspelled` a title close to a known name is one.

    Raises TableError if the file is not a table at all, OSError if it cannot be read.
    """
    reading = reading or Reading()
    names = Names(columns)
    mapped = {side for pair in reading.renamed.items() for side in pair}

    def known(cells: Sequence[str]) -> int:
        return names.count(cells) + sum(any(_same(cell, side) for side in mapped) and not names.count([cell]) for cell in cells if cell)

    try:
        cells = text.read(path, known, reading.sheet)
    except ValueError as error:  # A TextError, or pandas' ParserError.
        raise TableError([Fault(str(error))], path) from error
    return _Reader(path, cells, names, reading, known, misspelled).sheet()


def _same(title: str, wanted: str) -> bool:
    return title.strip() == wanted.strip() or any(key(written) == key(wanted) != "" for written, _ in splits(title))


class _Reader:
    def __init__(self, path: Path, cells: Cells, names: Names, reading: Reading, known: Any, misspelled: bool) -> None:
        self.misspelled = misspelled
        self.path, self.cells, self.names, self.reading = path, cells, names, reading
        self.faults: list[Fault] = []
        self.remarks: list[str] = []
        self.ignored: list[str] = []
        self.taken: dict[str, Taken] = {}
        self.failed: set[str] = set()
        rows = range(min(text.HEAD, len(cells.frame)))
        # The first of the rows with most names.
        self.header = max(rows, key=lambda row: (known(cells.row(row)), -row))
        if self.header:
            self.remarks.append(f"{self.header} rows above the header are not read")
        self.titles = cells.row(self.header)
        self.units: list[str] = [""] * len(self.titles)
        self.first = self.header + 1
        if self.first < len(cells.frame) and self._is_row_of_units(cells.row(self.first)):
            self.units = cells.row(self.first)
            self.first += 1

    @staticmethod
    def _is_row_of_units(row: Sequence[str]) -> bool:
        """No numbers apart from the unit 1, and at least half of the cells are units."""
        filled = [cell for cell in row if cell]
        if not filled or any(cell != "1" and any(numerals.number(cell, name) is not None for name in numerals.SIGNS) for cell in filled):
            return False
        known = sum(units.is_unit(cell) for cell in filled)
        return any(cell not in ("1", "-") and units.is_unit(cell) for cell in filled) and 2 * known >= len(filled)

    def sheet(self) -> Sheet:
        self._take()
        body = self.cells.frame.iloc[self.first :]
        lines = self.cells.lines[self.first :]
        self._extra_cells(body, lines)
        decimal = self._decimal(body)
        values, texts = {}, {}
        bad = np.zeros(len(body), dtype=bool)
        left_out: list[Fault] = []
        columns = {}
        for name, one in self.taken.items():
            column = body[one.place].tolist()
            if one.column.dimension == "text":
                texts[name] = [str(cell) for cell in column]
            elif decimal is not None:
                columns[name], errors = self._numbers(one, column, lines, decimal)
                if errors.all() and len(errors):
                    self.remarks.append(f"column {one.title} has no value")
                    errors[:] = False
                for row in np.flatnonzero(errors & ~bad):
                    left_out.append(Fault(f"'{column[row]}' is no value", int(lines[row]), one.title))
                bad |= errors
        values = columns
        found = Sheet(
            self.path, self.cells.source, decimal or "unknown", self.taken, self.ignored, self.remarks, values, texts, lines, left_out,
            self.faults, self.failed,
        )  # fmt: skip
        found.keep(~bad)
        return found

    # Titles

    def _take(self) -> None:
        places: dict[str, list[Taken]] = {}
        renamed = self._renamed()
        for place, title in enumerate(self.titles):
            one = self._taken(place, title, renamed.get(place))
            if one is not None:
                places.setdefault(one.name, []).append(one)
        for name, found in places.items():
            explicit = [one for one in found if one.place in renamed] or found
            if len(explicit) > 1:
                titles = " and ".join(one.title for one in explicit)
                self.faults.append(Fault(f"it appears {len(explicit)} times: {titles}", self._line, name))
            self.taken[name] = explicit[0]

    @property
    def _line(self) -> int:
        return int(self.cells.lines[self.header])

    def _renamed(self) -> dict[int, str]:
        """Known name, possibly with a unit, by place, as the user asks for."""
        found: dict[int, str] = {}
        for one, other in self.reading.renamed.items():
            for title, wanted in ((one, other), (other, one)):
                places = [k for k, there in enumerate(self.titles) if there.strip() == title.strip()]
                places = places or [k for k, there in enumerate(self.titles) if there and _same(there, title)]
                if places and self.names.split(_turned(wanted)[1] or ""):
                    found[places[0]] = wanted
                    break
            else:
                known = self.names.split(_turned(one)[1] or "") or self.names.split(_turned(other)[1] or "")
                text = f"there is no column {one} in the file" if known else f"neither {one} nor {other} is a known name"
                self.faults.append(Fault(f"--map {one}={other}: {text}"))
        return found

    def _taken(self, place: int, title: str, wanted: str | None) -> Taken | None:
        row_unit = self.units[place].strip() if place < len(self.units) else ""
        turned, wanted = _turned(wanted)
        candidates = self.names.split(wanted if wanted is not None else title)
        if wanted is None and title.startswith("#"):
            return None
        if not candidates:
            self._unknown(title)
            return None
        own = next((unit for written, unit in splits(title) if unit is not None and key(written)), None)
        # A unit in the title counts before one in the row below.
        written = candidates[0][1] if candidates[0][1] is not None else (own if wanted is not None else None)
        spelled = written if written is not None and written.strip() else row_unit
        missed: list[tuple[str, Column]] = []
        for name, _ in candidates:
            column = self.names.columns[name.removesuffix(DEVIATION)]
            if column.dimension == "text":
                return Taken(title, name, "", place, Unit(1.0), column)
            scale = units.find(spelled, column.dimension) if spelled else column.without_unit()
            if scale is not None:
                return Taken(title, name, spelled, place, scale, column, turned)
            missed.append((name, column))
        name, column = missed[0]
        self.failed.add(name)
        foreign = bool(spelled) and bool(units.dimensions(spelled)) and wanted is None
        full = key(name) == key(next(iter(splits(title)))[0])
        if foreign and not full:
            # A short name may mean something else: T_P in °C is a temperature.
            self.remarks.append(f"column {title}: {spelled} is not a unit of {name}")
            self.ignored.append(title)
            self.failed.discard(name)
        elif spelled:
            self.faults.append(Fault(f"the unit of {name} is {units.names(column.dimension)}, not {spelled}", self._line, title))
        else:
            choice = " or ".join(f"{name} [{unit}]" for unit in units.PREFERRED[column.dimension])
            self.faults.append(Fault(f"no unit; write {choice}", self._line, title))
        return None

    def _unknown(self, title: str) -> None:
        if title.startswith("#"):
            return
        if key(title) in INDEX:
            if title:
                self.ignored.append(title)
            return
        near = None if not self.misspelled else next((close for written, _ in splits(title) if (close := self.names.close(written)) is not None), None)
        if near is not None:
            self.failed.add(near)
            self.faults.append(Fault(f"there is no such column; {near} is meant? --map \"{title}\"={near} says so", self._line, title))
        else:
            self.ignored.append(title)

    # Numbers

    def _extra_cells(self, body: pd.DataFrame, lines: np.ndarray[Any, Any]) -> None:
        """Cells beyond the last title."""
        last = max((k for k, title in enumerate(self.titles) if title), default=-1)
        for row, cells in enumerate(body.iloc[:, last + 1 :].itertuples(index=False)):
            filled = [k for k, cell in enumerate(cells) if str(cell) != ""]
            if filled:
                count = last + 2 + filled[-1]
                self.faults.append(Fault(f"{count} cells, but the header has {last + 1}", int(lines[row])))

    def _decimal(self, body: pd.DataFrame) -> str | None:
        if self.reading.decimal is not None:
            return self.reading.decimal
        places = [one.place for one in self.taken.values() if one.column.dimension != "text"]
        sample = {cell for place in places for cell in body[place].iloc[:SAMPLE] if isinstance(cell, str)}
        sure = numerals.certain(sample)
        if sure is not None:
            return sure
        texts = {cell for place in places for cell in body[place] if isinstance(cell, str)}
        try:
            return numerals.settle(texts, self.cells.separator)
        except NumeralError as error:
            self.faults.append(Fault(str(error)))
            return None

    def _numbers(
        self, one: Taken, column: Sequence[Any], lines: np.ndarray[Any, Any], decimal: str
    ) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """SI values of a column, and the rows with an error value in it."""
        plain = self._plain(one, column, decimal)
        if plain is not None:
            return plain, np.zeros(len(column), dtype=bool)
        found = np.full(len(column), np.nan)
        errors = np.zeros(len(column), dtype=bool)
        for row, cell in enumerate(column):
            if isinstance(cell, str):
                if not cell or cell in "-–—":
                    continue
                if numerals.missing(cell):
                    errors[row] = True
                    continue
                value = numerals.number(cell, decimal)
                scale = Unit(0.01) if cell.rstrip().endswith("%") else one.scale
                if cell.rstrip().endswith("%") and one.column.dimension != "ratio":
                    value = None
            elif isinstance(cell, Percent):
                value, scale = cell.share, Unit(1.0)
            else:
                value, scale = float(cell), one.scale
            if value is None:
                other = next(name for name in numerals.SIGNS if name != decimal)
                is_other = isinstance(cell, str) and numerals.number(cell, other) is not None
                hint = f" with a decimal {decimal}, which the other numbers of the file have" if is_other else ""
                self.faults.append(Fault(f"'{cell}' is not a number{hint}", int(lines[row]), one.title))
                continue
            si = one.si(value, scale) if not one.name.endswith(DEVIATION) else scale.factor * value
            if self._in_range(one, si, cell, int(lines[row]), scale):
                found[row] = si
        return found, errors

    @staticmethod
    def _plain(one: Taken, column: Sequence[Any], decimal: str) -> np.ndarray[Any, Any] | None:
        """SI values of a column of plain numbers that are all in range; None for any other column."""
        if decimal != "point" or one.turned or one.name.endswith(DEVIATION):
            return None
        import pandas as pd

        numbers = pd.to_numeric(pd.Series(list(column), dtype=object), errors="coerce").to_numpy(dtype=float)
        values = one.scale.factor * numbers + one.scale.offset
        inside = (values >= one.column.low) & (values <= one.column.high)
        return values if inside.all() and np.isfinite(values).all() else None

    def _in_range(self, one: Taken, value: float, cell: Any, line: int, scale: Unit) -> bool:
        deviation = one.name.endswith(DEVIATION)
        low, high = (0.0, one.column.high - one.column.low) if deviation else (one.column.low, one.column.high)
        if low <= value <= high and not (deviation and value == 0.0):
            return True
        offset = 0.0 if deviation else scale.offset
        limits = [(low - offset) / scale.factor, (high - offset) / scale.factor]
        if one.turned and not deviation:
            limits = sorted(-limit if one.turned == "-" else 1.0 / limit if limit else np.inf for limit in limits)
        allowed = f"{limits[0]:.6g} to {limits[1]:.6g}"
        above = "above " if deviation else ""
        written = one.unit or one.column.default
        unit = f" {written}" if written not in (None, "", "1", "-") else ""
        shown = f"{cell.share:g}" if isinstance(cell, Percent) else f"{cell}"
        self.faults.append(Fault(f"{shown} is not within {above}{allowed}{unit}", line, one.title))
        return False
