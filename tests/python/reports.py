"""Common checks of reports: self-contained, and drawn without complaints."""

from __future__ import annotations

import re
from pathlib import Path

import browser


def stands_alone(report: Path) -> str:
    """The report's text, after checks that it has no external resources and contains its library once."""
    text = report.read_text(encoding="utf-8")
    packed = '<script type="application/gzip" id="plotly">'
    assert text.count(packed) == 1
    own = re.sub(r"<pre>.*?</pre>", "", text.split(packed)[0], flags=re.DOTALL)
    assert not re.search(r"""(?:src|href|action|data)\s*=\s*["']?(?:https?:)?//|url\(|@import""", own)
    return text


def figures(text: str) -> int:
    return text.count('<div class="panel">')


def look_at(report: Path) -> None:
    """Opens the report in a browser: its figures are drawn, without a complaint and without a request. This must be the last call of a test,
    because it is skipped without a browser. `test_reports` looks closer, at a page with every kind of figure."""
    with browser.page() as (page, complaints):
        browser.show(page, report, 1280)
        missing = page.evaluate(
            """[...document.querySelectorAll('.plot')].filter((plot) => {
                const drawn = plot.querySelectorAll('.trace, .contour, .contourlines, .contourlayer path, .fills path').length;
                return drawn === 0 || plot.getBoundingClientRect().width < 100 && plot.offsetParent;
            }).map((plot) => plot.getAttribute('aria-label'))"""
        )
        images = page.evaluate("[...document.images].filter((one) => one.naturalWidth === 0).length")
        empty = page.evaluate("[...document.querySelectorAll('.belt svg')].filter((one) => !one.querySelector('.element[d]')).length")
        assert (missing, images, empty, complaints) == ([], 0, 0, [])
