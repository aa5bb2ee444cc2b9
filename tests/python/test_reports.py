"""A page with every kind of figure, as a reader uses it: legible on a desktop and a telephone, by pointer and by keyboard."""

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pypdfium2
import pytest
import reports
from conftest import ROOT
from PIL import Image
from playwright.sync_api import Browser, Page
from test_charts import BENCH, EVERYTHING

from pushbelt.fmu import data
from pushbelt.fmu.results import BeltState, Profile
from pushbelt.report import belt_view, style
from pushbelt.report.charts import Chart, Mark, Panel, Series, Shade
from pushbelt.report.page import write_html

sys.path.insert(0, str(ROOT / "fmu-build" / "python"))
import pictures  # noqa: E402

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
    outputs |= dict(zip(belt_view.SPEEDS, (100.0, 80.0, 5.0), strict=True))
    push = 500.0 * (1.0 + np.sin(2.0 * np.pi * position / curve.length))
    profiles = [Profile(position, np.roll(push, k), none, none, none, none, none) for k in (0, 36)]
    states = {float(k): BeltState({"reference.theta": 0.2, **outputs}, profile) for k, profile in enumerate(profiles)}
    return belt_view.belt_view(states, BENCH, "A belt", group="one")


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two linked panels and the belt, a figure of every kind, facts and tables."""
    time = np.linspace(0.0, 1.0, 101)
    panels = [
        Panel("First", [Series("a", time, time, width=3.2, opacity=0.5), Series("b", time, 2.0 * time, dash="dashdot")], "time (s)", x_range=(0.0, 1.0)),
        Panel("Second", [Series("c", time, 10.0 ** (3.0 * time)), Series("d", time, -time)], x_range=(0.0, 1.0)),
    ]
    linked = Chart(panels, "Two panels", linked=True, group="one").__html__()
    every = Chart([replace(EVERYTHING, equal=False, x_ticks=(), marks=[Mark(1.5, "1")]), *NARROW], "Every kind of figure").__html__()
    ends = [Panel(f"Shared {k}", [Series("kept", X, X), Series("other", X, -X)], x_ticks=((0.0, "left"), (1800.0, f"right {k}"))) for k in (1, 2)]
    shared = Chart(ends, "Shared keys", columns=2, common_legend=True).__html__()
    facts = '<div class="facts"><div><b>12</b><span>points</span></div></div>'
    folder = tmp_path_factory.mktemp("page")
    (folder / "page.html.j2").write_text("{% extends 'base.html.j2' %}{% block main %}{{ content | safe }}{% endblock %}", encoding="utf-8")
    path = folder / "report.html"
    write_html("page.html.j2", {"content": f"{belt()}{linked}{facts}{TABLE}{UNSORTED}{every}{shared}"}, path, folder)
    return path


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with reports.chromium() as browser:
        yield browser


@pytest.fixture
def opened(report: Path, chromium: Browser) -> Iterator[Page]:
    with reports.page(chromium) as (opened, complaints):
        reports.show(opened, report, 1280)
        yield opened
        assert complaints == []


@pytest.mark.parametrize("width", [1280, 400], ids=["desktop", "telephone"])
def test_the_page_is_legible(report: Path, chromium: Browser, width: int) -> None:
    with reports.page(chromium) as (page, complaints):
        reports.show(page, report, width)
        assert (reports.faults(page, "legends", "labels", "tight"), complaints) == ([], [])
        assert page.evaluate("document.documentElement.scrollWidth") <= width, "the page scrolls sideways"


SIZES = "[...document.querySelectorAll('.plot .main-svg:first-child')].map((one) => one.getAttribute('width'))"


@pytest.mark.parametrize("drawn", [True, False], ids=["shown before", "not shown"])
def test_a_printed_page_has_its_figures_and_keys_whole(report: Path, chromium: Browser, tmp_path: Path, drawn: bool) -> None:
    """Before it is printed, as the browser lays it out, and as PDF on A4; afterwards the screen is as before."""
    with reports.page(chromium) as (page, complaints):
        page.set_viewport_size({"width": 1280, "height": 900})
        page.goto(report.resolve().as_uri())
        page.evaluate(f"pushbelt.ready.then(() => {'pushbelt.draw()' if drawn else 'true'})")
        before = page.evaluate(SIZES)
        page.pdf(path=tmp_path / "report.pdf", format="A4")
        if drawn:
            assert page.evaluate(SIZES) == before
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        page.emulate_media(media="print")
        hidden = "[...document.querySelectorAll('.keys button')].filter((key) => !key.getClientRects().length).length"
        assert (reports.faults(page, "missing", "labels"), page.evaluate(hidden), complaints) == ([], 0, [])
    pages = list(pypdfium2.PdfDocument(tmp_path / "report.pdf"))
    texts = [one.get_textpage() for one in pages]
    whole = " ".join(text.get_text_bounded() for text in texts)
    assert [word for word in ("kept", "other", "right 1", "right 2") if word not in whole] == []
    # The margins of the page are 34 pt.
    boxes = np.array([text.get_charbox(k) for text in texts for k in range(text.count_chars())])
    assert boxes[:, 0].min() > 32.0 and boxes[:, 2].max() < pages[0].get_width() - 32.0


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


def test_the_checks_of_reports_find_a_fault(report: Path, chromium: Browser, tmp_path: Path) -> None:
    reports.stands_alone(report)
    reports.look_at(report, chromium)
    text, faulty = report.read_text(encoding="utf-8"), tmp_path / "report.html"
    for broken in ('<img src="https://example.org/a.png">', "<style>@import 'x.css'</style>", '<link href="//example.org">'):
        faulty.write_text(text.replace("<main>", f"<main>{broken}"), encoding="utf-8")
        with pytest.raises(AssertionError):
            reports.stands_alone(faulty)
    scripts = "<script>nothing.here();</script><script>fetch('http://127.0.0.1:9/x')</script>"
    faulty.write_text(text.replace("<main>", f'<main>{scripts}<div class="plot" aria-label="no lines"></div>'), encoding="utf-8")
    with pytest.raises(AssertionError) as found:
        reports.look_at(faulty, chromium)
    assert all(part in str(found.value) for part in ("nothing", "127.0.0.1:9/x", "no lines"))


def test_the_docs_picture_is_taken_from_a_report(report: Path, chromium: Browser, tmp_path: Path) -> None:
    picture = tmp_path / "report.png"
    pictures.take(report, picture, None, chromium)
    docs = (ROOT / "docs" / "report.png").read_bytes()
    assert docs[16:24] == picture.read_bytes()[16:24], "the picture in the docs has another size than that of this program"
    assert pictures.stamped(picture) == pictures.shown("report.png")
    with Image.open(picture) as image:
        assert image.text == {"Shows": pictures.shown("report.png")}


@pytest.mark.parametrize("name", sorted(pictures.STORED))
def test_a_picture_of_the_docs_shows_the_stored_results(name: str) -> None:
    of = pictures.STORED[name][0]
    renewed = f"`cargo fmu {of}`, then `target/venv/bin/python fmu-build/python/pictures.py {of}`"
    assert pictures.stamped(ROOT / "docs" / name) == pictures.shown(name), f"docs/{name} is older than what it shows: renew it by {renewed}"
