"""The search of a calibration, on models with known results: counts of solutions, bounds, priors, bad fits."""

import hashlib
import json
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import reports
from conftest import MESH
from rig_tables import written

from pushbelt.calibrate import __main__, fit, report, worker
from pushbelt.calibrate.model import Model
from pushbelt.calibrate.parameters import Parameter
from pushbelt.calibrate.worker import Found, Job
from pushbelt.fmu.data import parameter_set
from pushbelt.report import charts
from pushbelt.tables import points as tables
from pushbelt.tables.points import Measured, Point

NAMES = tuple("abcdef")
Law = Callable[[np.ndarray, float], float]
TRUTH = (1.15, 0.8, 1.3, 0.9, 1.1, 0.75)
TITLES = "i_geo,n_P [rpm],T_P [Nm],F_S [kN],F_P [kN],slip [%]"
# Below 0.09, where a search starts, waves of the thrust ratio on the coarse mesh of `--short`, of 1 %, hold the search.
SPEED, FORCE, FRICTION = 200.0, 11e3, 0.094
BASE = {**parameter_set("bench168"), "friction.pulley": FRICTION}
Rows = list[list[float]]
SLIP = (Measured("slip", 0.0, 1.0, True),)
HEADER = "ratio.geometric;primary.speed [rad/s];primary.torque [Nm];secondary.clampingForce [N];thrustRatio;slip;efficiency"
ERRORS = np.array([0.4, -1.0, 0.7, 1.5, -2.2, 0.1, -0.6, 1.1, 0.9, -0.3])


def parameter(name: str, start: float = 1.0, low: float = 0.0, high: float = np.inf, prior: tuple[float, float] | None = None) -> Parameter:
    return Parameter(name, (name,), "1", start, low, high, prior)


def model(law: Law, truth: Sequence[float], names: Sequence[str] = NAMES, count: int = 30, deviation: float = 0.01) -> Model:
    """A model whose slip at place u in 0 to 1 is a law of the parameters; measured with the true ones, without noise."""
    places = np.linspace(0.0, 1.0, count)

    def solve(jobs: Sequence[Job]) -> list[Found]:
        return [Found({"slip": law(np.array([values[name] for name in names]), point.torque)}) for values, point in jobs]

    def point(k: int, place: float) -> Point:
        value = law(np.array(truth, dtype=float), place)
        return Point(k, f"{k}", 1.0, None, 100.0, float(place), 1e4, None, (Measured("slip", value, deviation, True),))

    return Model([point(k, place) for k, place in enumerate(places, 2)], solve)


TWO = [parameter("a"), parameter("b")]


def curve(values: np.ndarray, place: float) -> float:
    """A smooth law that is not linear in its parameters."""
    phases = np.arange(len(values))
    return float(np.sum(values * np.cos(2.0 * phases * place)) + 0.2 * np.exp(values[0] * place) + 0.1 * np.prod(values[:2]))


def test_six_parameters_over_thirty_points_take_few_solutions() -> None:
    """Derivatives are computed at the start and at the end only; a trust region with full derivatives takes about 100 sets."""
    opened = model(curve, TRUTH)
    found = fit.fit(opened, [parameter(name) for name in NAMES])
    assert [estimate.value for estimate in found.estimates] == pytest.approx(TRUTH, rel=2e-3)
    assert found.converged and not found.misfit
    sets = opened.solves / len(opened.points)
    assert found.evaluations <= 10
    assert sets == pytest.approx(1 + 12 + found.evaluations + 12, abs=3)


def fitted(law: Law, truth: Sequence[float], *parameters: Parameter) -> tuple[fit.Estimate, ...]:
    return fit.fit(model(law, truth, "ab"), parameters or TWO).estimates


def test_a_parameter_at_its_bound_is_held_there_exactly() -> None:
    first, second = fitted(lambda v, u: v[0] * u + v[1] + 0.3 * v[0] * v[1], (1.2, -0.1))
    assert second.at_bound and second.value == 0.0 and first.half is not None


