"""Words of the command line that the programs refuse: one line names them, and nothing is written."""

from __future__ import annotations

import importlib.metadata
import sys
from pathlib import Path

import pytest
from conftest import WORDS
from test_console import TABLE

import pushbelt
from pushbelt import cli
from pushbelt.maps.data import Maps

BASE = {
    "belt": "--width 30 --layers 12 --element-thickness 1.5 --length 0.70 --center-distance 0.17",
    "durability": "run.csv", "linearize": "", "maps": "", "sweep": "",
}  # fmt: skip
REFUSED = {
    "belt": [
        ("--length 700", "length of the belt is 700 m"), ("--ratio 3.2", "0.386 to 2.591"), ("--ratio nan", "0.386 to 2.591"),
        ("--set belt.colour=1", "belt.colour"), ("--strength 2e9", "strength of the steel: 2e+09 MPa"),
        ("--limit 2.1GPa", "limit of the steel: 2100 MPa"), ("--stress-safety 0.1", "safety of the steel: 0.1"),
        ("--safety 0.1", "safety of the load case: 0.1"), ("--rpm 0", "speed of the load case: 0 rad/s"),
        ("--torque nan", "torque of the load case: nan N.m"), ("--element-mass 60", "is 0.06 kg"), ("--young 400", "is 4e+11 Pa"),
        ("--wedge-angle 45", "is 0.785398 rad"),
    ],
    "durability": [
        ("--strength 2e9", "strength of the steel: 2e+09 MPa"), ("--limit 6e8", "limit of the steel: 6e+08 MPa"),
        ("--strength 2e9Pa --limit 2500MPa", "limit of the steel: 2500 MPa"), ("--knee 10", "knee of the steel: 10"),
        ("--variator chain168", "belt.kind = 2"), ("--slope nan", "slope of the steel: nan"), ("--safety 0.1", "safety of the steel: 0.1"),
    ],
    "linearize": [
        ("initial.ratio", "initial.ratio"), ("initial.ratio=one", "initial.ratio = 'one'"), ("initial.ratio=nan", "ratio = nan"),
        ("initial.ratio=1 initial.ratio=2", "initial.ratio appears twice"), ("initial.ratio=1:2:0", "initial.ratio = '1:2:0'"),
        ("secondary.torque=-1,-2", "secondary.torque"), ("ring.model=ALE0,ALE9", "ring.model = 'ALE9'"), ("initial.ratoi=1", "initial.ratio"),
        ("initial.primarySpeed=0", "0 rad/s"), ("--frequency 0", "frequency = 0 Hz"), ("--safety 0.1", "--safety 0.1"),
        ("--safety 1.3 secondary.clampingForce=9000", "secondary.clampingForce"), (f"--outputs sleep {' '.join(WORDS)}", "sleep"),
        # An earlier version returned a model at a slip of 0.81 here, with the default ring and mesh.
        ("initial.ratio=1 primary.torque=400", "no steady state at ratio 1, 400 N·m, 209.44 rad/s and 10000 N"),
        (f"initial.ratio=1 primary.torque=60 primary.clampingForce=20000 {' '.join(WORDS)}", " N, but 20000 N is specified"),
        ("--variator bench169", "bench169"), (f"--sample-time 0 {' '.join(WORDS)}", "sample_time = 0 s"),
    ],
    "maps": [("--speed 0", "speed must be positive"), ("--set belt.colour=1", "belt.colour"), ("--ratios 1", "two ratios")],
    "sweep": [
        ("--vary belt.play=1e-4:2e-4", "belt.play"), ("--vary belt.play=1e-4 --samples 5", "--samples"),
        ("--vary belt.play=1e-4 --short", "--short"), ("--samples 5", "--samples"), ("--points points.csv --ratio 1", "--points"),
        ("--vary belt.play=1e-4 --set belt.play=1e-4", "belt.play"), ("--print-job", "--print-job"), ("--slurm jobs=1 --workers 1", "--slurm"),
        ("--force 12 --ratio 1 --utilisation 0.3,0.6", "12 kN are 12000 N"), ("--vary primary.torque=20:90:4 --force 9", "9 kN are 9000 N"),
        ("--vary primary.torque=8000,9000 --force 12e3", "8000 N·mm are 8 N·m"),
    ],
}  # fmt: skip


