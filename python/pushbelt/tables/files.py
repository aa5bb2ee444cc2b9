"""Cells of a table file: CSV in any usual encoding and with any usual separator, a sheet of an .xlsx file, Parquet or MF4; gzip in any case."""

import codecs
import csv
import gzip
import io
import re
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ..errors import ArgumentError
from .names import Names
from .numerals import MISSING, Percent

SEPARATORS = {";": "semicolon", "\t": "tab", "|": "bar", ",": "comma", "  ": "blanks"}
"""Signs between columns, in the order of preference."""
LARGEST = 1_000_000_000  # Largest file, bytes
LEAST_NAMES = 3  # Number of known columns from which a remark is a header, and a sheet a table beside another one with the same
WANTED = "export it as CSV, .xlsx, Parquet or MDF"
HEAD = 60  # Rows in which the header is searched


class Cells(NamedTuple):
    """Cells of a file, row by row."""

    frame: pd.DataFrame
    """Text, or numbers and `Percent` of a spreadsheet. An empty cell is an empty text. The columns are counted from 0, and the index has the
    line of each row in the file, from 1."""
    source: str  # Encoding and separator, or the name of the sheet, for people
    separator: str = ""  # Sign between columns; empty in a spreadsheet
    remarks: tuple[str, ...] = ()  # What is not read

    def head(self) -> list[list[str]]:
        """The first rows as text without blanks around the cells."""
        return [[str(cell).strip() for cell in row] for row in self.frame.iloc[:HEAD].itertuples(index=False)]


def read(path: Path, names: Names, sheet: str | None = None, encoding: str | None = None) -> Cells:
    """Cells of a file, by the separator or in the sheet with most known names. Raises ArgumentError for no table, OSError if unreadable."""
    size = path.stat().st_size
    if size > LARGEST:
        raise ArgumentError(f"the file has {size / 1e6:.0f} MB, above the limit of {LARGEST / 1e6:.0f} MB")
    data = path.read_bytes()
    if data.startswith(b"\x1f\x8b"):
        try:
            data = gzip.GzipFile(fileobj=io.BytesIO(data)).read(LARGEST + 1)
        except (OSError, EOFError, zlib.error) as error:
            raise ArgumentError(f"the file is not a whole gzip file: {error}") from error
        if len(data) > LARGEST:
            raise ArgumentError(f"the file has more than {LARGEST / 1e6:.0f} MB when it is unpacked")
    if data.startswith((b"MDF ", b"UnFinMF ")):
        return _mf4(data, names)
    if data.startswith(b"PAR1"):
        return _parquet(data)
    if re.match(rb'(?:\xef\xbb\xbf)?\s*(?:[{\[]\s*["{\[\]}]|<(?:[?!]|html))', data[:200], re.IGNORECASE):
        raise ArgumentError(f"this is {'XML or HTML' if b'<' in data[:10] else 'JSON'}, not a table: {WANTED}")
    if data.startswith(b"PK\x03\x04"):
        return _spreadsheet(data, names, sheet)
    return _text(data, names, encoding)


