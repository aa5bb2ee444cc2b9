"""Words of the command line that the programs refuse: one line names them, and nothing is written."""

import importlib.metadata
import sys
from pathlib import Path
from unittest.mock import Mock

import pytest
from conftest import WORDS
from test_console import TABLE

import pushbelt
from pushbelt import Maps, cli

BASE = {"belt": "--width 30 --layers 12 --element-thickness 1.5 --length 0.70 --center-distance 0.17", "durability": "run.csv"}
LINES = Path(__file__).with_name("refused.txt").read_text(encoding="utf-8").splitlines()
REFUSED = [line.replace("COARSE", " ".join(WORDS)).partition(" | ")[::2] for line in LINES if line[0] != "#"]
PROGRAMS = [
    ("calibrate t.csv", "tables"), ("calibrate t.csv --hold-out belt155", "tables"), ("compare u.csv v.csv", "reports"), ("demo", "reports"),
    ("drive --cycle nedc", "reports"), ("durability t.csv", "durability"), ("linearize", "reports"), ("maps", "sweep"), ("sweep", "sweep"),
]  # fmt: skip
DECLARED = ["numpy>=2", 'plotly>=6; extra == "reports"', *(f'pushbelt[reports]; extra == "{name}"' for name in ("tables", "durability", "sweep"))]


@pytest.mark.parametrize(("line", "named"), REFUSED)
def test_what_is_refused_is_named(
    line: str, named: str, fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    program, *words = line.split()
    assert cli.main([program, "--fmu", str(fmu), *BASE.get(program, "").split(), *words]) == 1
    said = capsys.readouterr().err
    assert named in said and said.count("\n") <= 2 and "Traceback" not in said
    assert not list(tmp_path.rglob("*.*"))


@pytest.mark.parametrize("kind", ["map_fmu", "fmu3"])
@pytest.mark.parametrize("words", [f"belt {BASE['belt']}", *(words for words, _ in PROGRAMS if not words.startswith(("compare", "drive")))])
def test_an_fmu_that_does_not_run_the_belt_is_named(
    words: str, kind: str, request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """In one line, before anything is solved."""
    monkeypatch.chdir(tmp_path)
    Path("t.csv").write_text(TABLE, encoding="utf-8")
    assert cli.main([*words.split(), "--fmu", str(request.getfixturevalue(kind))]) == 1
    said = capsys.readouterr().err
    assert ("FMI 2.0 is needed" if kind == "fmu3" else "ring.model") in said and said.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["t.csv"]


@pytest.mark.parametrize("there", ["5.24.1", None])
@pytest.mark.parametrize(("words", "extra"), PROGRAMS)
def test_a_package_of_an_extra_that_is_missing_or_old_is_named_before_anything_runs(
    words: str, extra: str, there: str | None, fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = None if there else importlib.metadata.PackageNotFoundError
    monkeypatch.setattr(importlib.metadata, "requires", lambda _: DECLARED)
    monkeypatch.setattr(importlib.metadata, "version", Mock(return_value=there, side_effect=missing))
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
    for name in ("scipy.io", "scipy.interpolate", "matplotlib"):
        monkeypatch.setitem(sys.modules, name, None)
    for extra, use in (
        ("maps", lambda: pushbelt.MapVariator), ("maps", lambda: Maps.read(tmp_path / "maps.nc")),
        ("control", lambda: grid.save(tmp_path / "models.mat")), ("plots", lambda: coarse.steady(1.0, 40.0).plot()),
    ):  # fmt: skip
        with pytest.raises(pushbelt.MissingPackageError, match=rf"pip install 'pushbelt\[{extra}\]'"):
            use()
