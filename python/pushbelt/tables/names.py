"""Titles of columns: a known name and a unit, in English and German.

Names are compared without case, blanks, points and brackets; any other sign makes another name. `Drehzahl der Primärscheibe` and
`input speed` are words for pulley and quantity.
"""

import difflib
import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

from . import units

DEVIATION = ".sd"  # Suffix of a column of standard deviations
CLOSE = 0.82  # Similarity above which an unknown name is taken for a misspelled one
LETTERS = str.maketrans({"ω": "omega", "η": "eta", "ζ": "zeta", "ν": "nu", "σ": "sigma", "é": "e", "è": "e", "ê": "e", "à": "a"})
WORDS = {
    "side": {
        "primary": "primary primär primaer primäre primärer primäres pri prim input in drive driving antrieb antriebs an eingang eingangs "
        "primaire menante entree",
        "secondary": "secondary sekundär sekundaer sekundäre sekundärer sekundäres sec sek output out driven abtrieb abtriebs ab ausgang "
        "ausgangs secondaire menee sortie desortie",
    },
    "quantity": {
        "speed": "speed rpm rotationalspeed angularspeed angularvelocity drehzahl winkelgeschwindigkeit vitesse vitessederotation regime",
        "torque": "torque moment drehmoment couple",
        "clampingForce": "clampingforce clampforce clamping force axialforce thrust thrustforce anpresskraft anpreßkraft klemmkraft spannkraft "
        "axialkraft kraft effort effortaxial effortdeserrage forceaxiale forcedeserrage poussee",
        "pressure": "pressure oilpressure clampingpressure druck öldruck oeldruck anpressdruck anpreßdruck pression "
        "pressionhuile",
    },
    "filler": {"": "pulley shaft sheave disc side scheibe scheiben scheibensatz welle wellen seite seitig der des am of the at on poulie "
        "arbre de du"},
}
"""Words of titles by what they mean."""
BARE = {"speed": "primary.speed", "torque": "primary.torque", "clampingForce": "secondary.clampingForce"}
"""Names of quantities whose title has no pulley."""
INVERSE = {
    "1/ratio.speed": "n_S/n_P n2/n1 nout/nin n_out/n_in n_ab/n_an omega_S/omega_P",
    "1/ratio.geometric": "r_P/r_S r1/r2",
    "1/thrustRatio": "F_S/F_P F2/F1",
}
"""Titles of inverse columns."""


def unquoted(title: str) -> str:
    return re.sub(r"""^(["'])(.*)\1$""", r"\2", title.strip()).strip().strip('"')


@lru_cache(10_000)
def key(name: str) -> str:
    """A name without case, blanks, points, hyphens and brackets. Any other letter or sign distinguishes it: `F_P*` is not `F_P`."""
    name = unicodedata.normalize("NFKC", unquoted(name)).strip().lower().translate(LETTERS)
    name = re.sub(r"\b[dl]['’](?=\w)", "", name)  # Couple d'entrée
    return re.sub(r"[\s_.,:;^~$(){}\[\]\N{HYPHEN}-\N{EM DASH}-]", "", name)


_MEANING = {w: (kind, value) for kind, group in WORDS.items() for value, words in group.items() for w in words.split()}
_TOKEN = re.compile("|".join(sorted(_MEANING, key=len, reverse=True)))
_TURNED = {key(title): name for name, titles in INVERSE.items() for title in titles.split()}


def in_words(name: str) -> tuple[str, bool] | None:
    """The known name that words for pulley and quantity have, and whether the pulley is missing; None for other words."""
    spelled = key(name)
    tokens = _TOKEN.findall(spelled)
    if "".join(tokens) != spelled:
        return None
    meanings = [_MEANING[token] for token in tokens]
    sides = {value for kind, value in meanings if kind == "side"}
    quantities = [value for kind, value in meanings if kind == "quantity"]
    if len(quantities) != 1 or len(sides) > 1 or not (sides or quantities[0] in BARE):
        return None
    return (f"{sides.pop()}.{quantities[0]}", False) if sides else (BARE[quantities[0]], True)


@dataclass(frozen=True)
class Column:
    dimension: str  # Dimension of its unit, or `text`
    low: float  # Least plausible value, SI
    high: float  # Largest, SI
    meaning: str
    aliases: tuple[str, ...] = ()  # Other common names
    default: str = ""  # Unit of a column without one; empty if a unit is required. Ratios need none


