"""Reading of parameter sets as SSV files (System Structure Parameter Values 1.0), which other tools read and write."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fmpy.ssp import ssd
from lxml import etree

from .start_values import StartValueError, checked

SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SCHEMA = Path(ssd.__file__).parent / "schema" / "SystemStructureParameterValues.xsd"  # The schema that fmpy contains
LARGEST = 10_000_000  # Largest size of a file, bytes


def check(document: etree._Element) -> None:
    """Raises StartValueError if a document violates the schema."""
    checker = etree.XMLSchema(etree.parse(str(SCHEMA)))
    if not checker.validate(document):
        raise StartValueError(f"the file violates the schema of SSV 1.0: {checker.error_log.last_error}")


def read(path: Path, variables: Mapping[str, Any]) -> dict[str, float]:
    """The values of an SSV file, checked against the FMU's variables. Units must be those of the FMU. Raises
    StartValueError if the file cannot be used, OSError if it cannot be read."""
    content = path.read_bytes()
    if len(content) > LARGEST:
        raise StartValueError(f"{path} has more than {LARGEST} bytes")
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        root = etree.fromstring(content, parser)
        check(root)
        values = dict(_value(element, variables) for element in root.iter(f"{{{SSV}}}Parameter"))
        return checked(variables, values)
    except (etree.XMLSyntaxError, StartValueError) as error:
        raise StartValueError(f"{path}: {error}") from error


def _value(element: etree._Element, variables: Mapping[str, Any]) -> tuple[str, str]:
    name, kind = element.get("name", ""), element[0]
    variable, unit = variables.get(name), kind.get("unit")
    if variable is not None and unit not in (None, variable.unit or "1"):
        raise StartValueError(f"{name} has the unit {unit}; the unit of the FMU is {variable.unit or '1'}")
    return name, kind.get("value", "")
