"""Maps: their parts as pure functions, the maps of a coarse belt on a cluster, their files read by other programs, and the report."""

import dataclasses
import json
import math
import re
from collections.abc import Sequence
from pathlib import Path

import netCDF4
import numpy as np
import pandas
import pytest
import reports
import xarray
from conftest import MESH
from scipy.io import loadmat, whosmat
from test_sweep import solved_by

from pushbelt import Variator
from pushbelt.fmu.data import pitch_radius, torque_capacity
from pushbelt.fmu.gradients import Asked
from pushbelt.fmu.steady import SteadyStates, driven_at_speed, driven_by_torque
from pushbelt.fmu.unit import Archive, Instance
from pushbelt.fmu.working_points import SHAFTS, Line, drag, driven_at
from pushbelt.maps import __main__, files, report
from pushbelt.maps import unit as map_unit
from pushbelt.maps.data import STATES, TABLES, MapError, Maps
from pushbelt.maps.plan import COARSE, Grid, Plan, collect, monotone, stops
from pushbelt.report.side_by_side import Call
from pushbelt.study import run
from pushbelt.study.tasks import variator

PARAMETERS = variator("bench168", changes={**MESH, "secondary.inertia": 80.0})  # A vehicle, on which lines do not depend
LOSSES = [name for name in TABLES if name.startswith("loss") and name != "lossShafts"]  # Of the belt
GRID = Grid((6e3, 12e3), (100.0, 300.0), (0.6, 1.0, 1.8), utilisation=(-0.5, -0.2, 0.0, 0.3, 0.7, 1.1), excess=(-0.4, -0.1, 0.0, 0.1, 0.4))
"""12 lines; a utilisation of 1.1 is beyond what the belt carries."""


@pytest.fixture(scope="module")
def plan(fmu: Path) -> Plan:
    return Plan(fmu, PARAMETERS, GRID)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("maps")


@pytest.fixture(scope="module")
def maps(plan: Plan, folder: Path) -> Maps:
    """The maps of all lines. Their files are in the folder."""
    found = collect(plan, run.solve(plan, folder, workers=2))
    files.write(found, folder)
    return found


def test_stops_are_where_a_radius_is_at_its_limit(plan: Plan) -> None:
    low, high = stops(plan.full)
    radii = {ratio: (pitch_radius(PARAMETERS, ratio), ratio * pitch_radius(PARAMETERS, ratio)) for ratio in (low, high)}
    assert min(0.082 - radii[low][0], radii[low][1] - 0.03) == pytest.approx(0.0, abs=1e-9)
    assert min(radii[high][0] - 0.03, 0.082 - radii[high][1]) == pytest.approx(0.0, abs=1e-9)
    default = dataclasses.replace(plan, grid=COARSE)
    assert len(default.tasks()) == 84
    assert low < default.ratios[0] < default.ratios[-1] < high


def test_shift_rates_are_made_monotone() -> None:
    excesses = np.array([-0.4, -0.1, 0.0, 0.1, 0.4])
    rates = monotone(np.array([[-2.0, -3.0, 1.0, math.nan]]), excesses)
    # The second rate is not above the first one, and the last is missing.
    assert rates[0].tolist() == pytest.approx([-3.0, -3.0, 0.0, 1.0, 1.0])
    assert rates[0, 2] == 0.0
    assert monotone(np.array([[0.5, -1.0, 1.0, 2.0]]), excesses)[0, 0] == -1.0


@pytest.mark.parametrize("values", [{"force": ()}, {"ratio": (1.0, 0.5)}, {"speed": (0.0, 10.0)}, {"excess": (-0.1, 0.1)}, {"slip_share": (-1.0, 0.5)}])
def test_grid_refuses(values: dict) -> None:
    with pytest.raises(ValueError, match=next(iter(values))):
        Grid(**values)