class Names:
    """Known names and their other spellings, and the titles that the user maps."""

    def __init__(self, columns: Mapping[str, Column], mapped: Iterable[str] = ()) -> None:
        self.columns, self.mapped = columns, tuple(mapped)
        self._known: dict[str, list[str]] = {}
        for name, column in columns.items():
            for spelled in (name, *column.aliases):
                self._known.setdefault(key(spelled), []).append(name)
        self.split = cache(self._split)  # Known names and units of a title, possibly several if the unit decides
        self.contained = cache(self._contained)  # The known name, with a pulley, that an unknown title contains; None without one

    def find(self, written: str) -> list[str]:
        """Known names with this spelling."""
        found = self._known.get(key(written))
        if found is None and (words := in_words(written)) is not None:
            # Only columns with other spellings have names in words.
            found = [name for name in self._known.get(key(words[0]), []) if self.columns[name].aliases]
        return found or []

    def bare(self, title: str) -> bool:
        """Whether a title names a quantity without a pulley."""
        return any(key(name) not in self._known and (in_words(name) or ("", False))[1] for name, _ in splits(title))

    def close(self, title: str) -> str | None:
        """The known name that is probably meant by an unknown title."""
        known = [name for name in self._known if len(name) > 3]
        for spelled in (key(written) for written, _ in self._splits(title)):
            # A sign such as * or Δ is no slip of the pen.
            plain = len(spelled) > 3 and re.fullmatch(r"[a-z0-9/äöüß]+", spelled)
            if plain and (near := difflib.get_close_matches(spelled, known, 1, CLOSE)):
                return self._known[near[0]][0]
        return None

    def count(self, cells: Sequence[str]) -> float:
        """Number of different known names among titles, and of mapped ones. One without a pulley counts half, one that an unknown title
        contains a tenth."""
        found: dict[str, float] = {}
        # `rpm` in a row of units is no name.
        for cell in (cell for cell in cells if not units.dimensions(cell)):
            if split := self.split(cell):
                found[split[0][0]] = 0.5 if self.bare(cell) else 1.0
            elif any(same(cell, one) for one in self.mapped if cell):
                found[cell] = 1.0
            elif name := self.contained(cell):
                found.setdefault(name, 0.1)
        return sum(found.values())

    def _contained(self, title: str) -> str | None:
        words = re.findall(r"[a-zäöüß0-9]+", next(splits(title))[0].lower().translate(LETTERS))
        for length in (4, 3, 2, 1) if any(map(str.isalpha, title)) else ():
            for part in (" ".join(words[k : k + length]) for k in range(len(words) - length + 1)):
                if len(key(part)) > 1 and not self.bare(part) and (found := self.find(part)):
                    return found[0]
        return None

    def _split(self, title: str) -> list[tuple[str, str | None]]:
        if not any(map(str.isalpha, title)):
            return []
        bracketed = title.rstrip()[-1:] in ("]", ")", "}")
        # T_S is a torque, not a T in S; t_s is a time.
        if re.fullmatch(r"\w+", title.strip()) and title.strip() != "t_s" and (whole := self._known.get(key(title))):
            return [(name, None) for name in whole]
        for written, unit in self._splits(title):
            found, end = self.find(written), ""
            if not found and (base := without_deviation(written)) is not None:
                found, end = self.find(base), DEVIATION
            # Without brackets the end of a title is a unit only if the column may have it.
            if fitting := [n for n in found if unit is None or bracketed or units.find(unit, self.columns[n].dimension)]:
                return [(name + end, unit) for name in fitting]
        return []

    def _splits(self, title: str) -> Iterator[tuple[str, str | None]]:
        """Without pairs like `n_P` and `Mean` of `n_P (Mean)`, which is another quantity."""
        for written, unit in splits(title):
            word = unit is not None and title.rstrip()[-1:] in ")）" and re.fullmatch(r"[^\W\d_]{3,}", unit)
            if unit is None or not word or units.dimensions(unit) or self.find(unit):
                yield written, unit

    def inverse(self, title: str) -> str | None:
        """The name such as `1/ratio.speed` of a title that says so; `i (n_S/n_P)` does as well."""
        wanted = (_TURNED.get(key(text)) for pair in splits(title) for text in pair if text is not None)
        return next((name for name in wanted if name is not None and name.removeprefix("1/") in self.columns), None)


def without_deviation(name: str) -> str | None:
    """A name without the word for a standard deviation; None if it has none."""
    words = r"(.+?)[.\s_-]*(?:sd|std|stddev|sigma)|(?:sd|std|sigma)[\s_.(]+(.+?)\)?"
    found = re.fullmatch(words, name.strip(), re.IGNORECASE)
    return (found[1] or found[2]) if found else None


def splits(title: str) -> Iterator[tuple[str, str | None]]:
    """Possible pairs of name and unit of a title, the most explicit one first."""
    title = unquoted(unicodedata.normalize("NFKC", title))
    bracketed = re.fullmatch(r"(.*?)[\s_,;:/-]*(?:\[([^\]]*)\]|\{([^}]*)\}|\(([^()]*(?:\([^()]*\))?[^()]*)\))\s*", title)
    if bracketed and bracketed[1]:
        yield bracketed[1], next(group for group in bracketed.groups()[1:] if group is not None)
    for pattern in (r"(.+?)\s+/\s*(\S.*)", r"(.+)/(\S+)", r"(.+?)\s*,\s*(\S.*)", r"(.+?)\s+in\s+(\S.*)"):
        found = re.fullmatch(pattern, title)
        if found and units.dimensions(found[2]):
            yield found[1], found[2]
    for sign in re.finditer(r"[\s_.:]+", title):
        if sign.start() and units.dimensions(title[sign.end() :]):
            yield title[: sign.start()], title[sign.end() :]
    yield title, None


def same(title: str, wanted: str) -> bool:
    """Whether a title of the file is the one that the user writes."""
    return title.strip() == wanted.strip() or any(key(written) == key(wanted) != "" for written, _ in splits(title))


def turned(wanted: str) -> tuple[str, str]:
    """The prefix `1/` or `-` of a name, and the name."""
    wanted = wanted.strip()
    prefix = next((sign for sign in ("1/", "-") if wanted.startswith(sign)), "")
    return prefix, wanted.removeprefix(prefix).strip()