def test_a_parameter_that_the_data_do_not_see_keeps_its_start_value() -> None:
    first, second = fitted(lambda v, u: v[0] * u + 1e-9 * v[1], (1.2, 2.0), parameter("a"), parameter("b", 3e-4))
    assert first.value == pytest.approx(1.2, rel=1e-3)
    assert second.undetermined is not None and second.value == 3e-4
    # Also one that has moved before the scatter shows that it is not determined.
    faint = model(lambda v, u: v[0] * u + 0.01 * v[1] * np.cos(3.0 * u), (1.2, 2.0), "ab")
    off = [with_value(point, point.measured[0].value + 0.05 * np.sin(9.0 * point.torque)) for point in faint.points]
    _, second = fit.fit(Model(off, faint.solve), TWO).estimates
    assert second.undetermined is not None and second.value == 1.0


def test_a_prior_determines_what_the_data_do_not() -> None:
    law, truth = lambda v, u: (v[0] + v[1]) * u, (1.2, 0.7)
    assert sum(estimate.undetermined is not None for estimate in fitted(law, truth)) == 1
    first, second = fitted(law, truth, parameter("a"), parameter("b", prior=(0.7, 0.01)))
    assert (first.value, second.value) == pytest.approx(truth, rel=5e-3)
    assert second.half == pytest.approx(0.02, rel=0.1)


def test_a_bad_fit_says_so() -> None:
    good = model(lambda v, u: v[0] * u, (1.2,), "a")
    assert fit.fit(good, [parameter("a")]).misfit is None
    bad = fit.fit(Model([with_value(point, np.sin(9.0 * point.torque)) for point in good.points], good.solve), [parameter("a")])
    # No value is an outlier: the scatter of all counts, not the given deviations.
    assert all(bad.kept) and bad.misfit
    with pytest.raises(fit.FitError, match="2 measured values"):
        fit.fit(model(curve, (1.0, 1.0), "ab", count=2), TWO)


def slipping(least: Callable[[float], float], cost: int = 1, *torques: float) -> Model:
    """A model of the friction 0.098 at ten places and at further ones. Points are lost up to a least friction over the place."""
    sound = model(lambda v, u: v[0] * (1.0 + u), (0.098,), ("friction.pulley",), count=10, deviation=1e-3)

    def solve(jobs: Sequence[Job]) -> list[Found]:
        shares = [values["friction.pulley"] / least(point.torque) for values, point in jobs]
        lost = [Found({}, "slips", 2.0 - share, cost) for share in shares]
        return [found if share > 1.0 else one for share, found, one in zip(shares, sound.solve(jobs), lost, strict=True)]

    return Model([*sound.points, *(replace(sound.points[0], torque=torque) for torque in torques)], solve)


def test_points_without_a_steady_state_do_not_break_the_fit() -> None:
    """With the initial friction no point is carried, so it is raised first. A point beyond any capacity is excluded."""
    result = fit.fit(slipping(lambda torque: 0.065 + 0.025 * torque, 1, 10.0), [parameter("friction.pulley", 0.062, high=0.19)])
    assert [found.reason for found in result.after] == [None] * 10 + ["slips"]
    assert result.estimates[0].value == pytest.approx(0.098, rel=2e-3)


def test_a_search_without_steady_states_is_bounded() -> None:
    """Points beyond the capacity cost most. Forces in a unit that is too small lose nearly all of them at any friction."""
    opened = slipping(lambda torque: 5.0 if torque > 0.2 else 1e-9, worker.LOST_SOLVES)
    opened.most_solves = 400
    with pytest.raises(fit.FitError, match=r"8 of 10 points have no steady state.*pounds"):
        fit.fit(opened, [parameter("friction.pulley", 0.062, high=10.0)])
    assert 200 < opened.solves <= opened.most_solves


def test_points_beyond_the_capacity_are_not_solved(fmu: Path, archive: Any) -> None:
    found = worker.solve(fmu, archive.directory, BASE, Point(0, "", 1.0, None, SPEED, 500.0, FORCE, None, SLIP))
    assert "no steady state: the capacity is" in found.reason and found.solves == 1 and 1.0 < found.missing < 2.0