def test_maps_are_complete_and_in_order(maps: Maps) -> None:
    """Thrust ratios fall with the ratio, slips grow with the torque, losses are positive, gaps are beyond the capacity."""
    assert maps["thrustRatio"].shape == (2, 2, 3, 6)
    assert np.all(maps.valid[..., :5]) and np.all(maps["state"][..., 5] == 2.0)
    assert [f"{number} {name}" in TABLES["state"].description for number, name in enumerate(STATES)] == [True] * 4
    assert len(maps.reasons) == 12 and all(reason.startswith("beyond the capacity") for reason in maps.reasons.values())
    assert np.all(np.diff(maps["thrustRatio"][..., 3], axis=2) < 0.0)
    assert np.all(np.diff(maps["slip"][..., :5], axis=-1) > 0.0)
    assert np.all(np.sum([maps[name] for name in LOSSES], axis=0) > 0.0)
    assert np.all(np.diff(maps["traction"], axis=-1) > 0.0)
    assert np.all(maps["capacity"][..., 0] < -0.5)
    assert np.all(maps["capacity"][..., 1] > 0.8)
    assert np.array_equal(maps["traction"][..., [0, -1]], maps["capacity"])
    assert np.all(np.diff(maps["shiftRate"], axis=-1) >= 0.0)
    assert np.all(maps["shiftGain"] > 0.0)
    assert np.all(np.diff(maps["thrustRatioAtShare"][..., -4:], axis=-1) < 0.0)
    efficiency = maps["efficiency"][..., [0, 4]]  # In overrun and in drive
    assert np.all((efficiency > 0.8) & (efficiency < 1.0))


def test_losses_of_the_maps_close(maps: Maps) -> None:
    """Torque loss and slip make up the sum of the belt's losses."""
    speed = maps.axes["speed"][None, :, None, None] / (1.0 - maps["slip"])
    by_torque = speed * (maps["slip"] * maps["primaryTorque"] + (1.0 - maps["slip"]) * maps["beltTorqueLoss"])
    by_law = np.sum([maps[name] for name in LOSSES], axis=0)
    # Without load the driving power is small: the error is relative to the power at a utilisation of 0.3 there.
    power = np.abs(maps["primaryTorque"] * speed)
    power = np.maximum(power, power[..., 3:4])
    assert np.max(np.abs(by_torque - by_law)[maps.valid] / power[maps.valid]) < 2e-3


@pytest.mark.parametrize("place", [(0, 0, 1, 4), (0, 1, 0, 4), (1, 0, 2, 3), (1, 1, 1, 1)])
def test_a_point_is_that_of_the_fmu_with_its_own_drag(archive: Archive, plan: Plan, maps: Maps, place: tuple[int, ...]) -> None:
    """Lines are measured without the drag of the shafts, which the maps add: at the torque of a point."""
    torque = maps["primaryTorque"][place]
    force, speed, ratio, utilisation = (getattr(GRID, name)[k] for name, k in zip(("force", "speed", "ratio", "utilisation"), place, strict=True))
    with Instance(archive, driven_by_torque(plan.full, ratio, speed, torque, force)) as unit:
        unit.initialise()
        drag = unit.get("primary.externalTorque") + unit.get("primary.shaftTorque")
        unit.restart(driven_by_torque(plan.full, ratio, speed, torque + drag, force))
        unit.initialise()
        found = unit.outputs()
    assert -found["primary.shaftTorque"] == pytest.approx(torque, rel=1e-3)
    assert torque == pytest.approx(utilisation * torque_capacity(plan.full, ratio, force))
    for name in ("slip", "thrustRatio"):
        assert maps[name][place] == pytest.approx(found[name], rel=2e-3)
    assert maps["lossShafts"][place] == pytest.approx(found["loss.shafts"], rel=2e-3)
    assert maps["efficiency"][place] == pytest.approx(found["efficiency"], abs=2e-4)
    loss = found["primary.externalTorque"] + found["secondary.externalTorque"] / ratio
    assert maps["torqueLoss"][place] == pytest.approx(loss, rel=2e-3)