def _decoded(data: bytes, encoding: str | None = None) -> tuple[str, str]:
    if encoding is None and data[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        encoding = "utf-16"
    if encoding is None and 0 in data[:4000]:
        raise ArgumentError(f"the file is not a table: it has bytes that no text has; {WANTED}")
    for candidate in [encoding] if encoding else ["utf-8-sig", "cp1252", "latin-1"]:
        try:
            return data.decode(candidate), candidate.removesuffix("-sig")
        except (UnicodeDecodeError, LookupError) as error:
            reason = error
    raise ArgumentError(f"the file is not text in {encoding}: {reason}")


def _text(data: bytes, names: Names, known: str | None) -> Cells:
    text, encoding = _decoded(data, known)
    guessed = encoding in ("cp1252", "latin-1") and known is None
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    # A spreadsheet may declare the separator.
    lines[0] = re.sub(r'^\s*"?sep=."?[\s;,\t]*$', "", lines[0], flags=re.IGNORECASE)
    lines = _with_header(lines, names)
    shown = [line for line in lines if line.strip(' ,;|\t"')]
    if not shown:
        raise ArgumentError("the table is empty")
    # That by which the lines have most known names; among equals, that in most lines.
    rows = {sign: [_split(line, sign) for line in shown[:HEAD]] for sign in SEPARATORS}
    separator = max(rows, key=lambda one: (max(map(names.count, rows[one])), sum(len(row) > 1 for row in rows[one])))
    name = f"{encoding.upper()}, {SEPARATORS[separator]} between columns"
    if separator == "  ":
        lines, separator = ["\x1f".join(_split(line, "  ")) if line.strip() else "" for line in lines], "\x1f"
    # The C parser of pandas takes the number of columns from here.
    width = max(line.count(separator) for line in lines) + 1
    frame = pd.read_csv(
        io.StringIO("\n".join(lines)), sep=separator, header=None, names=range(width), index_col=False, dtype=str, keep_default_na=False,
        skip_blank_lines=False, skipinitialspace=separator != "\t", on_bad_lines="error",
    ).fillna("")  # fmt: skip
    # A quoted cell may contain line breaks.
    breaks = frame.apply(lambda column: column.str.count("\n")).sum(axis=1).to_numpy(dtype=int)
    frame.index = 1 + np.arange(len(frame)) + np.cumsum(breaks) - breaks
    frame = frame.apply(lambda column: column.str.replace(r"\s*\n\s*", " ", regex=True).str.strip())
    remarks = (f"the text is no UTF-8 and is read as {encoding.upper()}; --encoding names another, such as shift_jis or gbk",)
    return Cells(frame[(frame != "").any(axis=1)], name, separator, remarks * guessed)


def _split(line: str, separator: str) -> list[str]:
    if separator == "  ":
        return re.split(r"\s{2,}", line.strip())
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]


def is_remark(line: str) -> bool:
    """Whether a line is a remark: it starts with `#`, and this is not an error value of a spreadsheet."""
    start = line.lstrip().lstrip('"').lower()
    return start.startswith("#") and not any(word.startswith("#") and start.startswith(word) for word in MISSING)


def _with_header(lines: Sequence[str], names: Names) -> list[str]:
    """The lines with remarks emptied. Above a row without names, the remark with most known names is the header."""

    def most(line: str) -> float:
        return max(names.count(_split(line, separator)) for separator in SEPARATORS)

    remarks = {place: re.sub(r'^\s*("?)#[# ]*', r"\1", line) for place, line in enumerate(lines) if is_remark(line)}
    found = ["" if place in remarks else line for place, line in enumerate(lines)]
    if remarks and most(next(filter(str.strip, found), "")) < 2:
        best = max(remarks, key=lambda place: most(remarks[place]))
        found[best] = remarks[best] if most(remarks[best]) >= LEAST_NAMES else ""
    return found


@contextmanager
def _reader(kind: str, package: str, extra: str) -> Iterator[None]:
    """Errors of a package that reads files, such as `an .xlsx` file, as an ArgumentError: they have no common base class."""
    try:
        yield
    except ImportError as error:
        raise ArgumentError(f"{kind} file requires the package {package}: pip install 'pushbelt[{extra}]'") from error
    except Exception as error:
        raise ArgumentError(f"the file is not a readable {kind.split()[1]} file: {error}") from error


def _spreadsheet(data: bytes, names: Names, wanted: str | None) -> Cells:
    with _reader("an .xlsx", "openpyxl", "excel"):
        import openpyxl

        book = openpyxl.load_workbook(io.BytesIO(data), data_only=True)
    if wanted is not None and wanted not in book.sheetnames:
        raise ArgumentError(f"there is no sheet {wanted}; there are {', '.join(book.sheetnames)}")
    sheets = [sheet for sheet in book.worksheets if wanted in (None, sheet.title)]
    hidden = [sheet.title for sheet in sheets if sheet.sheet_state != "visible" and wanted is None]
    found = {sheet.title: cells for sheet in sheets if len((cells := _sheet(sheet)).frame)}
    shown = [name for name in found if name not in hidden]
    if not shown:
        raise ArgumentError(f"all tables are in hidden sheets: --sheet reads one of {', '.join(hidden)}" if found else "the table is empty")
    counts = {name: max(map(names.count, found[name].head())) for name in shown}
    best = max(counts, key=lambda name: counts[name])
    same = [name for name, count in counts.items() if count == counts[best] >= LEAST_NAMES]
    if len(same) > 1:
        raise ArgumentError(f"the sheets {', '.join(same)} have the same columns: --sheet says which one is read")
    others = [f"sheet {name} is {'hidden and ' * (name in hidden)}not read" for name in found if name != best]
    return found[best]._replace(remarks=(*others, *found[best].remarks))


