"""Faults of a table, with line and column."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import PushbeltError

MOST = 0.5  # Share of a column's values with a fault from which the whole column has it; below, their rows are left out
SHOWN = 12  # Largest number of faults that an error lists in full


class Fault(NamedTuple):
    text: str
    line: int | None = None
    column: str | None = None

    def __str__(self) -> str:
        place = [f"{what} {name}" for what, name in (("line", self.line), ("column", self.column)) if name is not None]
        return f"{', '.join(place)}: {self.text}" if place else self.text


class TableError(PushbeltError, ValueError):
    """The table cannot be used. The message has every fault with line, column and value."""

    def __init__(self, faults: Sequence[Fault] | str, path: Path | None = None, found: Any = None) -> None:
        self.faults = (Fault(faults),) if isinstance(faults, str) else tuple(faults)
        self.found = found  # The sheet as it was understood in spite of the faults
        start = f"{path}: " if path is not None else ""
        if len(self.faults) == 1:
            super().__init__(f"{start}{self.faults[0]}")
            return
        more = len(self.faults) - SHOWN
        lines = [f"  {fault}" for fault in self.faults[:SHOWN]] + [f"  and {more} more of the same kinds"] * (more > 0)
        super().__init__("\n".join([f"{start}{len(self.faults)} faults", *lines]))


def of_the_column(faults: Sequence[Fault], good: int, hint: str = "") -> list[Fault]:
    """The first of the faults of a column for all of them, if at least half of its values have one."""
    if not faults or len(faults) < MOST * (len(faults) + good):
        return []
    more = f" (and {len(faults) - 1} more rows)" if len(faults) > 1 else ""
    return [faults[0]._replace(text=faults[0].text + more + hint)]


def grouped(faults: Sequence[Fault]) -> list[str]:
    """Texts of faults; equal ones of several lines are one."""
    lines: dict[Fault, list[int | None]] = {}
    for fault in faults:
        lines.setdefault(fault._replace(line=None), []).append(fault.line)
    return [
        str(same._replace(line=own[0])) if len(own) == 1
        else f"{len(own)} lines, {', '.join(map(str, own[:SHOWN]))}{' …' * (len(own) > SHOWN)}: {same}"
        for same, own in lines.items()
    ]  # fmt: skip
