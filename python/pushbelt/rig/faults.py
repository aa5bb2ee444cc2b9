"""Faults of a table, with line and column."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import PushbeltError

SHOWN = 12
"""Largest number of faults that an error lists in full."""


@dataclass(frozen=True)
class Fault:
    """A fault of a table."""

    text: str
    line: int | None = None
    column: str | None = None

    def __str__(self) -> str:
        place = [f"line {self.line}"] if self.line is not None else []
        place += [f"column {self.column}"] if self.column is not None else []
        return f"{', '.join(place)}: {self.text}" if place else self.text


class TableError(PushbeltError, ValueError):
    """The table cannot be used. The message has every fault with line, column and value."""

    def __init__(self, faults: Sequence[Fault] | str, path: Path | None = None, found: Any = None) -> None:
        self.faults = (Fault(faults),) if isinstance(faults, str) else tuple(faults)
        self.found = found
        """The sheet as it was understood in spite of the faults."""
        start = f"{path}: " if path is not None else ""
        if len(self.faults) == 1:
            super().__init__(f"{start}{self.faults[0]}")
        else:
            lines = [f"  {fault}" for fault in self.faults[:SHOWN]]
            if len(self.faults) > SHOWN:
                lines.append(f"  and {len(self.faults) - SHOWN} more of the same kinds")
            super().__init__("\n".join([f"{start}{len(self.faults)} faults", *lines]))


def grouped(faults: Sequence[Fault]) -> list[str]:
    """Texts of faults; equal ones of several lines are one."""
    lines: dict[tuple[str, str | None], list[Fault]] = {}
    for fault in faults:
        lines.setdefault((fault.text, fault.column), []).append(fault)
    found = []
    for (said, column), own in lines.items():
        numbers = ", ".join(str(fault.line) for fault in own[:SHOWN]) + (" …" if len(own) > SHOWN else "")
        found.append(str(own[0]) if len(own) == 1 else f"{len(own)} lines, {numbers}: {str(Fault(said, None, column))}")
    return found
