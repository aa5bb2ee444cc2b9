"""Parameter sets as SSV files (System Structure Parameter Values 1.0), which other tools read and write.

`python -m pushbelt.fmu.ssv` writes those of the published variators beside their JSON files.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import fmpy
from fmpy.ssp import ssd
from lxml import etree

from .files import RESOURCES
from .start_values import StartValueError, checked

SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SCHEMA = Path(ssd.__file__).parent / "schema" / "SystemStructureParameterValues.xsd"
"""The schema that fmpy contains."""
LARGEST = 10_000_000
"""Largest size of a file, bytes."""


def text_of(values: Mapping[str, Any], description: Any, name: str) -> bytes:
    """The content of an SSV file with these values, whose units, types and enumerations are those of a model description.

    Raises StartValueError for an unknown name, a wrong type, or a number out of range.
    """
    variables = {variable.name: variable for variable in description.modelVariables}
    root = etree.Element(f"{{{SSV}}}ParameterSet", nsmap={"ssv": SSV, "ssc": SSC}, version="1.0", name=name)
    parameters = etree.SubElement(root, f"{{{SSV}}}Parameters")
    units, enumerations = {}, {}
    for parameter, value in checked(variables, values).items():
        variable = variables[parameter]
        element = etree.SubElement(parameters, f"{{{SSV}}}Parameter", name=parameter)
        kind = etree.SubElement(element, f"{{{SSV}}}{variable.type}")
        if variable.type == "Real":
            kind.set("value", repr(float(value)))
            kind.set("unit", variable.unit)
            units[variable.unit] = next(unit for unit in description.unitDefinitions if unit.name == variable.unit)
        elif variable.type == "Enumeration":
            items = variable.declaredType.items
            kind.set("value", next(item.name for item in items if int(item.value) == value))
            kind.set("name", variable.declaredType.name)
            enumerations[variable.declaredType.name] = items
        else:
            kind.set("value", str(value).lower())
    _define(root, units, enumerations)
    text = etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)
    _check(etree.fromstring(text))
    return text


def _define(root: etree._Element, units: Mapping[str, Any], enumerations: Mapping[str, Any]) -> None:
    """Adds the definitions of enumerations and units."""
    if enumerations:
        group = etree.SubElement(root, f"{{{SSV}}}Enumerations")
        for name, items in enumerations.items():
            enumeration = etree.SubElement(group, f"{{{SSC}}}Enumeration", name=name)
            for item in items:
                etree.SubElement(enumeration, f"{{{SSC}}}Item", name=item.name, value=str(item.value))
    if units:
        group = etree.SubElement(root, f"{{{SSV}}}Units")
        for name, unit in units.items():
            element = etree.SubElement(group, f"{{{SSC}}}Unit", name=name)
            base = etree.SubElement(element, f"{{{SSC}}}BaseUnit")
            for exponent in ("kg", "m", "s", "rad"):
                if power := int(getattr(unit.baseUnit, exponent, 0) or 0) if unit.baseUnit is not None else 0:
                    base.set(exponent, str(power))


def _check(document: etree._Element) -> None:
    checker = etree.XMLSchema(etree.parse(str(SCHEMA)))
    if not checker.validate(document):
        raise StartValueError(f"the file violates the schema of SSV 1.0: {checker.error_log.last_error}")


def read(path: Path, variables: Mapping[str, Any]) -> dict[str, float]:
    """The values of an SSV file, checked against the FMU's variables. Units must be those of the FMU.

    Raises StartValueError if the file cannot be used, OSError if it cannot be read.
    """
    content = path.read_bytes()
    if len(content) > LARGEST:
        raise StartValueError(f"{path} has more than {LARGEST} bytes")
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        root = etree.fromstring(content, parser)
        _check(root)
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


def published(path: Path, description: Any) -> bytes:
    """The SSV file of a published variator."""
    document = json.loads(path.read_text(encoding="utf-8"))
    values = {name: entry["value"] for name, entry in document["parameters"].items()}
    return text_of(values, description, document["id"])


def main() -> None:
    """Writes the files of the published variators."""
    description = fmpy.read_model_description(str(RESOURCES.parent))
    for path in sorted((RESOURCES / "parameters").glob("*.json")):
        path.with_suffix(".ssv").write_bytes(published(path, description))


if __name__ == "__main__":
    main()
