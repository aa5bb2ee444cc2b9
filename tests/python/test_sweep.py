"""Parameter studies: their parts as pure functions, then the FMU on clusters in which workers and clients are killed."""

import dataclasses
import gzip
import itertools
import json
import math
import os
import shutil
import signal
from contextlib import closing
from pathlib import Path

import dask
import numpy as np
import pyarrow.parquet as pq
import pytest
import reports
from conftest import MESH
from distributed import LocalCluster

from pushbelt.fmu.bands import SAMPLES
from pushbelt.fmu.gradients import Asked
from pushbelt.fmu.unit import Archive, Instance
from pushbelt.study import cluster
from pushbelt.study.run import Effort, Store, chunks
from pushbelt.study.run import solve as solve_all
from pushbelt.study.tasks import Solver, Tasks, variator
from pushbelt.sweep import report
from pushbelt.sweep.design import Design
from pushbelt.sweep.point import Row, solve
from pushbelt.sweep.results import METADATA, table, write_parquet
from pushbelt.sweep.study import AXES, Grid, Study

PARAMETERS = variator("bench168", changes=MESH, varied=["friction.pulley"])
GRID = Grid(friction=(0.07, 0.09), speed=(200.0,), ratio=(0.8, 1.0, 1.25), utilisation=(0.3, 0.5, 0.7, 1.2))
"""24 points; a utilisation of 1.2 is beyond what the belt carries."""


def at(ratio: float, utilisation: float, friction: float, speed: float, force: float) -> dict[str, float]:
    values = {"ratio": ratio, "utilisation": utilisation, "friction": friction, "speed": speed, "force": force}
    return {axis.column: values[name] for name, axis in AXES.items()}


@pytest.fixture(scope="module")
def study(fmu: Path) -> Study:
    return Study(fmu, PARAMETERS, GRID)


def test_grid_numbers_its_points() -> None:
    grid = Grid(force=(1e4, 2e4), friction=(0.1,), speed=(100.0, 200.0), ratio=(0.5, 1.0), utilisation=(-0.5, 0.5, 1.0))
    points = grid.points()
    assert len(grid) == len(points) == len({tuple(point.items()) for point in points}) == 24
    place = np.unravel_index(17, (2, 1, 2, 2, 3))
    assert list(points[17].values()) == [getattr(grid, name)[k] for name, k in zip(AXES, place, strict=True)]
    assert points[1] == at(0.5, 0.5, 0.1, 100.0, 1e4)


def test_identity_is_that_of_the_results(study: Study, tmp_path: Path) -> None:
    copy = Path(shutil.copy(study.fmu, tmp_path / "copy.fmu"))
    assert Study(copy, dict(reversed(PARAMETERS.items())), GRID).identity == study.identity
    with copy.open("ab") as file:
        file.write(b"\0")
    others = [
        Study(copy, PARAMETERS, GRID),
        Study(study.fmu, {**PARAMETERS, "belt.play": 3e-4}, GRID),
        Study(study.fmu, PARAMETERS, dataclasses.replace(GRID, force=(1e4,))),
        type("Other", (Study,), {"procedure": Study.procedure[1:]})(study.fmu, PARAMETERS, GRID),
    ]
    assert len({study.identity, *(other.identity for other in others)}) == 5


@pytest.mark.parametrize("size", [None, 1, 5])
def test_chunks_are_what_is_missing(study: Study, size: int | None) -> None:
    finished = {0, 7, 23}
    found = chunks(study, finished, size or 8)
    assert sorted(index for chunk in found for index, _ in chunk) == sorted(set(range(24)) - finished)
    assert max(map(len, found)) <= (size or 24)
    assert chunks(study, set(range(24)), 8) == []
    index, values = found[0][0]
    assert values == study.start_values(study.grid.points()[index])


def made_up(study: Study) -> dict[int, Row]:
    """Ideal steady states; the largest utilisation has none."""
    rows = {}
    for number, point in enumerate(study.grid.points()):
        utilisation = point["utilisation"]
        if utilisation > 1.0:
            rows[number] = {"reason": "beyond the capacity", "time": 0.5}
            continue
        lost = 0.02 + 0.05 * (utilisation - 0.6) ** 2
        axes = {"point", *(axis.column for axis in AXES.values())}
        rows[number] = {name: 1.0 for name in table(study, {}).column_names if name not in axes} | {
            "primary.torque": study.start_values(point)["primary.torque"],
            "thrustRatio": 1.5 - 0.8 * math.log(point["initial.ratio"]) + 0.1 * utilisation,
            "efficiency": 1.0 - lost, "slip": 0.01 * utilisation**2, "primary.power": 1e4, "secondary.power": -1e4 * (1.0 - lost),
            "loss.total": 1e4 * lost + 150.0, "loss.shafts": 150.0, "drift": 1e-9, "macroSlip": False, "pastPeak": False,
            "remarks": None, "reason": None, "time": 0.1,
        }  # fmt: skip
    return rows


