"""A page with all elements of reports: it works with the pointer, and the checks of reports detect defects."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import browser
import numpy as np
import pictures
import pytest
import reports
from conftest import ROOT
from test_charts import BENCH, EVERYTHING, NARROW, TABLE

from pushbelt.fmu import data
from pushbelt.fmu.results import BeltState, Profile
from pushbelt.report import belt_view, charts, page
from pushbelt.report.charts import Chart, Mark, Panel, Series

PROGRAM = browser.find()
needs_browser = pytest.mark.skipif(
    PROGRAM is None and not os.environ.get("CI"), reason="no Chromium on the search path"
)


def belt() -> str:
    """Two times, between which the push force moves around the belt."""
    curve = data.curve_of(BENCH, 0.2)
    position = curve.length * np.arange(72) / 72
    none = np.zeros(72)
    outputs = {"reference.theta": 0.2}
    outputs |= {
        f"{pulley}.radius": curve.radius(pulley) - BENCH["belt.pitchOffset"] for pulley in ("primary", "secondary")
    }
    push = 500.0 * (1.0 + np.sin(2.0 * np.pi * position / curve.length))
    profiles = [Profile(position, np.roll(push, k), none, none, none, none, none) for k in (0, 36)]
    states = {float(k): BeltState(outputs, profile) for k, profile in enumerate(profiles)}
    turned = [np.array([0.0, 100.0]), np.array([0.0, 80.0]), np.array([0.0, 5.0])]
    return belt_view.belt_view(belt_view.motion(states, BENCH, turned), BENCH, "A belt", group="one")


def written(folder: Path, *, whole: bool = True) -> Path:
    """A page with two linked panels and the belt; with `whole` also a figure of every kind, facts and a table."""
    time = np.linspace(0.0, 1.0, 101)
    panels = [
        Panel("First", [Series("a", time, time, width=3.2, opacity=0.5), Series("b", time, 2.0 * time, dash="dashdot")], "time (s)", x_range=(0.0, 1.0)),
        Panel(
            "Second",
            [Series("c", time, 10.0 ** (3.0 * time)), Series("d", time, -time)],
            scale="symlog",
            x_range=(0.0, 1.0),
        ),
    ]
    chart = charts.html(Chart(panels, "Two panels", linked=True, group="one"))
    more = ""
    if whole:
        every = replace(EVERYTHING, equal=False, x_ticks=(), marks=[Mark(1.5, "1")])
        facts = '<div class="facts"><div><b>12</b><span>points</span></div></div>'
        more = f"{facts}{TABLE}{charts.html(Chart([every, *NARROW], 'Every kind of figure'))}"
    style = (ROOT / "python" / "pushbelt" / "report" / "style.css").read_text(encoding="utf-8")
    head = f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><style>{style}</style></head>'
    path = folder / "report.html"
    path.write_text(page.with_scripts(f"{head}<body><main>{belt()}{chart}{more}</main></body></html>"), encoding="utf-8")
    return path


@needs_browser
def test_pointer_moves_one_cursor_through_panels_and_belt_which_plays(tmp_path: Path) -> None:
    assert PROGRAM is not None, "no Chromium on the search path: install the package chromium"
    with browser.page(PROGRAM) as opened:
        opened.open(written(tmp_path, whole=False), 1280)
        opened.run("document.querySelector('.plot').scrollIntoView({ block: 'center' })")
        x, y, width = opened.run(
            "(({ left, top, height, width }) => [left, top + height / 2, width])"
            "(document.querySelector('.plot .nsewdrag').getBoundingClientRect())"
        )

        def mouse(kind: str, share: float, clicks: int = 1, buttons: int = 0) -> None:
            left = {"button": "left", "clickCount": clicks, "buttons": buttons} if kind != "mouseMoved" or buttons else {}
            opened.call("Input.dispatchMouseEvent", type=kind, x=x + share * width, y=y, **left)

        mouse("mouseMoved", 0.2)
        mouse("mouseMoved", 0.5)
        values = "[...document.querySelectorAll('.keys button output')].map((one) => Number(one.textContent.replace('\u2212', '-').replaceAll('\u202f', '')))"
        opened.wait(f"Math.abs({values}[0] - 0.5) < 0.02")
        a, b, c, d = opened.run(values)
        assert (b, d) == pytest.approx((2.0 * a, -a), abs=2e-3)
        assert c == pytest.approx(10.0 ** (3.0 * a), rel=0.02)
        assert opened.run("[...document.querySelectorAll('.cursor-line')].every((line) => !line.hidden)")
        assert opened.run("document.querySelector('.belt input').value") == str(round(1000 * a))
        mouse("mousePressed", 0.5)
        mouse("mouseReleased", 0.5)
        # A drag zooms both panels into the selection; a double click shows all again.
        mouse("mousePressed", 0.25)
        for share in (0.4, 0.75):
            mouse("mouseMoved", share, buttons=1)
        mouse("mouseReleased", 0.75)
        ranges = "[...document.querySelectorAll('.plot')].map((plot) => plot._fullLayout.xaxis.range)"
        opened.wait(f"{ranges}.every(([low, high]) => Math.abs(low - 0.25) < 0.02 && Math.abs(high - 0.75) < 0.02)")
        # Two clicks count as a double click independent of the speed of the machine, and the preceding drag is not one of them.
        opened.run(
            "document.querySelectorAll('.plot').forEach((plot) => {"
            " plot._context.doubleClickDelay = 600000; plot._mouseDownTime = 0; })"
        )
        for count in (1, 2):
            mouse("mousePressed", 0.5, count)
            mouse("mouseReleased", 0.5, count)
        opened.wait(f"{ranges}.every(([low, high]) => low === 0 && high === 1)")
        # The belt plays and stops.
        first = "document.querySelector('.belt .element').getAttribute('d')"
        before = opened.run(first)
        opened.run("document.querySelector('.belt button').focus()")
        opened.key("Enter")
        opened.wait(f"{first} !== {before!r}")
        opened.key("Enter")
        still = opened.run(first)
        opened.run("new Promise((done) => setTimeout(done, 100))")
        assert opened.run(first) == still and opened.complaints == []


BREAKAGE: dict[str, tuple[str, str]] = {
    "an error": ("</main>", "<script>nothing.here();</script></main>"),
    "something from elsewhere": ("</main>", "<script>fetch('http://127.0.0.1:9/x')</script></main>"),
    "something wide": ("<main>", '<main><div style="width: 500px">wide</div>'),
    "a belt that stands": ('addEventListener("input"', 'addEventListener("other"'),
    "a legend of another look": ("stroke-width: ${line.width}px", "stroke-width: 2px"),
}


@needs_browser
@pytest.mark.parametrize("what", BREAKAGE)
def test_the_look_at_a_report_finds(what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    report = written(tmp_path)
    text = report.read_text(encoding="utf-8")
    broken = text.replace(*BREAKAGE[what])
    assert broken != text
    report.write_text(broken, encoding="utf-8")
    monkeypatch.setattr(browser, "PATIENCE", 3.0)
    with pytest.raises((AssertionError, TimeoutError, RuntimeError)):
        reports.look_at(report, whole=True)


@needs_browser
def test_a_sound_page_passes(tmp_path: Path) -> None:
    report = written(tmp_path)
    reports.stands_alone(report)
    reports.look_at(report, whole=True)


@pytest.mark.parametrize(
    "address",
    ['<img src="https://example.org/a.png">', "<style>@import 'x.css'</style>", '<link href="//example.org">'],
)
def test_what_is_loaded_from_elsewhere_is_seen(address: str, tmp_path: Path) -> None:
    report = written(tmp_path)
    report.write_text(report.read_text(encoding="utf-8").replace("<main>", f"<main>{address}"), encoding="utf-8")
    with pytest.raises(AssertionError):
        reports.stands_alone(report)


@needs_browser
def test_the_docs_picture_is_taken_from_a_report(tmp_path: Path) -> None:
    picture = tmp_path / "report.png"
    assert pictures.main(["demo", str(written(tmp_path)), str(picture)]) == 0
    content = picture.read_bytes()
    size = tuple(int.from_bytes(content[k : k + 4], "big") for k in (16, 20))
    assert size == (pictures.WIDTH - 36, pictures.HEIGHT)
    docs = (ROOT / "docs" / "report.png").read_bytes()
    assert docs[16:24] == content[16:24], "the picture in the docs is not that of this program"
    assert pictures.main(["demo", str(tmp_path / "none.html"), str(picture)]) == 1
