"""Files related to the FMU (FMI-LS-REF, beta): the manifest, the smoke test from the archive alone, and parameter sets as SSV files."""

import posixpath
import re
import shutil
import sys
import zipfile
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
import xmlschema
from conftest import ROOT
from fmpy.ssp import ssd
from lxml import etree

from pushbelt import InputFileError, StartValueError, cli, parameter_set
from pushbelt.fmu import start_values
from pushbelt.fmu.unit import Archive, Instance

sys.path.insert(0, str(ROOT / "fmu-build" / "python"))
import related_files as reference  # noqa: E402

PREFIX = "{http://fmi-standard.org/fmi-ls-manifest}fmi-ls-"
FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
ROLES = re.compile(
    "document|requirement|specification|model|parameter|system|testcase|experiment(/(smoke-test|validation|uncertainty-analysis))?|result"
    "|method|rationale|report|request|delivery|configuration|signature|serialized-state(/.*)?|meta-data|other"
)  # Roles of FMI-LS-REF 1.0.0-beta.1
PARAMETERS = ROOT / "resources" / "parameters"


@pytest.fixture(params=["fmu", "fmu3"])
def path(request: pytest.FixtureRequest) -> Path:
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
    version = (root.get(f"{PREFIX}name"), root.get(f"{PREFIX}version"))
    assert version == ("org.fmi-standard.fmi-ls-ref", "1.0.0-beta.1") and f"{PREFIX}description" in root.attrib and len(root.attrib) == 3
    assert all(one.tag == "Related" and set(one.attrib) == {"type", "source", "role", "description"} for one in root)
    assert [one.get("type") for one in root if one.get("role").startswith("experiment")] == ["application/x-ma-hs-experiments"]
    found = related(path)
    assert all(ROLES.fullmatch(role) for role, _ in found)
    assert {"experiment/smoke-test", "result", "parameter"} <= {role for role, _ in found}
    # The inputs belong to the experiment.
    listed = {name for _, name in found}
    assert listed <= set(names)
    assert {name for name in names if name.startswith(FOLDER)} - listed == {f"{FOLDER}/fmi-ls-manifest.xml", f"{FOLDER}/smoke-test-in.csv"}


def test_files_are_up_to_date(fmu: Path) -> None:
    """Written by `fmu-build/python/related_files.py`. The result is compared by the smoke test, within its tolerance."""
    folder = ROOT / "resources" / "reference"
    contents = reference.files(fmu)
    assert {one.name for one in folder.iterdir()} == set(contents)
    for name in set(contents) - {reference.REFERENCES}:
        assert (folder / name).read_bytes() == contents[name], name
    with zipfile.ZipFile(fmu) as archive:
        assert all(archive.read(f"{FOLDER}/{name}") == (folder / name).read_bytes() for name in contents)


@pytest.mark.parametrize(("kind", "given"), [("fmu", {}), ("fmu3", {}), ("fmu", {"initial.ratio": 1.7, "friction.pulley": 0.08, "ring.model": "ALE0"})])
def test_the_smoke_test_runs_from_the_archive_alone(kind: str, given: dict, variables: dict, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    """Runs the experiment as an importer does that has only the archive, or a copy with other start values, and compares its result."""
    path, folder = request.getfixturevalue(kind), tmp_path / "unpacked"
    if given:
        start_values.write_copy(path, tmp_path / "copy.fmu", start_values.checked(variables, given))
        path = tmp_path / "copy.fmu"
    shutil.unpack_archive(path, folder, "zip")
    (experiments,) = [folder / name for role, name in related(path) if role == "experiment/smoke-test"]
    variables = {variable.name: variable for variable in fmpy.read_model_description(str(folder)).modelVariables}
    page = (folder / "documentation" / "fmi-ls-ref.html").read_text(encoding="utf-8")
    (tolerance,) = map(float, re.findall(r'id="tolerance">([^<]+)<', page))
    assert tolerance == reference.TOLERANCE and "beta" in page
    root = etree.parse(str(experiments)).getroot()
    assert root.tag == "Experiments" and root.get("name") and len(root) > 0
    for experiment in root:
        sources = {one.tag: experiments.parent / one.get("source") for one in experiment}
        assert list(sources) == ["Parameters", "Stimuli", "References"], "the order of the schema"
        parameters = {parameter.name: parameter.value for parameter in ssd.read_ssv(str(sources["Parameters"])).parameters}
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


@pytest.mark.parametrize("name", ["bench168", "belt155", "chain168"])
def test_published_sets_are_up_to_date(name: str, description: Any, variables: dict[str, Any]) -> None:
    """Written by `fmu-build/python/related_files.py`; the schema is checked by another program too."""
    path = PARAMETERS / f"{name}.ssv"
    assert path.read_bytes() == reference.published(path.with_suffix(".json"), description)
    assert xmlschema.XMLSchema(str(Path(ssd.__file__).parent / "schema" / "SystemStructureParameterValues.xsd")).is_valid(str(path))
    assert start_values.read_ssv(path, variables) == parameter_set(name)


def test_all_types_are_written_and_read(tmp_path: Path, description: Any, variables: dict[str, Any]) -> None:
    values = {"ring.model": "ALE0", "initial.steady": False, "ring.layers": 7, "primary.torque": -12.5}
    path = tmp_path / "set.ssv"
    path.write_bytes(reference.set_of(values, description, "own"))
    assert start_values.read_ssv(path, variables) == {**values, "ring.model": 1}


@pytest.mark.parametrize(
    ("before", "after", "why"),
    [
        ("belt.play", "belt.colour", "belt.colour"), ('value="0.0002" unit="m"', 'value="0.0002" unit="mm"', "has the unit mm"),
        ('value="0.0002"', 'value="-1"', "out of its range"), ('value="0.0002"', 'value="much"', "schema"),
        ("</ssv:Parameters>", "", "set.ssv"), ('version="1.0"', 'version="1.0" colour="red"', "schema"),
    ],
)  # fmt: skip
def test_files_that_do_not_fit_are_refused(tmp_path: Path, variables: dict[str, Any], before: str, after: str, why: str) -> None:
    text = (PARAMETERS / "bench168.ssv").read_text(encoding="utf-8")
    assert before in text
    path = tmp_path / "set.ssv"
    path.write_text(text.replace(before, after, 1), encoding="utf-8")
    with pytest.raises((InputFileError, StartValueError), match=why):
        start_values.read_ssv(path, variables)


def test_the_command_takes_a_set(fmu: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy.fmu"
    assert cli.main(["fmu", str(copy), "--fmu", str(fmu), "--ssv", str(PARAMETERS / "belt155.ssv"), "--set", "belt.play=3e-4"]) == 0
    expected = {**parameter_set("belt155"), "belt.play": 3e-4}
    with Archive.unpack(copy) as archive, Instance(archive, {}) as unit:
        unit.initialise()
        assert {name: unit.get(name) for name in expected} == expected
