"""Columns of a table in SI units, by known names. All faults of a file are in one error, with line and column.

A column has a title of name and unit; the unit may also be in the row below. Names are compared without case, blanks and points.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import numerals, text, units
from .faults import Fault, TableError
from .numerals import NumeralError, Percent
from .text import Cells
from .times import seconds
from .titles import DEVIATION, Column, Names, key, same, splits, turned
from .units import Unit

if TYPE_CHECKING:
    import pandas as pd

INDEX = frozenset({"", "#", "nr", "no", "index", "idx", "id", "row", "zeile", "unnamed0", "lfdnr", "point"})
"""Titles of columns that count the rows."""
SAMPLE = 500
"""Rows that suffice to settle the decimal sign if all their numbers agree."""
SEVERAL = 3
"""Least number of values without a unit that are read as per cent."""
HEADERS = 4
"""Rows below the titles in which units and descriptions are searched."""
MOST = 0.5
"""Share of a column's values with a fault above which the whole column has it; below, their rows are left out."""


@dataclass(frozen=True)
class Reading:
    """Choices of the user."""

    decimal: str | None = None
    """`point` or `comma`; None: determined from the file."""
    renamed: Mapping[str, str] = field(default_factory=dict)
    """Known name, possibly with a unit, by the title of the file, or the other way round."""
    sheet: str | None = None
    """Sheet of a spreadsheet."""
    as_written: bool = False
    """Whether values that are not plausible are taken as they are written."""


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
    errors: dict[str, np.ndarray[Any, Any]] = field(default_factory=dict)
    """Standard errors of averaged values by name."""

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
        """Raises TableError if there are faults. It has the rows that are left out as well."""
        if self.faults:
            raise TableError([*self.faults, *self.left_out], self.path, self)


def read(path: Path, columns: Mapping[str, Column], reading: Reading | None = None, misspelled: bool = True) -> Sheet:
    """Columns of a file. Faults are collected in the result; with `misspelled` a title close to a known name is one.

    Raises TableError if the file is not a table at all, OSError if it cannot be read.
    """
    reading = reading or Reading()
    names = Names(columns)
    mapped = {side for pair in reading.renamed.items() for side in pair}

    def known(cells: Sequence[str]) -> float:
        return names.count(cells) + sum(any(same(cell, side) for side in mapped) and not names.count([cell]) for cell in cells if cell)

    try:
        cells = text.read(path, known, reading.sheet)
        return _Reader(path, cells, names, reading, known, misspelled).sheet()
    except TableError:
        raise
    except ValueError as error:  # A TextError, or pandas' ParserError.
        raise TableError([Fault(str(error))], path) from error


def _is_number(cell: str) -> bool:
    return any(numerals.number(cell, name) is not None for name in numerals.SIGNS)


