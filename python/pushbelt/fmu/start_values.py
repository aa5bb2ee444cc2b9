"""The FMU's variables, a user's start values that are checked against them, also from SSV, and copies of the FMU."""

from __future__ import annotations

import hashlib
import math
import zipfile
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lxml import etree

from ..arguments import refused
from ..errors import PushbeltError, UnknownNameError, similar
from ..whole_file import copy_archive
from .results import dataframe
from .untrusted import named

if TYPE_CHECKING:
    import pandas

DESCRIPTION = "modelDescription.xml"
LIST = "resources/start-values.txt"  # File of start values that the library reads: one line `name = value` each
SHARED = len("{01234567-0123-0123-")
"""Characters of its GUID that a copy shares with the original. The library compares as many (`crates/fmi/src/start_values.rs`)."""
TRUTH = {"true": True, "1": True, "1.0": True, "false": False, "0": False, "0.0": False}
SETTABLE = ("parameter", "input")  # Causalities of variables with a start value that can be set


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
        low, high, nominal = (None if text is None else float(text) for text in (declared.min, declared.max, declared.nominal))
        items = declared.declaredType.items if declared.type == "Enumeration" else ()
        return cls(
            name=declared.name, type=declared.type, causality=declared.causality, variability=declared.variability,
            unit=declared.unit or "1", description=declared.description or "",
            start=None if declared.start is None else _read(declared, declared.start)[0],
            min=low, max=high, nominal=nominal, items={one.name: int(one.value) for one in items},
        )  # fmt: skip

    @property
    def facts(self) -> list[str]:
        """Start value, and the range, the items or the unit."""
        unit, found = "" if self.unit == "1" else f" {self.unit}", []
        if self.start is not None:
            named = {number: name for name, number in self.items.items()}
            shown = str(self.start) if self.type == "Boolean" else named.get(int(self.start), f"{self.start:g}")
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


class StartValueError(PushbeltError, ValueError):
    """A value that the FMU does not accept. The message contains the variable and the reason."""


def checked(variables: Mapping[str, Any], values: Mapping[str, Any], causalities: Collection[str] = SETTABLE) -> dict[str, float]:
    """The values converted to the types of their variables. Text may be a number, a Boolean or the name of an
    enumeration's item. Raises StartValueError for an unknown name, a wrong type, or a number out of range."""
    settable = {name: variable for name, variable in variables.items() if variable.causality in causalities}
    for name in (name for name in values if name not in settable):
        why = f": its causality is {variables[name].causality}" if name in variables else similar(name, settable)
        raise StartValueError(f"the FMU has no {' or '.join(causalities)} {name}{why}")
    return {name: _value(settable[name], value) for name, value in values.items()}


def _value(variable: Any, value: Any) -> float:
    found, wanted = _read(variable, value)
    if found is None:
        raise StartValueError(refused(variable.name, value, wanted))
    low = -math.inf if variable.min is None else float(variable.min)
    high = math.inf if variable.max is None else float(variable.max)
    if not low <= found <= high:
        unit = f" {variable.unit}" if variable.unit not in (None, "1") else ""
        raise StartValueError(f"{variable.name} = {found:g}{unit} is out of its range, {low:g} to {high:g}{unit}")
    return found


def _read(variable: Any, value: Any) -> tuple[float | None, str]:
    """A value in the type of its variable, or None and what is wanted."""
    if variable.type == "Boolean":
        return TRUTH.get(str(value).strip().lower()), "true or false"
    if variable.type == "Enumeration":
        items = {item.name: int(item.value) for item in variable.declaredType.items}
        numbers = {str(number): number for number in items.values()}
        whole = isinstance(value, (int, float)) and math.isfinite(value) and value == int(value)
        text = str(int(value)) if whole else str(value).removesuffix(".0")
        known = ", ".join(f"{name} ({number})" for name, number in items.items())
        return items.get(text, numbers.get(text)), f"one of {known}"
    if variable.type not in ("Real", "Integer"):
        return None, f"of use: the type {variable.type} cannot be set"
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        return None, "a finite number"
    if variable.type == "Real":
        return number, ""
    return int(number) if number == int(number) else None, "an integer"


def read_ssv(path: Path, variables: Mapping[str, Any]) -> dict[str, float]:
    """The values of an SSV file (System Structure Parameter Values 1.0), checked against the FMU's variables. Units must be those of the FMU.
    Raises InputFileError for another file, StartValueError for its values, OSError if it cannot be read."""
    from fmpy.ssp import ssd

    with named(path, "valid by the schema of SSV 1.0"):
        parameters = ssd.read_ssv(str(path)).parameters
    for one in parameters:
        own = variables[one.name].unit or "1" if one.name in variables else None
        if own is not None and (one.unit or own) != own:
            raise StartValueError(f"{path}: {one.name} has the unit {one.unit}; the unit of the FMU is {own}")
    try:
        return checked(variables, {one.name: one.value for one in parameters})
    except StartValueError as error:
        raise StartValueError(f"{path}: {error}") from error


def write_copy(fmu: Path, copy: Path, values: Mapping[str, float]) -> None:
    """Writes a copy of an FMU with other start values, which must be checked before, completely or not at all. The values are in the model
    description for importers, and in a list that the library reads, for importers that do not set start values. Those of an earlier copy
    remain unless they are specified again. The GUID is the copy's own: the library does not run it without its list, and importers that
    remember FMUs by their GUID tell copies apart."""
    with zipfile.ZipFile(fmu) as source:
        listed = _listed(source) | {name: _written(value) for name, value in values.items()}
    lines = [f"{name} = {value}" for name, value in listed.items()]
    head = "# Start values of this copy, read by the library. Written by `pushbelt fmu`."
    changed = {DESCRIPTION: edited(partial(_describe, values=values, lines=lines))} if lines else {}
    copy_archive(fmu, copy, changed, {LIST: ("\n".join([head, *lines]) + "\n").encode()} if lines else {})


def _listed(fmu: zipfile.ZipFile) -> dict[str, str]:
    """The list of start values in an earlier copy."""
    if LIST not in fmu.namelist():
        return {}
    lines = (line.strip() for line in fmu.read(LIST).decode("utf-8").splitlines())
    pairs = (line.partition("=") for line in lines if line and not line.startswith("#"))
    return {name.strip(): value.strip() for name, _, value in pairs}


def _written(value: float) -> str:
    """A value as text that is read back without loss."""
    return str(value).lower() if isinstance(value, bool) else repr(value)


def _describe(root: etree._Element, values: Mapping[str, float], lines: list[str]) -> None:
    """Sets other start values, and the GUID of a copy that has the list `lines`."""
    variables = {variable.get("name"): variable for variable in root.find("ModelVariables")}
    for name, value in values.items():
        # In FMI 2.0 the start value belongs to an element of the type inside the variable.
        kinds = [child for child in variables[name] if variables[name].tag == "ScalarVariable" and child.tag != "Annotations"]
        (kinds[0] if kinds else variables[name]).set("start", _written(value))
    digits = hashlib.sha256("\n".join(sorted(lines)).encode()).hexdigest()
    token = "guid" if "guid" in root.attrib else "instantiationToken"
    root.set(token, f"{root.get(token)[:SHARED]}{digits[:4]}-{digits[4:16]}}}")


def edited(*changes: Callable[[etree._Element], object]) -> Callable[[bytes], bytes]:
    """A function that changes an XML file."""

    def written(xml: bytes) -> bytes:
        root = etree.fromstring(xml)
        for change in changes:
            change(root)
        return etree.tostring(root, xml_declaration=True, encoding="UTF-8")

    return written
