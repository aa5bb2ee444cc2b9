"""Forces that close the pulleys: the law in Python against the FMU's outputs, and what holds a point with cylinders."""

import json
import math
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from conftest import COARSE, MESH, ROOT, WORDS

import pushbelt
from pushbelt import ArgumentError, Variator, cli, load_linear, parameter_set
from pushbelt.fmu.closing import closing_at, closing_force, sheave_position
from pushbelt.fmu.unit import Archive
from pushbelt.study.tasks import Solver, variator
from pushbelt.sweep.design import Varied, crossed
from pushbelt.sweep.point import solve
from pushbelt.sweep.results import table
from pushbelt.sweep.study import Study, warnings_of

CYLINDERS = str(ROOT / "resources" / "bench168-cylinders.json")
PULLEYS = ("primary", "secondary")
OIL = {"primary.clampingForce": 0.0, "secondary.clampingForce": 0.0, "primary.pressure": 9e5, "secondary.pressure": 1e6}


@pytest.fixture(scope="module")
def pressed(fmu: Path) -> Iterator[Variator]:
    with Variator(CYLINDERS, COARSE, fmu=fmu) as opened:
        yield opened


def test_the_law_is_that_of_the_fmu(fmu: Path) -> None:
    """Clamp, pressure, spring, rotating oil and seals, while the ratio changes."""
    more = {f"{pulley}.cylinder.{name}": value for pulley in PULLEYS for name, value in (("springStiffness", 2e4), ("seal", 300.0))}
    loads = {**OIL, "primary.clampingForce": 700.0, "primary.torque": 30.0, "secondary.torque": -21.0, "initial.ratio": 0.7}
    with Variator(CYLINDERS, {**COARSE, **more, **loads}, fmu=fmu) as run:
        run.start()
        for _ in range(3):
            run.step(0.005, {"primary.pressure": 1.9e6})
            for pulley in PULLEYS:
                position, speed, velocity = (run[f"{pulley}.{name}"] for name in ("position", "speed", "sheaveVelocity"))
                assert abs(velocity) > 1e-3
                values = {name: run[name] for name in run.variables if name in OIL or ".cylinder." in name}
                seal = run[f"{pulley}.cylinder.seal"] * velocity / math.hypot(velocity, run["friction.velocity"])
                assert closing_force(values, pulley, position, speed) - seal == pytest.approx(run[f"{pulley}.clampingForceTotal"], rel=1e-12)
        place = sheave_position(parameter_set(CYLINDERS), "secondary", run["ratio.geometric"])
        assert run["secondary.position"] == pytest.approx(place, abs=2e-4)


@pytest.mark.parametrize("ratio", [0.55, 1.0, 1.9])
def test_points_are_held_by_pressure(pressed: Variator, ratio: float) -> None:
    state = pressed.steady(ratio, 45.0, force=12e3)
    assert state["secondary.clampingForceTotal"] == pytest.approx(12e3, rel=3e-4)
    assert state["torqueUtilisation"] == pytest.approx(45.0 / pressed.torque_capacity(ratio, 12e3), rel=0.02)
    model = pressed.linearize(ratio, 45.0, force=12e3)
    assert model.held["primary.clampingForce"] == model.held["secondary.clampingForce"] == 0.0
    cylinders = {name: value for name, value in parameter_set(CYLINDERS).items() if ".cylinder." in name}
    for pulley, force in (("primary", state["primary.axialForce"]), ("secondary", 12e3)):
        place = state[f"{pulley}.position"], state[f"{pulley}.speed"]
        assert closing_force({**cylinders, **model.held}, pulley, *place) == pytest.approx(force, rel=1e-3)


def test_without_a_safety_factor_the_force_is_that_of_the_inputs(fmu: Path) -> None:
    with Variator(CYLINDERS, {**COARSE, **OIL}, fmu=fmu) as run:
        state, values = run.steady(0.7, 40.0, safety=None), {**parameter_set(CYLINDERS), **OIL}
        assert state["secondary.clampingForceTotal"] == pytest.approx(closing_at(values, "secondary", 0.7, 200.0), rel=1e-3)
        assert run.linearize(0.7, 40.0, safety=None).held["secondary.pressure"] == pytest.approx(1e6, rel=1e-3)


