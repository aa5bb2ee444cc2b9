"""Cells of a table file: CSV in any usual encoding and with any usual separator, a sheet of an .xlsx file, Parquet or MF4; gzip in any case."""

from __future__ import annotations

import codecs
import csv
import gzip
import io
import re
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import PushbeltError
from .numerals import MISSING, Percent

if TYPE_CHECKING:
    import pandas as pd

Known = Callable[[Sequence[str]], float]
SEPARATORS = {";": "semicolon", "\t": "tab", "|": "bar", ",": "comma", "  ": "blanks"}
"""Signs between columns, in the order of preference."""
LARGEST = 1_000_000_000
"""Largest file, bytes."""
HEAD = 60
"""Rows in which the header is searched."""

BOMS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)


class TextError(PushbeltError, ValueError):
    """The file is not a table. The message contains the reason."""


@dataclass(frozen=True)
class Cells:
    """Cells of a file, row by row."""

    frame: pd.DataFrame
    """Text, or numbers and `Percent` of a spreadsheet. An empty cell is an empty text. The columns are counted from 0."""
    lines: np.ndarray[Any, Any]
    """Line of each row in the file, from 1."""
    separator: str
    """Sign between columns; empty in a spreadsheet."""
    source: str
    """Encoding and separator, or the name of the sheet, for people."""

    def row(self, place: int) -> list[str]:
        """A row as text without blanks around the cells."""
        return [str(cell).strip() for cell in self.frame.iloc[place]]


def decoded(data: bytes) -> tuple[str, str]:
    """Text and encoding of a file."""
    encoding = next((name for mark, name in BOMS if data.startswith(mark)), None)
    if encoding is None and data[:4000].count(0):
        # UTF-16 without a mark: the zeros of Latin text are at odd places if the low byte comes first.
        even, odd = data[0:4000:2].count(0), data[1:4000:2].count(0)
        if max(even, odd) < len(data[:4000]) // 8:
            raise TextError("the file is not a table: it has bytes that no text has")
        encoding = "utf-16-le" if odd > even else "utf-16-be"
    for candidate in [encoding] if encoding else ["utf-8", "cp1252"]:
        try:
            return data.decode(candidate).lstrip("\N{ZERO WIDTH NO-BREAK SPACE}"), candidate.removesuffix("-sig")
        except UnicodeDecodeError as error:
            reason = error
    if encoding is not None:
        raise TextError(f"the file is not text in {encoding}: {reason}")
    return data.decode("latin-1"), "latin-1"


def _lines(text: str) -> list[str]:
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def _split(line: str, separator: str) -> list[str]:
    if separator == "  ":
        return re.split(r"\s{2,}", line.strip())
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]


def is_remark(line: str) -> bool:
    """Whether a line is a remark: it starts with `#`, and this is not an error value of a spreadsheet."""
    start = line.lstrip().lstrip('"').lower()
    if not start.startswith("#"):
        return False
    return not any(word.startswith("#") and start.startswith(word) for word in MISSING)


def read(path: Path, known: Known, sheet: str | None = None) -> Cells:
    """Cells of a file. `known` counts the known names among the cells of a row: the separator or the sheet is the one with most.

    Raises TextError if the file is not a table, OSError if it cannot be read.
    """
    size = path.stat().st_size
    if size > LARGEST:
        raise TextError(f"the file has {size / 1e6:.0f} MB, above the limit of {LARGEST / 1e6:.0f} MB")
    data = path.read_bytes()
    if data.startswith(b"\x1f\x8b"):
        data = _unzipped(data)
    if data.startswith((b"MDF ", b"UnFinMF ")):
        return _mf4(data, known)
    if data.startswith(b"PAR1"):
        return _parquet(data)
    if data.startswith(b"PK\x03\x04"):
        return _spreadsheet(data, known, sheet)
    if data.startswith(b"\xd0\xcf\x11\xe0"):
        raise TextError("this is an old Excel file: save it as .xlsx or CSV")
    return parse(data, known)


def parse(data: bytes, known: Known) -> Cells:
    """Cells of a CSV file."""
    text, encoding = decoded(data)
    lines = _lines(text)
    declared = re.fullmatch(r'\s*"?sep=(.)"?[\s;,\t]*', lines[0], re.IGNORECASE) if lines else None
    if declared:
        lines[0] = ""
    lines = _with_header(lines, known)
    shown = [line for line in lines if line.strip(' ,;|\t"')]
    if not shown:
        raise TextError("the table is empty")
    separator = declared.group(1) if declared else _separator(shown[:HEAD], known)
    frame = _frame(lines, separator)
    # A quoted cell may contain line breaks.
    breaks = frame.apply(lambda column: column.str.count("\n")).sum(axis=1).to_numpy()
    numbers = 1 + np.arange(len(frame)) + np.concatenate([[0], np.cumsum(breaks)[:-1]]).astype(int)
    frame = frame.apply(lambda column: column.str.replace(r"\s*\n\s*", " ", regex=True).str.strip())
    filled = (frame != "").any(axis=1).to_numpy()
    name = SEPARATORS.get(separator, repr(separator))
    return Cells(
        frame[filled].reset_index(drop=True), numbers[filled], separator, f"{encoding.upper()}, {name} between columns"
    )


