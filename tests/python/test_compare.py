"""Comparison of two runs: pairs of files, differences, and the report."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import reports
from conftest import CHEAP

from pushbelt import ArgumentError, Variator, parameter_set
from pushbelt.compare import __main__, report, runs, sets
from pushbelt.tables import titles
from pushbelt.tables import write as write_table


def write(path: Path, step: float = 0.01, shift: float = 0.0, end: float = 1.0, unit: str = "rad/s") -> Path:
    """A run of a sine that is shifted, a constant, and a column that is equal in all."""
    time = np.arange(0.0, end + 0.5 * step, step)
    table = np.column_stack([time, np.sin(6.0 * time) + shift * (time > 0.5), np.full_like(time, 2.0), time])
    path.parent.mkdir(parents=True, exist_ok=True)
    write_table(path, ["time [s]", "slip [1]", "primary.torque [N.m]", f"secondary.speed [{unit}]"], table.tolist())
    return path


def test_a_difference_has_its_size_and_its_time(tmp_path: Path) -> None:
    (pair,) = runs.pairs(write(tmp_path / "a.csv"), write(tmp_path / "b.csv", shift=0.25))
    (slip,) = pair.differing
    assert (slip.name, pair.name) == ("slip", "a and b")
    assert slip.largest == pytest.approx(0.25)
    assert slip.when == pytest.approx(0.51, abs=0.011)
    assert slip.root_mean_square == pytest.approx(0.25 * np.sqrt(50 / 101))
    assert [d.name for d in pair.differences if d.share == 0.0] == ["primary.torque", "secondary.speed"]


def test_runs_of_other_steps_and_ends_are_compared_where_both_are(tmp_path: Path) -> None:
    (pair,) = runs.pairs(write(tmp_path / "a.csv", step=0.001), write(tmp_path / "b.csv", end=0.8))
    difference = next(d for d in pair.differences if d.name == "slip")
    # A chord of 10 ms below the sine: ω² h²/8.
    assert difference.largest == pytest.approx(36.0 * 0.01**2 / 8.0, rel=0.05)
    assert difference.when < 0.8


def test_folders_are_paired_by_the_names_of_their_runs(tmp_path: Path) -> None:
    for folder, shift in (("one", 0.0), ("two", 0.1)):
        write(tmp_path / folder / "slip-control.csv", shift=shift)
        (tmp_path / folder / "cases.csv").write_text("case,slip\nfirst,1\n", encoding="utf-8")
    write(tmp_path / "two" / "close-up.csv")
    assert [pair.name for pair in runs.pairs(tmp_path / "one", tmp_path / "two")] == ["slip-control"]


BAD = {
    "run.csv": {"case,slip\nfirst,1\n": "time", "time,slip\n": "rows", "time,slip\n0,1\n0,2\n": "ascend", "time,slip\n0,1\n1,2,3\n": "line 3"},
    "set.json": {"[1]": "not a parameter set", '{"parameters": {"mu": {"value": 1, "interval95": [2, 1]}}}': "interval95", '{"parameters": {}}': "in common"},
}
"""What a file that is no run or no set is refused for."""


def test_what_is_no_pair_is_an_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good, sound = write(tmp_path / "good.csv"), calibrated(tmp_path / "a.json", mu=(0.09, 0.002))
    cases = [([good, tmp_path / "none.csv"], "none.csv"), ([good, tmp_path], str(tmp_path)), ([good, good, "--variables=sloop"], "sloop")]
    for name, first in (("run.csv", good), ("set.json", sound)):
        for k, (text, why) in enumerate(BAD[name].items()):
            (tmp_path / f"{k}-{name}").write_text(text, encoding="utf-8")
            cases.append(([first, tmp_path / f"{k}-{name}"], why))
    for words, why in cases:
        assert __main__.main([*map(str, words), "--output", str(tmp_path / "out")]) == 1
        said = capsys.readouterr().err
        assert why in said and said.count("\n") == 1


def test_units_are_those_in_the_files(tmp_path: Path) -> None:
    """A file without units, as of other tools, has the units of the other one."""
    a, b, other = write(tmp_path / "a.csv", unit="rpm"), tmp_path / "b.csv", write(tmp_path / "c.csv")
    b.write_text("\n".join(["time,slip,primary.torque,secondary.speed", *other.read_text(encoding="utf-8").splitlines()[1:]]), encoding="utf-8")
    (pair,) = runs.pairs(a, b)
    assert pair.units == {"time": "s", "primary.torque": "N.m", "secondary.speed": "rpm"}
    assert not pair.differing
    with pytest.raises(ArgumentError, match="secondary.speed is in rpm in"):
        runs.pairs(a, other)


@pytest.mark.parametrize("folders", [False, True])
def test_equal_runs_need_one_line_and_no_report(folders: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    both = [str(path.parent if folders else path) for path in (write(tmp_path / name / "run.csv") for name in ("a", "b"))]
    assert __main__.main([*both, "--output", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().out.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_runs_with_another_column_gap_or_time_are_not_equal(tmp_path: Path) -> None:
    a, b = write(tmp_path / "a.csv"), tmp_path / "b.csv"
    lines = a.read_text(encoding="utf-8").splitlines()
    another_column = [f"{lines[0]},more", *(f"{line},1" for line in lines[1:])]
    gap = [*lines[:-1], f"{lines[-1].split(',')[0]},nan,2,nan"]
    for text in (another_column, gap, lines[:-1]):
        b.write_text("\n".join(text), encoding="utf-8")
        (pair,) = runs.pairs(a, b)
        assert not pair.equal and not pair.differing


def test_the_belts_of_both_runs_are_shown(fmu: Path, tmp_path: Path) -> None:
    """Where both files have the fields along the belt."""
    paths, names = [tmp_path / "a.csv", tmp_path / "b.csv"], report.needed(parameter_set("bench168"))
    for path, force in zip(paths, (13e3, 15e3), strict=True):
        rows = []
        with Variator("bench168", {**CHEAP, "primary.clampingForce": force}, fmu=fmu) as belt:
            belt.start()
            for _ in range(20):
                rows.append([belt.time, *(belt[name] for name in names)])
                belt.step(1e-3)
            write_table(path, ["time [s]", *titles(names, {name: belt.variables[name].unit for name in names})], rows)
    out = tmp_path / "out"
    assert __main__.main([*map(str, paths), "--output", str(out), "--fmu", str(fmu)]) == 0
    text = reports.stands_alone(out / "report.html")
    assert text.count('<div class="belt"') == 2 and "The belt of run B" in text
    (pair,) = runs.pairs(*paths)
    first, second = (report.belt_of(run) for run in pair.runs)
    assert len(first) == 20
    force = np.array([state.profile.push_force for state in first.values()])
    assert force == pytest.approx(np.column_stack([pair.runs[0][n] for n in report.places("pushForce")]))
    assert max(abs(first[time]["primary.radius"] - second[time]["primary.radius"]) for time in first) > 1e-6, "the belts are at other ratios"
    # Fields are in the table, but not among the curves.
    assert "<code>profile.pushForce[1]</code>" in text
    reports.look_at(out / "report.html")
    assert __main__.main([str(paths[0]), str(write(tmp_path / "c.csv")), "--output", str(out)]) == 0
    assert '<div class="belt"' not in (out / "report.html").read_text(encoding="utf-8"), "one file has none"


def test_the_report_shows_both_runs(fmu: Path, tmp_path: Path) -> None:
    a, b = write(tmp_path / "a.csv", unit="rpm"), write(tmp_path / "b.csv", shift=0.25, unit="rpm")
    assert __main__.main([str(a), str(b), "--output", str(tmp_path / "out"), "--fmu", str(fmu)]) == 0
    text = reports.stands_alone(tmp_path / "out" / "report.html")
    assert reports.figures(text) == 3
    assert "primary.torque (N.m)" in text and "secondary.speed (rpm)" in text
    rows = pd.read_csv(tmp_path / "out" / "differences.csv", keep_default_na=False)
    assert list(zip(rows["column"], rows["unit"], strict=True)) == [("slip", ""), ("primary.torque", "N.m"), ("secondary.speed", "rpm")]
    assert rows["largest [SI]"][0] == pytest.approx(0.25)


def calibrated(path: Path, **values: tuple[float, float | None]) -> Path:
    """A parameter set with values and half-widths of their intervals."""
    entries = {name: {"value": value} | ({"interval95": [value - half, value + half]} if half else {}) for name, (value, half) in values.items()}
    path.write_text(json.dumps({"parameters": entries}), encoding="utf-8")
    return path


def test_sets_agree_if_no_difference_exceeds_the_largest_of_so_many(tmp_path: Path) -> None:
    """In standard deviations, 1.96 of which are the half of an interval. Of one difference 1.96 may be chance, of two 2.24."""
    for sizes, agree in (((2.0,), False), ((2.0, 0.1), True), ((2.3, 0.1), False)):
        names = "ab"[: len(sizes)]
        a = calibrated(tmp_path / "a.json", **dict.fromkeys(names, (1.0, 0.3 * 1.959964)))
        b = calibrated(tmp_path / "b.json", **{name: (1.0 + 0.5 * size, 0.4 * 1.959964) for name, size in zip(names, sizes, strict=True)})
        found = sets.differences(a, b)
        assert [row.relative for row in found] == pytest.approx(sizes, rel=1e-5)
        assert sets.verdict(found).startswith("the sets agree" if agree else "the sets differ in a:")


def test_the_report_of_two_sets(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Values without intervals are compared as such, and equal sets need no report."""
    a, out = calibrated(tmp_path / "a.json", mu=(0.09, 0.002), play=(2e-4, None)), tmp_path / "out"
    b = calibrated(tmp_path / "b.json", mu=(0.0905, 0.002), play=(3e-4, 1e-5), more=(1.0, None))
    assert __main__.main([str(a), str(a), "--output", str(out)]) == 0 and not out.exists()
    assert __main__.main([str(a), str(b), "--output", str(out)]) == 0
    said = capsys.readouterr().out
    assert "equal in all 2 common parameters" in said and "agree within their intervals" in said and "1 of 1 values" in said
    assert "agree within their intervals" in (out / "report.html").read_text(encoding="utf-8")
    rows = pd.read_csv(out / "differences.csv")
    assert rows["difference [SI]"].tolist() == pytest.approx([5e-4, 1e-4]) and np.isnan(rows["deviation [SI]"][1])


