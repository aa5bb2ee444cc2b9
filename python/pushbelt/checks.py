"""A statement that results must bear out, as all reports print it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """A statement and whether the results bear it out."""

    statement: str
    passed: bool
    found: str
