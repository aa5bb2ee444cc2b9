"""`pushbelt.Variator` and the command `pushbelt`, in the source tree."""

import math
import pickle
import zipfile
from pathlib import Path

import numpy as np
import pytest
from conftest import COARSE
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu
from test_docs_commands import reference

import pushbelt
from pushbelt import cli, variator
from pushbelt.fmu import data, files, unit
from pushbelt.fmu.enumerations import RingModel
from pushbelt.fmu.start_values import StartValueError

pytestmark = pytest.mark.usefixtures("own_cache")


def test_a_run_is_that_of_the_fmu_call_by_call(belt: variator.Variator, archive: unit.Archive) -> None:
    with unit.Instance(archive, {**data.parameter_set("bench168"), **COARSE, "ring.model": RingModel.ALE0}) as other:
        other.initialise()
        for k in range(20):
            inputs = {"primary.torque": 50.0 + k, "primary.clampingForce": 12e3}
            other.set(inputs)
            other.step_to((k + 1) * 1e-3)
            state = belt.step(1e-3, inputs)
        expected = other.outputs()
    assert belt.time == pytest.approx(0.02)
    assert {name: state[name] for name in expected} == expected
    assert belt["thrustRatio"] == expected["thrustRatio"]
    assert belt["ring.model"] == 1 and belt["secondary.clampingForce"] == 10e3


def test_outputs_are_arrays_over_all_steps(belt: variator.Variator) -> None:
    """Wrong steps are refused and change nothing."""
    assert len(belt.outputs) == 0
    belt.start()
    for _ in range(5):
        belt.step(2e-3, {"primary.torque": 55.0})
    for error, duration, inputs in (
        *((pushbelt.ArgumentError, duration, {}) for duration in (0.0, -1e-3, math.nan)),
        (StartValueError, 1e-3, {"primary.clampingForce": -1.0}), (StartValueError, 1e-3, {"belt.play": 1e-4}),
    ):  # fmt: skip
        with pytest.raises(error):
            belt.step(duration, inputs)
    run = belt.outputs
    assert run["time"] == pytest.approx(2e-3 * np.arange(6))
    assert run["primary.torque"].tolist() == [50.0] + 5 * [55.0]
    assert np.ptp(run["primary.speed"]) > 0.0
    assert {"thrustRatio", "loss.total", "macroSlip"} <= set(run.dtype.names)
    belt.step(1e-3)
    belt.close()
    assert len(belt.outputs) == 7
    with pytest.raises(pushbelt.UnitError, match="closed"):
        belt.step(1e-3)


def test_a_steady_state_is_at_the_point_and_leaves_the_run(belt: variator.Variator) -> None:
    belt.step(1e-3)
    before = belt.outputs
    state = belt.steady(1.5, 40.0, speed=150.0)
    assert state["ratio.geometric"] == pytest.approx(1.5, rel=1e-6)
    assert state["primary.externalTorque"] == pytest.approx(40.0, rel=1e-6)
    assert state["primary.speed"] == pytest.approx(150.0, rel=0.02)
    # The belt's axial force is the clamping force as well as the solution is found.
    assert state["secondary.axialForce"] == pytest.approx(belt.least_force(1.5, 40.0), rel=1e-4)
    assert -60.0 < state.load_torque < -50.0
    assert np.array_equal(belt.outputs, before)


def test_bands_are_chords_over_steady_states(belt: variator.Variator) -> None:
    deviations, force = {"friction.pulley": 1e-3, "torque": 0.5}, belt.least_force(1.5, 40.0, 2.0)
    bands = belt.bands(1.5, 40.0, deviations, force=force)
    above, below = (belt.steady(1.5, torque, force=force) for torque in (40.5, 39.5))
    for name in ("thrustRatio", "slip", "loss.total", "primary.speed"):
        of_friction, of_torque = bands.chords[name]
        assert of_torque == pytest.approx(0.5 * (above[name] - below[name]), rel=1e-4)
        assert bands[name] == pytest.approx(np.hypot(of_friction, of_torque), rel=0.02) and sum(bands.largest(name).values()) == pytest.approx(1.0)
    assert math.isnan(bands.lost) and belt.bands(1.5, 40.0, {"friction.pulley": 0.02}, safety=1.2).lost > 0.0
    assert bands.to_dataframe().loc["slip"].tolist() == pytest.approx([bands.outputs["slip"], bands["slip"], *bands.chords["slip"]])


def test_a_gradient_is_a_table_of_derivatives(belt: variator.Variator) -> None:
    force = belt.least_force(1.5, 40.0)
    state, step = belt.steady(1.5, 40.0, force=force), 0.002
    table = state.gradient(["friction.pulley", "ratio", "torque", "speed", "force", "secondary.clampingForce"])
    for name, (above, below) in {
        "ratio": [belt.steady(1.5 + sign * step, 40.0, force=force) for sign in (1.0, -1.0)],
        "speed": [belt.steady(1.5, 40.0, speed=200.0 + sign * step, force=force) for sign in (1.0, -1.0)],
    }.items():
        for output in ("thrustRatio", "slip", "loss.total", "primary.speed"):
            assert table.loc[output, name] == pytest.approx(0.5 * (above[output] - below[output]) / step, rel=0.02, abs=1e-6), (name, output)
    assert np.allclose(table["force"], table["secondary.clampingForce"], equal_nan=True) and math.isnan(table.loc["ring.stressMax", "ratio"])
    assert table.attrs["units"]["torque"] == "N.m" and table.attrs["units"]["loss.total"] == "W"
    for hold, kept in (("speed ratio", "ratio.speed"), ("forces", "primary.axialForce")):
        held = state.gradient("torque", hold=hold)
        assert abs(held.loc[kept, "torque"]) < 1e-9 * abs(table.loc[kept, "torque"]) and held.loc["ratio.geometric", "torque"] != 0.0
    with pytest.raises(pushbelt.ArgumentError, match="stored"):
        pickle.loads(pickle.dumps(state)).gradient(["torque"])


