"""The origin that every report names: command, date, and hashes of what was read."""

import hashlib
import importlib
from pathlib import Path

import pytest

from pushbelt import provenance


def test_the_command_can_be_pasted_into_a_shell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is that of the tool that started the program, if another did."""
    monkeypatch.setattr(provenance, "_current", None)
    path = tmp_path / "my table.csv"
    path.write_bytes(b"x")
    found = provenance.begin("calibrate", [str(path), "--map", "i=ratio.geometric"])
    assert found.command == f"pushbelt calibrate '{path}' --map i=ratio.geometric"
    assert found.inputs == {hashlib.sha256(b"x").hexdigest(): path.name}
    assert provenance.current("calibrate") is found
    assert provenance.current("sweep") is None
    assert provenance.begin("paper", [], "pushbelt_paper").command == "python -m pushbelt_paper"
    monkeypatch.setenv(provenance.COMMAND, "cargo fmu calibrate points.csv")
    monkeypatch.setattr("sys.argv", ["__main__.py", "points.csv"])
    assert provenance.begin("calibrate", None).command == "cargo fmu calibrate points.csv"
    # `pushbelt` passes the arguments on.
    assert provenance.begin("calibrate", ["points.csv"]).command == "pushbelt calibrate points.csv"


def test_runs_of_folders_are_inputs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(provenance, "_current", None)
    monkeypatch.chdir(tmp_path)
    for folder in ("one", "out"):
        (tmp_path / folder).mkdir()
        for name in ("b.csv", "a.csv", "report.html"):
            (tmp_path / folder / name).write_text(f"{folder}, {name}", encoding="utf-8")
    expected = [(f"one/{name}", hashlib.sha256(f"one, {name}".encode()).hexdigest()) for name in ("a.csv", "b.csv")]
    for words in (["one", "out", "--output=out"], ["one", "one/a.csv", "--output", "out", "--out"]):
        assert [(name, sha256) for sha256, name in provenance.begin("compare", words).inputs.items()] == expected


def test_every_program_records_its_origin(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its `main` begins a report's origin with its name and its arguments."""
    monkeypatch.setattr(provenance, "_current", None)
    for name in ("calibrate", "compare", "demo", "drive", "durability", "linearize", "maps", "sweep"):
        with pytest.raises(SystemExit):
            importlib.import_module(f"pushbelt.{name}.__main__").main(["--nonsense"])
        assert provenance.current(name).command == f"pushbelt {name} --nonsense"
