"""Files of FMI-LS-REF 1.0.0-alpha.1 in the FMU: a smoke test with its result, and the parameter sets.

FMI-LS-REF is the layered standard of the Modelica Association for related files in an FMU; this version is an alpha. `python -m
pushbelt.fmu.reference` writes the files to `resources/reference/`; the build packs them into `extra/org.fmi-standard.fmi-ls-ref/`.
"""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from lxml import etree

from . import ssv
from .files import RESOURCES, default_fmu
from .geometry import Array

NAME = "org.fmi-standard.fmi-ls-ref"
VERSION = "1.0.0-alpha.1"
NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
ABOUT = "Layered Standard providing information on related files included in an FMU."
"""The description that the standard requires."""
FOLDER = f"extra/{NAME}"
"""Folder in the archive."""
MANIFEST, EXPERIMENTS = "fmi-ls-manifest.xml", "smoke-test.exp"
PARAMETERS, STIMULI, REFERENCES = "smoke-test.ssv", "smoke-test-in.csv", "smoke-test-ref.csv"
SSV_TYPE, EXPERIMENTS_TYPE, CSV_TYPE = "application/x-ssp-parameter-set", "application/x-ma-ls-experiments", "text/csv"
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
    return ssv.text_of(values, description, "smoke-test")


def _start(variable: Any) -> Any:
    if variable.type == "Boolean":
        return variable.start == "true"
    return float(variable.start) if variable.type == "Real" else int(variable.start)


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
    folder = RESOURCES / "reference"
    folder.mkdir(exist_ok=True)
    for name, content in files(default_fmu()).items():
        (folder / name).write_bytes(content)


if __name__ == "__main__":
    main()