def some(rows: dict[int, Row], numbers: range) -> dict[int, Row]:
    return {number: rows[number] for number in numbers}


def test_store_keeps_whole_files_only(study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A damaged file is removed, but not one that cannot be read."""
    rows = made_up(study)
    store = Store(tmp_path, study)
    store.add(some(rows, range(5)))
    store.add(some(rows, range(5, 8)))
    (store.folder / "tasks-8-9.json.gz.77.partial").write_bytes(b"no more than this")
    assert store.rows() == some(rows, range(8))
    for content in (b"", (store.folder / "tasks-5-7.json.gz").read_bytes()[:100], gzip.compress(b"[[1,")):
        (store.folder / "tasks-5-7.json.gz").write_bytes(content)
        assert sorted(Store(tmp_path, study).rows()) == list(range(5))
        assert [path.name for path in store.folder.glob("tasks-*.gz")] == ["tasks-0-4.json.gz"]
    store.add(some(rows, range(3, 9)))
    assert store.rows() == some(rows, range(9))
    assert table(study, store.rows()).equals(table(study, some(rows, range(9))))
    assert not Store(tmp_path, dataclasses.replace(study, grid=dataclasses.replace(GRID, force=(1e4,)))).rows()
    with monkeypatch.context() as patch:
        patch.setattr(Path, "read_bytes", lambda _: os.close(-1))
        with pytest.raises(OSError, match="descriptor"):
            store.rows()
    assert store.rows() == some(rows, range(9))


def test_results_say_what_they_are(study: Study, tmp_path: Path) -> None:
    path = tmp_path / "results.parquet"
    write_parquet(table(study, made_up(study)), path)
    found = pq.read_table(path)
    assert found.num_rows == 24
    units = {field.name: field.metadata[b"unit"].decode() for field in found.schema}
    expected = {"secondary.clampingForce": "N", "initial.primarySpeed": "rad/s", "primary.torque": "N.m", "belt.speed": "m/s", "slip": "1"}
    assert expected.items() <= units.items()
    assert all(field.metadata[b"description"] for field in found.schema)
    document = json.loads(found.schema.metadata[METADATA])
    assert document["study"] == study.identity
    assert document["fmu"]["guid"] == study.description.guid
    assert document["parameters"]["geometry.beltLength"] == 0.703 and document["grid"]["friction"] == [0.07, 0.09]
    assert (document["points"], document["failed"]) == (24, 6)
    failed = found.filter(np.array(found["reason"].is_valid()))
    assert set(failed["utilisation"].to_pylist()) == {1.2}
    assert failed["thrustRatio"].null_count == len(failed)
    assert failed["primary.torque"].null_count == 0


@pytest.mark.parametrize(
    ("values", "statement"),
    [
        ({}, None), ({"thrustRatio": 2.5}, "Thrust ratio falls"), ({"slip": 0.05}, "Slip grows"), ({"efficiency": 0.9}, "Efficiency has one peak"),
        ({"loss.total": 500.0}, "Losses of the belt sum"), ({"drift": 0.01}, "Steady states are stationary"),
        ({"reason": "none found"}, "If a utilisation has a steady state"),
    ],
)  # fmt: skip
def test_checks_find_a_spot(study: Study, values: dict, statement: str | None) -> None:
    """Ratio 1.25, utilisation 0.5, μ 0.09, or without a value the point below it; and nothing where all is right."""
    index = GRID.points().index(at(1.25, 0.5, 0.09, 200.0, 12e3))
    rows = made_up(study)
    rows[index] |= {name: value for name, value in values.items() if name != "reason"}
    if "reason" in values:
        rows[index - 1] = values
    failed = [check for check in report.evaluate(report.data_set(study.grid, table(study, rows))) if not check.passed]
    assert [check.statement.startswith(statement or "") for check in failed] == [True] * (statement is not None)
    assert all("ratio 1.25, utilisation 0." in check.found and "μ 0.09" in check.found for check in failed)


@pytest.fixture(scope="module")
def solved(study: Study, archive: Archive) -> dict[int, Row]:
    """The whole study, solved by one instance, last point first."""
    with closing(Solver(archive, {}, solve)) as solver:
        return {number: row for chunk in chunks(study, set(), 8)[::-1] for number, row in solver.solve(chunk)}


def test_points_are_what_a_fresh_instance_finds(study: Study, archive: Archive, solved: dict[int, Row]) -> None:
    for number in (2, 13):
        point = study.grid.points()[number]
        with Instance(archive, study.start_values(point)) as unit:
            unit.initialise()
            unit.step_to(1e-3)
            outputs = unit.outputs()
        assert {name: solved[number][name] for name in outputs} == outputs
        # By the definition of the efficiency, −P₂/P₁ of the shafts. The belt torque is smaller by the shaft's drag.
        lost = outputs["primary.power"] + outputs["secondary.power"] + outputs["loss.shafts"]
        torque = study.start_values(point)["primary.torque"]
        assert lost / (1.0 - outputs["efficiency"]) / outputs["primary.speed"] == pytest.approx(torque, rel=1e-4)
        assert -outputs["primary.shaftTorque"] < torque
        assert outputs["torqueUtilisation"] == pytest.approx(point["utilisation"], rel=0.02)
        assert outputs["ratio.geometric"] == pytest.approx(point["initial.ratio"], rel=1e-4)


def test_states_make_sense_and_the_report_shows_maps_cuts_and_what_failed(study: Study, solved: dict[int, Row], tmp_path: Path) -> None:
    """The coarse mesh doesn't close the power balance to 0.2 % at low torque."""
    assert {k for k, row in solved.items() if row["reason"]} == {k for k, point in enumerate(study.grid.points()) if point["utilisation"] == 1.2}
    results = table(study, solved)
    failed = [check.statement for check in report.evaluate(report.data_set(study.grid, results)) if not check.passed]
    assert all(statement.startswith("Losses of the belt sum") for statement in failed)
    path = report.write(study, results, tmp_path, Effort(len(solved), 1.0, 2.0))
    text = reports.stands_alone(path)
    # A map for each friction of three quantities, and three cuts.
    assert reports.figures(text) == 2 * 3 + 3
    assert "beyond the capacity of the clamping forces" in text and "18 of 24" in text
    reports.look_at(path)


def solved_by(archive: Archive, tasks: Tasks) -> dict[int, Row]:
    with closing(Solver(archive, tasks.common, tasks.measure)) as solver:
        return dict(solver.solve(list(enumerate(tasks.tasks()))))


def test_bands_are_columns_and_maps(study: Study, archive: Archive, monkeypatch: pytest.MonkeyPatch) -> None:
    grid = Grid((12e3,), (0.09,), (200.0,), (1.0, 1.25), (0.3, 0.5))
    banded = dataclasses.replace(study, grid=grid, deviations={"friction.pulley": 0.01, "belt.play": 1e-4})
    started, original = [], Instance.initialise
    monkeypatch.setattr(Instance, "initialise", lambda self: (started.append(self), original(self))[1])
    rows = solved_by(archive, banded)
    assert (len(started) - len(grid) * (1 + 2 * len(banded.deviations))) % SAMPLES == 0, "each state once"
    assert all(0.0 < row["slip.sd"] < row["slip"] and row["slip by"].startswith("friction.pulley") for row in rows.values())
    assert banded.identity != study.identity
    found = table(banded, rows)
    assert found.column("thrustRatio.sd").to_pylist() == [row["thrustRatio.sd"] for row in rows.values()]
    assert "Standard deviation of slip (%)" in report.contours(report.data_set(banded.grid, found))


def test_gradients_are_columns_and_maps(study: Study, archive: Archive) -> None:
    """They are differences of points beside: at a ratio, and with a given primary force."""
    common = {"torque": ("primary.torque", 50.0, 0.05), "friction.pulley": ("friction.pulley", 0.09, 1e-4)}
    held = common | {"ratio": ("initial.ratio", 1.1, 1e-4), "force": ("secondary.clampingForce", 12e3, 20.0)}
    for asked in (held, common | {"primary.clampingForce": ("primary.clampingForce", 14e3, 20.0)}):
        middle = {column: value for column, value, _ in asked.values()}
        points = [middle, *(middle | {column: value + sign * step} for column, value, step in asked.values() for sign in (1, -1))]
        design = Design("list", tuple(middle), tuple(tuple(point.values()) for point in points))
        one = Study(study.fmu, variator("bench168", changes=MESH, varied=design.columns), design, asked=Asked(tuple(asked)))
        frame = table(one, solved_by(archive, one)).to_pandas()
        for output, (k, (name, (_, _, step))) in itertools.product(("slip", "loss.total", "ratio.speed"), enumerate(asked.items())):
            above, below = frame[output][2 * k + 1 : 2 * k + 3]
            assert frame[f"d {output}/d {name}"][0] == pytest.approx((above - below) / (2.0 * step), rel=0.01, abs=1e-9), (output, name)
    assert frame["d ratio.geometric/d primary.clampingForce"][0] < -1e-5
    grid = dataclasses.replace(study, grid=Grid((12e3,), (0.09,), (200.0,), (1.0, 1.25), (0.3, 0.5)), asked=Asked(("torque",), "forces"))
    found = table(grid, solved_by(archive, grid))
    assert found.schema.field("d loss.total/d torque").metadata[b"unit"] == b"W/(N.m)" and grid.identity != study.identity
    assert found["d primary.idleArc/d torque"].null_count == len(found)
    charts = report.contours(report.data_set(grid.grid, found))
    assert "D slip/d torque (1/(N.m))" in charts and max(map(abs, found["d primary.axialForce/d torque"].to_pylist())) < 1e-6
    # Past the peak of traction.
    driven = Study(study.fmu, PARAMETERS | {"friction.pulley": 0.09}, Design("list", ("primary.speedSetpoint",), ((300.0,),)), asked=Asked(("torque",)))
    (row,) = solved_by(archive, driven).values()
    assert row["pastPeak"] and "slip through" in row["remarks"] and table(driven, {0: row})["d slip/d torque"].null_count == 1


def test_a_point_that_is_refused_leaves_the_others_alone(study: Study, archive: Archive, solved: dict[int, Row]) -> None:
    values = study.tasks()
    refused = {**values[1], "belt.play": -1.0}
    with closing(Solver(archive, {}, solve)) as solver:
        found = solver.solve([(0, values[0]), (1, refused), (100, {**values[1], "belt.colour": 1.0}), (2, values[2])])
    assert "belt.play" in found[1][1]["reason"]
    assert "belt.colour" in found[2][1]["reason"]
    for number, row in (found[0], found[3]):
        assert {**row, "time": 0.0} == {**solved[number], "time": 0.0}


@pytest.mark.slow
def test_a_killed_worker_loses_nothing(study: Study, solved: dict[int, Row], tmp_path: Path) -> None:
    reports, store = [], Store(tmp_path / "out", study)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as processes:
        killed = processes.workers[0].pid

        def listen(done: int, failed: int, _: int) -> None:
            # What is finished is stored at once, for a client that is killed.
            assert len(store.rows()) == done
            if 4 <= done < 16 and not any(before >= 4 for before, _ in reports):
                os.kill(killed, signal.SIGKILL)
            reports.append((done, failed))

        found = table(study, solve_all(study, tmp_path / "out", scheduler=processes, chunk=2, progress=listen))
        assert killed not in [worker.pid for worker in processes.workers.values()]
    assert reports[-1] == (24, 6)
    assert found["point"].to_pylist() == list(range(24))
    assert found.drop_columns("time").equals(table(study, solved).drop_columns("time"))


def test_a_point_that_crashes_its_worker_is_identified() -> None:
    def solve(chunk: list) -> list[tuple[int, Row]]:
        if any(index == 3 for index, _ in chunk):
            os._exit(1)
        return [(index, {"reason": None}) for index, _ in chunk]

    work = [[(index, {}) for index in range(start, start + 2)] for start in range(0, 8, 2)]
    with dask.config.set({"distributed.scheduler.allowed-failures": 0}), cluster.connect(None, 1) as client:
        found = dict(row for rows in cluster.rows(client, solve, work) for row in rows)
    assert sorted(found) == list(range(8))
    assert {index: row["reason"] for index, row in found.items() if row["reason"]} == {3: cluster.WORKER_LOST}


def test_a_scheduler_that_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pushbelt.study.cluster.CONNECT_TIMEOUT", 0.5)
    with pytest.raises(cluster.ClusterError, match="127.0.0.1:9"), cluster.connect("tcp://127.0.0.1:9", None):
        pass
