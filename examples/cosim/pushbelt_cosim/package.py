"""The system as a package `drive.ssp` (System Structure and Parameterization 1.0).

The table `WIRES` lists the connections. A variable has the same name in every unit.
"""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import fmpy
from fmpy.ssp import ssd as fmpy_ssd
from lxml import etree

SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SCHEMAS = Path(fmpy_ssd.__file__).parent / "schema"

WIRES = (
    ("vehicle", "variator", ("primary.torque", "secondary.torque")),
    ("control", "variator", ("primary.pressure", "secondary.pressure")),
    ("variator", "vehicle", ("primary.speed", "secondary.speed", "ratio.geometric")),
    (
        "variator",
        "control",
        ("primary.speed", "secondary.speed", "ratio.geometric", "primary.radius", "slip", "macroSlip"),
    ),
    ("vehicle", "control", ("torque.estimated", "power.demand")),
)
"""Connections: source, sink, variables."""
UNITS: Mapping[str, Mapping[str, str]] = {
    "1": {},
    "m": {"m": "1"},
    "rad/s": {"rad": "1", "s": "-1"},
    "Pa": {"kg": "1", "m": "-1", "s": "-2"},
    "N.m": {"kg": "1", "m": "2", "s": "-2"},
    "W": {"kg": "1", "m": "2", "s": "-3"},
}
"""Units by the exponents of base units."""
UNIT_OF = {
    "torque": "N.m",
    "pressure": "Pa",
    "speed": "rad/s",
    "radius": "m",
    "estimated": "N.m",
    "demand": "W",
}
"""Units by the last part of a variable's name. Other variables have the unit 1."""
PARAMETER_SET = "start"
"""Name of the parameter set of every unit. ecos selects a parameter set by its name."""

Values = Mapping[str, float | bool]


@dataclass(frozen=True)
class Component:
    """A unit of the system."""

    fmu: Path
    parameters: Values
    """Start values by name. The Python type (Boolean, integer or real number) must match the type in the FMU."""


def write(path: Path, components: Mapping[str, Component], stop: float) -> None:
    """Writes the package of a system that runs from 0 to `stop` seconds. Raises ValueError if it violates the schema."""
    root = etree.Element(
        f"{{{SSD}}}SystemStructureDescription", nsmap={"ssd": SSD, "ssc": SSC, "ssv": SSV}, version="1.0", name="drive"
    )
    system = etree.SubElement(root, f"{{{SSD}}}System", name="drive", description="A car on the WLTC")
    elements = etree.SubElement(system, f"{{{SSD}}}Elements")
    for name, component in components.items():
        _component(elements, name, component)
    connections = etree.SubElement(system, f"{{{SSD}}}Connections")
    for source, sink, variables in WIRES:
        for variable in variables:
            ends = {"startElement": source, "startConnector": variable, "endElement": sink, "endConnector": variable}
            etree.SubElement(connections, f"{{{SSD}}}Connection", ends)
    units = etree.SubElement(root, f"{{{SSD}}}Units")
    for name, exponents in UNITS.items():
        unit = etree.SubElement(units, f"{{{SSC}}}Unit", name=name)
        etree.SubElement(unit, f"{{{SSC}}}BaseUnit", dict(exponents))
    etree.SubElement(root, f"{{{SSD}}}DefaultExperiment", startTime="0.0", stopTime=f"{stop:.17g}")
    validate(root, "SystemStructureDescription")

    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("SystemStructure.ssd", _text(root))
        for name, component in components.items():
            values = parameter_set(component)
            validate(values, "SystemStructureParameterValues")
            archive.writestr(f"resources/{name}.ssv", _text(values))
            archive.write(component.fmu, f"resources/{component.fmu.name}")


def _component(parent: etree._Element, name: str, component: Component) -> None:
    attributes = {"name": name, "type": "application/x-fmu-sharedlibrary", "source": f"resources/{component.fmu.name}"}
    element = etree.SubElement(parent, f"{{{SSD}}}Component", attributes, implementation="CoSimulation")
    connectors = etree.SubElement(element, f"{{{SSD}}}Connectors")
    types = {variable.name: variable.type for variable in fmpy.read_model_description(component.fmu).modelVariables}
    for variable, kind in _connectors(name).items():
        connector = etree.SubElement(connectors, f"{{{SSD}}}Connector", name=variable, kind=kind)
        if types[variable] == "Real":
            etree.SubElement(connector, f"{{{SSC}}}Real", unit=UNIT_OF.get(variable.rsplit(".", 1)[-1], "1"))
        else:
            etree.SubElement(connector, f"{{{SSC}}}{types[variable]}")
    bindings = etree.SubElement(element, f"{{{SSD}}}ParameterBindings")
    etree.SubElement(bindings, f"{{{SSD}}}ParameterBinding", source=f"resources/{name}.ssv")


def _connectors(unit: str) -> dict[str, str]:
    """Connected variables of a unit, each with its causality, input or output."""
    found = {}
    for source, sink, variables in WIRES:
        if unit in (source, sink):
            found.update(dict.fromkeys(variables, "output" if unit == source else "input"))
    return found


def parameter_set(component: Component) -> etree._Element:
    """The start values of a component, as a document."""
    types = {variable.name: variable.type for variable in fmpy.read_model_description(component.fmu).modelVariables}
    root = etree.Element(f"{{{SSV}}}ParameterSet", nsmap={"ssv": SSV, "ssc": SSC}, version="1.0", name=PARAMETER_SET)
    parameters = etree.SubElement(root, f"{{{SSV}}}Parameters")
    for variable, value in component.parameters.items():
        parameter = etree.SubElement(parameters, f"{{{SSV}}}Parameter", name=variable)
        kind = types[variable]
        text = {
            "Real": lambda value: f"{value:.17g}",
            "Integer": lambda value: f"{value:.0f}",
            "Boolean": lambda value: str(bool(value)).lower(),
        }[kind](value)
        etree.SubElement(parameter, f"{{{SSV}}}{kind}", value=text)
    return root


def validate(document: etree._Element, schema: str) -> None:
    """Checks a document against the schema of SSP 1.0 that fmpy contains. Raises ValueError with the first error."""
    checker = etree.XMLSchema(etree.parse(str(SCHEMAS / f"{schema}.xsd")))
    # The written bytes are parsed again, so that the check covers the file itself.
    if not checker.validate(etree.fromstring(_text(document))):
        raise ValueError(f"{schema}: {checker.error_log.last_error}")


def _text(document: etree._Element) -> bytes:
    return etree.tostring(document, xml_declaration=True, encoding="UTF-8", pretty_print=True)