def _with_header(lines: list[str], known: Known) -> list[str]:
    """The lines with remarks emptied. A remark with known names above rows of numbers is the header."""
    found = list(lines)
    first = next((line for line in lines if line.strip() and not is_remark(line)), "")
    for place, line in enumerate(lines):
        if not is_remark(line):
            continue
        bare = line.lstrip().lstrip('"#').strip() if not line.lstrip().startswith('"#') else line.replace("#", "", 1)
        best = max((known(_split(bare, separator)) for separator in SEPARATORS), default=0)
        in_place = max((known(_split(line, separator)) for separator in SEPARATORS), default=0)
        has_header = max((known(_split(first, separator)) for separator in SEPARATORS), default=0) >= 2
        if best >= 3 and not has_header:
            # A first cell `#` is an index column.
            found[place] = line if in_place == best and re.match(r'\s*"?#"?\s*[;,|\t]', line) else bare
        else:
            found[place] = ""
    return found


def _separator(lines: Sequence[str], known: Known) -> str:
    """The separator by which the lines have most known names; among equals, the one in most lines."""

    def merit(separator: str) -> tuple[float, int]:
        rows = [_split(line, separator) for line in lines]
        return max(known(row) for row in rows), sum(len(row) > 1 for row in rows)

    return max(SEPARATORS, key=merit)


def _frame(lines: Sequence[str], separator: str) -> pd.DataFrame:
    import pandas as pd

    if separator == "  ":
        lines, separator = ["\x1f".join(_split(line, "  ")) if line.strip() else "" for line in lines], "\x1f"
    # The C parser of pandas takes the number of columns from here.
    width = max(line.count(separator) for line in lines) + 1
    frame = pd.read_csv(
        io.StringIO("\n".join(lines)),
        sep=separator,
        header=None,
        names=range(width),
        index_col=False,
        dtype=str,
        keep_default_na=False,
        skip_blank_lines=False,
        skipinitialspace=separator != "\t",
        on_bad_lines="error",
    )
    return frame.fillna("")


# Spreadsheets


def _spreadsheet(data: bytes, known: Known, wanted: str | None) -> Cells:
    import pandas as pd

    try:
        book = pd.ExcelFile(io.BytesIO(data), engine="openpyxl")
    except ImportError as error:
        raise TextError("an .xlsx file requires the package openpyxl: pip install 'pushbelt[excel]'") from error
    except Exception as error:  # openpyxl and zipfile have no common base class of errors.
        raise TextError(f"the file is not a readable .xlsx file: {error}") from error
    with book:
        if wanted is not None and wanted not in book.sheet_names:
            raise TextError(f"there is no sheet {wanted}; there are {', '.join(map(str, book.sheet_names))}")
        found: list[tuple[float, Cells]] = []
        for name in [wanted] if wanted is not None else book.sheet_names:
            cells = _sheet(book, str(name), data)
            if cells is not None:
                best = max(known(cells.row(place)) for place in range(min(HEAD, len(cells.frame))))
                found.append((best, cells))
    if not found:
        raise TextError("the table is empty")
    return max(found, key=lambda pair: pair[0])[1]


def _sheet(book: pd.ExcelFile, name: str, data: bytes) -> Cells | None:
    import pandas as pd

    frame = pd.read_excel(book, sheet_name=name, header=None, dtype=object, keep_default_na=False, na_values=[])
    if frame.empty:
        return None
    frame.columns = range(frame.shape[1])
    for row, column, share in _percent_cells(book.book[name]):
        if row < frame.shape[0] and column < frame.shape[1]:
            frame.iat[row, column] = Percent(share)
    for row, column in _uncalculated(book.book[name], data):
        if row < frame.shape[0] and column < frame.shape[1]:
            frame.iat[row, column] = "="
    # pandas gives NaN for error values and an empty text for empty cells.
    frame = frame.map(lambda cell: "#N/A" if isinstance(cell, float) and np.isnan(cell) else cell)
    frame = frame.map(
        lambda cell: (
            cell if isinstance(cell, (int, float, Percent)) and not isinstance(cell, bool) else str(cell).strip()
        )
    )
    filled = (frame != "").any(axis=1).to_numpy()
    remarks = np.array(
        [is_remark(str(next((c for c in row if str(c) != ""), ""))) for row in frame.itertuples(index=False)]
    )
    headers = np.array([sum(str(cell) != "" for cell in row) > 3 for row in frame.itertuples(index=False)])
    keep = filled & (~remarks | headers)
    if not keep.any():
        return None
    return Cells(frame[keep].reset_index(drop=True), 1 + np.flatnonzero(keep), "", f"sheet {name}")


