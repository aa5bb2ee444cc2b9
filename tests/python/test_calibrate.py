"""Calibration: parameters as pure functions, then fits of tables with results of the FMU."""

import dataclasses
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import reports
from conftest import MESH
from rig_tables import written

from pushbelt.calibrate import __main__, model, parameters, worker
from pushbelt.calibrate.worker import Found, Job
from pushbelt.errors import ArgumentError
from pushbelt.fmu.data import parameter_set, torque_capacity
from pushbelt.fmu.unit import Archive
from pushbelt.tables.points import Measured, Point

BASE = {**parameter_set("bench168"), **MESH}
TRUTH = {"friction.pulley": 0.098, "friction.ring": 0.07, "belt.play": 6e-4}  # True values in the tables; the fits start from `bench168`
NOISE = {"thrustRatio": 0.01, "slip": 2e-4, "efficiency": 2e-3, "ds/dt": 0.02}  # Standard deviations of the tables
SPEED, FORCE = 209.0, 10e3  # Primary speed, rad/s, and secondary force, N, of the points


def test_start_values_and_bounds_come_from_the_fmu(variables: Mapping[str, Any]) -> None:
    wanted = {"belt.play": 5e-4, "tiltStiffness": None, "belt.pushStiffness": None}
    play, tilt, push = parameters.choose(wanted, {"belt.play": (-1.0, 1e-3)}, variables, {"primary.tiltStiffness": 6e5})
    assert (play.start, play.low, play.high) == (5e-4, 0.0, 1e-3)
    assert (play.logarithmic, tilt.logarithmic) == (False, True)
    assert tilt.variables == ("primary.tiltStiffness", "secondary.tiltStiffness")
    assert (tilt.start, tilt.high) == (6e5, np.inf)
    known = variables["belt.pushStiffness"]
    assert (push.start, push.low, push.high) == (float(known.start), float(known.min), float(known.max))
    for parameter in (play, tilt, push):
        place = parameter.coordinate(1.1 * parameter.start)
        assert parameter.value(place) == pytest.approx(min(1.1 * parameter.start, parameter.high))
        low, high = parameter.bounds
        assert low < place < high


@pytest.mark.parametrize(
    ("wanted", "limits", "prior", "why"),
    [
        ({"belt.colour": None}, {}, {}, "belt.colour"), ({"ring.model": None}, {}, {}, "ring.model"), ({"thrustRatio": None}, {}, {}, "thrustRatio"),
        ({"friction.pully": None}, {}, {}, "friction.pulley"), ({"friction.pulley": 0.3}, {}, {}, "start value, 0.3"),
        ({"friction.pulley": None}, {}, {"friction.pulley": (9.0, 1.0)}, "prior, 9"), ({"belt.play": 0.0}, {}, {}, "belt.play starts at 0"),
        ({"belt.play": None}, {"friction.ring": (0.0, 1.0)}, {}, "friction.ring"),
        ({"tiltStiffness": None, "primary.tiltStiffness": None}, {}, {}, "primary.tiltStiffness"),
    ],
)  # fmt: skip
def test_parameters_that_cannot_be_fitted_are_named(wanted: dict, limits: dict, prior: dict, why: str, variables: Mapping[str, Any]) -> None:
    with pytest.raises(ArgumentError, match=why):
        parameters.choose(wanted, limits, variables, BASE, prior)


def planned(ratio: float, utilisation: float, *quantities: str, force: float = FORCE) -> Point:
    """A point without measured values."""
    torque = utilisation * torque_capacity(BASE, ratio, force)
    measured = tuple(Measured(quantity, 0.0, NOISE[quantity], True) for quantity in quantities)
    return Point(0, f"{ratio:g} {utilisation:g}", ratio, None, SPEED, torque, force, None, measured)


STEADY = [planned(ratio, share, "thrustRatio", "slip", "efficiency") for ratio in (0.5, 1.0, 2.0) for share in (0.2, 0.5, 0.7)]
SHIFTS = [dataclasses.replace(planned(ratio, 0.2, "ds/dt"), primary_force=force) for ratio, force in ((1.0, 11e3), (1.0, 19e3), (1.6, 15e3))]


@pytest.fixture(scope="module")
def solver(fmu: Path, archive: Archive) -> Callable[[Sequence[Job]], list[Found]]:
    return lambda jobs: [worker.solve(fmu, archive.directory, {**BASE, **values}, point) for values, point in jobs]


def measured(solver: Callable[[Sequence[Job]], list[Found]], points: Sequence[Point]) -> list[Point]:
    """The points as `TRUTH` has them, with noise."""
    random, found = np.random.default_rng(168), []
    for point in points:
        noisy = point
        # A shift starts at a ratio from which it passes the point's ratio if it shifts as measured, hence a second round.
        for scatter in (0.0, 1.0):
            (state,) = solver([(TRUTH, noisy)])
            values = {m.quantity: state.values[m.quantity] + scatter * m.deviation * random.standard_normal() for m in point.measured}
            noisy = dataclasses.replace(point, measured=tuple(dataclasses.replace(m, value=values[m.quantity]) for m in point.measured))
        found.append(noisy)
    return found


