"""The comparison with theory and measurements: verdicts, data, and a short run."""

import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import reports
from pushbelt_validation import __main__, bands, measured, report, results
from pushbelt_validation.bench import Bench, Plan
from pushbelt_validation.outcome import Check, Column, Part, Section, Source, Unit, Verdict, table, within
from pushbelt_validation.runs import SECTIONS, Results

from pushbelt.fmu.steady import driven_by_slip, driven_by_torque
from pushbelt.fmu.unit import Archive
from pushbelt.tables import split
from pushbelt.tables.units import dimensions

SOURCE = Source("somebody 2007", "fitted")


@pytest.fixture(scope="module")
def bench(archive: Archive) -> Iterator[Bench]:
    with Bench(archive) as opened:
        yield opened


@pytest.mark.parametrize(
    ("values", "limits", "used"),
    [
        ((0.95, 1.04), (0.9, 1.1), 0.5), ((0.7, 1.0), (0.9, 1.1), 3.0), ((0.98, 0.97), (0.97, None), 1.0), ((0.873,), (0.97, None), 1.1),
        ((0.2, 0.5), (None, 2.0), 0.25), ((9.0,), (0.5, None), 0.0), ((0.1,), (0.0, None), None), ((), (0.9, 1.1), None),
    ],
)  # fmt: skip
def test_a_check_has_the_share_of_its_tolerance_that_is_used(values: tuple, limits: tuple, used: float | None) -> None:
    check = within("key", "statement", SOURCE, [(str(v), v) for v in values], *limits)
    assert check.used == (None if used is None else pytest.approx(used))
    if used is not None:
        assert (check.used > 1.0 + 1e-12) == (check.verdict is Verdict.MISSED)


@pytest.mark.parametrize(("outside", "why"), [(2.0, "1 of 2 outside, by up to 0.9"), (None, "without a steady state"), (math.nan, "without a steady state")])
def test_a_point_that_misses_is_named(outside: float | None, why: str) -> None:
    check = within("key", "statement", SOURCE, [("a", 1.0), ("gone", outside)], 0.9, 1.1, Unit("N", 1))
    assert check.verdict is Verdict.MISSED
    assert why in check.by and ": gone" in check.by
    assert within("key", "statement", SOURCE, [], 0.0, 2.0).verdict is Verdict.MISSED


def test_tables_show_units_and_keep_si_values() -> None:
    found = table("key", "title", [Column("F", "kN", 1, 1e-3), Column("x", digits=2, signed=True)], [[1234.0, 0.5], [None, math.nan]])
    assert found.shown() == [["1.2", "+0.50"], ["–", "–"]]
    assert results.rows([c.heading for c in found.columns], found.shown()[:1]) == "| F (kN) | x |\n| --- | --- |\n| 1.2 | +0.50 |\n"


def test_a_short_plan_keeps_the_ends() -> None:
    short = Plan(short=True)
    assert [short.thin([1, 2, 3, 4, 5], *most) for most in ((), (2,), (1,))] == [[1, 3, 5], [1, 5], [3]]
    assert Plan().thin([1, 2, 3, 4, 5]) == [1, 2, 3, 4, 5]


def of_verdicts(*verdicts: Verdict, part: Part = Part.MEASUREMENTS) -> Section:
    checks = tuple(Check(f"{part.value}-{k}", f"statement {k}", SOURCE, "goal", "found", one) for k, one in enumerate(verdicts))
    return Section("key", part, "Title", "lead", checks)


def test_a_quantity_meets_its_goals_if_it_meets_all_and_a_miss_is_met_within_the_band() -> None:
    assert [bands.verdict(*of) for of in ((1.5, 0.3), (1.5, 0.2), (0.9, 0.0), (None, 0.3), (1.5, None))] == ["yes", "no", "yes", "", ""]
    met, missed, reported = Verdict.MET, Verdict.MISSED, Verdict.REPORTED
    for verdicts, expected in (((met, reported), ("met", 1, 1)), ((met, missed, missed), ("missed", 1, 3)), ((reported,), ("reported", 0, 0))):
        found = report.summary(of_verdicts(*verdicts))
        assert (found["verdict"], found["met"], found["goals"]) == expected


