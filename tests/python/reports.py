"""What every report has to be: whole in itself, drawn without complaint, usable by keys, readable on a telephone."""

from __future__ import annotations

import os
import re
from pathlib import Path

import browser
import pytest

WIDTHS = (1280, 400)
"""Of a desk and of a telephone, px."""


def stands_alone(report: Path) -> str:
    """The report's text, after a check that it loads nothing from elsewhere and has its library once."""
    text = report.read_text(encoding="utf-8")
    packed = '<script type="application/gzip" id="plotly">'
    assert text.count(packed) == 1
    own = re.sub(r"<pre>.*?</pre>", "", text.split(packed)[0], flags=re.DOTALL)
    assert not re.search(r"""(?:src|href|action|data)\s*=\s*["']?(?:https?:)?//|url\(|@import""", own)
    return text


def figures(text: str) -> int:
    """How many panels a report has."""
    return text.count('<div class="panel">')


def look_at(report: Path) -> None:
    """Opens the report in a browser at both widths, moves what moves, and looks for what is missing.

    A test's last call: it skips the rest of the test where there is no browser, and fails there in CI.
    """
    program = browser.find()
    if program is None:
        if os.environ.get("CI"):
            pytest.fail("no Chromium on the search path: install the package chromium")
        pytest.skip("no Chromium on the search path, so the report is not looked at")
    with browser.page(program) as page:
        for width in WIDTHS:
            page.open(report, width)
            _is_drawn(page)
            _fits(page, width)
        _sliders_move(page)
        _keys_move(page)
        assert page.complaints == []
        assert [address for address in page.requests if not address.startswith(("file:", "data:", "blob:"))] == []


def _is_drawn(page: browser.Page) -> None:
    missing = page.run(
        """[...document.querySelectorAll('.plot')].filter((plot) => {
            const drawn = plot.querySelectorAll('.trace, .contour, .contourlines, .contourlayer path, .fills path').length;
            return drawn === 0 || plot.getBoundingClientRect().width < 100 && plot.offsetParent;
        }).map((plot) => plot.getAttribute('aria-label'))"""
    )
    assert missing == []
    images = page.run("[...document.images].filter((one) => one.naturalWidth === 0).length")
    empty = page.run(
        "[...document.querySelectorAll('.belt svg')].filter((one) => !one.querySelector('.element[d]')).length"
    )
    assert (images, empty) == (0, 0)


def _fits(page: browser.Page, width: int) -> None:
    """The page itself does not scroll sideways: what is wide does so by itself. No card is smaller than what it holds."""
    assert page.run("document.documentElement.scrollWidth") <= width
    tight = "one.scrollHeight > one.clientHeight + 1 || one.scrollWidth > one.clientWidth + 1"
    assert (
        page.run(f"[...document.querySelectorAll('.statements li, .facts div')].filter((one) => {tight}).length") == 0
    )


def _sliders_move(page: browser.Page) -> None:
    for number in range(page.run("document.querySelectorAll('.belt').length")):
        shown = f"document.querySelectorAll('.belt')[{number}]"
        read = f"[...{shown}.querySelectorAll('.element, .belt g g')].map((one) => one.getAttribute('d')).join()"
        page.run(f"{shown}.querySelector('input').focus()")
        # Pictures that share their time stand at its end by now.
        page.key("Home")
        before = page.run(read)
        page.key("End")
        page.key("ArrowLeft")
        assert page.run(f"{shown}.querySelector('input').value") == "999"
        assert page.run(read) != before


def _keys_move(page: browser.Page) -> None:
    """The cursor of the first linked chart by keys, its zoom, and a legend that switches a line off."""
    chart = "[...document.querySelectorAll('.chart')].find((one) => one.querySelector('script').textContent.includes('\"linked\":true'))"
    if page.run(f"Boolean({chart})"):
        plot = f"{chart}.querySelector('.plot')"
        span = f"(([a, b]) => b - a)({plot}._fullLayout.xaxis.range)"
        whole = page.run(span)
        page.run(f"{plot}.focus()")
        page.key("ArrowRight")
        assert page.run(f"{chart}.querySelector('.cursor').textContent") != ""
        page.key("+")
        page.wait(f"{span} < {0.7 * whole}")
        others = f"[...{chart}.querySelectorAll('.plot')].every((one) => Math.abs(one._fullLayout.xaxis.range[0] - {plot}._fullLayout.xaxis.range[0]) < 1e-6)"
        page.wait(others)
        page.key("0")
        page.wait(f"Math.abs({span} - {whole}) < 1e-6")
    key = "document.querySelector('.keys button')"
    if page.run(f"Boolean({key})"):
        page.run(f"{key}.focus()")
        page.key("Enter")
        page.wait(f"{key}.getAttribute('aria-pressed') === 'false'")
        visible = f"{key}.closest('.chart').querySelector('.plot').data.some((one) => one.visible === false)"
        page.wait(visible)