def test_a_line_is_stored_when_it_is_solved(plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """So an interrupt loses no finished line, also without dask."""

    def interrupted(calls: Sequence[Call], *_: object) -> None:
        function, arguments = calls[0]
        function(*arguments)
        raise KeyboardInterrupt

    monkeypatch.setattr(run.side_by_side, "run_all", interrupted)
    monkeypatch.setattr(run.side_by_side, "tick", lambda _: None)
    with pytest.raises(KeyboardInterrupt):
        run.solve_in_processes(plan, tmp_path, "lines")
    assert [bool(row["points"]) for row in run.Store(tmp_path, plan).rows().values()] == [True]


@pytest.mark.parametrize("place", [(0, 1, 1, 2, 1), (1, 0, 2, 0, 3)])
def test_a_shift_rate_is_that_at_the_ratio_of_its_line(archive: Archive, maps: Maps, place: tuple[int, ...]) -> None:
    """A belt that passes through the ratio in the middle of the time, under the force of the excess, shifts at that rate."""
    f, s, r, u, e = place
    line, rate = Line(GRID.force[f], GRID.speed[s], GRID.ratio[r]), maps["shiftRate"][place]
    with SteadyStates(archive, {**PARAMETERS, **SHAFTS, "secondary.inertia": 0.003}) as states:
        load = states.at(driven_at(states, line, GRID.shift_utilisation[u])).get("secondary.externalTorque")
        holding = states.at(driven_at_speed({}, line.ratio, line.speed, load, line.force)).get("primary.axialForce")
        unit = states.at(driven_at_speed({}, line.ratio * math.exp(0.09 * rate * line.speed), line.speed, load, line.force))
        unit.set({"primary.clampingForce": holding * math.exp(GRID.excess[e])})
        unit.step_to(0.06)
        begin = unit.get("ratio.geometric")
        unit.step_to(0.12)
        assert math.log(begin / unit.get("ratio.geometric")) / 0.06 / line.speed == pytest.approx(rate, rel=0.03)


def test_lines_without_results_have_those_of_the_nearest(plan: Plan, maps: Maps, folder: Path) -> None:
    rows = run.Store(folder, plan).rows()
    rows[4] = {"reason": "no belt", "time": 0.1}
    found = collect(plan, rows)
    f, s, r = np.unravel_index(4, (2, 2, 3))
    assert found["thrustRatio"][f, s, r].tolist() in [maps["thrustRatio"][f, s, k].tolist() for k in (r - 1, r + 1)]
    assert set(found["state"][f, s, r]) == {3.0}
    assert found.reasons[f"{f}/{s}/{r}/0"] == "no belt"
    with pytest.raises(ValueError, match="no belt"):
        collect(plan, {4: rows[4]})


@pytest.fixture(scope="module")
def banded(archive: Archive, fmu: Path) -> Maps:
    """Maps with standard deviations and derivatives; a utilisation of 1.1 is beyond what the belt carries."""
    grid = Grid((6e3,), (100.0,), (0.8, 1.2), utilisation=(-0.3, 0.3, 1.1), slip_share=(-1.0, 0.0, 1.0), excess=(0.0,))
    plan = Plan(fmu, PARAMETERS, grid, {"friction.pulley": 1e-3, "primary.drag.constant": 0.06}, Asked(("torque", "ratio", "belt.play")))
    return collect(plan, solved_by(archive, plan))


def test_deviations_and_derivatives_are_those_of_the_variator(banded: Maps, fmu: Path) -> None:
    """At the torque of the primary shaft of a point."""
    with Variator(banded.parameters, fmu=fmu) as variator:
        for place, ratio in (((0, 0, 1, 0), 1.2), ((0, 0, 0, 1), 0.8)):
            turning = 100.0 / (1.0 - banded["slip"][place])
            torque = banded["primaryTorque"][place] + drag(banded.parameters, "primary", turning, banded["bearingLoad"][place])
            point = {"ratio": ratio, "torque": float(torque), "speed": 100.0, "force": 6e3}
            bands = variator.bands(**point, deviations={"friction.pulley": 1e-3, "primary.drag.constant": 0.06})
            state = variator.steady(**point)
            slopes = state.gradient(["torque", "ratio", "belt.play"])
            for name in ("thrustRatio", "slip", "efficiency"):
                assert banded[f"{name}Deviation"][place] == pytest.approx(bands[name], rel=0.01)
                assert banded.by[name]["/".join(map(str, place))] == ", ".join(bands.largest(name))
                for over, table in (("torque", "Torque"), ("ratio", "Ratio"), ("belt.play", "BeltPlay")):
                    assert banded[f"{name}Per{table}"][place] == pytest.approx(slopes.loc[name, over], rel=0.02, abs=1e-7)
            assert banded["torqueLossDeviation"][place] == pytest.approx(bands["secondary.externalTorque"] / ratio, rel=0.01)
            beside = [variator.steady(**point | {"ratio": ratio + step}) for step in (1e-4, -1e-4)]
            losses = [one["primary.externalTorque"] + one["secondary.externalTorque"] / one["ratio.geometric"] for one in beside]
            assert banded["torqueLossPerRatio"][place] == pytest.approx((losses[0] - losses[1]) / 2e-4, rel=0.05)
    assert np.isnan(banded["slipDeviation"][..., 2]).all() and np.isnan(banded["slipPerTorque"][..., 2]).all()


def test_deviations_are_in_all_files_and_the_fmu_runs_on_them(banded: Maps, map_fmu: Path, tmp_path: Path) -> None:
    paths = files.write(banded, tmp_path)
    for path in paths[: len(files.OWN)]:
        found = Maps.read(path)
        assert (found.identity, found.by, found.added) == (banded.identity, banded.by, banded.added)
    assert banded.added["torqueLossPerBeltPlay"].unit == "N.m/m"
    with xarray.open_dataset(tmp_path / "maps.nc") as data:
        assert data["slipPerTorque"].units == "1/(N.m)"
    frame = pandas.read_csv(tmp_path / "maps.csv", header=[0, 1])
    assert frame["slipDeviation", "1"].notna().sum() == frame["slipPerBeltPlay", "1/m"].notna().sum() == 4
    assert frame.xs("slip by", axis=1).iloc[1, 0].startswith("friction.pulley")
    assert np.array_equal(loadmat(tmp_path / "maps.mat")["tbl_slipDeviation"], banded["slipDeviation"].transpose(2, 3, 1, 0), equal_nan=True)
    text = report.write(banded, tmp_path, run.Effort(2, 1.0, 2.0)).read_text(encoding="utf-8")
    assert "Standard deviation of slip</h2>" in text and "friction.pulley, primary.drag.constant</td>" in text and "Derivative of torqueLoss over belt.play, the ratio kept (N.m/m)" in text
    map_unit.write_fmu(tmp_path / "copy.fmu", banded, map_fmu)
    with Archive.unpack(tmp_path / "copy.fmu") as unpacked, Instance(unpacked, {"initial.ratio": 1.0}) as unit:
        unit.initialise()
        unit.step_to(0.01)


@pytest.mark.parametrize("name", files.OWN)
def test_files_are_read_back_and_damaged_ones_refused(maps: Maps, folder: Path, tmp_path: Path, name: str) -> None:
    found, content = Maps.read(folder / name), (folder / name).read_bytes()
    assert found.identity == maps.identity
    assert (found.source, found.reasons, found.parameters) == (maps.source, maps.reasons, maps.parameters)
    for k, damaged in enumerate((content[: len(content) // 2], b"", b"{}", b"\x89" + content[1:])):
        path = tmp_path / f"{k}-{name}"
        path.write_bytes(damaged)
        with pytest.raises(MapError, match=str(path.name)):
            Maps.read(path)
    with pytest.raises(OSError, match="none"):
        Maps.read(tmp_path / f"none-{name}")


def test_maps_that_are_not_finite_are_refused(maps: Maps) -> None:
    document = maps.document()
    document["tables"]["slip"]["values"][0][0][0][0] = math.nan
    with pytest.raises(MapError, match="slip"):
        Maps.of_document(document)


def test_netcdf_is_read_by_other_libraries(maps: Maps, folder: Path) -> None:
    with netCDF4.Dataset(folder / "maps.nc") as file:
        assert file.data_model == "NETCDF3_64BIT_OFFSET"
        variable = file["thrustRatio"]
        assert variable.dimensions == ("force", "speed", "ratio", "utilisation")
        assert (variable.units, file["beltTorqueLoss"].units, file["ratio"].units) == ("1", "N.m", "1")
        assert np.array_equal(variable[:], maps["thrustRatio"])
        assert json.loads(file.parameters) == maps.parameters
        assert file["state"].flag_meanings.split()[2] == "beyond_capacity"
    with xarray.open_dataset(folder / "maps.nc", engine="netcdf4") as data:
        assert float(data.sel(force=6e3, speed=300.0, ratio=1.0, utilisation=0.3).slip) == maps["slip"][0, 1, 1, 3]
        assert float(data.slip.where(data.valid == 1.0).max()) == np.nanmax(maps.masked("slip"))


def test_matlab_file_is_read_back(maps: Maps, folder: Path) -> None:
    assert max(map(len, {name for name, _, _ in whosmat(folder / "maps.mat")})) <= 31
    found = loadmat(folder / "maps.mat")
    assert np.array_equal(found["tbl_thrustRatio"], maps["thrustRatio"].transpose(2, 3, 1, 0))
    assert found["bp_ratio"].ravel().tolist() == maps.axes["ratio"].tolist()
    assert found["tbl_shiftGain"].shape == (3, 4, 2, 2)
    assert [row[1][0] for row in found["names"] if row[0][0] == "tbl_slip"] == ["ratio,utilisation,speed,force"]


def test_modelica_tables_are_read(maps: Maps, folder: Path) -> None:
    """CombiTable2D: text with the line #1, and MAT v4. Row and column 0 have the values of the inputs."""
    found = loadmat(folder / "maps_combitable.mat")
    table = found["thrustRatio_f2_s1"]
    assert table[0, 1:].tolist() == maps.axes["utilisation"].tolist()
    assert table[1:, 0].tolist() == maps.axes["ratio"].tolist()
    assert np.array_equal(table[1:, 1:], maps["thrustRatio"][1, 0])
    assert found["forces"].tolist() == [[6e3, 12e3]]
    # A matrix of MAT v4 begins with its type, 0 for doubles in little endian.
    assert (folder / "maps_combitable.mat").read_bytes()[:4] == b"\0\0\0\0"
    text = (folder / "maps_combitable.txt").read_text(encoding="ascii")
    assert text.startswith("#1\n")
    blocks = re.findall(r"double (\w+)\((\d+),(\d+)\)\n((?:[-\d][^\n]*\n)+)", text)
    assert {name for name, *_ in blocks} == {name for name in found if not name.startswith("__")}
    for name, rows, columns, body in blocks:
        values = np.array([line.split() for line in body.splitlines()], dtype=float)
        assert values.shape == (int(rows), int(columns))
        assert np.array_equal(values, found[name])


def test_csv_files_are_read_by_pandas(maps: Maps, folder: Path) -> None:
    table = pandas.read_csv(folder / "maps.csv", skiprows=[1])
    assert len(table) == maps.valid.size
    assert table.thrustRatio.tolist() == maps["thrustRatio"].ravel().tolist()
    assert table.reason.notna().sum() == len(maps.reasons)
    loss = pandas.read_csv(folder / "torque_loss.csv")
    assert len(loss) == maps.valid.sum()
    assert np.allclose(loss.torque_loss_Nm, maps["torqueLoss"][maps.valid], rtol=1e-8)
    assert loss.speed_rpm.max() == pytest.approx(300.0 * 30.0 / math.pi)
    assert list(table)[:4] == ["force", "speed", "ratio", "utilisation"]


def test_the_program_writes_what_it_names(fmu: Path, maps: Maps, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = tmp_path / "out"
    words = ["--force=6000", "--speed=100", "--ratio=0.8,1.2", "--utilisation=-0.3,0,0.3,0.6", "--workers=1"]
    words += [f"--set={name}={value}" for name, value in MESH.items()] + ["--beside", str(folder / "maps.nc")]
    assert __main__.main(["--fmu", str(fmu), "--output", str(output), *words]) == 0
    printed = [Path(line.split(" (")[0]) for line in capsys.readouterr().out.splitlines()]
    assert len(printed) == 9
    assert all(path.is_file() for path in printed)
    text = reports.stands_alone(output / "report.html")
    assert "side by side" in text
    assert reports.figures(text) == 4 * 2 + 3
    assert not list((output / "studies").rglob("*.partial"))
    reports.look_at(output / "report.html")
