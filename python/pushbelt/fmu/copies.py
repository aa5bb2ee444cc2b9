"""Copies of an FMU for importers that are stricter than the standard: outputs that are all Real, scalars instead of arrays of FMI 3.0, and
flat names. Only descriptions change, so the library, its values and its GUID are those of the original; parameter sets in the archive keep
their names. The library answers for the value references that the copies add (`crates/fmi/src/table.rs`).

For importers on ARM that look in `linux64` there is a copy with the library for ARM in that folder.
"""

import re
import zipfile
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path

from lxml import etree

from ..errors import ArgumentError
from ..whole_file import copy_archive
from .start_values import DESCRIPTION, edited

SCALARS = 1_000_000  # Added to the value reference of an element of an array: the element as a scalar of FMI 3.0
REALS = 2_000_000  # Added to the value reference of a truth value: 1 or 0 as a real number
REAL = "Real"  # End of the name of a truth value as a real number
REAL_TYPES = ("Real", "Float64")  # of FMI 2.0 and 3.0
TERMINALS = "terminalsAndIcons/terminalsAndIcons.xml"
ARM, LINUX = "binaries/aarch64-linux/", "binaries/linux64/"  # Folders of libraries in FMI 2.0


def with_real_outputs(description: etree._Element) -> None:
    """Makes outputs that are not real local variables. Each truth value among them, such as `macroSlip`, gets a real output of its own."""
    variables, structure = description.find("ModelVariables"), description.find("ModelStructure")
    for number, variable in enumerate(list(variables), start=1):
        kind = _kind(variable)
        if variable.get("causality") != "output" or kind.tag in REAL_TYPES:
            continue
        # FMI 2.0 counts variables, FMI 3.0 has their value references.
        key, own = ("valueReference", variable.get("valueReference")) if kind is variable else ("index", str(number))
        unknowns = [one for one in structure.iter("Unknown", "Output", "InitialUnknown") if one.get(key) == own]
        if kind.tag == "Boolean":
            variables.append(real := _as_real(variable))
            for one in unknowns:
                one.set(key, real.get(key, str(len(variables))))
                # The lists are in the order of the variables.
                if (last := one.getparent().findall(one.tag)[-1]) is not one:
                    last.addnext(one)
        else:
            for one in unknowns:
                one.getparent().remove(one)
        variable.set("causality", "local")


def _kind(variable: etree._Element) -> etree._Element:
    """The element whose tag is the type of a variable: in FMI 2.0 one within that of the variable."""
    return next(child for child in variable if child.tag != "Annotations") if variable.tag == "ScalarVariable" else variable


def _as_real(truth: etree._Element) -> etree._Element:
    """The real output for a truth value."""
    real = deepcopy(truth)
    real.set("name", truth.get("name") + REAL)
    real.set("valueReference", str(int(truth.get("valueReference")) + REALS))
    real.set("description", f"1 if {truth.get('name')} is true, otherwise 0")
    _kind(real).tag = "Real" if real.tag == "ScalarVariable" else "Float64"
    return real


def with_scalars(description: etree._Element) -> None:
    """Replaces each array of FMI 3.0 by its elements, whose names are those of FMI 2.0."""
    for array in list(description.find("ModelVariables").iter("Float64")):
        dimension = array.find("Dimension")
        if dimension is None:
            continue
        array.remove(dimension)
        for number in reversed(range(int(dimension.get("start")))):
            element = deepcopy(array)
            element.set("name", f"{array.get('name')}[{number + 1}]")
            element.set("valueReference", str(int(array.get("valueReference")) + SCALARS + number))
            element.set("description", f"Element {number + 1} of: {array.get('description')}")
            array.addnext(element)
        array.getparent().remove(array)


def flat(name: str) -> str:
    """`primary_torque` for `primary.torque`, for tools that read a dot as a structure."""
    return re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")


def with_flat_names(description: etree._Element) -> None:
    for one in [*description.find("ModelVariables"), *description.iter("Alias")]:
        one.set("name", flat(one.get("name")))
    description.set("variableNamingConvention", "flat")


def _with_flat_members(terminals: etree._Element) -> None:
    for member in terminals.iter("TerminalMemberVariable"):
        member.set("variableName", flat(member.get("variableName")))


def write_copy(fmu: Path, copy: Path, *changes: Callable[[etree._Element], None]) -> None:
    """Writes a copy with a changed description, completely or not at all. `copy` may be the FMU itself."""
    changed = {DESCRIPTION: edited(*changes)}
    if with_flat_names in changes:
        changed[TERMINALS] = edited(_with_flat_members)
    copy_archive(fmu, copy, changed, {})


def check_arm(fmu: Path, version: str) -> None:
    """Raises ArgumentError if an FMU has no library for Linux on ARM, or is of FMI 3.0, in which no importer looks elsewhere for it."""
    if version != "2.0":
        raise ArgumentError(f"--arm: {fmu} is of FMI {version}, in which importers on ARM look in aarch64-linux")
    with zipfile.ZipFile(fmu) as archive:
        if not any(name.startswith(ARM) for name in archive.namelist()):
            raise ArgumentError(f"--arm: {fmu} has no library for Linux on ARM; `cargo fmu build --portable --arm` builds an FMU that has")


def write_arm_copy(fmu: Path, copy: Path) -> None:
    """Writes a copy whose `linux64` has the library for ARM, completely or not at all. `copy` may be the FMU itself."""
    with zipfile.ZipFile(fmu) as source:
        names = source.namelist()
        libraries = {LINUX + name.removeprefix(ARM): source.read(name) for name in names if name.startswith(ARM)}
    copy_archive(fmu, copy, {}, {**{name: None for name in names if name.startswith(LINUX)}, **libraries})
