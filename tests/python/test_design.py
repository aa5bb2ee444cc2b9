"""Designs of experiments with any parameters and inputs, and jobs of Slurm as workers."""

import json
import math
import os
import re
import stat
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
import reports
from conftest import MESH

from pushbelt.errors import ArgumentError
from pushbelt.fmu.data import torque_capacity
from pushbelt.study.cluster import slurm
from pushbelt.study.run import solve
from pushbelt.study.tasks import variator
from pushbelt.sweep.__main__ import main
from pushbelt.sweep.design import Design, Varied, crossed, listed, varied
from pushbelt.sweep.point import start_values
from pushbelt.sweep.results import METADATA, table
from pushbelt.sweep.study import Grid, Study, warnings_of
from pushbelt.tables.sheet import TableError

COARSE_OPTIONS = [f"--set={name}={value}" for name, value in MESH.items()]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("belt.play=1e-4,3e-4", Varied("belt.play", (1e-4, 3e-4))), ("belt.play=2e-4", Varied("belt.play", (2e-4,))),
        ("primary.torque=-50:50:3", Varied("primary.torque", (-50.0, 0.0, 50.0))), ("ratio=0.5:2", Varied("initial.ratio", span=(0.5, 2.0))),
        *((text, None) for text in ("belt.play", "belt.play=", "belt.play=a", "belt.play=2:1", "belt.play=1:2:1", "a=1:2:2.5", "a=1:2,3")),
    ],
)  # fmt: skip
def test_columns_are_read(text: str, expected: Varied | None) -> None:
    if expected is not None:
        assert varied(text) == expected
        return
    with pytest.raises(ArgumentError, match=re.escape(text)):
        varied(text)


def test_a_hypercube_fills_each_range_evenly_in_each_combination() -> None:
    columns = [Varied("belt.play", span=(0.0, 4e-4)), Varied("initial.ratio", (0.5, 2.0)), Varied("friction.pulley", span=(0.06, 0.1))]
    design = crossed(columns, samples=20, seed=3)
    assert (design.kind, len(design)) == ("Latin hypercube", 40)
    rows = design.points()
    for name, low, high in (("belt.play", 0.0, 4e-4), ("friction.pulley", 0.06, 0.1)):
        for ratio in (0.5, 2.0):
            values = np.array([row[name] for row in rows if row["initial.ratio"] == ratio])
            assert sorted(np.floor((values - low) / (high - low) * 20).astype(int)) == list(range(20))
    assert crossed(columns, samples=20, seed=3) == design
    assert crossed(columns, samples=20, seed=4) != design


@pytest.fixture
def read(tmp_path: Path, variables: Mapping[str, Any]) -> Callable[[str], tuple[Design, list[str]]]:
    """The design that a list is, by its text, and the remarks on it."""
    path = tmp_path / "points.csv"
    return lambda text: (path.write_text(text, encoding="utf-8"), listed(path, variables))[1]


def test_a_list_is_read_as_tables_of_rigs_are(read) -> None:
    """Names of rigs and short names, units in the header, SI without."""
    design, remarks = read("ratio;n_P [1/min];F_S [kN];belt.play;T_P [Nm]\n0,5;3000;12,5;1e-4;40\n\n2;1500;20,0;3e-4;-20\n")
    names = ("initial.ratio", "initial.primarySpeed", "secondary.clampingForce", "belt.play", "primary.torque")
    assert (design.kind, design.columns, remarks) == ("list", names, [])
    assert design.rows[0] == pytest.approx((0.5, 314.159, 12500.0, 1e-4, 40.0), rel=1e-5)
    assert design.rows[1] == pytest.approx((2.0, 157.080, 20000.0, 3e-4, -20.0), rel=1e-5)


def test_what_a_list_does_not_set_is_named(read) -> None:
    design, remarks = read("no,ratio,thrustRatio,tester,belt.play [mm],secondary.pressure [bar]\n1,1,1.2,NN,0.1,20\n2,2,0.9,NN,#DIV/0!,20\n")
    assert (design.columns, design.rows) == (("initial.ratio", "belt.play", "secondary.pressure"), ((1.0, 1e-4, 2e6),))
    why = "is no parameter or input of the FMU and is not read"
    assert f"column tester {why}" in remarks and f"column thrustRatio {why}" in remarks
    assert any("line 3" in remark and remark.endswith("the row is left out") for remark in remarks)


@pytest.mark.parametrize(
    ("text", "whys"),
    [
        ("ratio\n", ["header"]), ("ratio,belt.play\n1,\n", ["line 2, column belt.play"]), ("ratio,initial.ratio\n1,1\n", ["2 times"]),
        ("a,b\n1,2\n", ["no column"]), ("belt.paly,initial.ratio [N],belt.play\n1,1,z\n", ["belt.play is meant?", "not N", "'z' is not a number"]),
    ],
)  # fmt: skip
def test_lists_that_are_refused(read, text: str, whys: list[str]) -> None:
    """All faults of a file are in one answer."""
    with pytest.raises(TableError) as caught:
        read(text)
    for why in whys:
        assert why in str(caught.value)


