"""Planned points of a calibration."""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from conftest import WORDS

from pushbelt.calibrate import __main__, plan
from pushbelt.calibrate.model import Model
from pushbelt.calibrate.parameters import Parameter
from pushbelt.calibrate.worker import Found, Job
from pushbelt.errors import ArgumentError
from pushbelt.fmu.data import parameter_set, torque_capacity
from pushbelt.tables import points as tables
from pushbelt.tables.points import Measured, Point

BENCH = parameter_set("bench168")
WITHIN = {plan.SPEED: (100.0, 300.0), plan.FORCE: (8e3, 20e3)}
TWO = [Parameter(name, (name,), "1", 1.0, 0.0, np.inf) for name in "ab"]
FIXED = ("primary.speed=200:200", "secondary.clampingForce=1e4:1e4")
SLIP = (Measured("slip", np.nan, 0.01, True),)


def places(*torques: float) -> list[Point]:
    return [Point(0, "", 1.0, None, 100.0, torque, 1e4, None, SLIP) for torque in torques]


def planned(points: list[Point], count: int, known: int = 0, start: float = 1.0) -> plan.Plan:
    """A plan for the slip a + b T/40, where b starts at a value."""

    def solve(jobs: Sequence[Job]) -> list[Found]:
        return [Found({"slip": values["a"] + values["b"] * point.torque / 40.0, "thrustRatio": 1.0}) for values, point in jobs]

    two = [Parameter(name, (name,), "1", first, 0.0, np.inf) for name, first in (("a", 1.0), ("b", start))]
    return plan.plan(Model(points, solve), known, two, BENCH, count)


def test_a_line_is_measured_at_its_ends() -> None:
    """Two points at each end, so that each end remains if a point is lost; the interval is that of the line."""
    found = planned(places(*range(41)), 4)
    at = np.array(sorted(point.torque for point in found.points)) / 40.0
    assert at == pytest.approx([0.0, 0.025, 0.975, 1.0])
    half = 4.302653 * 0.01 / np.sqrt(np.sum((at - 0.5) ** 2))  # Student's t of two degrees of freedom
    assert found.widths["b"][:2] == (np.inf, pytest.approx(half, rel=1e-6))
    # Three points remain, with one degree of freedom.
    assert found.widths["b"][2] == pytest.approx(12.7062 * 0.01 / np.sqrt(np.ptp(at) ** 2 * 2 / 3), rel=0.05)
    assert {point.name for point in found.points} == {"a", "b"} and not found.unseen
    # What the table has is not measured again.
    more = planned(places(0.0, 0.0, 1.0, *range(41)), 2, known=3)
    assert sorted(point.torque for point in more.points) == [39.0, 40.0] and more.widths["b"][1] < more.widths["b"][0] < np.inf


def test_what_cannot_be_planned_is_an_error() -> None:
    with pytest.raises(ArgumentError, match=r"2 of 3 places .* below 90 % .* 3 planned"):
        planned(places(10.0, 20.0, 0.95 * torque_capacity(BENCH, 1.0, 1e4)), 3)
    assert planned(places(20.0, 20.5), 2, start=1e-4).unseen == ["b"]
    with pytest.raises(ArgumentError, match="determines a or b"):
        plan.plan(Model(places(10.0), lambda jobs: [Found({"slip": 0.01, "thrustRatio": 1.0}) for _ in jobs]), 0, TWO, BENCH, 1)


def test_places_are_those_of_the_limits_and_of_the_table() -> None:
    found = plan.candidates(plan.limits(WITHIN, BENCH, []), BENCH, [])
    assert len({(p.ratio, p.speed, p.torque, p.force) for p in found}) == len(found) == np.prod(list(plan.LEVELS.values()))
    assert max(p.torque / torque_capacity(BENCH, p.ratio, p.force) for p in found) == pytest.approx(0.9)
    assert {one.quantity for one in found[0].measured} == {"thrustRatio", "slip", "efficiency"}
    table = [Point(2, "", ratio, None, 200.0, 30.0, 10e3, None, (Measured("slip", 0.01, 1e-4, True),)) for ratio in (0.5, 2.0)]
    own = plan.candidates(plan.limits({plan.TORQUE: (30.0, 40.0)}, BENCH, table), BENCH, table)
    assert {(p.speed, p.force) for p in own} == {(200.0, 10e3)} and own[0].measured[0].deviation == 1e-4
    assert not any(p.ratio in (0.5, 2.0) and p.torque < 31.5 for p in own)


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ((), "no limits of primary.speed and secondary.clampingForce"),
        (("primary.sped=1:2",), "primary.sped"),
        ((*FIXED, "ratio.geometric=2:1"), "ratio.geometric=2:1 is no ascending range within 0.3748 to 2.668"),
        ((*FIXED, "primary.torque=500:600"), "below 90 % of the capacity"),
    ],
)
def test_bad_limits_are_one_error(words: tuple[str, ...], why: str, fmu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert __main__.main(["--plan", "4", "--fmu", str(fmu), *(f"--within={word}" for word in words)]) == 1
    error = capsys.readouterr().err
    assert why in error and error.count("\n") == 1


def test_a_plan_is_a_table_to_be_filled_in(fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--plan", "2", "--fmu", str(fmu), "--output", str(tmp_path), "--fit", "friction.pulley", "--workers", "1"]
    assert __main__.main([*words, *(f"--set={word}" for word in WORDS), *(f"--within={word}" for word in (*FIXED, "ratio.geometric=1:1"))]) == 0
    assert re.search(r"friction.pulley: not determined → ±\S+ %, 2 points", capsys.readouterr().out)
    path = tmp_path / "plan.csv"
    path.write_text(path.read_text(encoding="utf-8").replace(",,\n", "1.3,0.004,\n"), encoding="utf-8")
    rig = tables.read(path)
    assert [(p.speed, p.force, len(p.measured)) for p in rig.points] == [(200.0, 1e4, 2)] * 2
    assert max(p.torque for p in rig.points) <= plan.USED * torque_capacity(BENCH, 1.0, 1e4) * 1.0001