def _sheet(sheet: Any) -> Cells:
    """The cells of a sheet. Empty rows and remarks are left out, and rows of numbers that are hidden or struck out, which are named."""
    frame = pd.DataFrame([[*map(_cell, row)] for row in sheet.iter_rows()], dtype=object)
    texts = [[str(cell) for cell in row if str(cell) != ""] for row in frame.itertuples(index=False)]
    keep, unseen = [], {"hidden": [], "struck out": []}  # type: ignore[var-annotated]
    for line, (row, cells) in enumerate(zip(texts, sheet.iter_rows(), strict=True)):
        numbers = [cell for cell in cells if isinstance(cell.value, (int, float))]
        if numbers and sheet.row_dimensions[line + 1].hidden:
            unseen["hidden"].append(line + 1)
        elif any(cell.font is not None and cell.font.strike for cell in numbers):
            unseen["struck out"].append(line + 1)
        elif row and (len(row) > 3 or not is_remark(row[0])):
            keep.append(line)
    remarks = [f"{len(rows)} rows are {why} and not read: {', '.join(map(str, rows[:HEAD]))}" for why, rows in unseen.items() if rows]
    return Cells(frame.set_axis(frame.index + 1).iloc[keep], f"sheet {sheet.title}", remarks=tuple(remarks))


def _cell(cell: Any) -> str | float:
    """A number, or any other value as text."""
    value = "" if cell.value is None else cell.value
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return " ".join(str(value).split())
    return Percent(100.0 * value) if "%" in str(cell.number_format) else value


def _parquet(data: bytes) -> Cells:
    with _reader("a .parquet", "pyarrow", "parquet"):
        frame = pd.read_parquet(io.BytesIO(data), engine="pyarrow")
    if not isinstance(frame.index, pd.RangeIndex):
        frame = frame.reset_index(names=[frame.index.name or "time"] if frame.index.nlevels == 1 else None)
    for name in frame.select_dtypes("timedelta"):
        frame[name] = frame[name].dt.total_seconds()
    return _cells([list(map(str, frame.columns))], frame, "Parquet")


def _mf4(data: bytes, names: Names) -> Cells:
    """The channels with a known name, each at its own times."""
    columns, titles, unit_row = [], ["time"], ["s"]
    with _reader("an MDF", "asammdf", "mf4"):
        from asammdf import MDF

        with MDF(io.BytesIO(data)) as file:
            listed = {(group, k): one.name.split("\\")[0] for group, own in enumerate(file.groups) for k, one in enumerate(own.channels)}  # type: ignore[attr-defined]
            for (group, index), name in listed.items():
                double = list(listed.values()).count(name) > 1
                title = f"{name} group {group} channel {index}" if double else name
                if file.masters_db.get(group) == index or not names.count([title]):
                    continue
                signal = file.get(group=group, index=index)
                if np.issubdtype(signal.samples.dtype, np.number) and signal.samples.ndim == 1:
                    own = pd.Series(signal.samples.astype(float), index=signal.timestamps)
                    columns.append(own[~own.index.duplicated()])
                    titles.append(title)
                    unit_row.append(signal.unit or "")
    if not columns:
        raise ArgumentError("no channel has a known name; --map says what a channel is")
    return _cells([titles, unit_row], pd.concat(columns, axis=1).sort_index().reset_index(), "MDF")


def _cells(head: list[list[str]], body: pd.DataFrame, source: str) -> Cells:
    """Cells below rows of titles; the lines count the rows of values."""
    body = body.astype(object).where(body.notna(), "")
    body = body.map(lambda cell: cell if isinstance(cell, (int, float, np.number)) and not isinstance(cell, bool) else str(cell).strip())
    frame = pd.concat([pd.DataFrame(head, dtype=object), body.set_axis(range(body.shape[1]), axis=1)], ignore_index=True)
    return Cells(frame.set_axis(frame.index - len(head) + 1), source)