def _uncalculated(sheet: Any, data: bytes) -> Iterator[tuple[int, int]]:
    """Places of formulas without a value, from 0: no spreadsheet program has calculated them."""
    import openpyxl

    # Only the file of formulas says that an empty cell has one.
    formulas = openpyxl.load_workbook(io.BytesIO(data))[sheet.title]
    for row in formulas.iter_rows():
        for cell in row:
            if cell.data_type == "f" and sheet.cell(cell.row, cell.column).value is None:
                yield cell.row - 1, cell.column - 1


def _percent_cells(sheet: Any) -> Iterator[tuple[int, int, float]]:
    """Numbers that the sheet shows in per cent, with row and column from 0."""
    for row in sheet.iter_rows():
        for cell in row:
            if isinstance(cell.value, (int, float)) and "%" in str(getattr(cell, "number_format", "")):
                yield cell.row - 1, cell.column - 1, float(cell.value)


# Other files


def _unzipped(data: bytes) -> bytes:
    with gzip.GzipFile(fileobj=io.BytesIO(data)) as file:
        try:
            found = file.read(LARGEST + 1)
        except (OSError, EOFError, zlib.error) as error:
            raise TextError(f"the file is not a whole gzip file: {error}") from error
    if len(found) > LARGEST:
        raise TextError(f"the file has more than {LARGEST / 1e6:.0f} MB when it is unpacked")
    return found


def _parquet(data: bytes) -> Cells:
    import pandas as pd

    try:
        frame = pd.read_parquet(io.BytesIO(data), engine="pyarrow")
    except ImportError as error:
        raise TextError("a .parquet file requires the package pyarrow: pip install 'pushbelt[parquet]'") from error
    except (OSError, ValueError) as error:
        raise TextError(f"the file is not a readable .parquet file: {error}") from error
    if not isinstance(frame.index, pd.RangeIndex):
        frame = frame.reset_index(names=[frame.index.name or "time"] if frame.index.nlevels == 1 else None)
    for name in frame.select_dtypes("timedelta"):
        frame[name] = frame[name].dt.total_seconds()
    return _cells([list(map(str, frame.columns))], frame, "Parquet")


def _mf4(data: bytes, known: Known) -> Cells:
    """The channels with a known name, each at its own times."""
    import pandas as pd

    try:
        from asammdf import MDF
    except ImportError as error:
        raise TextError("an MDF file requires the package asammdf: pip install 'pushbelt[mf4]'") from error
    columns, titles, unit_row = [], ["time"], ["s"]
    try:
        with MDF(io.BytesIO(data)) as file:
            for name, ((group, index), *_) in file.channels_db.items():
                title = name.split("\\")[0]
                if file.masters_db.get(group) == index or not known([title]):
                    continue
                signal = file.get(group=group, index=index)
                if np.issubdtype(signal.samples.dtype, np.number) and signal.samples.ndim == 1:
                    own = pd.Series(signal.samples.astype(float), index=signal.timestamps)
                    columns.append(own[~own.index.duplicated()])
                    titles.append(title)
                    unit_row.append(signal.unit or "")
    except Exception as error:  # asammdf's errors have no common base class.
        raise TextError(f"the file is not a readable MDF file: {error}") from error
    if not columns:
        raise TextError("no channel has a known name; --map says what a channel is")
    frame = pd.concat(columns, axis=1).sort_index().reset_index()
    return _cells([titles, unit_row], frame, "MDF")


def _cells(head: list[list[str]], body: pd.DataFrame, source: str) -> Cells:
    """Cells below rows of titles; the lines count the rows of values."""
    import pandas as pd

    body = body.astype(object).where(body.notna(), "")
    body = body.map(
        lambda cell: (
            cell if isinstance(cell, (int, float, np.number)) and not isinstance(cell, bool) else str(cell).strip()
        )
    )
    body.columns = range(body.shape[1])
    frame = pd.concat([pd.DataFrame(head, dtype=object), body], ignore_index=True)
    return Cells(frame, np.arange(len(frame)) - len(head) + 1, "", source)