@pytest.mark.slow
def test_the_step_of_the_differences_stands_on_a_plateau(solver: Any, variables: Mapping[str, Any]) -> None:
    """Central differences over a third and three times the step agree to 2 % of the largest slope of their quantity. On twice the default mesh:
    on coarser ones thrust ratios, and on the default mesh a shift gain (2.2 %), have waves over the friction coefficient."""
    chosen = parameters.choose({"friction.pulley": 0.087, "friction.ring": None, "belt.play": None}, {}, variables, BASE)
    opened = model.Model([STEADY[1], STEADY[7], SHIFTS[0]], solver)
    place = np.array([parameter.coordinate(parameter.start) for parameter in chosen])
    fixed = {**parameters.assign(chosen, place), **{name: 2 * int(variables[name].start) for name in MESH}}
    base = opened.states(fixed)
    found = [opened.slopes(chosen, fixed, place, base, factor * model.STEP) for factor in (1.0 / 3.0, 1.0, 3.0)]
    assert np.abs(found[1]).max(axis=0).min() > 0.8
    for rows in opened.values.groupby("quantity").indices.values():
        assert max(np.abs(other - found[1])[rows].max() for other in found) < 0.02 * np.abs(found[1][rows]).max()


@pytest.mark.parametrize("jumped", ["above", "here", "below"])
def test_a_jump_of_a_state_is_not_a_slope(jumped: str) -> None:
    """One of three states lies on another branch, far from the others."""
    friction = parameters.Parameter("friction.pulley", ("friction.pulley",), "1", 0.09, 0.0, 0.19)
    sides = {"below": friction.value(1.0 - model.STEP), "here": 0.09, "above": friction.value(1.0 + model.STEP)}

    def solve(jobs: Sequence[Job]) -> list[Found]:
        values = [values["friction.pulley"] for values, _ in jobs]
        off = [0.1 * (abs(value - sides[jumped]) < 1e-9) for value in values]
        return [Found({"thrustRatio": 10.0 * value + jump}) for value, jump in zip(values, off, strict=True)]

    opened = model.Model([planned(1.0, 0.5, "thrustRatio")], solve)
    base = opened.states({"friction.pulley": 0.09})
    slopes = opened.slopes([friction], {}, np.array([1.0]), base)
    assert slopes == pytest.approx(np.array([[0.9 / NOISE["thrustRatio"]]]))


def test_a_lost_point_counts_more_the_less_it_carries(solver: Any) -> None:
    found = solver([({"friction.pulley": friction}, STEADY[8]) for friction in (0.09, 0.06, 0.05)])
    assert found[0].reason is None and found[0].missing == 0.0
    assert all("steady state" in lost.reason for lost in found[1:])
    assert 1.0 < found[1].missing < found[2].missing < 2.0
    opened = model.Model([STEADY[8]], solver)
    assert np.isnan(opened.relative(found[1:2])).all()
    assert opened.distance(found[:1]) <= 3 * model.FAR**2 < opened.distance(found[1:2]) < opened.distance(found[2:])


@pytest.mark.slow
def test_parameters_of_a_noisy_table_are_recovered(fmu: Path, solver: Any, tmp_path: Path) -> None:
    """Within their 95 % intervals, which are narrow; report, parameters and residuals are written."""
    points = measured(solver, [*STEADY[::3], *STEADY[2::3], *SHIFTS[:2]])
    titles = ["i_geo", "n_P [rad/s]", "T_P [Nm]", "F_S [N]", "F_P [N]", *(f"{name}{end}" for name in NOISE for end in (" [1/s]" * ("/" in name), ".sd"))]
    known = [{m.quantity: (m.value, m.deviation) for m in point.measured} for point in points]
    cells = [[cell for name in NOISE for cell in one.get(name, ("", ""))] for one in known]
    rows = [[p.ratio, p.speed, p.torque, p.force, p.primary_force or "", *own] for p, own in zip(points, cells, strict=True)]
    written(tmp_path / "table.csv", [titles, *rows])
    out = tmp_path / "out"
    words = [str(tmp_path / "table.csv"), "--fmu", str(fmu), "--output", str(out), *(f"--set={name}={value}" for name, value in MESH.items())]
    assert __main__.main([*words, "--fit", "friction.pulley=0.085,friction.ring,belt.play"]) == 0
    document = json.loads((out / "parameters.json").read_text(encoding="utf-8"))
    widest = {"friction.pulley": 0.04, "friction.ring": 0.3, "belt.play": 0.3}
    for name, true in TRUTH.items():
        entry = document["parameters"][name]
        low, high = entry["interval95"]
        assert low < true < high and low < entry["value"] < high and high - low < widest[name] * true
        assert entry["origin"] == "calibrated"
    found = parameter_set(str(out / "parameters.json"))
    assert {**BASE, **{name: found[name] for name in TRUTH}} == found
    relative = np.array([float(row["residual/sd"]) for row in reports.by_name(out / "residuals.csv")])
    assert len(relative) == sum(len(point.measured) for point in points)
    assert 0.6 < np.sqrt(np.mean(relative**2)) < 1.4
    report = reports.stands_alone(out / "report.html")
    # Three quantities have trends over ratio, torque and row order.
    assert reports.figures(report) == 3 * len(NOISE) + 3 * 3 and "not identified" not in report
    section = report[report.index('<h2 id="correlations">') : report.index('<h2 id="residuals">')]
    assert [row.count("1.00<") for row in section.split("<tr>")[2:]] == [1, 1, 1]
    reports.look_at(out / "report.html")
