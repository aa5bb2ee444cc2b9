"""Numbers as text: which decimal sign a file has, and what its cells say."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from ..errors import PushbeltError

GROUPS = " \N{NO-BREAK SPACE}\N{NARROW NO-BREAK SPACE}\N{THIN SPACE}'\N{RIGHT SINGLE QUOTATION MARK}_"
"""Signs between thousands that are no decimal signs."""
MISSING = frozenset(
    "nan -nan +nan n/a na null none nil missing inf -inf +inf 1.#qnan 1.#inf -1.#ind #null! #div/0! #value! #ref! #name? #num! #n/a #nv "
    "#wert! #bezug! #zahl! #name? #spill! #calc! #getting_data invalid overflow overrange -- --- ---- ? * error fehler nodata no_data null".split()
)
"""Texts of cells without a value, in small letters."""
SENTINELS = (-999.0, -9999.0, -99999.0, -999999.0)
"""Numbers that loggers write where nothing was measured."""
SIGNS = {"point": ".", "comma": ","}
"""Decimal signs by name."""


@dataclass(frozen=True)
class Percent:
    """A number of a spreadsheet cell that is shown in per cent."""

    share: float


class NumeralError(PushbeltError, ValueError):
    """The decimal sign cannot be determined. The message contains the reason."""


def _pattern(decimal: str) -> re.Pattern[str]:
    others = "".join(sign for sign in ".," if sign != decimal) + GROUPS
    group = rf"[1-9]\d{{0,2}}(?:(?P<sign>[{re.escape(others)}])\d{{3}})(?:(?P=sign)\d{{3}})*"
    point = re.escape(decimal)
    return re.compile(rf"[+-]?(?:(?:{group}|\d+)(?:{point}\d*)?|{point}\d+)(?:[eEdD][+-]?\d+)?")


PATTERNS: Mapping[str, re.Pattern[str]] = {name: _pattern(sign) for name, sign in SIGNS.items()}


def cleaned(text: str) -> str:
    """A cell without blanks around it, a per cent sign and typographic minus signs."""
    text = text.strip().strip("\N{NO-BREAK SPACE}").translate({0x2212: "-", 0x2013: "-", 0xFF0D: "-"})
    return text.removesuffix("%").rstrip()


def missing(text: str) -> bool:
    """Whether a cell has an error value or says that nothing was measured."""
    return text.strip().lower() in MISSING


def number(text: str, decimal: str) -> float | None:
    """The number of a cell by the name of the decimal sign; None if it is no such number."""
    plain = cleaned(text)
    if not PATTERNS[decimal].fullmatch(plain):
        return None
    sign = SIGNS[decimal]
    plain = re.sub(rf"[{re.escape(GROUPS)}]", "", plain)
    plain = plain.replace("," if sign == "." else ".", "").replace(sign, ".").replace("d", "e").replace("D", "e")
    value = float(plain)
    return value if math.isfinite(value) else None


def certain(cells: Iterable[str]) -> str | None:
    """The name of the decimal sign if all numbers can be read with it, and some not with the other one."""
    texts = {cleaned(text) for text in cells if text.strip() and not missing(text) and any(map(str.isdigit, text))}
    readable = [name for name in SIGNS if all(number(text, name) is not None for text in texts)]
    return readable[0] if len(readable) == 1 else None


def settle(cells: Iterable[str], separator: str) -> str:
    """The name of the decimal sign of a file from all its numbers. Raises NumeralError if both readings fit and differ.

    `separator` is the sign between columns: a file with commas between its columns has no decimal comma without quotes.
    """
    texts = list(dict.fromkeys(cleaned(text) for text in cells if text.strip() and not missing(text)))
    # Words are no numbers with any sign.
    texts = [text for text in texts if any(number(text, name) is not None for name in SIGNS)]
    unreadable = {name: sum(number(text, name) is None for text in texts) for name in SIGNS}
    if unreadable["point"] != unreadable["comma"]:
        return min(unreadable, key=lambda name: unreadable[name])
    differing = [text for text in texts if number(text, "point") != number(text, "comma")]
    if not differing or unreadable["point"]:
        return "point"
    if separator == "," and not any("," in text for text in texts):
        return "point"
    one = differing[0]
    raise NumeralError(
        f"'{one}' is {number(one, 'point'):.10g} with a decimal point and {number(one, 'comma'):.10g} with a decimal comma, and no number of "
        "the file settles it: specify --decimal point or --decimal comma"
    )
