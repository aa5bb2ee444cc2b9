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
    assert [(one.name, one.sha256) for one in found.inputs] == [(path.name, hashlib.sha256(b"x").hexdigest())]
    assert provenance.current("calibrate") is found
    assert provenance.current("sweep") is None
    assert provenance.begin("paper", [], "pushbelt_paper").command == "python -m pushbelt_paper"
    monkeypatch.setenv(provenance.COMMAND, "cargo fmu calibrate points.csv")
    monkeypatch.setattr("sys.argv", ["__main__.py", "points.csv"])
    assert provenance.begin("calibrate", None).command == "cargo fmu calibrate points.csv"
    # `pushbelt` passes the arguments on.
    assert provenance.begin("calibrate", ["points.csv"]).command == "pushbelt calibrate points.csv"


def test_folders_are_inputs_with_the_hash_of_their_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither the order in which files were made nor the results count."""
    monkeypatch.setattr(provenance, "_current", None)
    monkeypatch.chdir(tmp_path)
    for folder, names in (("one", ("b.csv", "a/z.csv", "B.csv")), ("two", ("B.csv", "b.csv", "a/z.csv")), ("one", ("out/report.html",))):
        for name in names:
            path = tmp_path / folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(name, encoding="utf-8")

    def inputs(*words: str) -> list[tuple[str, str]]:
        return [(one.name, one.sha256) for one in provenance.begin("compare", [*words, "--output=one/out"]).inputs]

    text = "".join(f"{hashlib.sha256(name.encode()).hexdigest()}  ./{name}\n" for name in ("B.csv", "a/z.csv", "b.csv"))
    same = hashlib.sha256(text.encode()).hexdigest()
    assert inputs("one") == [("one/", same)] and inputs("two", "--output", "one/out") == [("two/", same)]
    (tmp_path / "two" / "b.csv").write_text("changed", encoding="utf-8")
    assert inputs("two")[0][1] != same
    # A folder is no input because an option has its name.
    assert inputs("--one") == []


def test_every_program_records_its_origin(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its `main` begins a report's origin with its name and its arguments."""
    monkeypatch.setattr(provenance, "_current", None)
    for name in ("calibrate", "compare", "demo", "drive", "durability", "linearize", "maps", "sweep"):
        with pytest.raises(SystemExit):
            importlib.import_module(f"pushbelt.{name}.__main__").main(["--nonsense"])
        assert provenance.current(name).command == f"pushbelt {name} --nonsense"
