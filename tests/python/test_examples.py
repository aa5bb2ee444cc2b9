"""The examples: the notebook, the car, the hydraulic circuit, and the programs of the drivetrain."""

import re
import runpy
import shutil
import sys
from pathlib import Path

import nbformat
import numpy as np
import pytest
from conftest import ROOT, module_of

import pushbelt
from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.unit import Archive

DRIVETRAIN = ROOT / "examples" / "drivetrain"
CAR = module_of(DRIVETRAIN / "car.py")
PULLEYS = ("primary", "secondary")


@pytest.fixture(autouse=True)
def outside(fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to run an example in, with the FMU under test and a separate cache."""
    for name, value in {"PUSHBELT_FMU": fmu, "PYTHONPATH": ROOT / "python", "XDG_CACHE_HOME": tmp_path, "MPLBACKEND": "Agg"}.items():
        monkeypatch.setenv(name, str(value))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_notebook_runs_from_start_to_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MPLBACKEND")
    monkeypatch.syspath_prepend(ROOT / "examples")
    import notebook

    def printed(outputs: list[nbformat.NotebookNode]) -> str:
        return "".join(output.text for output in outputs if output.output_type == "stream" and output.name == "stdout")

    kept, book = nbformat.read(notebook.PATH, as_version=4), notebook.run(tmp_path)
    stored, outputs = ([output for cell in one.cells if cell.cell_type == "code" for output in cell.outputs] for one in (kept, book))
    said = printed(outputs)
    assert said == printed(stored), "run examples/notebook.py"
    assert str(ROOT) not in notebook.PATH.read_text(encoding="utf-8")
    before, after = said.split("\nratio ")[1].splitlines()[0].split(" -> ")
    assert float(before) == pytest.approx(1.5, abs=1e-3)
    assert float(after) < 1.2
    assert 1.0 < float(said.split("45 N·m: ")[1]) < 1.4
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 2
    assert not [output.text for output in outputs if output.output_type == "stream" and output.name == "stderr"]


@pytest.mark.slow
def test_the_car_launches_shifts_and_stops(outside: Path) -> None:
    run = CAR.main()
    time, torque, ratio = run["time"], run["primary.torque"], run["ratio.geometric"]
    speed = 3.6 * CAR.LEVER * run["secondary.speed"]
    assert abs(speed[0]) < 1e-3 and 45.0 < speed.max() < 60.0
    assert np.abs(speed[time > 21.5]).max() < 0.01
    # Driving, overrun after the tip-out, driving again after the tip-in, overrun while braking.
    at = lambda moment: float(np.interp(moment, time, torque))  # noqa: E731
    assert [np.sign(at(moment)) for moment in (5.0, 10.5, 13.5, 17.0)] == [1.0, -1.0, 1.0, -1.0]
    assert ratio[time < 4.0] == pytest.approx(2.2, rel=0.03)
    assert ratio.min() < 0.55 and ratio[-1] > 2.1
    # The clutch does not chatter and the belt does not slip through.
    assert np.abs(np.diff(torque)).max() < 10.0
    assert not run["macroSlip"].any()
    assert (outside / "car.png").stat().st_size > 10_000


@pytest.mark.slow
def test_a_clutch_with_too_steep_a_law_chatters() -> None:
    """The instability that the rule for external inertias prevents. Until the clutch locks both runs are smooth."""
    run = CAR.main(naive=True, end=3.0)
    changes = np.abs(np.diff(run["primary.torque"]))
    assert changes[run["time"][1:] < 2.0].max() < 10.0
    assert changes.max() > 200.0


def test_a_hydraulic_circuit_shifts_by_its_valves(tmp_path: Path) -> None:
    """Stable in steps of 1 ms, and the energies of oil, sheaves and belt are balanced."""
    example, picture = module_of(ROOT / "examples" / "hydraulics.py"), tmp_path / "hydraulics.png"
    trace, pressures, energies = example.main(str(picture))
    assert picture.stat().st_size > 10_000
    at = {time: trace["ratio.geometric"][round(time / example.STEP)] for time in (0.3, 0.8, 1.3, 1.9)}
    assert at[0.8] < at[0.3] - 0.1 and at[1.9] > at[1.3] + 0.05
    held = pressures[round(2.3 / example.STEP) :, 1]
    assert np.abs(np.diff(held, 2)).max() < 1e-4 * held.mean(), "no ripple"
    spent = ("relief", "valves", *PULLEYS, "stored")
    assert energies["pump"] == pytest.approx(sum(energies[name] for name in spent), abs=1e-6)
    for pulley in PULLEYS:
        assert energies[f"{pulley} sheave"] == pytest.approx(energies[pulley], rel=5e-3)
    assert abs(energies["belt"]) < 1e-3 * example.STEP * trace["primary.power"].sum()


def test_the_mean_flow_loses_no_oil() -> None:
    """A pulsating supply in steps of 5 ms: what is not in the compliance is in the cylinder, but with the flow at the end."""
    example = module_of(ROOT / "examples" / "hydraulics.py")
    lost = []
    for feedback in example.FEEDBACK.values():
        pressures, supplied, taken = example.coupled(5e-3, 3e-12, feedback, 3e-4, 0.4)
        assert len(pressures) == 81, "the pressure stays within bounds"
        lost.append(abs(taken / supplied - 1.0))
    assert lost[0] < 1e-9 and max(lost[1:]) > 0.03
    exact, at_end, _ = example.FEEDBACK.values()
    assert [example.is_stable(1e-3, 3e-13, feedback) for feedback in (exact, at_end)] == [True, False]


def test_rollback_makes_a_stiff_circuit_stable(fmu3: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "examples")
    monkeypatch.setenv("PUSHBELT_FMU3", str(fmu3))
    example = module_of(ROOT / "examples" / "hydraulic_hosts.py")
    stable = {way: [example.is_quiet(way, 1e-3, compliance) for compliance in (2e-14, 6e-13)] for way in example.WAYS}
    assert stable == {"rollback": [True, True], "intermediate updates": [False, True]}


def test_the_example_cylinders_follow_from_their_radii() -> None:
    """As docs/hydraulics.md derives it; the secondary one has a compensation chamber."""

    def centrifugal(inner: float, outer: float, fill: float) -> float:
        square = outer**2 - inner**2
        return np.pi * 850.0 * square * (0.25 * (outer**2 + inner**2) - 0.5 * fill**2)

    values = parameter_set(str(ROOT / "resources" / "bench168-cylinders.json"))
    for pulley, outer in (("primary", 71.3e-3), ("secondary", 61.8e-3)):
        assert values[f"{pulley}.cylinder.area"] == pytest.approx(np.pi * (outer**2 - 25e-3**2), rel=4e-3)
    assert values["primary.cylinder.centrifugal"] == pytest.approx(centrifugal(25e-3, 71.3e-3, 12e-3), rel=4e-3)
    secondary = centrifugal(25e-3, 61.8e-3, 12e-3) - centrifugal(20e-3, 62.5e-3, 0.0)
    assert values["secondary.cylinder.centrifugal"] == pytest.approx(secondary, rel=0.02)


def test_only_points_without_a_linear_model_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(DRIVETRAIN)
    import stability

    coarse = {**stability.PARAMETERS, "ring.model": "ALE0"}
    with pushbelt.Variator(coarse) as variator:
        assert stability.linear_model(variator, 1.0, 500.0, 200.0) is None
        model = stability.linear_model(variator, 1.0, 40.0, 200.0)
        belt = stability.Belt(model)
        assert belt.at[0] == pytest.approx(1.0)
        for _ in range(20):
            belt.advance(np.array([10.0, 0.0, 0.0]))
        # A ramp over one step, then ten newtons more on P: half a step late.
        time = 19.5 * stability.STEP
        expected = 10.0 * model.select(["ratio.geometric"], ["primary.clampingForce"]).step(time).item()
        assert belt.read()[0] == pytest.approx(expected, rel=2e-3)
        with pytest.raises(pushbelt.ArgumentError):
            stability.linear_model(variator, -1.0, 40.0, 200.0)


def test_a_shaft_between_units_needs_a_damper_and_derivatives_have_order_two(archive: Archive) -> None:
    """A delayed spring is a negative damper; the delay is longer with the ramp."""
    damping = module_of(DRIVETRAIN / "damping.py")
    ramp, jump, _, derivatives = damping.WAYS
    ends = {
        (way, factor): damping.amplitude(damping.run(archive, way, factor * damping.STIFFNESS * damping.STEP, damping.STEP, kick=damping.KICK)[-50:])
        for way in (ramp, jump) for factor in (0.0, 0.6, 1.0)
    }  # fmt: skip
    assert ends[ramp, 0.0] > 2.0 * ends[jump, 0.0] > 20.0 and ends[ramp, 0.6] > 0.5 > ends[jump, 0.6]
    assert max(ends[ramp, 1.0], ends[jump, 1.0]) < 0.1
    errors = {way: np.array([damping.run(archive, way, damping.STABLE, h * damping.STEP, ripple=damping.RIPPLE) for h in (1.0, 0.5, 0.25)]) for way in (jump, derivatives)}
    orders = {way: np.log2(np.abs(of[0] - of[1]).max() / np.abs(of[1] - of[2]).max()) for way, of in errors.items()}
    assert abs(orders[jump] - 1.0) < 0.3 and orders[derivatives] > 1.6


def printed(name: str, outside: Path, fmu: Path, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """Lines that a program of `examples/drivetrain` prints."""
    (outside / "target").mkdir()
    shutil.copy(fmu, outside / "target" / "PushbeltVariator.fmu")
    runpy.run_path(str(DRIVETRAIN / f"{name}.py"), run_name="__main__")
    return capsys.readouterr().out.splitlines()


@pytest.mark.parametrize(
    ("program", "last"),
    [("wiring", "step  1 ms"), ("calibrate", "| `ring.axialStiffness`"), pytest.param("friction_velocity", "5e-05 m/s", marks=pytest.mark.slow)],
)
def test_programs_run(program: str, last: str, outside: Path, fmu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert last in printed(program, outside, fmu, capsys)[-1]


def test_controller_reaches_its_target(outside: Path, fmu: Path, map_fmu: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    *states, end = printed("controller", outside, fmu, capsys)
    ratios = [float(line.split("ratio.geometric ")[1].split()[0]) for line in states]
    ratios.append(float(end.split()[1].rstrip(",")))
    assert end.endswith("target 0.8")
    assert ratios[0] == pytest.approx(1.6, rel=1e-3)
    assert ratios[2:] == pytest.approx([0.8] * len(ratios[2:]), rel=0.05)
    # The FMU of maps has the holding thrust ratio as an output.
    monkeypatch.setattr(sys, "argv", ["controller.py", str(map_fmu)])
    runpy.run_path(str(DRIVETRAIN / "controller.py"), run_name="__main__")
    end = capsys.readouterr().out.splitlines()[-1]
    assert float(end.split()[1].rstrip(",")) == pytest.approx(0.8, rel=0.03)


@pytest.mark.slow
def test_the_shift_follows_and_steps_are_those_of_the_linear_loop(outside: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found, wanted = module_of(DRIVETRAIN / "linear_control.py").main()
    assert np.abs(found - wanted).max() < 0.12
    assert abs(found[-1] - wanted[-1]) < 2e-3
    assert (outside / "linear-control.png").stat().st_size > 10_000
    said = capsys.readouterr().out
    apart = [int(share) for share in re.findall(r"at most (\d+) % of the step apart", said)]
    assert len(apart) == 6 and max(apart) <= 10
    # The loop's crossover, 1 Hz, is its time constant.
    assert list(map(float, re.findall(r"linear loop ([\d.]+) s", said))) == pytest.approx([0.5 / np.pi] * 6, rel=0.3)
