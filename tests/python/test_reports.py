"""A page with every kind of figure, as a reader uses it: legible on a desktop and a telephone, by pointer and by keyboard."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import browser
import numpy as np
import pictures
import pytest
import reports
from conftest import ROOT
from playwright.sync_api import Page
from test_charts import BENCH, EVERYTHING

from pushbelt.fmu import data
from pushbelt.fmu.results import BeltState, Profile
from pushbelt.report import belt_view, charts, style
from pushbelt.report.charts import Chart, Mark, Panel, Series, Shade
from pushbelt.report.page import write_html

X = np.linspace(0.0, 1800.0, 50)
NARROW = [
    Panel(
        "Large numbers", [Series("a", X, 1e5 * np.sin(X))],
        "time since the beginning of the whole driving cycle in seconds (s)", "a long title of an axis (kN)",
    ),
    Panel("Named", [Series("b", [0.0, 1.0, 2.0, 3.0], [1.0, 2.0, 3.0, 4.0])], x_ticks=tuple((float(k), f"underdrive {k}") for k in range(4))),
    Panel(
        "Shaded", [Series("d", X, X)], x_range=(0.0, 1800.0),
        shades=[Shade(200.0 * k, 200.0 * k + 200.0, style.BLUE, f"secondary arc {k}") for k in range(9)],
    ),
    Panel("Logarithmic", [Series("c", X + 1.0, 1e-3 * X + 1e-6)], "frequency (Hz)", x_scale="log", scale="log"),
]  # fmt: skip
"""Long names of ticks, large numbers and long titles of axes."""
TABLE = (
    "<table><tr><th>Name</th><th>Value</th></tr>"
    "<tr><td>c</td><td>\N{MINUS SIGN}2.5 %</td></tr><tr><td>a</td><td>1\N{NARROW NO-BREAK SPACE}200</td></tr>"
    "<tr><td>b</td><td>\N{EN DASH}</td></tr><tr><td>d</td><td>30 <small>kN</small></td></tr></table>"
)
UNSORTED = TABLE.replace("<td>b</td>", "<td colspan='2'>b</td>") + "<table><tr><th>A</th></tr><tr><td>2</td></tr><tr><td>1</td></tr></table>"
"""Irregular and short tables, which stay as they are."""


def belt() -> str:
    """Two times, between which the push force moves around the belt."""
    curve = data.curve_of(BENCH, 0.2)
    position = curve.length * np.arange(72) / 72
    none = np.zeros(72)
    outputs = {f"{pulley}.radius": curve.radius(pulley) - BENCH["belt.pitchOffset"] for pulley in ("primary", "secondary")}
    push = 500.0 * (1.0 + np.sin(2.0 * np.pi * position / curve.length))
    profiles = [Profile(position, np.roll(push, k), none, none, none, none, none) for k in (0, 36)]
    states = {float(k): BeltState({"reference.theta": 0.2, **outputs}, profile) for k, profile in enumerate(profiles)}
    turned = [np.array([0.0, 100.0]), np.array([0.0, 80.0]), np.array([0.0, 5.0])]
    return belt_view.belt_view(belt_view.motion(states, BENCH, turned), BENCH, "A belt", group="one")


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two linked panels and the belt, a figure of every kind, facts and tables."""
    time = np.linspace(0.0, 1.0, 101)
    panels = [
        Panel("First", [Series("a", time, time, width=3.2, opacity=0.5), Series("b", time, 2.0 * time, dash="dashdot")], "time (s)", x_range=(0.0, 1.0)),
        Panel("Second", [Series("c", time, 10.0 ** (3.0 * time)), Series("d", time, -time)], scale="symlog", x_range=(0.0, 1.0)),
    ]
    linked = charts.html(Chart(panels, "Two panels", linked=True, group="one"))
    every = charts.html(Chart([replace(EVERYTHING, equal=False, x_ticks=(), marks=[Mark(1.5, "1")]), *NARROW], "Every kind of figure"))
    facts = '<div class="facts"><div><b>12</b><span>points</span></div></div>'
    folder = tmp_path_factory.mktemp("page")
    (folder / "page.html.j2").write_text("{% extends 'base.html.j2' %}{% block main %}{{ content | safe }}{% endblock %}", encoding="utf-8")
    path = folder / "report.html"
    write_html("page.html.j2", {"content": f"{belt()}{linked}{facts}{TABLE}{UNSORTED}{every}"}, path, folder)
    return path


@pytest.fixture
def opened(report: Path) -> Iterator[Page]:
    with browser.page() as (opened, complaints):
        browser.show(opened, report, 1280)
        yield opened
        assert complaints == []


