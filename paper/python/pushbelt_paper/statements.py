"""All statements of the paper."""

from __future__ import annotations

from .results import PaperResults
from .statement import Statement
from .statements_rings import rings_alone
from .statements_outlook import outlook
from .statements_variator import variator


def evaluate(results: PaperResults) -> list[Statement]:
    """All statements in the paper's order."""
    return rings_alone(results) + variator(results) + outlook(results)