def with_value(point: Point, value: float) -> Point:
    return replace(point, measured=(replace(point.measured[0], value=float(value)),))


def noisy(count: int, seed: int, shifts: dict[int, float], truth: Sequence[float] = (1.2, 0.7)) -> Model:
    """A model of two parameters, measured with noise of the standard deviation 0.01. `shifts` are errors of points."""
    opened = model(lambda v, u: v[0] * u + v[1] * np.exp(-u), truth, "ab", count)
    noise = 0.01 * np.random.default_rng(seed).standard_normal(count)
    values = [p.measured[0].value + n + shifts.get(k, 0.0) for k, (p, n) in enumerate(zip(opened.points, noise, strict=True))]
    return Model([with_value(p, value) for p, value in zip(opened.points, values, strict=True)], opened.solve)


@pytest.mark.parametrize("shifts", [{5: 1.0}, {0: -0.4, 29: 3.0}, {3: 100.0, 4: 100.0, 20: 0.1}])
def test_outliers_are_left_out(shifts: dict[int, float]) -> None:
    """Also a small one beside large ones. The fit is that of a table without them, and takes few solutions."""
    opened = noisy(30, 1, shifts)
    found = fit.fit(opened, TWO)
    assert [k for k, kept in enumerate(found.kept) if not kept] == sorted(shifts)
    alone = fit.fit(Model([point for k, point in enumerate(opened.points) if k not in shifts], opened.solve), TWO)
    assert all(alone.kept)
    for one, other in zip(found.estimates, alone.estimates, strict=True):
        assert one.value == pytest.approx(other.value, rel=1e-3)
        assert one.half == pytest.approx(other.half, rel=2e-2)
    assert not found.misfit and found.rms[1] == pytest.approx(alone.rms[1], rel=1e-3) and found.rms_of_all > 2.0 * found.rms[1]
    assert found.evaluations <= alone.evaluations + 6


def test_noise_has_few_outliers() -> None:
    assert sum(not all(fit.fit(noisy(30, seed, {}), TWO).kept) for seed in range(40)) <= 4


def test_a_row_is_left_out_as_a_whole_and_named(tmp_path: Path) -> None:
    """One value of a row is far off; the other may depend on the same faulty cell."""
    opened = noisy(30, 1, {7: 1.0, 20: -1.0})
    points = [replace(point, measured=(*point.measured, replace(point.measured[0], deviation=1.0))) for point in opened.points]
    double = Model(points, opened.solve)
    found = fit.fit(double, TWO)
    assert [k for k, kept in enumerate(found.kept) if not kept] == [14, 15, 40, 41]
    shown = report.Results("t.csv", "1", "v", {}, double, found)
    assert list(shown.outliers["line"]) == [9, 22]
    text = report.outliers(shown)
    assert "line 9, slip" in text and f"{found.rms_of_all:.3g} with them" in text
    report.write_residuals(shown, tmp_path / "residuals.csv")
    assert (tmp_path / "residuals.csv").read_text(encoding="utf-8").count("outlier") == 4


def test_samples_of_a_record_are_left_out_alone() -> None:
    opened = noisy(30, 1, {7: 1.0})

    def solve(jobs: Sequence[Job]) -> list[Found]:
        places = list(enumerate(np.linspace(0.0, 1.0, 30)))
        return [Found({f"{k}": values["a"] * u + values["b"] * np.exp(-u) for k, u in places}) for values, _ in jobs]

    samples = tuple(replace(p.measured[0], key=f"{k}", time=float(k)) for k, p in enumerate(opened.points))
    found = fit.fit(Model([Point(2, "up", 1.0, None, 100.0, 0.0, 1e4, 1e4, samples)], solve), TWO)
    assert [k for k, kept in enumerate(found.kept) if not kept] == [7]


