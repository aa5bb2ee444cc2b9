"""Columns of a table in SI units, by known names. All faults of a file are in one error, with line and column.

A column has a title of name and unit; the unit may also be in the row below. Names are compared without case, blanks and points.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..errors import ArgumentError, PushbeltError
from ..fmu.geometry import Array
from . import numerals, units
from .names import DEVIATION, Column, Names, key, same, splits, turned
from .units import Unit

if TYPE_CHECKING:
    import pandas as pd

    from .files import Cells

MOST = 0.5  # Share of a column's values with a fault from which the whole column has it; below, their rows are left out
SHOWN = 12  # Largest number of faults that an error lists in full
INDEX = frozenset({"", "#", "nr", "no", "index", "idx", "id", "row", "zeile", "unnamed0", "lfdnr", "point"})
"""Titles of columns that count the rows."""
STATISTICS = frozenset(map(key, "mean average avg median min max minimum maximum mittel mittelwert mittelwerte durchschnitt summe sum "
    "total std stddev stdev sd sigma stdabw standardabweichung streuung varianz variance range moyenne écart-type ø".split()))  # fmt: skip
"""Words of rows that are computed from other rows."""
VALID = {key(word): good for words, good in (("valid isvalid validity gültig gueltig ok use used include verwenden valide", True),
         ("invalid ungültig outlier ausreißer exclude excluded reject rejected bad", False)) for word in words.split()}  # fmt: skip
"""Titles of columns that say whether a row is valid, or that it is not."""
YES = frozenset("1 10 true wahr vrai yes y ja j oui x ok gültig valid".split())
SAMPLE = 500  # Rows that suffice to settle the decimal sign if all their numbers agree
MEANT = "not read; if"  # Start of the remark that says how an unknown column is read
TIMED = re.compile(r"zeit|time|temps|stamp|clock|(?:^|[\[({/,]|\bin )\s*(?:s|ms|us|µs|sec|sek)\s*[\])}]*$")  # Titles of times
ASCENDING = 0.9  # Share of the values of an unknown column that are not below the one above, if it is the time
HEADERS = 4  # Rows below the titles in which units and descriptions are searched


class Fault(NamedTuple):
    text: str
    line: int | None = None
    column: str | None = None

    def __str__(self) -> str:
        place = [f"{what} {name}" for what, name in (("line", self.line), ("column", self.column)) if name is not None]
        return f"{', '.join(place)}: {self.text}" if place else self.text


class TableError(PushbeltError, ValueError):
    """The table cannot be used. The message has every fault with line, column and value."""

    def __init__(self, faults: Sequence[Fault] | str, path: Path | None = None, found: Any = None) -> None:
        self.faults = (Fault(faults),) if isinstance(faults, str) else tuple(faults)
        self.found = found  # The sheet as it was understood in spite of the faults
        start = f"{path}: " if path is not None else ""
        more = len(self.faults) - SHOWN
        lines = [f"  {fault}" for fault in self.faults[:SHOWN]] + [f"  and {more} more of the same kinds"] * (more > 0)
        text = str(self.faults[0]) if len(self.faults) == 1 else "\n".join([f"{len(self.faults)} faults", *lines])
        super().__init__(start + text)


def grouped(faults: Sequence[Fault]) -> list[str]:
    """Texts of faults; equal ones of several lines are one."""
    lines: dict[Fault, list[int | None]] = {}
    for fault in faults:
        lines.setdefault(fault._replace(line=None), []).append(fault.line)
    return [
        str(same._replace(line=own[0])) if len(own) == 1
        else f"{len(own)} lines, {', '.join(map(str, own[:SHOWN]))}{' …' * (len(own) > SHOWN)}: {same}"
        for same, own in lines.items()
    ]  # fmt: skip


@dataclass(frozen=True)
class Reading:
    decimal: str | None = None  # `point` or `comma`; None: determined from the file
    renamed: Mapping[str, str] = field(default_factory=dict)  # Known name, possibly with a unit, by the title of the file
    sheet: str | None = None  # Sheet of a spreadsheet
    encoding: str | None = None  # Of a text; None: UTF-8, what its first bytes say, or CP1252
    as_written: bool = False  # Whether values that are not plausible are taken as they are written
    accuracy: Mapping[str, str] = field(default_factory=dict)
    """Standard deviation of a column, by title or known name: a number in its unit, or a share of its values such as `0.5%`."""


@dataclass(frozen=True)
class Taken:
    title: str  # Title in the file
    name: str  # Known name, with `.sd` for standard deviations
    unit: str  # Unit as written; empty without one
    place: int
    scale: Unit
    column: Column
    turned: str = ""  # `1/` if the file has the inverse, `-` if it has the opposite sign

    @property
    def deviation(self) -> bool:
        """Whether these are standard deviations, which an offset or the opposite sign does not change."""
        return self.name.endswith(DEVIATION)

    def si(self, written: Array) -> Array:
        """SI values of numbers of the file; NaN for the inverse of 0."""
        if self.deviation:
            return self.scale.factor * written
        found = self.scale.si(written)
        return 1.0 / np.where(found == 0.0, np.nan, found) if self.turned == "1/" else -found if self.turned else found

    def written(self, si: Array) -> Array:
        """Numbers of the file of SI values."""
        if self.deviation:
            return si / self.scale.factor
        with np.errstate(divide="ignore"):
            return ((1.0 / si if self.turned == "1/" else -si if self.turned else si) - self.scale.offset) / self.scale.factor

    @property
    def limits(self) -> tuple[float, float]:
        """Least and largest value, SI."""
        low, high = self.column.low, self.column.high
        return (0.0, high - low) if self.deviation else (low, high)

    @property
    def in_per_cent(self) -> Taken:
        """The column if its numbers are in per cent."""
        return replace(self, unit="%", scale=Unit(0.01))


@dataclass
class Sheet:
    path: Path
    source: str
    decimal: str = "unknown"
    taken: dict[str, Taken] = field(default_factory=dict)  # Columns by known name
    ignored: list[str] = field(default_factory=list)  # Titles of unknown columns
    remarks: list[str] = field(default_factory=list)  # What was assumed or computed from other columns, and warnings
    values: dict[str, Array] = field(default_factory=dict)  # SI values by name; NaN where a cell is empty
    texts: dict[str, Array] = field(default_factory=dict)  # Columns of texts by name
    others: dict[str, Array] = field(default_factory=dict)  # Unknown columns by title: cells, or numbers if most are
    lines: Array = field(default_factory=lambda: np.empty(0, dtype=int))  # Line of each row
    left_out: list[Fault] = field(default_factory=list)  # Rows that are not used, and why
    faults: list[Fault] = field(default_factory=list)
    failed: set[str] = field(default_factory=set)  # Known names of columns that have faults and are not in `taken`
    errors: dict[str, Array] = field(default_factory=dict)  # Standard errors of averaged values by name

    def __len__(self) -> int:
        return len(self.lines)

    def title(self, name: str) -> str:
        """The title in the file of a known name, or the name itself."""
        return self.taken[name].title if name in self.taken else name

    def check(self) -> None:
        """Raises TableError if there are faults. It has the rows that are left out as well."""
        if self.faults:
            raise TableError([*self.faults, *self.left_out], self.path, self)


def read(path: Path, columns: Mapping[str, Column], reading: Reading | None = None, misspelled: bool = True) -> Sheet:
    """Columns of a file. Faults are collected in the result; with `misspelled` a title close to a known name is one. Raises
    TableError if the file is not a table at all, OSError if it cannot be read."""
    from . import files  # It needs pandas, which the help of a program does not.

    reading = reading or Reading()
    names = Names(columns, reading.renamed)
    try:
        return _Reader(path, files.read(path, names, reading.sheet, reading.encoding), names, reading, misspelled).read()
    except ValueError as error:  # An ArgumentError, or pandas' ParserError.
        raise TableError(str(error), path) from error


def header(cells: Cells, names: Names) -> tuple[list[str], list[str], int, int, list[str]]:
    """Titles, units, row of the titles, first row of values, and remarks. Raises ArgumentError if the titles are below each other."""
    head = cells.head()
    at = max(range(len(head)), key=lambda row: (names.count(head[row]), -row))
    titles = head[at]
    if any(names.count([row[k] for row in head]) > max(names.count(titles), 2.0) for k in range(min(2, len(titles)))):
        raise ArgumentError("the table is transposed: its titles are below each other. Exchange rows and columns")
    for row in range(len(head) - 1):
        # Titles over two rows: primary, secondary above speed, torque.
        above = [next((cell for cell in head[row][k::-1] if cell), "") for k in range(len(head[row]))]
        # A title over both rows has nothing below.
        joined = [f"{one} {other}".strip() if other else own for one, other, own in zip(above, head[row + 1], head[row], strict=True)]
        if names.count(joined) > max(names.count(titles), 1.0):
            at, titles = row + 1, joined
    below = [row for row in range(at + 1, at + 1 + HEADERS) if row < len(head)]
    found = next((row for row in [*below, at - 1] if row >= 0 and _is_row_of_units(head[row])), None)
    first = max(at, -1 if found is None else found) + 1
    remarks = [*cells.remarks, *[f"{at} rows above the header are not read"] * (at > 0)]
    return titles, [""] * len(titles) if found is None else head[found], at, first, remarks


def _is_row_of_units(row: Sequence[str]) -> bool:
    """No numbers apart from the unit 1, and at least half of the cells are known units, or in brackets like one."""
    filled = [cell for cell in row if cell]
    known = [cell for cell in filled if units.dimensions(cell) or re.fullmatch(r"\[[^\]]*\]|\([^)]*\)", cell)]
    numbers = [cell for cell in filled if cell != "1" and any(numerals.number(cell, name) is not None for name in numerals.SIGNS)]
    return bool(set(known) - {"1", "-"}) and 2 * len(known) >= len(filled) and not numbers


class _Reader:
    def __init__(self, path: Path, cells: Cells, names: Names, reading: Reading, misspelled: bool) -> None:
        self.cells, self.names, self.reading, self.misspelled = cells, names, reading, misspelled
        self.titles, self.units, row, first, remarks = header(cells, names)
        self.line, self.body = int(cells.frame.index[row]), cells.frame.iloc[first:]
        self.sheet = Sheet(path, cells.source, remarks=remarks, lines=self.body.index.to_numpy(dtype=int))

    def read(self) -> Sheet:
        """The sheet, without the rows that are left out."""
        sheet = self.sheet
        self._take()
        self._extra_cells()
        decimal = self._decimal()
        sheet.decimal = decimal or "unknown"
        if decimal is not None and "time" in self.names.columns and "time" not in sheet.taken:
            self._ascending(decimal)
        self._flagged()
        # Standard deviations have the unit of their column.
        for name, one in sorted(sheet.taken.items(), key=lambda item: item[1].deviation):
            column = self.body[one.place]
            if one.deviation and not one.unit and (base := sheet.taken.get(name.removesuffix(DEVIATION))):
                sheet.taken[name] = replace(one, unit=base.unit, scale=base.scale)
            if one.column.dimension == "text":
                sheet.texts[name] = column.astype(str).to_numpy(dtype=object)
            elif decimal is not None:
                sheet.values[name] = self._values(name, column, decimal)
        for place, title in enumerate(self.titles):
            if title in sheet.ignored and key(title) not in INDEX:
                numbers = numerals.numbers(self.body[place], decimal or "point")
                sheet.others[title] = numbers if np.isfinite(numbers).mean() > MOST else self.body[place].to_numpy(dtype=object)
        keep = ~np.isin(sheet.lines, [fault.line for fault in sheet.left_out if fault.line is not None])
        for some in (sheet.values, sheet.texts, sheet.others):
            some.update({name: column[keep] for name, column in some.items()})
        sheet.lines = sheet.lines[keep]
        return sheet

    def _ascending(self, decimal: str) -> None:
        """Takes the first unknown column in s or ms, or with a word for time, as the time if it ascends."""
        for place, title in enumerate(self.titles):
            below = self.units[place]
            found = (*(unit for _, unit in splits(title) if unit), title.strip("[](){} "), below)
            unit = next((unit for unit in found if units.find(unit, "time")), "")
            told = TIMED.search(title.lower()) or below.strip(" []()").lower() in ("s", "ms", "us", "µs")
            if title in self.sheet.ignored and told:
                one = Taken(title, "time", unit, place, units.find(unit or "s", "time") or Unit(1.0), self.names.columns["time"])
                times = numerals.seconds(self.body[place], one.scale, decimal)
                steps = np.diff(times[np.isfinite(times)])
                if steps.size and (steps >= 0.0).mean() >= ASCENDING and (steps > 0.0).any():
                    self.sheet.taken["time"] = one
                    self.sheet.ignored.remove(title)
                    return self.sheet.remarks.append(f"{title} ascends and is taken as the time")

    def _flagged(self) -> None:
        """Leaves out rows that are means or extremes of others by a word, and rows that a column says are not valid."""
        for place, title in enumerate(self.titles):
            label = any(one.place == place and one.name == "name" for one in self.sheet.taken.values())
            if title not in self.sheet.ignored and key(title) not in INDEX and not label:
                continue
            words, valid = self.body[place].map(lambda cell: key(str(cell))), VALID.get(key(title))
            named = words.isin(STATISTICS)
            # A point may be called max; below the others it is none.
            bad = named[::-1].cummin()[::-1] if label else named & (named.mean() < MOST)
            if valid is not None:
                bad = ~words.isin(("", *YES)) if valid else words.isin(YES)
                self.sheet.ignored = [other for other in self.sheet.ignored if other != title]
            for line, word in self.body[place][bad.to_numpy(dtype=bool)].items():
                text = f"'{word}': the row is not valid" if valid is not None else f"'{word}': no measured row"
                self.sheet.left_out.append(Fault(text, int(line), title or None))

    def _take(self) -> None:
        """Chooses a column for each known name: what the user wants, else a title with a pulley, else a clock before a date."""
        renamed = self._renamed()
        found = [one for place, title in enumerate(self.titles) if (one := self._taken(place, title, renamed.get(place)))]

        def rank(one: Taken) -> tuple[bool, bool, int]:
            clocks = [key(word) for word in (one.name, *one.column.aliases) if one.column.dimension == "time"]
            ranks = [clocks.index(k) for word, _ in splits(one.title) if (k := key(word)) in clocks]
            free = one.place not in renamed
            return free, free and self.names.bare(one.title), min(ranks, default=0)

        for name in dict.fromkeys(one.name for one in found):
            own = [one for one in found if one.name == name]
            best = [one for one in own if rank(one) == min(map(rank, own))]
            first = self.sheet.taken[name] = best[0]
            self.sheet.ignored += [one.title for one in own if one not in best]
            if self.names.bare(first.title) and first.place not in renamed:
                self.sheet.remarks.append(f"{first.title} is taken as {name}")
            if len(best) > 1:
                self._fault(f"it appears {len(best)} times: {' and '.join(one.title for one in best)}", name)
        self.sheet.remarks += self._meant()

    def _meant(self) -> Iterator[str]:
        """The options that take unknown columns whose titles contain a name, if that has no column."""
        for place, title in enumerate(self.titles):
            name = self.names.contained(title) if title in self.sheet.ignored else None
            if name is not None and name not in self.sheet.taken.keys() | self.sheet.failed:
                dimension, unit = self._column(name).dimension, self._unit(place, title, (name, None), True)
                usual = "" if dimension in ("ratio", "text") else " or ".join(units.usual(dimension))
                shown = f" [{unit if units.find(unit, dimension) else usual}]" if usual or unit else ""
                yield f'{MEANT} {title} is {name}: --map "{title}={name}{shown}"'

    def _fault(self, text: str, column: str) -> None:
        self.sheet.faults.append(Fault(text, self.line, column))

    def _renamed(self) -> dict[int, str]:
        """Known name, possibly with a unit, by place, as the user asks for."""
        found: dict[int, str] = {}
        for title, wanted in self.reading.renamed.items():
            places = [k for k, there in enumerate(self.titles) if there.strip() == title.strip()]
            places = places or [k for k, there in enumerate(self.titles) if there and same(there, title)]
            if not self.names.split(turned(wanted)[1]):
                self.sheet.faults.append(Fault(f"--map {title}={wanted}: {wanted} is not a known name"))
            elif not places:
                self.sheet.faults.append(Fault(f"--map {title}={wanted}: there is no column {title} in the file"))
            else:
                found[places[0]] = wanted
        return found

    def _taken(self, place: int, title: str, wanted: str | None) -> Taken | None:
        """What a column is, by its title or as the user wants it; None if it is not used."""
        said = self.names.inverse(title) if wanted is None else None
        if said:
            self.sheet.remarks.append(f"{title} is taken as {said}")
        sign, name = turned(said or wanted or "")
        candidates = self.names.split(name or title)
        if not candidates or (title.startswith("#") and not name):
            return self._unknown(title)
        written = self._unit(place, title, candidates[0], bool(name))
        for name, _ in candidates:
            column = self._column(name)
            if column.dimension == "text":
                return Taken(title, name, "", place, Unit(1.0), column)
            # A standard deviation without a unit has that of its column.
            of_column = not written and name.endswith(DEVIATION)
            scale = Unit(1.0) if of_column else units.find(written or column.default, column.dimension)
            if scale is not None:
                return Taken(title, name, written, place, scale, column, sign)
        name = candidates[0][0]
        full = key(name) == key(next(iter(splits(title)))[0])
        if written and units.dimensions(written) and wanted is None and not said and not full:
            # A short name may mean something else: T_P in °C is a temperature.
            self.sheet.remarks.append(f"column {title}: {written} is not a unit of {name}")
            self.sheet.ignored.append(title)
            return None
        self.sheet.failed.add(name)
        usual = units.usual(self._column(name).dimension)
        no_unit = f"no unit; write {' or '.join(f'{name} [{unit}]' for unit in usual)}"
        return self._fault(f"the unit of {name} is {' or '.join(usual)}, not {written}" if written else no_unit, title)

    def _column(self, name: str) -> Column:
        return self.names.columns[name.removesuffix(DEVIATION)]

    def _unit(self, place: int, title: str, candidate: tuple[str, str | None], wanted: bool) -> str:
        """The unit of a column as it is written; empty without one. That in the title counts before that in the row of units."""
        name, written = candidate
        dimension = self._column(name).dimension
        if written is None and wanted:
            # `n_P (Mean)` and `n_P:1` have no unit of speed in the title.
            own = [unit for word, unit in splits(title) if unit and key(word) and units.dimensions(unit)]
            other = own[0] if own and title.rstrip()[-1] in "])}" and not self.units[place].strip() else None
            written = next((unit for unit in own if units.find(unit, dimension)), other)
        found = written if written and written.strip() else self.units[place].strip()
        # `i (n_P/n_S)` has no unit.
        other_name = dimension == "ratio" and not units.dimensions(found) and (self.names.find(found) or self.names.inverse(found))
        return "" if other_name else found

    def _unknown(self, title: str) -> None:
        if not title or title.startswith("#"):
            return
        if self.misspelled and key(title) not in INDEX and (near := self.names.close(title)):
            self.sheet.failed.add(near)
            self._fault(f'there is no such column; {near} is meant? --map "{title}"={near} says so', title)
        else:
            self.sheet.ignored.append(title)

    def _extra_cells(self) -> None:
        """Cells beyond the last title."""
        titles = 1 + max((k for k, title in enumerate(self.titles) if title), default=-1)
        filled = (self.body.iloc[:, titles:] != "").to_numpy()
        for row in np.flatnonzero(filled.any(axis=1)):
            count = titles + 1 + np.flatnonzero(filled[row])[-1]
            self.sheet.faults.append(Fault(f"{count} cells, but the header has {titles}", int(self.body.index[row])))

    def _decimal(self) -> str | None:
        """The decimal sign of the file, from its first rows if they settle it."""
        if self.reading.decimal is not None:
            return self.reading.decimal
        places = [one.place for one in self.sheet.taken.values() if one.column.dimension not in ("text", "time")]
        first, every = (
            (cell for place in places for cell in rows[place].unique() if isinstance(cell, str)) for rows in (self.body.iloc[:SAMPLE], self.body)
        )
        try:
            return numerals.settle(first, certainly=True) or numerals.settle(every, self.cells.separator)
        except ArgumentError as error:
            self.sheet.faults.append(Fault(str(error)))
            return None

    def _values(self, name: str, column: pd.Series, decimal: str) -> Array:
        """SI values of a column, NaN without one; and its faults, and rows to leave out. A cell that is empty is no fault."""
        sheet, one = self.sheet, self.sheet.taken[name]
        if one.column.dimension == "time" and not one.deviation:
            return numerals.seconds(column, one.scale, decimal)
        numbers = numerals.numbers(column, decimal)
        shares = column.map(lambda cell: str(cell).endswith("%")).to_numpy(dtype=bool)
        values = np.where(shares, one.in_per_cent.si(numbers) if one.column.dimension == "ratio" else np.nan, one.si(numbers))
        low, high = one.limits
        words = column.map(lambda cell: isinstance(cell, str) and numerals.missing(cell)).to_numpy(dtype=bool)
        absent, empty = words | np.isin(numbers, numerals.SENTINELS), column.isin(["", *"-–—"]).to_numpy(dtype=bool)
        inside = (values > low if one.deviation else values >= low) & (values <= high) & ~absent
        if absent.any() and (absent | empty).all():
            sheet.remarks.append(f"column {one.title} has no value")
            return np.where(inside, values, np.nan)
        wrong = np.flatnonzero(~(inside | absent | empty))
        faults = [Fault(self._why(one, column.iloc[row], numbers[row], values[row]), int(column.index[row]), one.title) for row in wrong]
        if faults and len(faults) >= MOST * (len(faults) + inside.sum()):
            more = f" (and {len(faults) - 1} more rows)" * (len(faults) > 1) + self._other_unit(one, numbers[wrong][np.isfinite(numbers[wrong])])
            sheet.faults.append(faults[0]._replace(text=faults[0].text + more))
            faults = []
        faults += [Fault(f"'{cell}' is no value", int(line), one.title) for line, cell in column[absent].items()]
        sheet.left_out += sorted(faults, key=lambda fault: fault.line or 0)
        return np.where(inside, values, np.nan)

    @staticmethod
    def _why(one: Taken, cell: str | float, number: float, value: float) -> str:
        """Why a cell has no value of its column."""
        if np.isnan(number) or (np.isnan(value) and not one.turned):
            return f"'{cell}' is not a number"
        low, high = sorted((one.in_per_cent if str(cell).endswith("%") else one).written(np.array(one.limits)))
        unit = one.unit or one.column.default
        shown = "" if unit in ("", "1", "-") else f" {unit}"
        return f"{cell} is not within {'above ' if one.deviation else ''}{low:.6g} to {high:.6g}{shown}"

    @staticmethod
    def _other_unit(one: Taken, numbers: Array) -> str:
        """The first unit in which numbers would be in the range of the column, with the option that says so."""
        for unit in units.confused(one.column.dimension) if numbers.size and not one.turned else ():
            scale = units.find(unit, one.column.dimension)
            if scale not in (None, one.scale) and (np.clip(scale.si(numbers), one.column.low, one.column.high) == scale.si(numbers)).all():
                return f'; plausible is {unit} (--map "{one.title}={one.name} [{unit}]")'
        return ""
