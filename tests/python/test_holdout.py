"""Scores of parameter sets on a table that they were not fitted to, and the origin that every report names."""

from __future__ import annotations

import csv
import hashlib
import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
import reports

from pushbelt import provenance
from pushbelt.calibrate import __main__ as calibrate
from pushbelt.calibrate import worker
from pushbelt.fmu.data import RESOURCES, parameter_set
from pushbelt.tables.points import Measured, Point

SPEED, FORCE = 190.0, 12e3


@pytest.fixture(scope="module")
def table(fmu: Path, archive: Any, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A table without noise of a variator with another friction, and its parameter set."""
    folder = tmp_path_factory.mktemp("holdout")
    document = json.loads((RESOURCES / "parameters" / "bench168.json").read_text(encoding="utf-8"))
    document["parameters"]["friction.pulley"]["value"] = 0.1
    fitted = folder / "fitted.json"
    fitted.write_text(json.dumps(document), encoding="utf-8")
    rows = ["i_geo;n_P [rad/s];T_P [Nm];F_S [kN];thrustRatio;slip [%]"]
    for ratio, torque in ((1.8, 40.0), (1.0, 55.0), (0.6, 35.0)):
        point = Point(0, "", ratio, None, SPEED, torque, FORCE, None, (Measured("slip", 0.0, 1.0, True),))
        found = worker.solve(fmu, archive.directory, parameter_set(str(fitted)), point)
        assert found.reason is None
        values = found.values["thrustRatio"], 100.0 * found.values["slip"]
        rows.append(";".join(f"{value!r}".replace(".", ",") for value in (ratio, SPEED, torque, FORCE / 1e3, *values)))
    path = folder / "rig.csv"
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path, fitted


def test_the_set_of_the_table_scores_better_than_the_default(fmu: Path, table: tuple[Path, Path], tmp_path: Path) -> None:
    path, fitted = table
    out = tmp_path / "out"
    words = [str(path), "--hold-out", str(fitted), "--fmu", str(fmu), "--output", str(out), "--workers", "1"]
    assert calibrate.main(words) == 0
    scores = {(s["quantity"], s["variator"]): s for s in json.loads((out / "holdout.json").read_text(encoding="utf-8"))}
    assert {quantity for quantity, _ in scores} == {"thrustRatio", "slip"}
    for quantity in ("thrustRatio", "slip"):
        assert scores[quantity, str(fitted)]["relative"] < 1e-3
        assert scores[quantity, "bench168"]["relative"] > 0.5
        assert (scores[quantity, "bench168"]["count"], scores[quantity, "bench168"]["lost"]) == (3, 0)
    with (out / "residuals.csv").open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    assert len(rows) == 6 and "measured [SI]" in header
    report = reports.stands_alone(out / "report.html")
    assert reports.figures(report) == 6
    # The origin: command, date, and hashes of the FMU, the table and the set.
    assert f"pushbelt calibrate {path} --hold-out {fitted}" in report
    for file in (fmu, path, fitted):
        assert hashlib.sha256(file.read_bytes()).hexdigest() in report
    reports.look_at(out / "report.html")


# Origin of reports


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
    if shutil.which("sha256sum") and shutil.which("find"):
        command = "find . -type f | LC_ALL=C sort | xargs -d '\\n' sha256sum | sha256sum"
        done = subprocess.run(["bash", "-c", command], cwd=tmp_path / "two", capture_output=True, text=True, check=True)
        assert done.stdout.split()[0] == provenance.hash_of_folder(tmp_path / "two")


def test_every_program_records_its_origin() -> None:
    """Each `main` begins a report's origin with its arguments."""
    for program in ("calibrate", "compare", "demo", "drive", "durability", "linearize", "maps", "sweep"):
        text = (Path(provenance.__file__).parent / program / "__main__.py").read_text(encoding="utf-8")
        assert f'provenance.begin("{program}", arguments' in text
