"""Numbers and times as text: which decimal sign a file has, and what its cells say."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ArgumentError
from .units import Unit

if TYPE_CHECKING:
    import pandas as pd

GROUPS = " \N{NO-BREAK SPACE}\N{NARROW NO-BREAK SPACE}\N{THIN SPACE}'\N{RIGHT SINGLE QUOTATION MARK}_"
"""Signs between thousands that are no decimal signs."""
MISSING = frozenset(
    "nan -nan +nan n/a na null none nil missing inf -inf +inf 1.#qnan 1.#inf -1.#ind #null! #div/0! #value! #ref! #name? #num! #n/a #nv "
    "#wert! #bezug! #zahl! #spill! #calc! #getting_data invalid overflow overrange -- --- ---- ? * error fehler nodata no_data".split()
)
"""Texts of cells without a value, in small letters."""
SENTINELS = (-999.0, -9999.0, -99999.0, -999999.0)  # Numbers that loggers write where nothing was measured
SIGNS = {"point": ".", "comma": ","}  # Decimal signs by name
EPOCHS = ((1e17, 1e-9), (1e14, 1e-6), (1e11, 1e-3))
"""Numbers without a unit that are above the first value are a time since 1970 in this unit."""
SAMPLE = 50  # Cells that decide whether times are numbers


class Percent(float):
    """The number of a spreadsheet cell that is shown in per cent, as it is shown."""

    def __str__(self) -> str:
        return f"{float(self):g}%"


def _pattern(decimal: str) -> re.Pattern[str]:
    others = re.escape("".join({".", ","} - {decimal}) + GROUPS)
    group, point = rf"[1-9]\d{{0,2}}(?:(?P<sign>[{others}])\d{{3}})(?:(?P=sign)\d{{3}})*", re.escape(decimal)
    return re.compile(rf"[+-]?(?:(?:{group}|\d+)(?:{point}\d*)?|{point}\d+)(?:[eEdD][+-]?\d+)?")


PATTERNS = {name: _pattern(sign) for name, sign in SIGNS.items()}
PLAIN = {
    name: str.maketrans({**dict.fromkeys(GROUPS + other), "d": "e", "D": "e", sign: "."})
    for (name, sign), other in zip(SIGNS.items(), ",.", strict=True)
}
"""Translation of the signs of a number to those of Python."""


def cleaned(text: str) -> str:
    """A cell without blanks around it, a per cent sign and typographic minus signs."""
    return text.strip().translate({0x2212: "-", 0x2013: "-", 0xFF0D: "-"}).removesuffix("%").rstrip()


def missing(text: str) -> bool:
    """Whether a cell has an error value or says that nothing was measured."""
    return text.strip().lower() in MISSING


def number(text: str, decimal: str) -> float | None:
    """The number of a cell by the name of the decimal sign; None if it is no such number."""
    plain = cleaned(text)
    if not PATTERNS[decimal].fullmatch(plain):
        return None
    value = float(plain.translate(PLAIN[decimal]))
    return value if math.isfinite(value) else None


def numbers(cells: pd.Series, decimal: str) -> np.ndarray:
    """The numbers of cells, of which a spreadsheet has some already; NaN for any other cell."""
    known = {cell: number(cell, decimal) if isinstance(cell, str) else cell for cell in cells.unique()}
    found = cells.map(known).to_numpy(dtype=float)
    return np.where(np.isfinite(found), found, np.nan)


def settle(cells: Iterable[str], separator: str = "", certainly: bool = False) -> str | None:
    """The name of the decimal sign of a file from all its numbers. Raises ArgumentError if both readings fit and differ. With
    `certainly` it is None, unless all cells with digits are numbers with exactly one sign. `separator` is the sign between
    columns: a file with commas between its columns has no decimal comma without quotes."""
    texts = dict.fromkeys(cleaned(text) for text in cells if text.strip() and not missing(text))
    values = {text: [number(text, name) for name in SIGNS] for text in texts if any(map(str.isdigit, text))}
    # Words are no numbers with any sign.
    known = {text: pair for text, pair in values.items() if pair != [None, None]}
    points, commas = (sum(pair[k] is not None for pair in known.values()) for k in (0, 1))
    if certainly and (points == commas or max(points, commas) < len(values)):
        return None
    if points != commas:
        return "point" if points > commas else "comma"
    differing = [text for text, (point, comma) in known.items() if point != comma]
    if not differing or points < len(known) or (separator == "," and not any("," in text for text in known)):
        return "point"
    point, comma = known[differing[0]]
    raise ArgumentError(
        f"'{differing[0]}' is {point:.10g} with a decimal point and {comma:.10g} with a decimal comma, and no number of the file settles it: "
        "specify --decimal point or --decimal comma"
    )


def seconds(cells: pd.Series, scale: Unit, decimal: str) -> np.ndarray:
    """Times as numbers, times of the day, or dates: seconds, of dates those since the first; NaN for a cell that is no time."""
    import pandas as pd

    filled = (cells != "").to_numpy(dtype=bool)
    if np.isfinite(numbers(cells[filled][:SAMPLE], decimal)).sum() >= 0.5 * min(filled.sum(), SAMPLE):
        found = numbers(cells, decimal)
        largest = np.nanmax(np.abs(found), initial=0.0)
        return found * (scale.factor if scale.factor != 1.0 else next((factor for above, factor in EPOCHS if largest > above), 1.0))
    texts = cells.astype(str).str.strip().str.replace(",", ".", regex=False)
    clock = texts.str.fullmatch(r"(?:\d+ days?,? )?\d{1,3}:\d{2}(?::\d{2}(?:\.\d*)?)?")
    if clock[filled].mean() > 0.5:
        whole = texts.where(texts.str.count(":") == 2, texts + ":00")
        times = pd.to_timedelta(whole.where(clock), errors="coerce").dt.total_seconds().to_numpy(dtype=float)
        # A clock starts again at midnight.
        return times + 86400.0 * np.cumsum(np.diff(times, prepend=times[:1]) < -43200.0)
    year_first = texts.str.match(r"\d{4}-")
    day_first = not year_first.any() and not texts.str.contains("/").any()
    with warnings.catch_warnings():
        # pandas warns if it finds no common format.
        warnings.simplefilter("ignore", UserWarning)
        for form in ("ISO8601",) if year_first.mean() > 0.5 else (None, "mixed"):
            dates = pd.to_datetime(texts, errors="coerce", format=form, dayfirst=day_first and form != "ISO8601", utc=True)
            if dates[filled].isna().mean() <= 0.1:
                break
    return (dates - dates.min()).dt.total_seconds().to_numpy(dtype=float)