def test_a_force_that_no_pressure_gives_is_refused(pressed: Variator) -> None:
    with pytest.raises(pushbelt.SteadyStateError, match=r"secondary.pressure = .* out of its range"):
        pressed.steady(1.0, 20.0, force=250e3)


@pytest.mark.parametrize(
    ("words", "pressures"),
    [(["secondary.clampingForce=0", "secondary.pressure=1e6"], [1e6]), (["secondary.pressure=9e5,1.2e6"], [9e5, 1.2e6]),
     (["secondary.clampingForce=10447.46"], [1e6])],
)  # fmt: skip
def test_linearize_takes_pressures(fmu: Path, tmp_path: Path, words: list[str], pressures: list[float]) -> None:
    point = ["initial.ratio=1", "initial.primarySpeed=209.44", "primary.torque=40"]
    more = ["--variator", CYLINDERS, "--fmu", str(fmu), "--output", str(tmp_path)]
    assert cli.main(["linearize", *words, *point, *more, *WORDS]) == 0
    models = [model for _, model in load_linear(tmp_path / "models.npz").points()]
    assert [model.held["secondary.pressure"] for model in models] == pytest.approx(pressures, rel=1e-3)
    assert all(model.held["primary.pressure"] > 5e5 for model in models)


def test_sweeps_know_the_whole_force(fmu: Path) -> None:
    """Torques and utilisations with a pressure beside a clamping force, and without one."""
    columns = [Varied("initial.ratio", (0.7, 1.5)), Varied("secondary.clampingForce", (0.0, 6e3)), Varied("secondary.pressure", (1e6,))]
    parameters = variator(CYLINDERS, "ALE0", {**MESH, "friction.pulley": 0.085})
    for given in (Varied("primary.torque", (50.0,)), Varied("utilisation", (0.4,))):
        study = Study(fmu, parameters, crossed([*columns, given]))
        with Archive.unpack(fmu) as archive, closing(Solver(archive, study.parameters, solve)) as solver:
            rows = table(study, dict(solver.solve(list(enumerate(study.tasks()))))).to_pylist()
        for row in rows:
            assert row["reason"] is None and row["utilisation"] == pytest.approx(row["torqueUtilisation"], rel=0.02)
            values = study.start_values(study.grid.points()[row["point"]])
            whole = closing_at(values, "secondary", row["initial.ratio"], row["initial.primarySpeed"])
            assert row["secondary.clampingForceTotal"] == pytest.approx(whole, rel=1e-3)
    beside = Study(fmu, parameters, crossed([Varied("secondary.pressure", (1e6,))]))
    assert any("acts beside secondary.pressure" in text for text in warnings_of(beside))
    loads = {"secondary.clampingForce": 0.0, "secondary.pressure": 12.0, "primary.torque": 50.0}
    in_bar = crossed([Varied(name, (value,)) for name, value in loads.items()])
    with pytest.raises(ArgumentError, match=r"Is the pressure in bar\? 12 bar are 1.2e\+06 Pa"):
        list(warnings_of(Study(fmu, parameters, in_bar)))


def test_a_set_adds_to_its_base(tmp_path: Path) -> None:
    found, base = parameter_set(CYLINDERS), parameter_set("bench168")
    assert base.items() <= found.items() and found["primary.cylinder.area"] == 0.014
    for name, over in (("own", "next.json"), ("next", "belt155"), ("ring", "ring.json"), ("wrong", 5), ("lost", "bench169")):
        document = {"base": over, "parameters": {"friction.pulley": {"value": 0.08}} if name != "next" else {}}
        (tmp_path / f"{name}.json").write_text(json.dumps(document), encoding="utf-8")
    assert parameter_set(str(tmp_path / "own.json")) == {**parameter_set("belt155"), "friction.pulley": 0.08}
    for name, why in (("ring", "which adds to it"), ("wrong", "5"), ("lost", "bench169")):
        with pytest.raises(pushbelt.PushbeltError, match=why):
            parameter_set(str(tmp_path / f"{name}.json"))
    with pytest.raises(pushbelt.PushbeltError, match='lack geometry.centerDistance.*"base"'):
        closing_at({"secondary.cylinder.springStiffness": 1.0}, "secondary", 1.2, 200.0)
