"""Writes files that the build packs into the FMU: those of FMI-LS-REF 1.0.0-beta.1, and the published parameter sets as SSV.

FMI-LS-REF is the layered standard of the Modelica Association for related files in an FMU; this version is a beta. It takes the format of
experiments from the harmonised specification ma-hs-experiments. Its files, a smoke test with its result, are in `resources/reference/`, and
in the FMU in `extra/org.fmi-standard.fmi-ls-ref/`.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.ssp import ssd
from lxml import etree

from pushbelt.fmu.files import RESOURCES, default_fmu
from pushbelt.fmu.geometry import Array
from pushbelt.fmu.start_values import checked

NAME = "org.fmi-standard.fmi-ls-ref"
VERSION = "1.0.0-beta.1"
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
ABOUT = "Layered Standard providing information on related files included in an FMU."
"""The description that the standard requires."""
FOLDER = f"extra/{NAME}"
"""Folder in the archive."""
MANIFEST, EXPERIMENTS = "fmi-ls-manifest.xml", "smoke-test.exp"
PARAMETERS, STIMULI, REFERENCES = "smoke-test.ssv", "smoke-test-in.csv", "smoke-test-ref.csv"
SSV_TYPE, EXPERIMENTS_TYPE, CSV_TYPE = "application/x-ssp-parameter-set", "application/x-ma-hs-experiments", "text/csv"
STOP, STEP, INTERVAL = 0.5, 1e-3, 1e-2
"""End of the smoke test, communication step and spacing of the results, s."""
TOLERANCE = 5e-3
"""Largest difference between results and reference, as a share of the largest absolute reference of the variable."""
INPUTS = {
    "primary.torque": (50.0, 50.0, 70.0, 70.0),
    "secondary.torque": (-49.0, -49.0, -60.0, -60.0),
    "primary.clampingForce": (13500.0, 13500.0, 15000.0, 15000.0),
    "secondary.clampingForce": (10000.0, 10000.0, 10000.0, 10000.0),
    "primary.speedSetpoint": (209.44,) * 4,
    "secondary.speedSetpoint": (209.44,) * 4,
}
"""Inputs at the times `TIMES`, linear between them."""
TIMES = (0.0, 0.1, 0.3, STOP)
OUTPUTS = (
    "primary.speed",
    "secondary.speed",
    "ratio.geometric",
    "thrustRatio",
    "belt.speed",
    "slip",
    "loss.total",
    "primary.axialForce",
    "secondary.axialForce",
    "pushForce.max",
    "ring.tensionMax",
)
SETS = {
    "bench168": "variator with a centre distance of 168 mm, as in the literature; these are the start values",
    "belt155": "variator with a centre distance of 155 mm",
    "chain168": "pull chain on the pulleys of bench168",
}
"""Published parameter sets and their descriptions."""


def files(fmu: Path) -> dict[str, bytes]:
    """Names and contents of the files. The result is that of the FMU."""
    description = fmpy.read_model_description(str(fmu))
    return {
        MANIFEST: manifest(),
        EXPERIMENTS: experiments(),
        PARAMETERS: parameters(description),
        STIMULI: table({"time": np.array(TIMES), **{name: np.array(values) for name, values in INPUTS.items()}}),
        REFERENCES: table(result(fmu)),
    }


def manifest() -> bytes:
    """The manifest: roles of all related files."""
    root = etree.Element("fmiReferences", nsmap={"fmi-ls": NAMESPACE})
    for key, value in (("name", NAME), ("version", VERSION), ("description", ABOUT)):
        root.set(f"{{{NAMESPACE}}}fmi-ls-{key}", value)
    page = "About these files, with the tolerance of the result"
    related = [
        (EXPERIMENTS_TYPE, EXPERIMENTS, "experiment/smoke-test", f"Shift and torque step of {STOP} s"),
        (CSV_TYPE, REFERENCES, "result", "Result of the smoke test"),
        (SSV_TYPE, PARAMETERS, "parameter", "All parameters of the smoke test"),
    ]
    related += [
        (SSV_TYPE, f"../../resources/{name}.ssv", "parameter", f"{name}: {about}") for name, about in SETS.items()
    ]
    related.append(("text/html", "../../documentation/fmi-ls-ref.html", "document", page))
    for kind, source, role, about in related:
        etree.SubElement(root, "Related", type=kind, source=source, role=role, description=about)
    return _text(root)


def experiments() -> bytes:
    """The smoke test."""
    root = etree.Element("Experiments", name="smoke-test", description="Basic check of the FMU in a new importer")
    experiment = etree.SubElement(
        root,
        "Experiment",
        name="shift",
        description="From a steady state at ratio 1, torque and clamping force grow and the belt shifts towards overdrive",
        startTime="0.0",
        stopTime=repr(STOP),
        stepSize=repr(STEP),
    )
    etree.SubElement(experiment, "Parameters", source=PARAMETERS)
    etree.SubElement(experiment, "Stimuli", source=STIMULI)
    etree.SubElement(experiment, "References", source=REFERENCES)
    return _text(root)


def parameters(description: Any) -> bytes:
    """Every parameter with its start value, so that the smoke test also holds in copies of the FMU with other start values."""
    values = {one.name: _start(one) for one in description.modelVariables if one.causality == "parameter"}
    return set_of(values, description, "smoke-test")


def _start(variable: Any) -> Any:
    if variable.type == "Boolean":
        return variable.start == "true"
    return float(variable.start) if variable.type == "Real" else int(variable.start)


def set_of(values: Mapping[str, Any], description: Any, name: str) -> bytes:
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
    ssd.validate_tree(etree.fromstring(text), "SystemStructureParameterValues.xsd")
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


def published(path: Path, description: Any) -> bytes:
    """The SSV file of a published variator."""
    document = json.loads(path.read_text(encoding="utf-8"))
    values = {name: entry["value"] for name, entry in document["parameters"].items()}
    return set_of(values, description, document["id"])


def result(fmu: Path) -> dict[str, Array]:
    """Time and outputs of the smoke test, run by fmpy with the start values of the FMU."""
    names = list(INPUTS)
    rows = [(time, *(INPUTS[name][k] for name in names)) for k, time in enumerate(TIMES)]
    found = fmpy.simulate_fmu(
        str(fmu),
        stop_time=STOP,
        # fmpy communicates at each output.
        output_interval=STEP,
        input=np.array(rows, dtype=[(name, float) for name in ("time", *names)]),
        output=list(OUTPUTS),
    )
    rows_of_interval = slice(None, None, round(INTERVAL / STEP))
    return {name: found[name][rows_of_interval] for name in ("time", *OUTPUTS)}


def table(columns: dict[str, Array]) -> bytes:
    """A CSV file with nine significant digits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([f"{value:.9g}" for value in row] for row in zip(*columns.values(), strict=True))
    return text.getvalue().encode()


def _text(root: etree._Element) -> bytes:
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def main() -> None:
    """Writes the files."""
    description = fmpy.read_model_description(str(RESOURCES.parent))
    for path in sorted((RESOURCES / "parameters").glob("*.json")):
        path.with_suffix(".ssv").write_bytes(published(path, description))
    folder = RESOURCES / "reference"
    folder.mkdir(exist_ok=True)
    for name, content in files(default_fmu()).items():
        (folder / name).write_bytes(content)


if __name__ == "__main__":
    main()