def test_the_page_passes_the_checks_of_reports(report: Path) -> None:
    reports.stands_alone(report)
    reports.look_at(report)


LEGENDS = """[...document.querySelectorAll('.keys button')].filter((key) => key.querySelector('path.line')).flatMap((key) => {
    const sample = key.querySelector('path.line'), name = key.childNodes[1].textContent;
    const look = (path, opacity) => [...['stroke', 'strokeWidth', 'strokeDasharray'].map((one) => getComputedStyle(path)[one]), Number(opacity)].join(' ');
    const shown = look(sample, sample.closest('svg').getAttribute('opacity'));
    const drawn = [...key.closest('.chart').querySelectorAll('.plot')].flatMap((plot) =>
        [...plot.querySelectorAll('.scatterlayer .trace')].filter((trace) => trace.__data__[0].trace.name === name)
            .flatMap((trace) => [...trace.querySelectorAll('.js-line')].map((path) => look(path, getComputedStyle(trace).opacity))));
    return drawn.length === 0 || drawn.includes(shown) ? [] : [`${name}: ${shown}, drawn ${drawn[0]}`];
})"""
"""Legends whose sample has not the colour, width, dash and opacity of a line of its name."""
LABELS = """[...document.querySelectorAll('.plot')].filter((plot) => plot.offsetParent).flatMap((plot) => {
    const outer = plot.getBoundingClientRect();
    const seen = (selector) => [...plot.querySelectorAll(selector)].map((one) => ({ text: one.textContent, box: one.getBoundingClientRect() }))
        .filter(({ text, box }) => text.trim() && box.width > 0);
    const complaints = [...plot.querySelectorAll('text')].filter((one) => one.textContent.trim() && parseFloat(getComputedStyle(one).fontSize) < 11.9)
        .map((one) => `small: ${one.textContent}`);
    for (const { text, box } of [...seen('.xtick text, .ytick text'), ...seen('.xtitle, .ytitle')]) {
        if (box.left < outer.left - 1 || box.right > outer.right + 1 || box.top < outer.top - 1 || box.bottom > outer.bottom + 1) {
            complaints.push(`cut off: ${text}`);
        }
    }
    // The box of a line of text is higher than its digits.
    for (const [selector, from, to, slack] of [['.xtick text', 'left', 'right', 0], ['.ytick text', 'top', 'bottom', 5]]) {
        const ticks = seen(selector).sort((a, b) => a.box[from] - b.box[from]);
        ticks.slice(1).filter((tick, k) => tick.box[from] < ticks[k].box[to] - slack).forEach(({ text }) => complaints.push(`overlap: ${text}`));
    }
    const labels = seen('.annotation-text').sort((a, b) => a.box.left - b.box.left);
    labels.slice(1).filter(({ box }, k) => box.left < labels[k].box.right - 1 && box.top < labels[k].box.bottom - 3 && labels[k].box.top < box.bottom - 3)
        .forEach(({ text }) => complaints.push(`overlap: ${text}`));
    return complaints;
})"""
"""Labels of axes that are less than 12 px high, are cut off, or overlap."""
TIGHT = "[...document.querySelectorAll('.facts div')].filter((one) => one.scrollHeight > one.clientHeight + 1 || one.scrollWidth > one.clientWidth + 1)"
"""Cards that are smaller than their content."""


@pytest.mark.parametrize("width", [1280, 400], ids=["desktop", "telephone"])
def test_the_page_is_legible(report: Path, width: int) -> None:
    with browser.page() as (page, complaints):
        browser.show(page, report, width)
        assert [page.evaluate(one) for one in (LEGENDS, LABELS, TIGHT)] == [[], [], []]
        assert page.evaluate("document.documentElement.scrollWidth") <= width, "the page scrolls sideways"
        assert complaints == []


def test_a_table_is_sorted_by_value(opened: Page) -> None:
    assert opened.locator("th[aria-sort]").count() == 2
    names = "[...document.querySelector('table').querySelectorAll('td:first-child')].map((one) => one.textContent).join('')"
    for column, order, sort in ((1, "cdab", "ascending"), (1, "adcb", "descending"), (0, "abcd", "none")):
        opened.locator("th").nth(column).press("Enter")
        assert opened.evaluate(names) == order
        assert opened.locator("th").nth(1).get_attribute("aria-sort") == sort


