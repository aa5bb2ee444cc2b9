"""The variator from maps as an FMU: in fmpy, with other tables, against the detailed unit and against `MapVariator`."""

from __future__ import annotations

import os
import re
import zipfile
from collections.abc import Iterator
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from sample_maps import default_maps
from scipy.interpolate import PchipInterpolator

from pushbelt import MapVariator, cli
from pushbelt.demo import simulate as demo
from pushbelt.drive import simulate
from pushbelt.drive.cycle import CYCLES
from pushbelt.drive.measure import measure
from pushbelt.drive.thrust_map import ThrustMap
from pushbelt.drive.vehicle import demo_car
from pushbelt.fmu.data import manoeuvre_inputs, parameter_set, torque_capacity
from pushbelt.fmu.steady import driven_at_speed, driven_by_torque
from pushbelt.fmu.unit import Archive, Instance, UnitError
from pushbelt.maps import unit as map_unit
from pushbelt.maps.data import MapError, Maps
from pushbelt.whole_file import copy_archive

LOADS = {"primary.torque": 60.0, "secondary.torque": -58.0, "primary.clampingForce": 14e3, "secondary.clampingForce": 10e3}


@pytest.fixture(scope="module")
def maps_archive(map_fmu: Path) -> Iterator[Archive]:
    with Archive.unpack(map_fmu) as unpacked:
        yield unpacked


def test_both_versions_are_valid_and_agree(map_fmu: Path, map_fmu3: Path) -> None:
    outputs = ["ratio.geometric", "slip", "primary.speed", "loss.total"]
    results = []
    for path in (map_fmu, map_fmu3):
        assert validate_fmu(path) == []
        result = fmpy.simulate_fmu(path, stop_time=1.0, output_interval=0.01, start_values=LOADS, output=outputs)
        results.append(np.array([result[name] for name in outputs]))
    assert np.array_equal(*results)
    assert np.ptp(results[0][0]) > 0.005


def test_an_array_from_maps_runs_backwards_as_forwards() -> None:
    """Each has the states of one that runs alone, the other way round."""
    found = []
    for signs in ([1.0], [1.0, -1.0]):
        variators, sign = MapVariator(count=len(signs)), np.array(signs)
        variators.start(1.2, 200.0 * sign)
        for _ in range(20):
            variators.step(0.01, 60.0 * sign, -58.0 * sign, 14e3, 10e3)
        found += np.transpose([variators.ratio, sign * variators.primary_speed, sign * variators.secondary_speed]).tolist()
    assert found[1] == pytest.approx(found[0], rel=1e-12) and found[2] == pytest.approx(found[0], rel=1e-12)
    assert abs(found[0][0] - 1.2) > 0.01


def test_tables_and_description_belong_together(map_fmu: Path, tmp_path: Path) -> None:
    """Other tables need another token; those that are put back have the first one."""
    with zipfile.ZipFile(map_fmu) as archive:
        tables, described = archive.read(map_unit.TABLES_FILE), archive.read("modelDescription.xml")
    assert tables == map_unit.default_maps().read_bytes()
    other, copy, back = (tmp_path / f"{name}.fmu" for name in ("other", "copy", "back"))
    same = tables.replace(b'"version":2', b'"version": 2', 1)
    copy_archive(map_fmu, other, {}, {map_unit.TABLES_FILE: same})
    with Archive.unpack(other) as archive, pytest.raises(UnitError, match="belongs to another binary"):
        Instance(archive, {})
    map_unit.write_tables(map_fmu, copy, same)
    with Archive.unpack(copy) as archive, Instance(archive, {}) as unit:
        unit.initialise()
    map_unit.write_tables(copy, back, tables)
    with zipfile.ZipFile(back) as archive:
        assert archive.read("modelDescription.xml") == described
    # A byte-order mark, which an editor may add, does not change the token, as in the library.
    assert map_unit.hash_of(b"\xef\xbb\xbf{}") == map_unit.hash_of(b"{}") != map_unit.hash_of(b"")