@pytest.mark.parametrize(("unmet", "code"), [(Verdict.MET, 0), (Verdict.MISSED, __main__.UNMET)])
def test_only_an_unmet_theory_fails(unmet: Verdict, code: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    sections = of_verdicts(Verdict.MET, unmet, part=Part.VERIFICATION), of_verdicts(Verdict.MISSED, Verdict.REPORTED)
    monkeypatch.setattr(__main__, "run_all", lambda *_: Results("1", sections, False))
    assert __main__.main(["--fmu", "x.fmu", "--output", str(tmp_path)]) == code
    document = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert document["verification"] == {"met": 2 - bool(code), "goals": 2, "reported": 0}
    assert document["measurements"] == {"met": 0, "goals": 1, "reported": 1}


def test_measurements_are_read_with_their_source_and_certainty() -> None:
    entries = [entry for key, entry in measured.data().items() if isinstance(entry, dict) and key != "causes"]
    entries += measured.data()["bounds"]
    assert len(entries) > 8 and all(entry["source"] and entry["certainty"] for entry in entries)
    points = measured.transmission_map()
    assert len(points) == 117 and {point.ratio for point in points} == {2.5, 2.0, 1.5, 1.0, 0.5}
    assert all(1000.0 <= one.rpm <= 5000.0 and 10.0 < one.torque < 100.0 and 0.7 < one.efficiency < 1.0 for one in points)


def test_start_values_lead_to_what_they_say(bench: Bench) -> None:
    slipping = bench.steady(driven_by_slip(bench.parameters, 1.5, 150.0, 0.03, 12e3), "slip")
    assert slipping and slipping["slip"] == pytest.approx(0.03, abs=1e-3)
    assert (slipping["ratio.geometric"], slipping["secondary.axialForce"]) == pytest.approx((1.5, 12e3), rel=1e-3)


def test_a_point_without_a_steady_state_leaves_its_reason(bench: Bench) -> None:
    solved: list[None] = []
    bench.solved, before = lambda: solved.append(None), len(bench.failures)
    force = bench.force(1.0, 50.0, safety=0.5)
    assert bench.steady(driven_by_torque(bench.parameters, 1.0, 200.0, 50.0, force), "too much") is None
    assert len(bench.failures) == before + 1 and bench.failures[-1].startswith("too much: ")
    # The next point is not affected.
    assert bench.steady(driven_by_torque(bench.parameters, 1.0, 200.0, 50.0, 4.0 * force), "enough")
    assert len(solved) == 2


def test_sections_alone_meet_the_theory_and_make_a_report(fmu: Path, tmp_path: Path) -> None:
    words = ["--short", "--section", "gaps", "--section", "chain"]
    assert __main__.main(["--fmu", str(fmu), "--output", str(tmp_path), *words]) == 0
    page = reports.stands_alone(tmp_path / "report.html")
    assert page.count('<tr><td class="text"><a href="#gaps') == 1
    assert "idle arc" in page and "Wedge angle</h3>" not in page
    found = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))["verification"]
    assert found["met"] == found["goals"] == 6
    reports.look_at(tmp_path / "report.html")


@pytest.fixture(scope="module")
def pinned() -> dict[str, Any]:
    return json.loads(results.PINNED.read_text(encoding="utf-8"))


def test_the_pinned_run_meets_the_theories_and_has_a_verdict_a_goal_and_a_source_for_each_check(pinned: dict[str, Any]) -> None:
    checks = pinned["checks"]
    assert len({check["key"] for check in checks}) == len(checks) > 50
    for check in checks:
        assert all(check[name] for name in ("statement", "goal", "found", "source", "certainty")), check["key"]
        if check["verdict"] == "missed":
            assert "not known" not in (check["cause"], check["decides"]), f"{check['key']} has no entry among the causes of measured.json"
    assert pinned["verification"]["met"] == pinned["verification"]["goals"] >= 18
    assert all("–" not in row[-1] for row in pinned["steps"]["rows"]), "the default belt has a steady state"


def test_the_book_shows_the_pinned_run(pinned: dict[str, Any]) -> None:
    assert results.PAGE.read_text(encoding="utf-8") == results.page(pinned)
    for path in results.telling():
        text = path.read_text(encoding="utf-8")
        assert results.renewed(text, pinned) == text, f"{path.name}: `cargo fmu validate -- --pin` has other numbers"
    readme = results.telling()[0].read_text(encoding="utf-8")
    assert all(re.search(sentence, readme) for sentence in results.QUOTED.values())


def test_numbers_of_goals_are_renewed() -> None:
    found = {"verification": {"met": 7, "goals": 8}, "single elements": {"met": 1, "goals": 2}, "measurements": {"met": 3, "goals": 5}, "score": 2.345}
    text = "Verification: 1 of 2 goals met, single elements: 3 of 4 goals met, measurements: 10 of 20 goals met**, 10 missed, and 4 missed; misses sum to 9.9 tolerances"
    assert results.renewed(text, found) == "Verification: 7 of 8 goals met, single elements: 1 of 2 goals met, measurements: 3 of 5 goals met**, 2 missed, and 4 missed; misses sum to 2.3 tolerances"
    (quantity, state), _ = next(iter(results.QUOTED.items()))
    found["steps"] = {"rows": [[quantity, state, "1.226", "9.999", "1.542"]]}
    assert results.renewed("the theory's thrust\nratio is 3.00 and the belt's 4.00.", found) == "the theory's thrust\nratio is 1.23 and the belt's 1.54."


@pytest.mark.slow
def test_a_full_run_has_the_pinned_verdicts_and_reports_every_section(fmu: Path, pinned: dict[str, Any], tmp_path: Path) -> None:
    """A changed verdict is a reviewed change: `cargo fmu validate -- --pin` renews them."""
    assert __main__.main(["--fmu", str(fmu), "--output", str(tmp_path)]) == 0
    assert results.verdicts(json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))) == results.verdicts(pinned)
    page = reports.stands_alone(tmp_path / "report.html")
    # The picture of the steps comes first.
    assert page.index('id="steps-figure"') < page.index('id="verification"') < page.index('id="single-elements"') < page.index('id="measurements"')
    assert reports.figures(page) > 10
    content = re.sub(r"<(style|script)[^>]*>.*?</\1>", "", page, flags=re.DOTALL)
    assert not re.search(r"\bnan\b", content.lower())
    tables = sorted(tmp_path.glob("*.csv"))
    assert len(tables) > len(SECTIONS)
    for path in tables:
        found = pd.read_csv(path)
        assert len(found) and isinstance(found.index, pd.RangeIndex), path.name
        assert all(dimensions(unit) for _, unit in map(split, found) if unit is not None), path.name
    reports.look_at(tmp_path / "report.html")