def test_the_belt_moves_by_its_slider_and_plays(opened: Page) -> None:
    drawn = "document.querySelector('.belt .element').getAttribute('d')"
    slider = opened.locator(".belt input")
    slider.press("Home")
    before = opened.evaluate(drawn)
    slider.press("End")
    slider.press("ArrowLeft")
    assert slider.input_value() == "999"
    assert (still := opened.evaluate(drawn)) != before
    play = opened.locator(".belt button")
    play.press("Enter")
    opened.wait_for_function(f"{drawn} !== {still!r}")
    play.press("Enter")
    still = opened.evaluate(drawn)
    opened.wait_for_timeout(100)
    assert opened.evaluate(drawn) == still


RANGES = "[...document.querySelectorAll('.chart')[0].querySelectorAll('.plot')].map((plot) => plot._fullLayout.xaxis.range)"


def test_keys_move_the_cursor_zoom_both_panels_and_hide_a_line(opened: Page) -> None:
    plot = opened.locator(".plot").first
    plot.press("ArrowRight")
    assert opened.locator(".cursor").first.text_content() != ""
    plot.press("+")
    opened.wait_for_function(f"{RANGES}.every(([low, high]) => high - low < 0.7)")
    plot.press("0")
    opened.wait_for_function(f"{RANGES}.every(([low, high]) => low === 0 && high === 1)")
    key = opened.locator(".keys button").first
    key.press("Enter")
    opened.wait_for_function("document.querySelector('.keys button').getAttribute('aria-pressed') === 'false'")
    opened.wait_for_function("document.querySelector('.plot').data.some((one) => one.visible === false)")


def test_the_pointer_moves_one_cursor_through_panels_and_belt(opened: Page) -> None:
    opened.locator(".plot").first.scroll_into_view_if_needed()
    box = opened.locator(".plot .nsewdrag").first.bounding_box()

    def move(share: float) -> None:
        opened.mouse.move(box["x"] + share * box["width"], box["y"] + 0.5 * box["height"])

    move(0.2)
    move(0.5)
    shown = "[...document.querySelector('.chart').querySelectorAll('.keys button output')].map((one) => one.textContent"
    values = f"{shown}.replace('\u2212', '-').replaceAll('\u202f', '')).map(Number)"
    opened.wait_for_function(f"Math.abs({values}[0] - 0.5) < 0.02")
    a, b, c, d = opened.evaluate(values)
    assert (b, d) == pytest.approx((2.0 * a, -a), abs=2e-3)
    assert c == pytest.approx(10.0 ** (3.0 * a), rel=0.02)
    assert opened.locator(".belt input").input_value() == str(round(1000 * a))
    # A drag zooms both panels into the selection; a double click shows all again.
    move(0.25)
    opened.mouse.down()
    for share in (0.4, 0.75):
        move(share)
    opened.mouse.up()
    opened.wait_for_function(f"{RANGES}.every(([low, high]) => Math.abs(low - 0.25) < 0.02 && Math.abs(high - 0.75) < 0.02)")
    # Two clicks count as a double click independent of the speed of the machine, and the preceding drag is not one of them.
    opened.evaluate("document.querySelectorAll('.plot').forEach((plot) => { plot._context.doubleClickDelay = 600000; plot._mouseDownTime = 0; })")
    opened.mouse.dblclick(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    opened.wait_for_function(f"{RANGES}.every(([low, high]) => low === 0 && high === 1)")


@pytest.mark.parametrize(
    ("check", "broken"),
    [
        (reports.look_at, "<script>nothing.here();</script>"), (reports.look_at, "<script>fetch('http://127.0.0.1:9/x')</script>"),
        (reports.look_at, '<div class="plot"></div>'), (reports.stands_alone, '<img src="https://example.org/a.png">'),
        (reports.stands_alone, "<style>@import 'x.css'</style>"), (reports.stands_alone, '<link href="//example.org">'),
    ],
)  # fmt: skip
def test_the_checks_of_reports_find_a_fault(check: Callable[[Path], object], broken: str, report: Path, tmp_path: Path) -> None:
    faulty = tmp_path / "report.html"
    faulty.write_text(report.read_text(encoding="utf-8").replace("<main>", f"<main>{broken}"), encoding="utf-8")
    with pytest.raises(AssertionError):
        check(faulty)


def test_the_docs_picture_is_taken_from_a_report(report: Path, tmp_path: Path) -> None:
    picture = tmp_path / "report.png"
    assert pictures.main(["demo", str(report), str(picture)]) == 0
    docs = (ROOT / "docs" / "report.png").read_bytes()
    assert docs[16:24] == picture.read_bytes()[16:24], "the picture in the docs has another size than that of this program"
