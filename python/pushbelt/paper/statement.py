"""A statement of the paper, in other words, and what was found.

Each statement names the section, figure or equation it comes from. A verdict follows from the figures of the run, and so does
the reason: where the same words would not hold for another outcome, there are words for it too.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

THIN = "\N{NARROW NO-BREAK SPACE}"


class Verdict(Enum):
    """Whether a statement was reproduced."""

    YES = "reproduced"
    PARTLY = "in part"
    NO = "not reproduced"
    OPEN = "not run"


@dataclass(frozen=True)
class Statement:
    """Something the paper says."""

    source: str
    claim: str
    verdict: Verdict
    found: str
    reason: str


def signed(value: float, digits: int = 1) -> str:
    """A share as per cent with its sign."""
    return f"{100.0 * value:+.{digits}f}{THIN}%".replace("-", "\N{MINUS SIGN}")


def span(values: Iterable[float], digits: int = 1) -> str:
    """Smallest and largest share as per cent."""
    values = list(values)
    return f"{signed(min(values), digits)} to {signed(max(values), digits)}"


def plain(value: float, form: str) -> str:
    """A number in a format, with a real minus."""
    return f"{value:{form}}".replace("-", "\N{MINUS SIGN}")


def verdict(yes: bool, partly: bool = False) -> Verdict:
    """Reproduced, else in part, else not."""
    return Verdict.YES if yes else Verdict.PARTLY if partly else Verdict.NO


def not_run(source: str, claim: str, reason: str) -> Statement:
    """A statement that this run can't decide."""
    return Statement(source, claim, Verdict.OPEN, "–", reason)