def test_repeated_rows_count_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Rows with another value, or another name only."""
    path = tmp_path / "table.csv"
    rows = ["a,2,1500,40,10,11,0.2", "b,0.5,1500,40,10,13,0.3", "c,2,1500,40,10,11,0.2", "a,2,1500,40,10,12,0.2", "a,2,1500,40,10,11,0.2"]
    path.write_text("\n".join([f"name,{TITLES}", *rows]) + "\n", encoding="utf-8")
    rig = __main__.once(tables.read(path))
    assert [point.line for point in rig.points] == [2, 3, 5]
    assert any("4 (as 2), 6 (as 2)" in remark for remark in rig.sheet.remarks)
    assert __main__.main([str(path), "--check"]) == 0
    assert "4 (as 2), 6 (as 2)" in capsys.readouterr().out


@pytest.mark.parametrize(
    "words", [("--workers", "0"), ("--workers", "-1"), *(("--prior", f"belt.play{end}") for end in ("", "=1", "=1±0", "=x±1", "=1±inf", "=nan±1"))]
)
def test_options_out_of_range_are_refused(words: tuple[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        __main__.parser().parse_args(["table.csv", *words])
    error = capsys.readouterr().err
    assert words[0] in error and words[1] in error
    assert __main__.prior("belt.play=2e-4±1e-4") == __main__.prior("belt.play=2e-4+-1e-4") == ("belt.play", (2e-4, 1e-4))


# With the FMU

@pytest.fixture(scope="module")
def solved(fmu: Path, archive: Any) -> Rows:
    """Rows of a table with the results of five points with a known friction."""
    found = []
    for ratio, torque in ((2.0, 35.0), (1.5, 45.0), (1.0, 40.0), (0.7, 45.0), (0.55, 30.0)):
        state = worker.solve(fmu, archive.directory, BASE, Point(0, "", ratio, None, SPEED, torque, FORCE, None, SLIP))
        assert state.reason is None
        found.append([ratio, SPEED, torque, FORCE, *(state.values[name] for name in ("thrustRatio", "slip", "efficiency"))])
    return found


@pytest.fixture
def calibrated(fmu: Path, tmp_path: Path) -> Callable[..., int]:
    """Runs the program on rows of a table; returns its exit code."""

    def run(rows: Rows, *more: str, header: str = HEADER) -> int:
        path = written(tmp_path / "rig.csv", [header.split(";"), *rows], ";")
        return __main__.main([str(path), "--fmu", str(fmu), "--output", str(tmp_path / "out"), "--workers", "1", "--fit", "friction.pulley", *more])

    return run


def scores(out: Path) -> dict[tuple[str, str], dict[str, float]]:
    """By quantity and variator."""
    return {(s["quantity"], s["variator"]): s for s in json.loads((out / "holdout.json").read_text(encoding="utf-8"))}


def fits(out: Path) -> None:
    document = json.loads((out / "parameters.json").read_text(encoding="utf-8"))
    assert document["fits"] and document["parameters"]["friction.pulley"]["value"] == pytest.approx(FRICTION, rel=1e-3)


def test_an_inverted_ratio_is_named_before_the_fit_and_does_not_fit(fmu: Path, calibrated, solved: Rows, tmp_path: Path, capsys: Any) -> None:
    out, rows = tmp_path / "out", [[1.0 / ratio, *others] for ratio, *others in solved]
    assert calibrated(rows) == 1 and not out.exists()
    option = "ratio.geometric=1/ratio.geometric"
    assert f'--map "{option}"' in capsys.readouterr().err
    assert calibrated(rows, "--as-written") == __main__.MISFIT
    assert capsys.readouterr().out.startswith("does not fit: ")
    assert json.loads((out / "parameters.json").read_text(encoding="utf-8"))["fits"] is False
    assert (out / "residuals.csv").is_file()
    assert '<div class="fault" role="alert">' in reports.stands_alone(out / "report.html")
    assert calibrated(rows, "--map", option) == 0
    fits(out)
    # On the same table the fitted set scores better than the default one.
    fitted = str(out / "parameters.json")
    assert calibrated(rows, "--map", option, "--hold-out", fitted) == 0
    found = scores(out)
    assert {quantity for quantity, _ in found} == {"thrustRatio", "slip", "efficiency"}
    for quantity in ("thrustRatio", "slip"):
        assert found[quantity, fitted]["relative"] < 0.05 and found[quantity, "bench168"]["relative"] > 0.3
        assert (found[quantity, "bench168"]["count"], found[quantity, "bench168"]["lost"]) == (5, 0)
    assert len(reports.by_name(out / "residuals.csv")) == 15
    report = reports.stands_alone(out / "report.html")
    assert reports.figures(report) == 9
    # The origin: command, date, and hashes of the FMU, the table and the set.
    assert f"--hold-out {fitted}" in report
    for file in (fmu, tmp_path / "rig.csv", out / "parameters.json"):
        assert hashlib.sha256(file.read_bytes()).hexdigest() in report
    reports.look_at(out / "report.html")


def test_torques_in_pound_feet_are_named(calibrated, solved: Rows, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Under [Nm] they are fitted by a friction of another size, but not as well as in their own unit."""
    rows = [[ratio, speed, torque / 1.3558179483314, *others] for ratio, speed, torque, *others in solved]
    assert calibrated(rows) == __main__.MISFIT
    option = re.search(r'factor of primary\.torque \[Nm\] = 0\.73.* --map "(.*lbf\.ft.*)"', (said := capsys.readouterr().out))
    assert option is not None, said
    assert "Possible cause: factor of primary.torque [Nm]" in reports.stands_alone(tmp_path / "out" / "report.html")
    assert calibrated(rows, "--map", option[1]) == 0
    fits(tmp_path / "out")


