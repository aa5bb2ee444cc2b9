"""Capacity of the belt: wrong units are answered before anything is solved, and clamping forces carry the torque on both pulleys."""

from pathlib import Path

import numpy as np
import pytest
from conftest import COARSE, WORDS

from pushbelt import StartValueError, Variator, VariatorWarning, cli
from pushbelt.fmu import unit
from pushbelt.points import LEAST_FORCE, MOST_STATES, SteadyStateError

NO_POINT = [
    ({"ratio": -1.0}, "ratio = -1"), ({"ratio": 0.0}, "ratio = 0"), ({"torque": float("nan")}, "torque = nan"),
    ({"force": -5e3}, "force = -5000 N"), ({"safety": 0.0}, "safety = 0 "),
]  # fmt: skip
BEYOND = [
    ({"torque": 40.0, "force": 9.0}, r"0.09\d+ N·m at 9 N. .* 9 kN"), ({"torque": -35.0, "force": 14.0}, r"-35 N·m, .* at 14 N. .* 14 kN"),
    ({"torque": 45e3, "force": 15e3}, r"45000 N·mm"), ({"torque": 70e3}, r"70000 N·m .* kN, above 300 kN. .* N·mm"),
    ({"torque": 300.0, "force": 9e3}, r"\d+\.?\d* N·m at 9000 N$"), ({"torque": 1500.0, "force": 20.0}, r"at 20 N$"),
    ({"torque": 6.0, "force": 25.0}, "25 kN"), ({"torque": 250.0, "force": 290.0}, "290 kN"), ({"torque": 250.0, "force": 310.0}, r"at 310 N$"),
]  # fmt: skip


@pytest.fixture
def initialised(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """One entry for each initial state that an FMU solves."""
    calls, original = [], unit.Instance.initialise
    monkeypatch.setattr(unit.Instance, "initialise", lambda self: (calls.append(self), original(self))[1])
    return calls


@pytest.mark.parametrize(("error", "point", "why"), [*((ValueError, *one) for one in NO_POINT), *((SteadyStateError, *one) for one in BEYOND)])
def test_what_no_belt_carries_is_refused_before_anything_is_solved(coarse: Variator, initialised: list, error: type, point: dict, why: str) -> None:
    for call in (coarse.steady, coarse.linearize):
        with pytest.raises(error, match=why):
            call(**{"ratio": 1.0, "torque": 40.0, **point})
    assert not initialised


@pytest.mark.filterwarnings("error")
def test_forces_in_kilonewtons_are_refused_at_the_start_and_give_a_warning_in_a_run(fmu: Path, initialised: list[object]) -> None:
    with Variator("bench168", {**COARSE, "secondary.clampingForce": 11.0}, fmu=fmu) as run:
        with pytest.raises(StartValueError, match=r"secondary.clampingForce = 11 N: .*Is the force in kN\?"):
            run.start()
    assert not initialised
    with Variator("bench168", COARSE, fmu=fmu) as run:
        run.start()
        with pytest.warns(VariatorWarning, match=r"Is the force in kN\?") as caught:
            run.set({"secondary.clampingForce": 13.0})
        assert caught[0].filename == __file__, "the warning names the line of the caller"
        # An open pulley, and a torque beyond the capacity that no unit explains.
        run.set({"secondary.clampingForce": 0.0})
        run.set({"secondary.clampingForce": 9e3, "primary.torque": 300.0})


@pytest.mark.filterwarnings("error")
def test_a_speed_in_rpm_gives_a_warning(coarse: Variator) -> None:
    with pytest.warns(VariatorWarning, match=r"\d+ m/s, above 60 m/s. .* 3000 rpm are 314.2"):
        coarse.steady(1.1, 20.0, speed=3000.0, force=9e3)
    coarse.steady(1.1, 20.0, speed=600.0, force=9e3)


def test_the_command_line_answers_too(fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["linearize", "initial.ratio=1.2", "primary.torque=30", "--fmu", str(fmu), "--output", str(tmp_path / "out"), *WORDS]
    for force, more, said in (("8", (), "Is the force in kN?"), ("8000", ("initial.primarySpeed=2500",), "  warning: 2500 rad/s at ratio 1.2")):
        assert cli.main([*words, f"secondary.clampingForce={force}", *more]) == 1 or more
        error = capsys.readouterr().err
        assert said in error and ".py:" not in error


@pytest.mark.parametrize("ratio", [0.5, 0.9, 1.6, 2.1])
@pytest.mark.parametrize("torque", [-110.0, -25.0, 25.0, 110.0])
def test_both_pulleys_carry_the_torque(coarse: Variator, initialised: list[object], ratio: float, torque: float) -> None:
    force = coarse.least_force(ratio, torque)
    assert 1 <= len(initialised) <= MOST_STATES
    state = coarse.steady(ratio, torque, force=force)
    safety = coarse.torque_capacity(ratio, force, state["thrustRatio"]) / abs(torque)
    assert safety > 1.26
    assert safety < 1.35 or force == LEAST_FORCE
    # Without a solution, by a known thrust ratio.
    count = len(initialised)
    known = coarse.least_force(ratio, torque, thrust_ratio=state["thrustRatio"])
    assert len(initialised) == count and known == pytest.approx(force, rel=0.03)


def test_a_point_that_the_belt_does_not_carry_is_refused(coarse: Variator) -> None:
    capacity = coarse.torque_capacity(1.0, 10e3)
    coarse.steady(1.0, 0.8 * capacity, force=10e3)
    for ratio, torque, force, named in ((1.0, 1.3 * capacity, 10e3, "at ratio 1, "), (30.0, 10.0, None, "initial.ratio = 30 is out of range")):
        with pytest.raises(SteadyStateError, match=named):
            coarse.steady(ratio, torque, force=force)
    assert coarse.steady(1.0, 0.0, force=10e3)["thrustRatio"] > 0.0


def test_a_map_holds_the_steady_states_and_has_overrun_in_underdrive(coarse: Variator) -> None:
    """Overrun was beyond capacity when the force counted the secondary pulley only."""
    found = coarse.thrust_map([1.5, 2.2], [-90.0, -15.0])
    assert (found["reason"] == "").all() and (found["thrustRatio"] < 1.0).all()
    assert not list(coarse.linear_grid([2.0], [-45.0, 45.0]).refused())
    found = coarse.thrust_map([0.6, 1.0], [-20.0, 60.0, 900.0], force=9e3)
    assert found.sizes == {"ratio": 2, "torque": 3}
    state, point = coarse.steady(0.6, 60.0, force=9e3), found.sel(ratio=0.6, torque=60.0)
    for name in ("thrustRatio", "efficiency"):
        assert float(point[name]) == pytest.approx(state[name])
    assert np.isnan(found["thrustRatio"].sel(torque=900.0)).all()
    assert (found["reason"] == "").values.tolist() == [[True, True, False]] * 2
    assert found["primary.speed"].attrs == {"units": "rad/s", "long_name": "Speed of the primary pulley"}


def test_a_solved_state_is_not_solved_again(coarse: Variator, initialised: list[object]) -> None:
    """It gave the force, and gives its gradient and bands. In drive at this ratio the first thrust ratio is above 1."""
    assert coarse.steady(0.8, 52.0).gradient("torque").loc["slip", "torque"] > 0.0
    assert len(initialised) == 1
    coarse.thrust_map([0.8], [50.0], force=12e3, deviations={"friction.pulley": 1e-3})
    assert len(initialised) == 1 + 1 + 2
