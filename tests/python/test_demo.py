"""The demo: its pure functions (geometry, load cases, event detection), then a short run of all of it."""

import math
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import reports
from conftest import MESH

import pushbelt
from pushbelt.demo import __main__, events
from pushbelt.errors import ArgumentError
from pushbelt.fmu import data
from pushbelt.fmu.geometry import primary_radius, theta_of
from pushbelt.fmu.load_cases import solve
from pushbelt.fmu.results import LoadCase, LoadCaseResult, Profile, SteadyState, Trace
from pushbelt.fmu.unit import UnitError
from pushbelt.report import page

BENCH = data.parameter_set("bench168")
ABSENT = ("pushForce.max", "loss.ring", "loss.layers", "primary.idleArc", "secondary.idleArc", "ring.stressMax")


def test_radii_are_those_derived_for_the_published_variator_and_impossible_belts_are_refused() -> None:
    derived = next(entry for entry in data.published_data()["variators"] if entry["id"] == "bench168")["derived"]
    at_one, overdrive = (data.curve_of(BENCH, theta_of(ratio)) for ratio in (1.0, 1 / 2.25))
    for curve, key in ((at_one, "radiiAtRatio1"), (overdrive, "radiiAtSpeedRatio2.25")):
        assert [curve.primary_radius, curve.secondary_radius] == pytest.approx(derived[key], abs=6e-6)
    assert [2 * (math.pi - overdrive.phi), 2 * overdrive.phi] == pytest.approx(derived["wrapAnglesAtSpeedRatio2.25"], abs=6e-4)
    for belt in ((0.0, 0.4, 0.7), (1.0, 0.168, 0.703)):
        with pytest.raises(ArgumentError):
            primary_radius(*belt)


def test_load_cases_are_the_nine_with_their_clamping_forces() -> None:
    cases = data.load_cases(BENCH)
    assert [case.name for case in cases] == data.published_data()["loadCases"]["order"]
    forces = {case.name: case.clamping_force for case in cases}
    assert forces["overdrive-30"] == 6000.0
    radius = data.curve_of(BENCH, -0.4).primary_radius - 1e-3
    expected = 1.3 * 100 * math.cos(math.radians(11)) / (2 * 0.09 * radius)
    assert forces["underdrive-100"] == pytest.approx(expected)
    assert 20e3 < expected < 23e3


def test_load_is_found_in_a_few_evaluations() -> None:
    tried: list[float] = []
    unit = SimpleNamespace(restart=lambda values, near: tried.append(values["secondary.torque"]), initialise=lambda: None, not_steady=None)
    unit.outputs = unit.profile = dict
    unit.get = lambda _: tried[-1] / 2.4 - 1.5
    state = solve(unit, {"initial.ratio": 2.3}, 50.0)
    assert state.load_torque == tried[-1] and len(tried) <= 4 and -unit.get("") == pytest.approx(50.0, rel=1e-4)
    unit.get = lambda _: max(tried[-1], -40.0)
    with pytest.raises(UnitError, match="off by -10 N·m"):
        solve(unit, {"initial.ratio": 2.3}, 50.0)


def synthetic_manoeuvre() -> Trace:
    """A synthetic trace with a launch, a shift, two torque steps, an over-torque and the recovery, in 1 ms steps."""
    time = np.arange(0.0, 10.0005, 1e-3)
    torque = np.interp(time, [0, 0.5, 6.0, 6.01, 7.0, 7.01, 8.5, 8.51, 8.7, 8.71], [0, 60, 60, 30, 30, 80, 80, 300, 300, 40])
    slipping = (time > 8.505) & (time < 8.8)
    columns = {
        "primary.externalTorque": torque, "primary.shaftTorque": -np.where(slipping, 130.0, torque), "torqueUtilisation": torque / 130.0,
        "secondary.speed": np.interp(time, [0, 0.05, 2, 10], [0, 0, 80, 150]),
        "ratio.geometric": np.interp(time, [0, 2, 3, 10], [2.2, 2.2, 0.5, 0.5]),
        "slip": np.where(slipping, 0.5, 0.01), "macroSlip": slipping.astype(float), "loss.total": np.where(slipping, 3e4, 100.0),
    }  # fmt: skip
    return Trace(time, columns)


def test_events_are_found_in_order() -> None:
    trace = synthetic_manoeuvre()
    part = Trace(trace.time[:1000], {name: column[:1000] for name, column in trace.columns.items()})
    assert [event.name for event in events.detect(part)] == ["Launch in underdrive"], "no later event is missing"
    found = events.detect(trace)
    assert all(event.occurred for event in found)
    steps = ["Torque step 60 → 30 N·m", "Torque step 30 → 80 N·m"]
    assert [event.name for event in found] == ["Launch in underdrive", "Shift to overdrive", *steps, events.OVERLOAD, "Recovery"]
    overload = found[4]
    assert (overload.start, overload.end) == pytest.approx((8.506, 8.799), abs=2e-3)
    assert found[1].start == pytest.approx(2.05, abs=0.02)


