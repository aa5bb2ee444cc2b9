"""Titles of columns: a known name and a unit, in English and German.

Names are compared without case, blanks and points. `Drehzahl der Primärscheibe` and `input speed` are words for pulley and quantity.
"""

from __future__ import annotations

import difflib
import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from . import units
from .units import Unit

DEVIATION = ".sd"
"""Suffix of a column of standard deviations."""
CLOSE = 0.82
"""Similarity above which an unknown name is taken for a misspelled one."""
LETTERS = str.maketrans(
    {"ω": "omega", "η": "eta", "ζ": "zeta", "ν": "nu", "σ": "sigma", "₁": "1", "₂": "2", "ₚ": "p", "ₛ": "s"}
)

SIDES = {
    "primary": "primary primär primaer primäre primärer primäres pri prim input in drive driving antrieb antriebs an eingang eingangs",
    "secondary": "secondary sekundär sekundaer sekundäre sekundärer sekundäres sec sek output out driven abtrieb abtriebs ab ausgang ausgangs",
}
WORDS = {
    "speed": "speed rpm rotationalspeed angularspeed angularvelocity drehzahl winkelgeschwindigkeit",
    "torque": "torque moment drehmoment",
    "clampingForce": "clampingforce clampforce clamping force axialforce thrust thrustforce anpresskraft anpreßkraft klemmkraft spannkraft "
    "axialkraft kraft",
    "pressure": "pressure oilpressure clampingpressure druck öldruck oeldruck anpressdruck anpreßdruck",
}
FILLERS = (
    "pulley shaft sheave disc side scheibe scheiben scheibensatz welle wellen seite seitig der des am of the at on"
)
BARE = {"speed": "primary.speed", "torque": "primary.torque", "clampingForce": "secondary.clampingForce"}
"""Names of quantities whose title has no pulley."""
INVERSE = {
    "1/ratio.speed": "n_S/n_P n2/n1 nout/nin n_out/n_in n_ab/n_an omega_S/omega_P",
    "1/ratio.geometric": "r_P/r_S r1/r2",
    "1/thrustRatio": "F_S/F_P F2/F1",
}
"""Titles of inverse columns."""


def key(name: str) -> str:
    """A name without case, blanks and signs. The division stays."""
    name = unicodedata.normalize("NFC", name).strip().lower().translate(LETTERS)
    return re.sub(r"[^a-z0-9/äöüß]", "", name)


_MEANING = {
    **{word: ("side", side) for side, words in SIDES.items() for word in words.split()},
    **{word: ("", "") for word in FILLERS.split()},
    **{word: ("quantity", quantity) for quantity, words in WORDS.items() for word in words.split()},
}
_TOKEN = re.compile("|".join(sorted(_MEANING, key=len, reverse=True)))
_TURNED = {key(title): name for name, titles in INVERSE.items() for title in titles.split()}


def in_words(name: str) -> tuple[str, bool] | None:
    """The known name that words for pulley and quantity have, and whether the pulley is missing; None for other words."""
    spelled = key(name)
    tokens = _TOKEN.findall(spelled)
    if not tokens or "".join(tokens) != spelled:
        return None
    meanings = [_MEANING[token] for token in tokens]
    sides = {value for kind, value in meanings if kind == "side"}
    quantities = [value for kind, value in meanings if kind == "quantity"]
    if len(quantities) != 1 or len(sides) > 1:
        return None
    if sides:
        return f"{sides.pop()}.{quantities[0]}", False
    return (BARE[quantities[0]], True) if quantities[0] in BARE else None


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
        found = self._known.get(key(written))
        if found is None and (words := in_words(written)) is not None:
            # Only columns with other spellings have names in words.
            found = [name for name in self._known.get(key(words[0]), []) if self.columns[name].aliases]
        return found or []

    def bare(self, title: str) -> bool:
        """Whether a title names a quantity without a pulley."""
        return any(
            key(written) not in self._known and (in_words(written) or ("", False))[1] for written, _ in splits(title)
        )

    def close(self, written: str) -> str | None:
        """The known name that is probably meant by an unknown one."""
        spelled = key(written)
        if len(spelled) < 4:
            return None
        near = difflib.get_close_matches(spelled, [known for known in self._known if len(known) > 3], 1, CLOSE)
        return self._known[near[0]][0] if near else None

    def count(self, cells: Sequence[str]) -> float:
        """Number of different known names among titles. One without a pulley counts half."""
        found = {split[0][0]: 0.5 if self.bare(cell) else 1.0 for cell in cells if (split := self.split(cell))}
        return sum(found.values())

    def split(self, title: str) -> list[tuple[str, str | None]]:
        """Known names and units of a title, possibly several if the unit decides."""
        if not any(map(str.isalpha, title)):
            return []
        bracketed = title.rstrip()[-1:] in ("]", ")", "}")
        whole = self._known.get(key(title)) if re.fullmatch(r"\w+", title.strip()) else None
        if whole and title.strip() != "t_s":
            # T_S is a torque, not a T in S; t_s is a time.
            return [(name, None) for name in whole]
        for written, unit in splits(title):
            base, deviation = without_deviation(written)
            found = self.find(written)
            end = ""
            if not found and deviation:
                found, end = self.find(base), DEVIATION
            # Without brackets the end of a title is a unit only if the column may have it.
            fitting = [
                name
                for name in found
                if unit is None or bracketed or units.find(unit, self.columns[name].dimension) is not None
            ]
            if fitting:
                return [(name + end, unit) for name in fitting]
        return []

    def inverse(self, title: str) -> str | None:
        """The name such as `1/ratio.speed` of a title that says so; `i (n_S/n_P)` does as well."""
        for text in (part for pair in splits(title) for part in pair if part is not None):
            wanted = _TURNED.get(key(text))
            if wanted is not None and wanted.removeprefix("1/") in self.columns:
                return wanted
        return None


def without_deviation(name: str) -> tuple[str, bool]:
    """A name without the word for a standard deviation, and whether it has one."""
    found = re.fullmatch(
        r"(.+?)[.\s_-]*(?:sd|std|stddev|sigma)|(?:sd|std|sigma)[\s_.(]+(.+?)\)?", name.strip(), re.IGNORECASE
    )
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


def same(title: str, wanted: str) -> bool:
    """Whether a title of the file is the one that the user writes."""
    return title.strip() == wanted.strip() or any(key(written) == key(wanted) != "" for written, _ in splits(title))


def turned(wanted: str | None) -> tuple[str, str | None]:
    """The prefix `1/` or `-` of a name, and the name."""
    for prefix in ("1/", "-"):
        if wanted is not None and wanted.strip().startswith(prefix):
            return prefix, wanted.strip().removeprefix(prefix).strip()
    return "", wanted
