"""The search of a calibration, on models with known results: counts of solutions, bounds, priors, bad fits."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import reports

from pushbelt.calibrate import __main__, fit
from pushbelt.fmu.data import parameter_set
from pushbelt.rig import points as tables
from pushbelt.rig import worker
from pushbelt.rig.measured import Measured, Point, Record
from pushbelt.rig.model import Model
from pushbelt.rig.parameters import Parameter
from pushbelt.rig.worker import Found, Job

NAMES = tuple("abcdef")
Law = Callable[[np.ndarray, float], float]


def parameter(name: str, start: float = 1.0, low: float = 0.0, high: float = np.inf, prior: tuple[float, float] | None = None) -> Parameter:
    return Parameter(name, (name,), "1", "", start, low, high, prior)


def model(law: Law, truth: Sequence[float], names: Sequence[str] = NAMES, count: int = 30, deviation: float = 0.01) -> Model:
    """A model whose slip at place u in 0 to 1 is a law of the parameters; measured with the true ones, without noise."""
    places = np.linspace(0.0, 1.0, count)

    def solve(jobs: Sequence[Job]) -> list[Found]:
        return [Found({"slip": law(np.array([values[name] for name in names]), point.torque)}) for values, point in jobs]

    def point(k: int, place: float) -> Point:
        value = law(np.array(truth, dtype=float), place)
        return Point(k, f"{k}", 1.0, None, 100.0, float(place), 1e4, None, (Measured("slip", value, deviation, True),))

    return Model([point(k, place) for k, place in enumerate(places, 2)], solve)


def curve(values: np.ndarray, place: float) -> float:
    """A smooth law that is not linear in its parameters."""
    phases = np.arange(len(values))
    return float(np.sum(values * np.cos(2.0 * phases * place)) + 0.2 * np.exp(values[0] * place) + 0.1 * np.prod(values[:2]))


TRUTH = (1.15, 0.8, 1.3, 0.9, 1.1, 0.75)


def test_six_parameters_over_thirty_points_take_few_solutions() -> None:
    """Derivatives are computed at the start and at the end only; a trust region with full derivatives takes about 100 sets."""
    opened = model(curve, TRUTH)
    found = fit.fit(opened, [parameter(name) for name in NAMES])
    assert [estimate.value for estimate in found.estimates] == pytest.approx(TRUTH, rel=2e-3)
    assert found.converged and found.fits
    sets = opened.solves / len(opened.points)
    assert found.evaluations <= 10
    assert sets == pytest.approx(1 + 6 + found.evaluations + 12, abs=3)


def test_a_parameter_at_its_bound_is_held_there_exactly() -> None:
    opened = model(lambda v, u: v[0] * u + v[1] + 0.3 * v[0] * v[1], (1.2, -0.1), "ab")
    first, second = fit.fit(opened, [parameter("a"), parameter("b")]).estimates
    assert second.at_bound and second.value == 0.0
    assert first.half is not None


def test_a_parameter_that_the_data_do_not_see_keeps_its_start_value() -> None:
    opened = model(lambda v, u: v[0] * u + 1e-9 * v[1], (1.2, 2.0), "ab")
    first, second = fit.fit(opened, [parameter("a"), parameter("b", 3e-4)]).estimates
    assert first.value == pytest.approx(1.2, rel=1e-3)
    assert second.undetermined is not None and second.value == 3e-4


def test_a_prior_determines_what_the_data_do_not() -> None:
    law: Law = lambda v, u: (v[0] + v[1]) * u  # noqa: E731
    truth = (1.2, 0.7)
    alone = fit.fit(model(law, truth, "ab"), [parameter("a"), parameter("b")])
    assert sum(estimate.undetermined is not None for estimate in alone.estimates) == 1
    known = [parameter("a"), parameter("b", prior=(0.7, 0.01))]
    first, second = fit.fit(model(law, truth, "ab"), known).estimates
    assert (first.value, second.value) == pytest.approx(truth, rel=5e-3)
    assert second.half == pytest.approx(0.02, rel=0.1)


def test_a_bad_fit_says_so() -> None:
    good = fit.fit(model(lambda v, u: v[0] * u, (1.2,), "a"), [parameter("a")])
    assert good.fits and good.misfit is None
    wrong = model(lambda v, u: v[0] * u, (1.2,), "a")
    values = [with_value(point, value=np.sin(9.0 * point.torque)) for point in wrong.points]
    bad = fit.fit(wrong.with_points(values, {}), [parameter("a")])
    assert not bad.fits
    assert "above 3" in bad.misfit


def with_value(point: Point, value: float) -> Point:
    """A point with another measured value."""
    return replace(point, measured=(replace(point.measured[0], value=float(value)),))


def test_the_options_of_priors() -> None:
    assert __main__.prior("belt.play=2e-4±1e-4") == __main__.prior("belt.play=2e-4+-1e-4") == ("belt.play", (2e-4, 1e-4))
    for text in ("belt.play=2e-4", "belt.play", "belt.play=1±0", "belt.play=x±1"):
        with pytest.raises(__main__.argparse.ArgumentTypeError, match="not of the form"):
            __main__.prior(text)


# With the FMU

SPEED, FORCE, FRICTION = 200.0, 11e3, 0.084


@pytest.fixture(scope="module")
def solved(fmu: Path, archive) -> list[tuple[float, float, dict[str, float]]]:
    """Ratio, torque and results of five points with a known friction, on the coarse mesh."""
    base = {**parameter_set("bench168"), **__main__.COARSE, "friction.pulley": FRICTION}
    found = []
    for ratio, torque in ((2.0, 35.0), (1.5, 45.0), (1.0, 40.0), (0.7, 45.0), (0.55, 30.0)):
        point = Point(0, "", ratio, None, SPEED, torque, FORCE, None, (Measured("slip", 0.0, 1.0, True),))
        state = worker.solve_or_say_why(fmu, archive.directory, base, point)
        assert state.reason is None
        found.append((ratio, torque, dict(state.values)))
    return found


def words(path: Path, fmu: Path, out: Path, *more: str) -> list[str]:
    return [str(path), "--fmu", str(fmu), "--output", str(out), "--short", "--workers", "1", "--fit", "friction.pulley", *more]


def test_an_inverted_ratio_is_named_before_the_fit_and_does_not_fit(
    fmu: Path, solved: list[tuple[float, float, dict[str, float]]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = tmp_path / "rig.csv", tmp_path / "out"
    rows = [f"{1 / i!r};{SPEED};{t};{FORCE};{v['thrustRatio']!r};{v['slip']!r};{v['efficiency']!r}" for i, t, v in solved]
    header = "ratio.geometric;primary.speed [rad/s];primary.torque [Nm];secondary.clampingForce [N];thrustRatio;slip;efficiency"
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    assert __main__.main(words(path, fmu, out)) == 1
    assert '--map "ratio.geometric=1/ratio.geometric"' in capsys.readouterr().err
    assert not out.exists()
    assert __main__.main(words(path, fmu, out, "--as-written")) == 3
    assert capsys.readouterr().out.startswith("does not fit: ")
    assert json.loads((out / "parameters.json").read_text(encoding="utf-8"))["fits"] is False
    assert (out / "residuals.csv").is_file()
    assert '<div class="fault" role="alert">' in reports.stands_alone(out / "report.html")
    assert __main__.main(words(path, fmu, out, "--map", "ratio.geometric=1/ratio.geometric")) == 0
    document = json.loads((out / "parameters.json").read_text(encoding="utf-8"))
    assert document["fits"] is True
    assert document["parameters"]["friction.pulley"]["value"] == pytest.approx(FRICTION, rel=1e-3)


def test_a_speed_ratio_starts_from_the_slip_of_the_last_search(
    fmu: Path, archive, solved: list[tuple[float, float, dict[str, float]]]
) -> None:
    base = {**parameter_set("bench168"), **__main__.COARSE, "friction.pulley": FRICTION}
    ratio, torque, values = solved[1]
    slips, counts = [0.0], []
    for nudge in (0.0, 1e-4):
        speed_ratio = ratio / (1.0 - values["slip"])
        measured = (Measured("slip", 0.0, 1.0, True),)
        point = Point(0, "", None, speed_ratio, SPEED, torque, FORCE, None, measured, slips[-1] + nudge)
        found = worker.solve_or_say_why(fmu, archive.directory, base, point)
        assert found.values["slip"] == pytest.approx(values["slip"], rel=1e-3)
        slips.append(found.values["slip"])
        counts.append(found.solves)
    last = worker.solve_or_say_why(fmu, archive.directory, base, replace(point, slip=slips[-1]))
    assert counts[0] <= 3 and counts[1] == 2 and last.solves <= 2


def test_recorded_shifts_are_simulated(fmu: Path, archive) -> None:
    """The model meets its own samples, and misses them with another friction."""
    base = {**parameter_set("bench168"), **__main__.COARSE}
    samples = tuple((0.02 * k, SPEED, 20.0, 17e3, 10e3, 1.2) for k in range(5))
    measured = tuple(Measured("ratio.geometric", 1.2, 0.01, True, f"ratio.geometric@{k}", 0.02 * k) for k in range(1, 5))
    record = Record(2, "up", 1.2, None, SPEED, 20.0, 10e3, 17e3, measured, samples=samples)
    first = worker.solve_or_say_why(fmu, archive.directory, base, record)
    assert first.reason is None
    course = [first.values[m.key] for m in measured]
    # The primary force is above equilibrium, so the ratio falls.
    assert all(later < earlier for earlier, later in zip([1.2, *course], course, strict=False))
    other = worker.solve_or_say_why(fmu, archive.directory, {**base, "friction.pulley": 0.11}, record)
    assert abs(other.values["ratio.geometric@4"] - course[-1]) > 1e-3