def test_events_that_do_not_occur_are_shown() -> None:
    trace = synthetic_manoeuvre()
    still = {name: np.full_like(values, values[0]) for name, values in trace.columns.items()}
    assert not any(event.occurred for event in events.detect(Trace(trace.time, still)))
    found = events.detect(Trace(trace.time, {**trace.columns, "slip": np.where(trace.time > 8.505, 0.5, 0.01)}))
    assert [event.name for event in found if not event.occurred] == ["Recovery"], "persistent slip"


def test_push_force_must_build_up_and_decay() -> None:
    curve = data.curve_of(BENCH, 0.0)
    position = np.linspace(0.0, curve.length, 500)

    def passes(*at_borders: float) -> bool:
        fields = [np.interp(position, curve.borders, at_borders), *[np.zeros(500)] * 5]
        state = SteadyState({"reference.theta": 0.0}, Profile(position, *fields), 0.0)
        return events._push_force_gains((LoadCaseResult(LoadCase("medium", 0.0, 100.0, 1e4), state, 0.0),), BENCH).passed

    assert passes(5e2, 0.0, 0.0, 1e3, 1e3, 5e2)
    assert not passes(5e2, 0.0, 1.3e3, 1e3, 1e3, 5e2), "it only decays"
    assert not passes(5e2, 1.3e3, 0.0, 1e3, 1e3, 5e2), "it only builds up"


def test_numbers_are_set_as_in_print() -> None:
    assert page.number(-1234.5, 1) == "−1\u202f234.5"
    assert page.number(-0.001, 1) == "0.0"
    assert page.percent(0.9654, 2) == "96.54"


def test_short_run_writes_report_and_tables(fmu: Path, tmp_path: Path) -> None:
    assert __main__.main(["--fmu", str(fmu), "--output", str(tmp_path), "--short"]) == 0
    report = reports.stands_alone(tmp_path / "report.html")
    # Results come first; reference sections are collapsed, unless a check fails.
    assert re.findall(r'<h2 id="(\w+)">', report) == ["manoeuvre", "cases", "belt", "checks", "sources", "limits"]
    assert report.index('<div class="facts">') < report.index("<h2") < report.index('<div class="belt"')
    assert report.index('<div class="belt"') < report.index('<div class="panel">') < report.index('id="cases"')
    assert re.findall(r'<h2 id="(\w+)">[^<]*</h2>\n<details( open)?><summary>([^<]*)', report) == [("checks", "", "8 of 8 hold")]
    verdicts = re.findall(r'class="(?:tick|cross)"[^>]*>(.)</span><span>([^<]*)', report.split('id="checks"')[1].split('id="sources"')[0])
    assert len(verdicts) == 8
    # Most events come after the first second. They are not listed.
    assert "✗" not in report and events.OVERLOAD not in report and "Launch in underdrive" in report
    # Load cases, manoeuvre, fields of a load case; the belt over time and in a steady state.
    assert reports.figures(report) == 3 + 7 + 6
    assert report.count('<div class="belt"') == 2
    run, cases = (pd.read_csv(tmp_path / f"{name}.csv") for name in ("results", "cases"))
    assert run["time [s]"].to_numpy() == pytest.approx(np.arange(1001) * 1e-3)
    reports.units_are_those_of(fmu, tmp_path / "results.csv", tmp_path / "cases.csv")
    assert list(cases["case"]) == ["overdrive-100", "medium-100", "underdrive-100"]
    assert cases["primary.shaftTorque [N.m]"].to_numpy() == pytest.approx(-100.0, rel=1e-4)
    reports.look_at(tmp_path / "report.html")


def test_a_chain_pulls(fmu: Path) -> None:
    with pushbelt.Variator("chain168", MESH, fmu=fmu) as variator:
        outputs = variator.start()
        profile = variator.profile()
    assert {name: outputs[name] for name in ABSENT} == dict.fromkeys(ABSENT, 0.0)
    assert outputs["loss.joints"] > 1.0
    assert not profile.push_force.any() and not profile.gap.any()
    assert profile.ring_tension.min() > 500.0


def test_the_pitch_line_of_a_chain_is_its_centre_line(tmp_path: Path) -> None:
    own = tmp_path / "own.json"
    own.write_text('{"parameters": {"belt.kind": {"value": 2}, "belt.pitchOffset": {"value": 1e-3}}}', encoding="utf-8")
    values = data.parameter_set(str(own))
    assert data.is_chain(values) and values["belt.pitchOffset"] == 0.0
    assert not data.is_chain(BENCH)


@pytest.mark.slow
def test_the_demo_draws_a_chain(fmu: Path, tmp_path: Path) -> None:
    assert __main__.main(["--fmu", str(fmu), "--output", str(tmp_path), "--variator", "chain168", "--short"]) == 0
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "The pins of the chain are drawn." in page and "kN tension" in page
    assert "Push force" not in page and "polygon action" in page
