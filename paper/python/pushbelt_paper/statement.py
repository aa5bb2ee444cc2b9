"""A paraphrased statement of the paper, and the result for it.

Each statement cites its section, figure or equation. The numbers of the run determine the verdict and, where the explanation
depends on the outcome, the choice of the explanation.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum

from pushbelt.page import MINUS

THIN = "\N{NARROW NO-BREAK SPACE}"


class Verdict(Enum):
    """Verdict on a statement."""

    YES = "reproduced"
    PARTLY = "in part"
    NO = "not reproduced"
    OPEN = "not run"
    ASIDE = "elsewhere"


@dataclass(frozen=True)
class Statement:
    """A statement of the paper."""

    source: str
    claim: str
    verdict: Verdict
    found: str
    reason: str


def plain(value: float, form: str) -> str:
    """A number in a format, with a real minus."""
    return f"{value:{form}}".replace("-", MINUS)


def signed(value: float, digits: int = 1) -> str:
    """A share as per cent with its sign."""
    return f"{plain(100.0 * value, f'+.{digits}f')}{THIN}%"


def span(values: Iterable[float], digits: int = 1) -> str:
    """Smallest and largest share as per cent."""
    values = list(values)
    return f"{signed(min(values), digits)} to {signed(max(values), digits)}"


def points(values: Iterable[float], digits: int = 2) -> str:
    """Smallest and largest difference of efficiencies in points, without their name."""
    values = list(values)
    return " to ".join(plain(100.0 * end, f"+.{digits}f") for end in (min(values), max(values)))


def listed(values: Mapping[str, str]) -> str:
    """Names with their values."""
    return ", ".join(f"{name} {value}" for name, value in values.items())


def verdict(yes: bool, partly: bool = False) -> Verdict:
    """The verdict: reproduced, reproduced in part, or not reproduced."""
    return Verdict.YES if yes else Verdict.PARTLY if partly else Verdict.NO


def not_run(source: str, claim: str, reason: str) -> Statement:
    """A statement that this run cannot check."""
    return Statement(source, claim, Verdict.OPEN, "–", reason)