def test_steady_states_are_those_of_the_detailed_unit(archive: Archive, maps_archive: Archive) -> None:
    """At points between those of the tables: slip, thrust ratio and loss with a held primary sheave."""
    for ratio, speed, torque, force in ((0.75, 140.0, 50.0, 8e3), (1.3, 260.0, 60.0, 12e3), (1.0, 330.0, -40.0, 10e3)):
        values = driven_by_torque({}, ratio, speed, torque, force)
        found = []
        for unpacked in (archive, maps_archive):
            with Instance(unpacked, values) as unit:
                unit.initialise()
                unit.step_to(0.01)
                found.append(unit.outputs())
        detailed, mapped = found
        assert mapped["slip"] == pytest.approx(detailed["slip"], rel=0.2, abs=2e-4)
        assert mapped["thrustRatio"] == pytest.approx(detailed["thrustRatio"], rel=0.03)
        assert mapped["loss.total"] == pytest.approx(detailed["loss.total"], abs=0.006 * abs(torque) * speed)
        assert mapped["loss.shafts"] == pytest.approx(detailed["loss.shafts"], rel=0.01)


SLIPPING = (0.6, -0.5, -0.3), (0.6, 0.8, -0.3), (1.6, 0.8, 0.3)  # Shifts in which the detailed belt slips through
STEPS = {(s, share, excess) for s in (0.6, 1.0, 1.6) for share in (-0.5, 0.0, 0.5, 0.8) for excess in (-0.3, 0.3)}.difference(SLIPPING)


@pytest.mark.parametrize(("s", "share", "excess"), sorted(STEPS))
def test_shifts_are_those_of_the_detailed_unit(s: float, share: float, excess: float, archive: Archive, maps_archive: Archive) -> None:
    """At 12 kN and 200 rad/s, 60 to 120 ms after a change of ln F_P. The driven shaft is light: it does not load the belt."""
    load, rates = -share * torque_capacity(parameter_set("bench168"), 1.0 / s, 12e3) / s, []
    for unpacked in (archive, maps_archive):
        with Instance(unpacked, driven_at_speed({"secondary.inertia": 0.003}, 1.0 / s, 200.0, load, 12e3)) as unit:
            unit.initialise()
            holding = unit.get("primary.axialForce") if unpacked is archive else 12e3 * unit.get("map.holdingThrustRatio")
            unit.set({"primary.clampingForce": holding * np.exp(excess)})
            unit.step_to(0.06)
            begin = unit.get("ratio.geometric")
            unit.step_to(0.12)
            rates.append(np.log(unit.get("ratio.geometric") / begin))
    assert rates[1] == pytest.approx(rates[0], rel=0.12)


def manoeuvre_of(unpacked: Archive, duration: float) -> dict[str, np.ndarray]:
    """The demo's manoeuvre in steps of 10 ms: outputs by name."""
    inputs, known = manoeuvre_inputs(), {variable.name for variable in unpacked.description.modelVariables}
    start = {**parameter_set("bench168"), **demo.START_VALUES, **inputs.at(0.0)}
    names, rows = ["ratio.geometric", "primary.speed", "secondary.speed", "macroSlip"], []
    with Instance(unpacked, {name: value for name, value in start.items() if name in known}) as unit:
        unit.initialise()
        for k in range(round(duration / 0.01)):
            unit.set(inputs.at(0.01 * k))
            unit.step_to(0.01 * (k + 1))
            rows.append([float(unit.get(name)) for name in names])
    return dict(zip(names, np.array(rows).T, strict=True))


