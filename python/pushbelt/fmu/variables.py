"""The table of the FMU's variables, with numbers instead of the texts of the model description."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from ..errors import UnknownNameError, similar
from .results import dataframe

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True, repr=False)
class Variable:
    name: str
    type: str  # `Real`, `Integer`, `Boolean` or `Enumeration`
    causality: str  # `parameter`, `input`, `output` or `local`
    variability: str  # `fixed`, `tunable`, `discrete` or `continuous`. A tunable parameter can be set during a run.
    unit: str  # Unit; `1` without one
    description: str
    start: float | None  # Start value. Booleans are True and False, enumerations have the number of an item.
    min: float | None
    max: float | None
    nominal: float | None
    items: Mapping[str, int]  # Names and numbers of an enumeration

    @classmethod
    def of(cls, declared: Any) -> Variable:
        """A variable of a model description that fmpy has read."""
        read = {"Boolean": lambda text: str(text).lower() in ("true", "1"), "Integer": int, "Enumeration": int}.get(declared.type, float)
        items = declared.declaredType.items if declared.type == "Enumeration" else ()
        return cls(
            **{name: getattr(declared, name) for name in ("name", "type", "causality", "variability")},
            unit=declared.unit or "1",
            description=declared.description or "",
            start=None if declared.start is None else read(declared.start),
            **{key: None if (text := getattr(declared, key)) is None else float(text) for key in ("min", "max", "nominal")},
            items={one.name: int(one.value) for one in items},
        )

    @property
    def facts(self) -> list[str]:
        """Start value, and the range, the items or the unit."""
        unit, found = "" if self.unit == "1" else f" {self.unit}", []
        if self.start is not None:
            named = {number: name for name, number in self.items.items()}
            shown = str(self.start) if self.type == "Boolean" else named.get(self.start, f"{self.start:g}")
            found.append(f"start {shown}{unit}")
        if self.items:
            found.append(f"one of {', '.join(self.items)}")
        elif self.min is not None and self.max is not None:
            found.append(f"range {self.min:g} to {self.max:g}{unit}")
        elif unit and self.start is None:
            found.append(self.unit)
        return found

    def __repr__(self) -> str:
        return f"<{self.name}: {', '.join([f'{self.variability} {self.causality}', *self.facts])}; {self.description}>"


class Variables(dict[str, Variable]):
    """The FMU's variables by name. An unknown name raises UnknownNameError with similar ones."""

    def __init__(self, declared: Iterable[Any]) -> None:
        super().__init__((one.name, Variable.of(one)) for one in declared)

    def __missing__(self, name: str) -> Variable:
        raise UnknownNameError(f"the FMU has no variable {name}{similar(name, self)}")

    def __repr__(self) -> str:
        counts = Counter(one.causality for one in self.values())
        return f"<Variables: {', '.join(f'{count} {kind}s' for kind, count in counts.items())}>"

    def to_dataframe(self) -> pandas.DataFrame:
        """A table over the names, with a column for each attribute. Needs `pushbelt[maps]`."""
        return dataframe([asdict(one) for one in self.values()]).set_index("name")