@pytest.mark.parametrize(
    ("columns", "row", "why"),
    [
        (("belt.colour",), (1.0,), "point 1 of the design: the FMU has no parameter or input belt.colour"),
        (("thrustRatio",), (1.0,), "its causality is output"), (("belt.play",), (-1.0,), "belt.play = -1 m is out of its range"),
        (("mesh.strand",), (4.5,), "mesh.strand = 4.5 is not an integer"), (("friction.ring",), (0.05,), "friction.ring"),
        (("primary.torque", "utilisation"), (10.0, 0.5), "determine each other"),
    ],
)  # fmt: skip
def test_study_refuses_a_design(fmu: Path, columns: tuple[str, ...], row: tuple[float, ...], why: str) -> None:
    with pytest.raises(ValueError, match=re.escape(why)):
        Study(fmu, variator("bench168", varied=["friction.pulley"]), Design("list", columns, (row,)))
    # Parameters that are unknown, set by the points, not finite.
    for name, value in (("belt.colour", 1.0), ("initial.ratio", 2.0), ("belt.play", math.nan)):
        for grid in (Grid(), Design("list", ("utilisation",), ((0.5,),))):
            with pytest.raises(ValueError, match=name):
                Study(fmu, {**variator("bench168", varied=["friction.pulley"]), name: value}, grid)


def test_a_point_follows_from_its_own_parameters() -> None:
    """The torque of a utilisation is that of the point's belt length."""
    parameters = variator("bench168")
    changed = {"geometry.beltLength": 0.72, "friction.pulley": 0.08, "utilisation": 0.5, "initial.ratio": 1.5}
    values = start_values(parameters, changed)
    assert values["primary.torque"] == pytest.approx(0.5 * torque_capacity({**parameters, **changed}, 1.5, 12e3))
    assert values["geometry.beltLength"] == 0.72
    assert values["secondary.speedSetpoint"] == pytest.approx(209.44 / 1.5)
    assert "utilisation" not in values
    assert start_values({**parameters, "friction.pulley": 0.09}, {"primary.torque": 33.0})["primary.torque"] == 33.0


def run(fmu: Path, folder: Path, *options: str) -> int:
    return main(["--fmu", str(fmu), "--output", str(folder), "--workers", "1", *COARSE_OPTIONS, *options])


