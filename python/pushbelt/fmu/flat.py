"""A copy of an FMU with flat names: `primary_torque` instead of `primary.torque`, for tools that read a dot as a structure.

Only names change, so the library, its values and its GUID are those of the original. Parameter sets in the archive keep their names.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterable
from pathlib import Path

from lxml import etree

from ..whole_file import copy_archive
from .start_values import DESCRIPTION

TERMINALS = "terminalsAndIcons/terminalsAndIcons.xml"
KEYWORDS = frozenset(
    (
        # Modelica
        "algorithm and annotation block break class connect connector constant constrainedby der discrete each else elseif elsewhen encapsulated "
        "end enumeration equation expandable extends external false final flow for function if import impure in initial inner input loop model not "
        "operator or outer output package parameter partial protected public pure record redeclare replaceable return stream then true type when "
        "while within "
        # MATLAB, and words of C and Python that these lack
        "case catch classdef continue global otherwise parfor persistent spmd switch try auto char const default do double enum extern float goto "
        "inline int long register restrict short signed sizeof static struct typedef union unsigned void volatile as assert async await del elif "
        "except finally from is lambda nonlocal pass raise with yield"
    ).split()
)


def flat(names: Iterable[str]) -> dict[str, str]:
    """Flat names by name: identifiers of any language, no keyword, no two equal."""
    found: dict[str, str] = {}
    taken = set(KEYWORDS)
    for name in names:
        short = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")
        while short in taken:
            short += "_"
        taken.add(short)
        found[name] = short
    return found


def write_copy(fmu: Path, copy: Path) -> None:
    """Writes the copy, completely or not at all. `copy` may be the FMU itself."""
    with zipfile.ZipFile(fmu) as source:
        description = etree.fromstring(source.read(DESCRIPTION))
    variables = description.find("ModelVariables")
    named = [*variables, *variables.iter("Alias")]
    names = flat(one.get("name") for one in named)
    for one in named:
        one.set("name", names[one.get("name")])
    description.set("variableNamingConvention", "flat")
    changed = {DESCRIPTION: lambda _: _written(description), TERMINALS: lambda xml: _terminals(xml, names)}
    copy_archive(fmu, copy, changed, {})


def _terminals(xml: bytes, names: dict[str, str]) -> bytes:
    root = etree.fromstring(xml)
    for member in root.iter("TerminalMemberVariable"):
        member.set("variableName", names[member.get("variableName")])
    return _written(root)


def _written(root: etree._Element) -> bytes:
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8")
