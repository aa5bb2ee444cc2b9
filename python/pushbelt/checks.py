"""A statement about results and its verdict, as the reports show it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """A statement, and whether the results confirm it."""

    statement: str
    passed: bool
    found: str