def test_without_an_fmu_its_build_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("PUSHBELT_FMU", raising=False)
    monkeypatch.setattr(files, "TREE", tmp_path)
    with pytest.raises(FileNotFoundError, match="cargo fmu build"):
        pushbelt.default_fmu()


def test_an_fmu_with_start_values_of_ones_own(fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    copy = tmp_path / "own.fmu"
    words = ["--variator", "belt155", *(f"--set={text}" for text in ("ring.model=ALE0", "initial.ratio=1.6", "initial.steady=false"))]
    assert cli.main(["fmu", str(copy), "--fmu", str(fmu), *words]) == 0
    assert f"{copy.resolve()} (" in capsys.readouterr().out
    assert not validate_fmu(str(copy))
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(copy) as target:
        assert [*source.namelist(), "resources/start-values.txt"] == target.namelist()
        other = [name for name in source.namelist() if source.read(name) != target.read(name)]
        assert "ring.model = 1\n" in target.read("resources/start-values.txt").decode()
    assert other == ["modelDescription.xml"]
    guids = [read_model_description(str(path)).guid for path in (fmu, copy)]
    assert guids[0] != guids[1] and guids[0][:20] == guids[1][:20]
    with variator.Variator({}, fmu=copy) as belt:
        assert belt["geometry.centerDistance"] == 0.155
        assert (belt["ring.model"], belt["initial.steady"]) == (1, False)
        assert belt.start()["ratio.geometric"] == pytest.approx(1.6, rel=1e-3)
    again = tmp_path / "again.fmu"
    assert cli.main(["fmu", str(again), "--fmu", str(copy), "--set", "initial.ratio=1.2"]) == 0
    with zipfile.ZipFile(again) as target:
        listed = target.read("resources/start-values.txt").decode()
        assert target.namelist().count("resources/start-values.txt") == 1
    assert "initial.ratio = 1.2\n" in listed and "initial.steady = false\n" in listed and "1.6" not in listed
    assert read_model_description(str(again)).guid not in guids


@pytest.mark.parametrize(("command", "values"), [("fmu", ["ring.model=ALE0", "mesh.strand=7", "initial.ratio=1.3"]), ("map-fmu", ["initial.ratio=1.3"])])
def test_a_copy_for_fmi_3_starts_like_that_for_fmi_2(
    command: str, values: list[str], fmu: Path, fmu3: Path, map_fmu: Path, map_fmu3: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, path in (("FMU", fmu), ("FMU3", fmu3), ("MAP_FMU", map_fmu), ("MAP_FMU3", map_fmu3)):
        monkeypatch.setenv(f"PUSHBELT_{name}", str(path))
    ends = []
    for name, words in (("two.fmu", []), ("three.fmu", ["--fmi3"])):
        copy = tmp_path / name
        assert cli.main([command, str(copy), *words, *(f"--set={one}" for one in values)]) == 0
        assert not validate_fmu(str(copy))
        ends.append(simulate_fmu(str(copy), stop_time=0.01, output_interval=1e-3, output=["ratio.geometric", "secondary.speed"])[-1].tolist())
    assert read_model_description(str(copy)).fmiVersion == "3.0"
    assert ends[0] == pytest.approx(ends[1], rel=1e-9) and ends[0][1] == pytest.approx(1.3, rel=0.01)


@pytest.mark.parametrize("name", cli.PROGRAMS)
def test_programs_have_the_fmu_and_a_folder_unless_they_are_named(name: str, monkeypatch: pytest.MonkeyPatch, fmu: Path, tmp_path: Path) -> None:
    monkeypatch.setenv("PUSHBELT_FMU", str(fmu))
    monkeypatch.setattr("sys.argv", ["pushbelt"])
    parser = reference.parser_of(cli.main, [name])
    needed = {"belt": "--width 30 --layers 12 --length 0.7 --center-distance 0.17", "compare": "a b", "durability": "a"}
    words = needed.get(name, "").split()
    options = parser.parse_args(words)
    assert (options.fmu, options.output, parser.prog) == (fmu, Path(f"pushbelt-{name}"), f"pushbelt {name}")
    monkeypatch.setenv("PUSHBELT_FMU", str(tmp_path / "none.fmu"))
    if name in ("compare", "durability", "calibrate"):
        assert parser.parse_args(words).fmu is None
    else:
        with pytest.raises(FileNotFoundError, match="environment variable PUSHBELT_FMU"):
            parser.parse_args(words)
