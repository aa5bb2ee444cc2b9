"""Parameter sets as SSV files: those of the published variators, and copies of the FMU with others."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest
import xmlschema
from conftest import ROOT
from fmpy.ssp.ssd import read_ssv

from pushbelt import cli
from pushbelt.fmu import ssv
from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.start_values import StartValueError
from pushbelt.fmu.unit import Archive, Instance

sys.path.insert(0, str(ROOT / "fmu-build" / "python"))
import related_files  # noqa: E402

FOLDER = ROOT / "resources" / "parameters"


@pytest.mark.parametrize("name", ["bench168", "belt155", "chain168"])
def test_published_sets_are_up_to_date(name: str, description: Any, variables: dict[str, Any]) -> None:
    """Written by `fmu-build/python/related_files.py`; the schema is checked by another program too."""
    path = FOLDER / f"{name}.ssv"
    assert path.read_bytes() == related_files.published(path.with_suffix(".json"), description)
    assert xmlschema.XMLSchema(str(ssv.SCHEMA)).is_valid(str(path))
    assert ssv.read(path, variables) == parameter_set(name)


def test_another_reader_reads_the_same(description: Any) -> None:
    found = read_ssv(str(FOLDER / "bench168.ssv"))
    document = json.loads((FOLDER / "bench168.json").read_text(encoding="utf-8"))["parameters"]
    values = {parameter.name: float(parameter.value) for parameter in found.parameters}
    assert values == {name: float(entry["value"]) for name, entry in document.items()}
    assert {variable.name for variable in description.modelVariables} >= values.keys()


def test_all_types_are_written_and_read(tmp_path: Path, description: Any, variables: dict[str, Any]) -> None:
    values = {"ring.model": "ALE0", "initial.steady": False, "ring.layers": 7, "primary.torque": -12.5}
    path = tmp_path / "set.ssv"
    path.write_bytes(related_files.set_of(values, description, "own"))
    assert ssv.read(path, variables) == {**values, "ring.model": 1}


@pytest.mark.parametrize(
    ("before", "after", "why"),
    [
        ("belt.play", "belt.colour", "belt.colour"),
        ('value="0.0002" unit="m"', 'value="0.0002" unit="mm"', "has the unit mm"),
        ('value="0.0002"', 'value="-1"', "out of its range"),
        ('value="0.0002"', 'value="much"', "schema"),
        ("</ssv:Parameters>", "", "set.ssv"),
        ('version="1.0"', 'version="1.0" colour="red"', "schema"),
    ],
)
def test_files_that_do_not_fit_are_refused(
    tmp_path: Path, variables: dict[str, Any], before: str, after: str, why: str
) -> None:
    text = (FOLDER / "bench168.ssv").read_text(encoding="utf-8")
    assert before in text
    path = tmp_path / "set.ssv"
    path.write_text(text.replace(before, after, 1), encoding="utf-8")
    with pytest.raises(StartValueError, match=why):
        ssv.read(path, variables)


def test_the_command_takes_a_set(fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    copy = tmp_path / "copy.fmu"
    words = ["fmu", str(copy), "--fmu", str(fmu), "--ssv", str(FOLDER / "belt155.ssv"), "--set", "belt.play=3e-4"]
    assert cli.main(words) == 0
    expected = {**parameter_set("belt155"), "belt.play": 3e-4}
    with Archive.unpack(copy) as archive, Instance(archive, {}) as unit:
        unit.initialise()
        assert {name: unit.get(name) for name in expected} == expected
    capsys.readouterr()
    assert cli.main([*words[:4], "--ssv", str(tmp_path / "none.ssv")]) == 1
    assert "none.ssv" in capsys.readouterr().err
