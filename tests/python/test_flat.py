"""A copy of the FMU with flat names: nothing else differs, and importers find the same."""

from __future__ import annotations

import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

from pushbelt import cli
from pushbelt.fmu.flat import DESCRIPTION, KEYWORDS, TERMINALS, flat

OUTPUTS = ("thrustRatio", "primary.speed", "ratio.geometric", "profile.pushForce[7]")
START = {"ring.model": 1, "initial.ratio": 1.4, "primary.clampingForce": 15e3}


def written(copy: Path, fmu: Path, *words: str) -> Path:
    assert cli.main(["fmu", "--flat", str(copy), "--fmu", str(fmu), *words]) == 0
    return copy


def variables(xml: bytes) -> list[etree._Element]:
    root = etree.fromstring(xml).find("ModelVariables")
    return [*root, *root.iter("Alias")]


def test_names_are_identifiers_without_keywords_and_equal_ones() -> None:
    names = ["a.b", "a_b", "a[1]", "a[1,2].c", "initial", "end.", "der(x)", "slip"]
    assert list(flat(names).values()) == ["a_b", "a_b_", "a_1", "a_1_2_c", "initial_", "end_", "der_x", "slip"]


@pytest.mark.parametrize("kind", ["fmu", "fmu3", "map_fmu", "map_fmu3"])
def test_only_the_names_differ(kind: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    original = request.getfixturevalue(kind)
    copy = written(tmp_path / "flat.fmu", original)
    with zipfile.ZipFile(original) as one, zipfile.ZipFile(copy) as other:
        assert one.namelist() == other.namelist()
        differing = [name for name in one.namelist() if one.read(name) != other.read(name)]
        before, after = one.read(DESCRIPTION), other.read(DESCRIPTION)
        terminals = [etree.fromstring(z.read(TERMINALS)) for z in (one, other)] if TERMINALS in differing else []
    assert set(differing) <= {DESCRIPTION, TERMINALS}
    names = {a.get("name"): b.get("name") for a, b in zip(variables(before), variables(after), strict=True)}
    assert len(set(names.values())) == len(names) and not KEYWORDS.intersection(names.values())
    assert all(name.isidentifier() and name.isascii() and len(name) <= 63 for name in names.values())
    assert names["primary.torque"] == "primary_torque" and names["initial.ratio"] == "initial_ratio"
    # With the names put back, everything is as before: the GUID, references, units, descriptions.
    root = etree.fromstring(after)
    assert root.get("variableNamingConvention") == "flat"
    root.set("variableNamingConvention", "structured")
    for element, name in zip([*root.find("ModelVariables"), *root.iter("Alias")], names, strict=True):
        element.set("name", name)
    assert etree.tostring(root) == etree.tostring(etree.fromstring(before))
    if terminals:
        members = [[m.get("variableName") for m in root.iter("TerminalMemberVariable")] for root in terminals]
        assert members[1] == [names[name] for name in members[0]] and len(members[0]) > 5


def test_fmpy_finds_no_fault_and_the_same_results(fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    flat_fmu = written(tmp_path / "flat.fmu", fmu)
    assert validate_fmu(flat_fmu) == []
    names = flat([*OUTPUTS, *START])
    settings = {"stop_time": 0.02, "step_size": 1e-3, "output_interval": 1e-3}
    expected = fmpy.simulate_fmu(str(fmu), output=OUTPUTS, start_values=START, **settings)
    start = {names[name]: value for name, value in START.items()}
    found = fmpy.simulate_fmu(str(flat_fmu), output=[names[name] for name in OUTPUTS], start_values=start, **settings)
    for name in OUTPUTS:
        assert np.array_equal(found[names[name]], expected[name])
    assert np.ptp(expected["primary.speed"]) > 0.0
    capsys.readouterr()
    assert cli.main(["variables", "--kind", "output", "--fmu", str(flat_fmu)]) == 0
    said = capsys.readouterr().out
    assert "ratio_geometric" in said and "profile_pushForce" not in said, "listed without the fields"


def test_start_values_hold_under_flat_names(fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    copy = written(tmp_path / "own.fmu", fmu, "--set", "initial.ratio=1.4", "--set", "ring.model=ALE0")
    assert "2 start values, flat names" in capsys.readouterr().out
    assert not list(tmp_path.glob("*.part"))
    result = fmpy.simulate_fmu(str(copy), stop_time=2e-3, step_size=1e-3, output=["ratio_geometric"], apply_default_start_values=True)
    assert result["ratio_geometric"][0] == pytest.approx(1.4, rel=1e-6)
    # They can't be written afterwards: the library reads them by their names with dots.
    assert cli.main(["fmu", str(tmp_path / "again.fmu"), "--fmu", str(copy), "--set", "initial_ratio=1.2"]) == 1
    said = capsys.readouterr().err
    assert "own.fmu" in said and "--flat" in said and "original" in said and said.count("\n") == 1