class _Reader:
    def __init__(self, path: Path, cells: Cells, names: Names, reading: Reading, known: Any, misspelled: bool) -> None:
        self.misspelled = misspelled
        self.path, self.cells, self.names, self.reading = path, cells, names, reading
        self.faults: list[Fault] = []
        self.remarks: list[str] = []
        self.ignored: list[str] = []
        self.taken: dict[str, Taken] = {}
        self.failed: set[str] = set()
        self.clocks: list[Taken] = []
        """Columns of times, if each channel has its own."""
        self._find_header(known)

    def _find_header(self, known: Any) -> None:
        """Titles, units and the first row of values."""
        cells = self.cells
        head = [cells.row(row) for row in range(min(text.HEAD, len(cells.frame)))]
        # The first of the rows with most names.
        counts = [known(row) for row in head]
        self.header = max(range(len(head)), key=lambda row: (counts[row], -row))
        first_column = next((column for k in range(min(2, len(head[0]))) if known(column := [row[k] for row in head]) > max(counts[self.header], 2.0)), None)
        if first_column:
            raise TableError("the table is transposed: its titles are below each other. Exchange rows and columns", self.path)
        self.titles = head[self.header]
        for row in range(len(head) - 1):
            # Titles over two rows: primary, secondary above speed, torque.
            above = [next((cell for cell in head[row][k::-1] if cell), "") for k in range(len(head[row]))]
            joined = [f"{one} {other}".strip() if other else "" for one, other in zip(above, head[row + 1], strict=True)]
            if known(joined) > max(known(self.titles), 1.0):
                self.header, self.titles = row + 1, joined
        if self.header:
            self.remarks.append(f"{self.header} rows above the header are not read")
        below = [row for row in range(self.header + 1, self.header + 1 + HEADERS) if row < len(head)]
        found = next((row for row in [*below, self.header - 1] if row >= 0 and self._is_row_of_units(head[row])), None)
        self.units = head[found] if found is not None else [""] * len(self.titles)
        self.first = max(self.header, -1 if found is None else found) + 1
        while self.first < len(head) and self.first in below and self._is_row_of_words(head[self.first]):
            self.first += 1
        for row in range(self.header + 1, self.first):
            if row != found:
                self.remarks.append(f"line {cells.lines[row]} has no values and is not read: {', '.join(filter(None, head[row]))[:80]}")

    @staticmethod
    def _is_row_of_words(row: Sequence[str]) -> bool:
        """Words in all cells, which are neither numbers nor signs for a missing value."""
        filled = [cell for cell in row if cell]
        return bool(filled) and all(any(map(str.isalpha, cell)) and not numerals.missing(cell) and not _is_number(cell) for cell in filled)

    @staticmethod
    def _is_row_of_units(row: Sequence[str]) -> bool:
        """No numbers apart from the unit 1, and at least half of the cells are units."""
        filled = [cell for cell in row if cell]
        if any(cell != "1" and _is_number(cell) for cell in filled):
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
        for name, one in self.taken.items():
            column = body[one.place].tolist()
            if one.column.dimension == "text":
                texts[name] = [str(cell) for cell in column]
            elif decimal is not None:
                one = self.taken[name] = self._per_cent(one, column, decimal)
                values[name], errors = self._numbers(one, column, decimal)
                if len(errors) == len(column) > 0 and all(text.endswith("is no value") for text in errors.values()):
                    self.remarks.append(f"column {one.title} has no value")
                    continue
                left_out += [Fault(text, int(lines[row]), one.title) for row, text in errors.items()]
                bad[list(errors)] = True
        if self.clocks and decimal is not None and not texts:
            values, lines = self._on_one_clock(values, body, lines, decimal)
            bad = np.zeros(len(lines), dtype=bool)
        found = Sheet(
            self.path, self.cells.source, decimal or "unknown", self.taken, self.ignored, self.remarks, values, texts, lines, left_out,
            self.faults, self.failed,
        )  # fmt: skip
        found.keep(~bad)
        return found

    def _on_one_clock(
        self, values: dict[str, np.ndarray], body: Any, lines: np.ndarray, decimal: str
    ) -> tuple[dict[str, np.ndarray], np.ndarray]:
        """Values and lines with a row for each time of any channel; a channel belongs to the times to the left of it."""
        moments, rows, channels = [], [], []
        for clock, end in zip(self.clocks, [*(clock.place for clock in self.clocks[1:]), len(self.titles)], strict=True):
            times, _ = self._numbers(clock, body[clock.place].tolist(), decimal)
            there = np.flatnonzero(np.isfinite(times))
            moments.append(times[there])
            rows.append(there)
            channels.append({name for name in values if clock.place < self.taken[name].place < end})
        order = np.argsort(np.concatenate(moments), kind="stable")
        found = {}
        for name, column in values.items():
            own = [column[there] if name in group else np.full(len(there), np.nan) for there, group in zip(rows, channels, strict=True)]
            found[name] = np.concatenate(moments if name == self.clocks[0].name else own)[order]
        self.remarks.append(f"{len(self.clocks)} columns {self.clocks[0].title}: each has the channels to the right of it")
        return found, lines[np.concatenate(rows)[order]]

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
            # A pulley in the title counts before none.
            explicit = [one for one in explicit if one.place in renamed or not self.names.bare(one.title)] or explicit
            if explicit[0].column.dimension == "time":
                # A date beside a clock is not needed.
                known = [key(spelled) for spelled in (name, *explicit[0].column.aliases)]
                ranks = [min((known.index(k) for w, _ in splits(one.title) if (k := key(w)) in known), default=0) for one in explicit]
                explicit = [one for one, rank in zip(explicit, ranks, strict=True) if rank == min(ranks)]
            self.ignored += [one.title for one in found if one not in explicit]
            if self.names.bare(explicit[0].title) and explicit[0].place not in renamed:
                self.remarks.append(f"{explicit[0].title} is taken as {name}")
            if len(explicit) > 1 and self._have_channels(explicit):
                self.clocks = explicit
            elif len(explicit) > 1:
                titles = " and ".join(one.title for one in explicit)
                self.faults.append(Fault(f"it appears {len(explicit)} times: {titles}", self._line, name))
            self.taken[name] = explicit[0]

    def _have_channels(self, clocks: Sequence[Taken]) -> bool:
        """Whether these are equal titles of times, each with other columns to the right of it."""
        ends = [*(clock.place for clock in clocks[1:]), len(self.titles)]
        apart = all(end - clock.place > 1 for clock, end in zip(clocks, ends, strict=True))
        return apart and clocks[0].column.dimension == "time" and len({key(clock.title) for clock in clocks}) == 1

    @property
    def _line(self) -> int:
        return int(self.cells.lines[self.header])

    def _renamed(self) -> dict[int, str]:
        """Known name, possibly with a unit, by place, as the user asks for."""
        found: dict[int, str] = {}
        for one, other in self.reading.renamed.items():
            for title, wanted in ((one, other), (other, one)):
                places = [k for k, there in enumerate(self.titles) if there.strip() == title.strip()]
                places = places or [k for k, there in enumerate(self.titles) if there and same(there, title)]
                if places and self.names.split(turned(wanted)[1] or ""):
                    found[places[0]] = wanted
                    break
            else:
                known = self.names.split(turned(one)[1] or "") or self.names.split(turned(other)[1] or "")
                text = f"there is no column {one} in the file" if known else f"neither {one} nor {other} is a known name"
                self.faults.append(Fault(f"--map {one}={other}: {text}"))
        return found

    def _taken(self, place: int, title: str, wanted: str | None) -> Taken | None:
        row_unit = self.units[place].strip() if place < len(self.units) else ""
        said = wanted is None and self.names.inverse(title)
        if said:
            wanted = said
            self.remarks.append(f"{title} is taken as {wanted}")
        sign, wanted = turned(wanted)
        candidates = self.names.split(wanted if wanted is not None else title)
        if wanted is None and title.startswith("#"):
            return None
        if not candidates:
            self._unknown(title)
            return None
        own = next((unit for written, unit in splits(title) if unit is not None and key(written)), None)
        if said and own is not None and units.find(own, "ratio") is None:
            own = None
        # A unit in the title counts before one in the row below.
        written = candidates[0][1] if candidates[0][1] is not None else (own if wanted is not None else None)
        spelled = written if written is not None and written.strip() else row_unit
        if self.names.columns[candidates[0][0].removesuffix(DEVIATION)].dimension == "ratio" and (self.names.find(spelled) or self.names.inverse(spelled)):
            # `i (n_P/n_S)` has no unit.
            spelled = ""
        missed: list[tuple[str, Column]] = []
        for name, _ in candidates:
            column = self.names.columns[name.removesuffix(DEVIATION)]
            if column.dimension == "text":
                return Taken(title, name, "", place, Unit(1.0), column)
            scale = units.find(spelled, column.dimension) if spelled else column.without_unit()
            if scale is not None:
                return Taken(title, name, spelled, place, scale, column, sign)
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
        places = [one.place for one in self.taken.values() if one.column.dimension not in ("text", "time")]
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

    def _per_cent(self, one: Taken, column: Sequence[Any], decimal: str) -> Taken:
        """The column in per cent if it has no unit, or 1, and its values are no shares, like an efficiency of 97."""
        if one.scale != Unit(1.0) or one.turned or one.name not in ("slip", "efficiency") or not all(isinstance(c, (str, float, int)) for c in column):
            return one
        found = np.array([numerals.number(str(cell), decimal if isinstance(cell, str) else "point") for cell in column], dtype=float)
        found = np.abs(found[np.isfinite(found)])
        low, high = (0.5, 50.0) if one.name == "slip" else (1.5, 100.0)
        if found.size < SEVERAL or not low < float(np.median(found) if one.name == "efficiency" else found.max()) <= high:
            return one
        self.remarks.append(f"{one.title} has values that are no shares and is read as %")
        return replace(one, unit="%", scale=Unit(0.01))

    def _numbers(self, one: Taken, column: Sequence[Any], decimal: str) -> tuple[np.ndarray[Any, Any], dict[int, str]]:
        """SI values of a column, and why rows have none. A cell that is empty is no error."""
        if one.column.dimension == "time" and not one.name.endswith(DEVIATION):
            return seconds(column, one.scale, decimal), {}
        plain = self._plain(one, column, decimal)
        if plain is not None:
            return plain, {}
        found = np.full(len(column), np.nan)
        errors: dict[int, str] = {}
        outside: dict[int, str] = {}
        raw = np.full(len(column), np.nan)
        for row, cell in enumerate(column):
            if isinstance(cell, str) and (not cell or cell in "-–—"):
                continue
            value, scale = self._value(one, cell, decimal)
            if isinstance(value, str):
                errors[row] = value
                continue
            si = one.si(value, scale) if not one.name.endswith(DEVIATION) else scale.factor * value
            text = self._out_of_range(one, si, cell, scale)
            if text is None:
                found[row] = si
            else:
                outside[row], raw[row] = text, value
        other = next(name for name in numerals.SIGNS if name != decimal)
        texts = [row for row in errors if isinstance(column[row], str)]
        for row in [row for row in texts if numerals.number(column[row], decimal) is None is not numerals.number(column[row], other)]:
            # A decimal sign unlike that of the other numbers is ambiguous.
            text = f"'{column[row]}' is not a number with a decimal {decimal}, which the other numbers of the file have"
            self.faults.append(Fault(text, self._line_of(row), one.title))
            del errors[row]
        words = {row: text for row, text in errors.items() if text.endswith("is not a number")}
        for some, hint in ((outside, self._other_unit(one, raw[np.isfinite(raw)])), (words, "")):
            if some and len(some) >= MOST * (len(some) + np.isfinite(found).sum()):
                row, more = next(iter(some)), f" (and {len(some) - 1} more rows)" if len(some) > 1 else ""
                self.faults.append(Fault(some[row] + more + hint, self._line_of(row), one.title))
                errors = {row: text for row, text in errors.items() if row not in some}
            else:
                errors |= some
        return found, dict(sorted(errors.items()))

    def _line_of(self, row: int) -> int:
        return int(self.cells.lines[self.first + row])

    @staticmethod
    def _value(one: Taken, cell: Any, decimal: str) -> tuple[float | str, Unit]:
        """The number of a cell with its unit, or why it has none."""
        if isinstance(cell, Percent):
            return cell.share, Unit(1.0)
        if not isinstance(cell, str):
            return f"'{cell:g}' is no value" if cell in numerals.SENTINELS else float(cell), one.scale
        if cell.startswith("="):
            return "a formula that was never calculated: open the file in a spreadsheet program and save it", one.scale
        if numerals.missing(cell):
            return f"'{cell}' is no value", one.scale
        value, per_cent = numerals.number(cell, decimal), cell.rstrip().endswith("%")
        if value is None or (per_cent and one.column.dimension != "ratio"):
            return f"'{cell}' is not a number", one.scale
        if value in numerals.SENTINELS:
            return f"'{cell}' is no value", one.scale
        return value, Unit(0.01) if per_cent else one.scale

    @staticmethod
    def _other_unit(one: Taken, values: np.ndarray[Any, Any]) -> str:
        """The first unit in which numbers would be in the range of the column, with the option that says so."""
        for unit in units.CONFUSED.get(one.column.dimension, ()):
            scale = units.find(unit, one.column.dimension)
            if scale is not None and scale != one.scale and not one.turned:
                si = scale.factor * values + scale.offset
                if ((si >= one.column.low) & (si <= one.column.high)).all():
                    return f'; plausible is {unit} (--map "{one.title}={one.name} [{unit}]")'
        return ""

    @staticmethod
    def _plain(one: Taken, column: Sequence[Any], decimal: str) -> np.ndarray[Any, Any] | None:
        """SI values of a column of plain numbers that are all in range, or empty; None for any other column."""
        if one.turned or one.name.endswith(DEVIATION):
            return None
        import pandas as pd

        cells = pd.Series(list(column), dtype=object)
        if decimal == "comma":
            if not cells.map(type).eq(str).all() or cells.str.contains(r"[^-+\d,eE]").any():
                return None
            cells = cells.str.replace(",", ".", regex=False)
        numbers = pd.to_numeric(cells, errors="coerce").to_numpy(dtype=float)
        values = one.scale.factor * numbers + one.scale.offset
        inside = (values >= one.column.low) & (values <= one.column.high)
        return values if ((inside & np.isfinite(values)) | (cells == "").to_numpy()).all() and not np.isin(numbers, numerals.SENTINELS).any() else None

    @staticmethod
    def _out_of_range(one: Taken, value: float, cell: Any, scale: Unit) -> str | None:
        """What is wrong with a value outside the range of the column."""
        deviation = one.name.endswith(DEVIATION)
        low, high = (0.0, one.column.high - one.column.low) if deviation else (one.column.low, one.column.high)
        if low <= value <= high and not (deviation and value == 0.0):
            return None
        offset = 0.0 if deviation else scale.offset
        limits = [(low - offset) / scale.factor, (high - offset) / scale.factor]
        if one.turned and not deviation:
            limits = sorted(-limit if one.turned == "-" else 1.0 / limit if limit else np.inf for limit in limits)
        allowed = f"{limits[0]:.6g} to {limits[1]:.6g}"
        above = "above " if deviation else ""
        written = one.unit or one.column.default
        unit = f" {written}" if written not in (None, "", "1", "-") else ""
        shown = f"{cell.share:g}" if isinstance(cell, Percent) else f"{cell}"
        return f"{shown} is not within {above}{allowed}{unit}"