@pytest.mark.parametrize(("program", "words", "named"), [(program, *one) for program, rows in REFUSED.items() for one in rows])
def test_what_is_refused_is_named(
    program: str, words: str, named: str, fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = tmp_path / "out"
    assert cli.main([program, "--fmu", str(fmu), "--output", str(output), *BASE[program].split(), *words.split()]) == 1
    said = capsys.readouterr().err
    assert named in said and said.count("\n") <= 2 and "Traceback" not in said
    assert not list(output.rglob("*.*"))


@pytest.mark.parametrize("kind", ["map_fmu", "fmu3"])
@pytest.mark.parametrize(
    "words",
    ["belt " + BASE["belt"], "calibrate t.csv", "calibrate t.csv --hold-out belt155", "demo", "durability t.csv", "linearize", "maps", "sweep"],
)
def test_an_fmu_that_does_not_run_the_belt_is_named(
    words: str, kind: str, request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """In one line, before anything is solved."""
    monkeypatch.chdir(tmp_path)
    Path("t.csv").write_text(TABLE, encoding="utf-8")
    fmu = request.getfixturevalue(kind)
    assert cli.main([*words.split(), "--fmu", str(fmu)]) == 1
    said = capsys.readouterr().err
    assert ("FMI 2.0 is needed" if kind == "fmu3" else "ring.model") in said and said.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["t.csv"]


DECLARED = ["numpy>=2", 'plotly>=6; extra == "reports"', *(f'pushbelt[reports]; extra == "{name}"' for name in ("tables", "durability", "sweep"))]


@pytest.mark.parametrize("there", ["5.24.1", None])
@pytest.mark.parametrize(
    ("words", "extra"),
    [
        ("calibrate t.csv", "tables"), ("calibrate t.csv --hold-out belt155", "tables"), ("compare u.csv v.csv", "reports"), ("demo", "reports"),
        ("drive --cycle nedc", "reports"), ("durability t.csv", "durability"), ("linearize", "reports"), ("maps", "sweep"), ("sweep", "sweep"),
    ],
)  # fmt: skip
def test_a_package_of_an_extra_that_is_missing_or_old_is_named_before_anything_runs(
    words: str, extra: str, there: str | None, fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def version(name: str) -> str:
        if there is None:
            raise importlib.metadata.PackageNotFoundError(name)
        return there

    monkeypatch.setattr(importlib.metadata, "requires", lambda _: DECLARED)
    monkeypatch.setattr(importlib.metadata, "version", version)
    monkeypatch.chdir(tmp_path)
    Path("t.csv").write_text(TABLE, encoding="utf-8")
    for name in ("u", "v"):
        Path(f"{name}.csv").write_text(f"time [s],slip [1]\n0,0\n1,{ord(name)}\n", encoding="utf-8")
    assert cli.main([*words.split(), "--fmu", str(fmu)]) == 1
    what = "plotly 5.24.1 is older than 6" if there else "the package plotly is missing"
    assert capsys.readouterr().err == f"pushbelt {words.split()[0]}: {what}: pip install 'pushbelt[{extra}]'\n"
    assert {path.name for path in tmp_path.iterdir()} == {"t.csv", "u.csv", "v.csv"}


def test_what_the_library_lacks_is_named_with_its_extra(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, coarse: pushbelt.Variator) -> None:
    (tmp_path / "maps.nc").touch()
    grid = coarse.linear_grid([1.0], [40.0])
    monkeypatch.delitem(sys.modules, "pushbelt.maps.variator", raising=False)
    for name in ("io", "interpolate"):
        monkeypatch.setitem(sys.modules, f"scipy.{name}", None)
    for extra, use in (
        ("maps", lambda: pushbelt.MapVariator), ("maps", lambda: Maps.read(tmp_path / "maps.nc")),
        ("control", lambda: grid.save(tmp_path / "models.mat")),
    ):  # fmt: skip
        with pytest.raises(pushbelt.MissingPackageError, match=rf"pip install 'pushbelt\[{extra}\]'"):
            use()
