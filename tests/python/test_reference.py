"""Related files in the FMU (FMI-LS-REF, alpha): the manifest, and the smoke test from the archive alone."""

from __future__ import annotations

import posixpath
import re
import sys
import zipfile
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from conftest import ROOT
from fmpy.ssp.ssd import read_ssv
from lxml import etree

from pushbelt.fmu.start_values import checked, write_copy

sys.path.insert(0, str(ROOT / "fmu-build" / "python"))
import related_files as reference  # noqa: E402

PREFIX = "{http://fmi-standard.org/fmi-ls-manifest}fmi-ls-"
FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
ROLES = re.compile(
    "document|requirement|specification|model|parameter|system|testcase|experiment(/(smoke-test|validation|uncertainty-analysis))?|result"
    "|method|rationale|report|request|delivery|configuration|signature|serialized-state(/.*)?|other"
)
"""Roles of FMI-LS-REF 1.0.0-alpha.1."""


@pytest.fixture(params=["fmu", "fmu3"])
def path(request: pytest.FixtureRequest) -> Path:
    """The FMU of each version."""
    return request.getfixturevalue(request.param)


def related(path: Path) -> list[tuple[str, str]]:
    """Roles, and paths in the archive."""
    with zipfile.ZipFile(path) as archive:
        root = etree.fromstring(archive.read(f"{FOLDER}/fmi-ls-manifest.xml"))
    return [(one.get("role"), posixpath.normpath(f"{FOLDER}/{one.get('source')}")) for one in root.findall("Related")]


def test_the_manifest_is_that_of_the_standard(path: Path) -> None:
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        root = etree.fromstring(archive.read(f"{FOLDER}/fmi-ls-manifest.xml"))
    assert root.tag == "fmiReferences"
    assert dict(root.attrib) == {
        f"{PREFIX}name": "org.fmi-standard.fmi-ls-ref",
        f"{PREFIX}version": "1.0.0-alpha.1",
        f"{PREFIX}description": "Layered Standard providing information on related files included in an FMU.",
    }
    assert {one.tag for one in root} == {"Related"}
    assert all(set(one.attrib) == {"type", "source", "role", "description"} for one in root)
    found = related(path)
    assert all(ROLES.fullmatch(role) for role, _ in found)
    assert {"experiment/smoke-test", "result", "parameter"} <= {role for role, _ in found}
    assert {name for _, name in found} <= set(names)
    unlisted = {name for name in names if name.startswith(FOLDER)} - {name for _, name in found}
    # The inputs belong to the experiment.
    assert unlisted == {f"{FOLDER}/fmi-ls-manifest.xml", f"{FOLDER}/smoke-test-in.csv"}


def test_files_are_up_to_date(fmu: Path) -> None:
    """Written by `fmu-build/python/related_files.py`. The result is compared by the smoke test, within its tolerance."""
    folder = ROOT / "resources" / "reference"
    contents = reference.files(fmu)
    assert {one.name for one in folder.iterdir()} == set(contents)
    for name in set(contents) - {reference.REFERENCES}:
        assert (folder / name).read_bytes() == contents[name], name
    with zipfile.ZipFile(fmu) as archive:
        assert all(archive.read(f"{FOLDER}/{name}") == (folder / name).read_bytes() for name in contents)


def test_the_smoke_test_runs_from_the_archive_alone(path: Path, tmp_path: Path) -> None:
    smoke_test(path, tmp_path)


def test_it_also_holds_for_a_copy_with_other_start_values(fmu: Path, variables: dict[str, Any], tmp_path: Path) -> None:
    copy = tmp_path / "copy.fmu"
    write_copy(fmu, copy, checked(variables, {"initial.ratio": 1.7, "friction.pulley": 0.08, "ring.model": "ALE0"}))
    smoke_test(copy, tmp_path)


def smoke_test(path: Path, folder: Path) -> None:
    """Runs the experiment as an importer does that has only the archive, and compares its result."""
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    (experiments,) = [folder / name for role, name in related(path) if role == "experiment/smoke-test"]
    variables = {variable.name: variable for variable in fmpy.read_model_description(str(folder)).modelVariables}
    page = (folder / "documentation" / "fmi-ls-ref.html").read_text(encoding="utf-8")
    (tolerance,) = map(float, re.findall(r'id="tolerance">([^<]+)<', page))
    assert tolerance == reference.TOLERANCE and "alpha" in page
    root = etree.parse(str(experiments)).getroot()
    assert root.tag == "Experiments" and root.get("name") and len(root) > 0
    for experiment in root:
        sources = {one.tag: experiments.parent / one.get("source") for one in experiment}
        assert list(sources) == ["Parameters", "Stimuli", "References"], "the order of the schema"
        parameters = {parameter.name: parameter.value for parameter in read_ssv(str(sources["Parameters"])).parameters}
        assert set(parameters) == {name for name, one in variables.items() if one.causality == "parameter"}
        expected = fmpy.util.read_csv(sources["References"])
        outputs = [name for name in expected.dtype.names if name != "time"]
        found = fmpy.simulate_fmu(
            str(folder), start_time=float(experiment.get("startTime")), stop_time=float(experiment.get("stopTime")),
            output_interval=float(experiment.get("stepSize")), input=fmpy.util.read_csv(sources["Stimuli"]), output=outputs,
            start_values={name: numbered(value, variables[name]) for name, value in parameters.items()},
        )  # fmt: skip
        assert found["time"][-1] == pytest.approx(expected["time"][-1])
        for name in outputs:
            values = np.interp(expected["time"], found["time"], found[name])
            assert np.abs(values - expected[name]).max() <= tolerance * np.abs(expected[name]).max(), name


def numbered(value: str, variable: Any) -> Any:
    """A value as fmpy takes it: enumerations by number."""
    if variable.type == "Enumeration":
        return next(int(item.value) for item in variable.declaredType.items if item.name == value)
    return value == "true" if variable.type == "Boolean" else float(value)