def test_a_hypercube_runs_and_goes_on(fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--vary", "belt.play=1e-4:5e-4", "--vary", "friction.pulley=0.07:0.1", "--vary", "ring.layers=8,9", "--samples", "6"]
    assert run(fmu, tmp_path, *options) == 0
    table = pq.read_table(tmp_path / "results.parquet")
    assert table.num_rows == 12
    assert set(table["ring.layers"].to_pylist()) == {8.0, 9.0}
    assert np.ptp(table["friction.pulley"].to_numpy()) > 0.02
    assert table["utilisation"].to_pylist() == pytest.approx([0.6] * 12)
    assert table["reason"].null_count == 12
    assert json.loads(table.schema.metadata[METADATA])["grid"]["columns"] == ["ring.layers", "belt.play", "friction.pulley"]
    # Thrust ratios rise with friction, as in the maps.
    rank = table.select(["friction.pulley", "thrustRatio"]).to_pandas().corr("spearman").iloc[0, 1]
    assert rank > 0.8
    text = reports.stands_alone(tmp_path / "report.html")
    assert f"{rank:.2f}" in re.search(r"<tr>\s*<td[^>]*>(?:<code>)?friction.pulley.*?</tr>", text, re.DOTALL)[0]
    assert reports.figures(text) == 3 * 3
    assert "Latin hypercube" in text
    (folder,) = (tmp_path / "studies").iterdir()
    (first, *_) = sorted(folder.glob("tasks-*"))
    first.unlink()
    capsys.readouterr()
    assert run(fmu, tmp_path, *options) == 0
    assert "of 12 points are already stored" in capsys.readouterr().out
    assert pq.read_table(tmp_path / "results.parquet").drop_columns("time").equals(table.drop_columns("time"))
    reports.look_at(tmp_path / "report.html")


def test_a_list_runs(fmu: Path, tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("ratio,primary.torque,speed [rpm]\n0.5,20,1000\n2,40,2000\n", encoding="utf-8")
    assert run(fmu, tmp_path, "--points", str(path), "--bands", "--gradient", "torque") == 0
    table = pq.read_table(tmp_path / "results.parquet")
    assert table["primary.torque"].to_pylist() == [20.0, 40.0] and table["slip by"].null_count == table["d slip/d torque"].null_count == 0
    assert table["ratio.geometric"].to_pylist() == pytest.approx([0.5, 2.0], rel=1e-3)
    assert table["utilisation"].to_pylist() == pytest.approx(table["torqueUtilisation"].to_pylist(), rel=0.05)


def test_a_slip_of_units_at_some_points_is_a_warning(fmu: Path) -> None:
    def warned(**columns: tuple[float, ...]) -> list[str]:
        design = crossed([Varied(name.replace("_", "."), values) for name, values in columns.items()])
        return list(warnings_of(Study(fmu, variator("bench168", varied=design.columns), design)))

    (text,) = warned(secondary_clampingForce=(15.0, 15e3, 20e3), primary_torque=(30.0, 60.0))
    assert "Is the force in kN? 15 kN are 15000 N" in text and "1 more of 6 points" in text
    (text,) = warned(initial_primarySpeed=(200.0, 2500.0))
    assert "above 60 m/s. Is the speed in rpm? 2500 rpm are 261.8 rad/s" in text
    # A torque beyond the capacity that no unit explains, an open pulley, and a fast belt of a car.
    assert not warned(primary_torque=(30.0, 400.0), secondary_clampingForce=(9e3,))
    assert not warned(secondary_clampingForce=(0.0, 12e3))
    assert not warned(initial_primarySpeed=(600.0,), initial_ratio=(0.8, 2.0))
    assert not list(warnings_of(Study(fmu, variator("bench168", varied=["friction.pulley"]))))


def test_job_script_has_the_options(fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("dask_jobqueue")
    asked = "queue=long account=gears walltime=1-02:00:00 cores=16 memory=24GB 'directive=--nice=100' 'prologue=module load python/3.12'"
    assert main(["--fmu", str(fmu), "--output", str(tmp_path), "--slurm", asked, "--print-job"]) == 0
    script = capsys.readouterr().out
    assert script.startswith("#!")
    directives = set(re.findall(r"^#SBATCH (.*)$", script, re.MULTILINE))
    assert {"-p long", "-A gears", "-t 1-02:00:00", "--cpus-per-task=16", "--nice=100"} <= directives
    assert "module load python/3.12" in script.splitlines()
    (command,) = (line for line in script.splitlines() if "dask_worker" in line)
    # Workers close before Slurm ends the job, so that no point is lost.
    for part in ("--nworkers 16 --nanny", "--nthreads 1", f"--lifetime {26 * 3600 - 120}s"):
        assert part in command
    assert not (tmp_path / "studies").exists()


def test_without_slurm_jobs_are_refused(fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("dask_jobqueue")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert main(["--fmu", str(fmu), "--output", str(tmp_path), "--slurm", "jobs=1"]) == 1
    assert "sbatch" in capsys.readouterr().err


@pytest.mark.skipif(os.name == "nt", reason="jobs of Slurm are shell scripts")
def test_jobs_of_slurm_solve_a_study(fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`sbatch` and `scancel` of this test run the job script on this machine, without this project on the path of the workers."""
    monkeypatch.delenv("PYTHONPATH", raising=False)
    pytest.importorskip("dask_jobqueue")
    commands = tmp_path / "bin"
    commands.mkdir()
    log = tmp_path / "jobs"
    scripts = {
        "sbatch": f'copy=$(mktemp -p {tmp_path})\ncp "$1" $copy\nsetsid bash $copy >> {log}.log 2>&1 &\necho $! >> {log}\necho "Submitted batch job $!"',
        "scancel": 'kill -- "-$1"',
    }
    for name, text in scripts.items():
        (commands / name).write_text(f"#!/bin/bash\n{text}\n", encoding="utf-8")
        (commands / name).chmod(stat.S_IRWXU)
    monkeypatch.setenv("PATH", f"{commands}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.chdir(tmp_path)
    design = crossed([Varied("belt.play", (1e-4, 3e-4)), Varied("utilisation", (0.3, 0.6))])
    study = Study(fmu, variator("bench168", changes=MESH, varied=design.columns), design)
    queue, jobs = slurm(f"jobs=2 walltime=00:30:00 local_directory={tmp_path}")
    with queue:
        queue.adapt(minimum_jobs=jobs, maximum_jobs=jobs)
        found = table(study, solve(study, tmp_path / "out", scheduler=queue, chunk=1))
    assert found["reason"].null_count == 4
    started = [int(line) for line in log.read_text(encoding="utf-8").split()]
    assert len(started) == 2
    end = time.monotonic() + 60.0
    while any(Path(f"/proc/{job}").exists() for job in started) and time.monotonic() < end:
        time.sleep(0.1)
    assert not any(Path(f"/proc/{job}").exists() for job in started)
    assert table(study, solve(study, tmp_path / "out")).equals(found)
    assert len(log.read_text(encoding="utf-8").split()) == 2