def test_the_manoeuvre_of_the_demo(archive: Archive, maps_archive: Archive) -> None:
    """Forces are given and no controller corrects the ratio, so its errors add up, until the over-torque at 8.5 s."""
    detailed, mapped = (manoeuvre_of(unpacked, 10.0) for unpacked in (archive, maps_archive))
    before = slice(50, 850)
    ratios = [one["ratio.geometric"][before] for one in (detailed, mapped)]
    error = np.sqrt(np.mean((ratios[1] - ratios[0]) ** 2)) / np.ptp(ratios[0])
    speed = np.max(np.abs(mapped["secondary.speed"][before] / detailed["secondary.speed"][before] - 1.0))
    assert error < 0.04 and speed < 0.05
    # Launch: the clutch of the manoeuvre brings the belt to its capacity.
    assert np.max(np.abs(mapped["primary.speed"][50:150] / detailed["primary.speed"][50:150] - 1.0)) < 0.015
    # In the over-torque both slip through, and both recover.
    for one in (detailed, mapped):
        assert one["macroSlip"][850:920].any()
        assert not one["macroSlip"][-20:].any()


SECTIONS = [(0.0, 1800.0)] if "PUSHBELT_WHOLE_CYCLE" in os.environ else [(10.0, 40.0), pytest.param((1478.0, 1640.0), marks=pytest.mark.slow)]  # fmt: skip
"""The first launch and half of the extra-high part of the WLTC, s; or all of it, for the page on levels."""


@pytest.mark.parametrize("span", SECTIONS)
def test_the_wltc(span: tuple[float, float], archive: Archive, maps_archive: Archive, fmu: Path, drive_folder: Path) -> None:
    """With slip control, in the detailed unit and in that of maps: ratio relative to its range, driving energy, belt loss."""
    car = demo_car()
    table = ThrustMap.of_maps(measure(fmu, simulate.unit_parameters(car, "ALE", "coarse"), drive_folder))
    setup = simulate.Setup("slip control", "slip", CYCLES["wltc"][1]().section(*span))
    detailed, mapped = (simulate.run(unpacked, car, table, setup) for unpacked in (archive, maps_archive))
    off = mapped["ratio.geometric"] - detailed["ratio.geometric"]
    energy = [run["work.engine"][run["work.engine"] > 0.0].sum() for run in (detailed, mapped)]
    loss = [float(np.mean(run["loss.total"] - run["loss.shafts"])) for run in (detailed, mapped)]
    found = np.sqrt(np.mean(off**2)) / np.ptp(detailed["ratio.geometric"]), energy[1] / energy[0] - 1.0, loss[1] / loss[0] - 1.0
    print(*(f"{100 * one:.2f} %" for one in found), *(f"{run.processor_time:.1f} s" for run in (detailed, mapped)))
    assert found[0] < 0.02 and abs(found[1]) < 0.003 and abs(found[2]) < 0.05


@pytest.mark.parametrize(
    ("ratio", "speed", "torque", "force", "thrust"),
    [(1.0, 200.0, 60.0, 1e4, 1.5), (2.0, 100.0, 30.0, 6e3, 1.1), (0.5, 300.0, -20.0, 8e3, 1.9), (1.0, 0.0, 20.0, 6e3, 1.3),
     (1.0, 200.0, 150.0, 1e4, 1.2), (1.0, 400.0, -150.0, 1e4, 1.2)],
)  # fmt: skip
def test_map_variator_has_the_equations_of_the_fmu(
    maps_archive: Archive, ratio: float, speed: float, torque: float, force: float, thrust: float
) -> None:
    """Shifts, a launch, overrun and macro-slip in both, in steps of 0.5 ms; the error is that of implicit Euler steps."""
    inertias = {"primary.inertia": 0.15, "secondary.inertia": 8.0, "primary.drag.constant": 2.0, "secondary.drag.viscous": 0.02}
    start = {"initial.ratio": ratio, "initial.primarySpeed": speed, "initial.steady": False, "inputs.ramp": 0.0}
    loads = (torque, -torque * ratio, thrust * force, force)
    own = MapVariator(parameters=inertias, count=3)
    own.start(ratio, speed)
    with Instance(maps_archive, {**start, **inertias, **dict(zip(LOADS, loads, strict=True))}) as unit:
        unit.initialise()
        for k in range(1000):
            unit.step_to(5e-4 * (k + 1))
            own.step(5e-4, *loads)
        expected = unit.outputs()
    assert own.primary_speed[2] == pytest.approx(expected["primary.speed"], rel=2e-3, abs=1e-4)
    assert own.secondary_speed[2] == pytest.approx(expected["secondary.speed"], rel=1e-3, abs=1e-4)
    assert own.ratio[2] == pytest.approx(expected["ratio.geometric"], rel=1e-3)
    assert np.ptp(own.primary_speed) == 0.0