def test_pressures_are_forces_of_the_set_and_a_hold_out_has_the_variator_beside_it(calibrated, solved: Rows, tmp_path: Path) -> None:
    """In the fit, in the check and in the hold-out, where --set holds for both sets."""
    area, out = 0.008, tmp_path / "out"
    rows = [[*row[:3], 1e-5 * FORCE / area, *row[4:]] for row in solved]
    run = partial(calibrated, rows, f"--set=secondary.cylinder.area={area}", header=HEADER.replace("clampingForce [N]", "pressure [bar]"))
    assert run("--check", "--set", "ring.model=ALE") == 0
    assert run() == 0
    fits(out)
    fitted = str(out / "parameters.json")
    assert run("--hold-out", fitted, "--variator", "belt155", "--set", f"friction.pulley={FRICTION}") == 0
    found = scores(out)
    assert {variator for _, variator in found} == {fitted, "belt155"}
    assert found["slip", fitted]["relative"] < 0.05 and found["slip", "belt155"]["relative"] > 0.3
    assert run("--hold-out", "bench168", "--set", f"friction.pulley={FRICTION}") == 0
    assert all(score["relative"] < 0.05 for score in scores(out).values())


def test_the_first_line_names_a_wrong_value(calibrated, solved: Rows, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A thrust ratio of ten times its value, a torque that no force carries, and a repeated row. The fit of the other rows is that without
    them."""
    first = solved[0]
    far, heavy = [*first[:4], 10.0 * first[4], *first[5:]], [*first[:2], 10.0 * first[2], *first[3:]]
    assert calibrated([*solved, far, heavy, solved[2]]) == 0
    said, errors = capsys.readouterr()
    assert "line 7, thrustRatio" in said.splitlines()[0]
    assert "9 (as 4)" in said
    assert "no steady state, not used: line 8" in errors
    fits(tmp_path / "out")
    assert "Left out as outliers: line 7" in reports.stands_alone(tmp_path / "out" / "report.html")


def test_a_speed_ratio_is_met_by_the_slip_of_the_model(fmu: Path, archive, solved: Rows) -> None:
    """The search starts from the slip of the last one, and with its derivatives."""
    ratio, _, torque, _, thrust_ratio, slip, efficiency = solved[1]
    point = Point(0, "", None, ratio / (1.0 - slip), SPEED, torque, FORCE, None, SLIP)
    first = worker.solve(fmu, archive.directory, BASE, point)
    assert first.values == pytest.approx({"thrustRatio": thrust_ratio, "slip": slip, "efficiency": efficiency}, rel=1e-3) and first.solves <= 3
    for off, most in ((1e-3, 2), (5e-6, 1)):
        near = replace(point, slip=first.values["slip"] + off, near=first.near, by_ratio=first.by_ratio)
        found = worker.solve(fmu, archive.directory, BASE, near)
        assert found.values == pytest.approx(first.values, abs=1e-6) and found.solves == most


def test_recorded_shifts_are_simulated(fmu: Path, archive) -> None:
    """The model meets its own samples, and misses them with another friction."""
    base = {**parameter_set("bench168"), **MESH}
    samples = tuple((0.02 * k, SPEED, 20.0, 17e3, 10e3, 1.2) for k in range(5))
    measured = tuple(Measured("ratio.geometric", 1.2, 0.01, True, f"ratio.geometric@{k}", 0.02 * k) for k in range(1, 5))
    record = Point(2, "up", 1.2, None, SPEED, 20.0, 10e3, 17e3, measured, samples=samples)
    first = worker.solve(fmu, archive.directory, base, record)
    assert first.reason is None
    course = [first.values[m.key] for m in measured]
    # The primary force is above equilibrium, so the ratio falls.
    assert all(later < earlier for earlier, later in zip([1.2, *course], course, strict=False))
    other = worker.solve(fmu, archive.directory, {**base, "friction.pulley": 0.11}, record)
    assert abs(other.values["ratio.geometric@4"] - course[-1]) > 1e-3


def residuals(errors: np.ndarray, fifth: float | None = None) -> pd.DataFrame:
    """Thrust ratios with errors in standard deviations; the fifth one may be measured as something else."""
    found = np.linspace(0.8, 1.4, len(errors))
    measured = found - 0.01 * errors
    if fifth is not None:
        measured[4] = fifth
    values = [(Measured("thrustRatio", value, 0.01, True),) for value in measured]
    rows = [Point(k, "", 0.5 + 0.1 * k, None, 1.0, 10.0 * k, 1.0, None, value) for k, value in enumerate(values)]
    return Model(rows, list).rows([Found({"thrustRatio": f}) for f in found])


def marked(panel: charts.Panel) -> list[tuple[str, float, float]]:
    """Text and place of the marked points."""
    return [values for one in panel.series if one.texts for values in zip(one.texts, one.x, one.y, strict=True)]


def test_an_outlier_is_at_the_border_with_its_value_and_the_axes_fit_the_others() -> None:
    sound, (compared, torque, ratio) = (report.chart("thrustRatio", {"fitted": residuals(ERRORS, fifth)}).panels for fifth in (None, 8.0))
    assert compared.x_range[1] < 1.6 and compared.y_range[1] < 1.6
    ((text, x, _),) = marked(compared)
    assert text == "8, model 1.07" and x == pytest.approx(compared.x_range[1], abs=0.03 * np.ptp(compared.x_range))
    for panel, other in ((torque, sound[1]), (ratio, sound[2])):
        assert panel.x_range == other.x_range and panel.y_range == pytest.approx(other.y_range, rel=0.2)
        ((text, _, y),) = marked(panel)
        assert text == "\N{MINUS SIGN}693" and y == pytest.approx(0.96 * panel.y_range[0])
    assert not any(map(marked, sound))
    # The outlier is nowhere among the other points.
    inside = [y for one in torque.series if one.kind == "points" and not one.texts for y in one.y]
    assert len(inside) == 9 and max(map(abs, inside)) <= torque.y_range[1]
    # Another set does not determine the axes, but is counted.
    chart = report.chart("slip", {"fitted": residuals(ERRORS), "start values": residuals(ERRORS + 60.0)})
    assert chart.panels[0].x_range == sound[0].x_range
    assert all("10 values of start values are outside" in panel.note for panel in chart.panels[1:])
    assert [one.name for one in chart.panels[1].series] == ["within 2", "start values", "fitted"]
    chart.__html__()