def test_drag_brings_a_light_shaft_to_rest_in_one_long_step() -> None:
    own = MapVariator(parameters={"primary.inertia": 0.01, "primary.drag.constant": 0.5})
    own.start(1.0, 0.5)
    own.step(0.1, 0.0, 0.0, 0.0, 0.0)
    assert 0.0 < own.primary_speed[0] < 0.3


def test_map_variator_refuses_what_it_does_not_know(tmp_path: Path, map_fmu: Path) -> None:
    with pytest.raises(ValueError, match="belt.play"):
        MapVariator(parameters={"belt.play": 1e-4})
    path = tmp_path / "no.fmu"
    path.write_bytes(b"no archive")
    with pytest.raises(MapError, match=r"no\.fmu"):
        MapVariator(path)
    assert MapVariator(map_fmu).parameters["friction.pulley"] == 0.09


def test_the_command_writes_an_fmu_from_maps(map_fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Maps with one force and one speed, and another friction."""
    maps, path, copy = default_maps(), tmp_path / "maps.json", tmp_path / "copy.fmu"
    axes = {**maps.axes, "force": maps.axes["force"][:1], "speed": maps.axes["speed"][:1]}
    parameters = {**maps.parameters, **MapVariator().parameters, "friction.pulley": 0.08}
    Maps(axes, {name: table[:1, :1] for name, table in maps.tables.items()}, parameters).write(path)
    words = ["map-fmu", str(copy), "--maps", str(path), "--fmu", str(map_fmu), "--set", "secondary.inertia=2"]
    assert cli.main(words) == 0
    assert str(copy) in capsys.readouterr().out
    with Archive.unpack(copy) as unpacked, Instance(unpacked, {"initial.ratio": axes["ratio"][3]}) as unit:
        unit.initialise()
        assert (unit.get("friction.pulley"), unit.get("secondary.inertia")) == (0.08, 2.0)
        traction = PchipInterpolator(axes["slipShare"], maps["traction"][0, 0, 3])
        utilisation = traction(unit.get("slip") / maps["capacitySlip"][0, 0, 3, 1])
        assert unit.get("torqueUtilisation") == pytest.approx(utilisation, rel=1e-2)
    written = copy.read_bytes()
    assert cli.main(["map-fmu", str(tmp_path / "copy.zip")]) == 1
    assert cli.main(["map-fmu", str(copy), "--maps", str(tmp_path / "none.nc")]) == 1
    assert cli.main([*words[:6], "--set", "friction.pulley=0.5"]) == 1
    assert "wedgeAngle" in capsys.readouterr().err and copy.read_bytes() == written, "a file that works stays"


def test_an_fmu_that_is_missing_is_named(fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("PUSHBELT_MAP_FMU", str(tmp_path / "none.fmu"))
    for words, why in (([], "there is no FMU at .*none.fmu"), (["--fmu", str(fmu)], "no FMU of maps")):
        assert cli.main(["map-fmu", str(tmp_path / "copy.fmu"), *words]) == 1
        assert re.fullmatch(f"pushbelt map-fmu: .*{why}.*\n", capsys.readouterr().err) and not list(tmp_path.iterdir())
