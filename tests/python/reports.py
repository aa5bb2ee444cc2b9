"""Common checks of reports: self-contained, drawn without errors, usable by keyboard, readable on a telephone."""

from __future__ import annotations

import os
import re
from pathlib import Path

import browser
import pytest

WIDTHS = (1280, 400)
"""Widths of a desktop and of a telephone screen, px."""


def stands_alone(report: Path) -> str:
    """The report's text, after checks that it has no external resources and contains its library once."""
    text = report.read_text(encoding="utf-8")
    packed = '<script type="application/gzip" id="plotly">'
    assert text.count(packed) == 1
    own = re.sub(r"<pre>.*?</pre>", "", text.split(packed)[0], flags=re.DOTALL)
    assert not re.search(r"""(?:src|href|action|data)\s*=\s*["']?(?:https?:)?//|url\(|@import""", own)
    return text


def figures(text: str) -> int:
    """Number of panels in a report."""
    return text.count('<div class="panel">')


def look_at(report: Path, *, whole: bool = False) -> None:
    """Opens the report in a browser: its figures are drawn, without a complaint and without a request. With `whole` it is opened at both
    widths, its controls are used, and its legibility is checked: for the page that has every kind of figure.

    This must be the last call of a test: without a browser it skips the rest of the test, or fails in CI.
    """
    program = browser.find()
    if program is None:
        if os.environ.get("CI"):
            pytest.fail("no Chromium on the search path: install the package chromium")
        pytest.skip("no Chromium on the search path, so the report is not checked")
    with browser.page(program) as page:
        for width in WIDTHS if whole else WIDTHS[:1]:
            page.open(report, width)
            _is_drawn(page)
            if whole:
                _legends_are_as_drawn(page)
                _fits(page, width)
                _is_legible(page)
        if whole:
            _tables_sort(page)
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
    empty = page.run("[...document.querySelectorAll('.belt svg')].filter((one) => !one.querySelector('.element[d]')).length")
    assert (images, empty) == (0, 0)


def _legends_are_as_drawn(page: browser.Page) -> None:
    """Checks that the sample of each line in a legend has the colour, width, dash and opacity of a line of that name."""
    wrong = page.run(
        """[...document.querySelectorAll('.keys button')].filter((key) => key.querySelector('path.line')).flatMap((key) => {
            const sample = key.querySelector('path.line'), name = key.childNodes[1].textContent;
            const look = (path, opacity) => [...['stroke', 'strokeWidth', 'strokeDasharray'].map((one) => getComputedStyle(path)[one]), Number(opacity)].join(' ');
            const shown = look(sample, sample.closest('svg').getAttribute('opacity'));
            const drawn = [...key.closest('.chart').querySelectorAll('.plot')].flatMap((plot) =>
                [...plot.querySelectorAll('.scatterlayer .trace')].filter((trace) => trace.__data__[0].trace.name === name)
                    .flatMap((trace) => [...trace.querySelectorAll('.js-line')].map((path) => look(path, getComputedStyle(trace).opacity))));
            return drawn.length === 0 || drawn.includes(shown) ? [] : [`${name}: ${shown}, drawn ${drawn[0]}`];
        })"""
    )
    assert wrong == [], wrong


def _fits(page: browser.Page, width: int) -> None:
    """Checks that the page does not scroll sideways (wide parts scroll separately), and that no card is smaller than its content."""
    assert page.run("document.documentElement.scrollWidth") <= width
    tight = "one.scrollHeight > one.clientHeight + 1 || one.scrollWidth > one.clientWidth + 1"
    assert page.run(f"[...document.querySelectorAll('.statements li, .facts div')].filter((one) => {tight}).length") == 0


def _sliders_move(page: browser.Page) -> None:
    for number in range(page.run("document.querySelectorAll('.belt').length")):
        shown = f"document.querySelectorAll('.belt')[{number}]"
        read = f"[...{shown}.querySelectorAll('.element, .belt g g')].map((one) => one.getAttribute('d')).join()"
        page.run(f"{shown}.querySelector('input').focus()")
        # Animations with a common time are at its end now.
        page.key("Home")
        before = page.run(read)
        page.key("End")
        page.key("ArrowLeft")
        assert page.run(f"{shown}.querySelector('input').value") == "999"
        assert page.run(read) != before


def _keys_move(page: browser.Page) -> None:
    """Tests the first linked chart by keyboard: its cursor, its zoom, and a legend that hides a line."""
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


def _is_legible(page: browser.Page) -> None:
    """Checks that labels of axes are at least 12 px high, lie inside their figure, and do not overlap."""
    small = page.run(
        """[...document.querySelectorAll('.plot text')].filter((one) => one.textContent.trim() &&
            parseFloat(getComputedStyle(one).fontSize) < 11.9).map((one) => one.textContent)"""
    )
    assert small == [], small
    wrong = page.run(
        """[...document.querySelectorAll('.plot')].filter((plot) => plot.offsetParent).flatMap((plot) => {
            const outer = plot.getBoundingClientRect();
            const seen = (selector) => [...plot.querySelectorAll(selector)].map((one) => ({ text: one.textContent, box: one.getBoundingClientRect() }))
                .filter(({ text, box }) => text.trim() && box.width > 0);
            const complaints = [];
            for (const { text, box } of [...seen('.xtick text, .ytick text'), ...seen('.xtitle, .ytitle')]) {
                if (box.left < outer.left - 1 || box.right > outer.right + 1 || box.top < outer.top - 1 || box.bottom > outer.bottom + 1) {
                    complaints.push(`cut off: ${text} of ${plot.getAttribute('aria-label')}`);
                }
            }
            for (const [selector, from, to] of [['.xtick text', 'left', 'right'], ['.ytick text', 'top', 'bottom']]) {
                const ticks = seen(selector).sort((a, b) => a.box[from] - b.box[from]);
                for (let k = 1; k < ticks.length; k++) {
                    // The box of a line of text is higher than its digits.
                    const slack = from === 'top' ? 5 : 0;
                    if (ticks[k].box[from] < ticks[k - 1].box[to] - slack) {
                        complaints.push(`overlap: ${ticks[k - 1].text} and ${ticks[k].text} of ${plot.getAttribute('aria-label')}`);
                    }
                }
            }
            const labels = seen('.annotation-text').sort((a, b) => a.box.left - b.box.left);
            for (let k = 1; k < labels.length; k++) {
                const [a, b] = [labels[k - 1], labels[k]];
                if (b.box.left < a.box.right - 1 && b.box.top < a.box.bottom - 3 && a.box.top < b.box.bottom - 3) {
                    complaints.push(`overlap: ${a.text} and ${b.text} of ${plot.getAttribute('aria-label')}`);
                }
            }
            return complaints;
        })"""
    )
    assert wrong == [], wrong


def _tables_sort(page: browser.Page) -> None:
    """Sorts the first visible sortable table by keyboard, and checks the order of its numbers. Cards of narrow screens have no header."""
    header = "[...document.querySelectorAll('table.sortable th[aria-sort]')].find((one) => one.offsetParent)"
    if not page.run(f"Boolean({header})"):
        return
    cells = f"[...{header}.closest('table').rows].slice(1).map((row) => row.cells[{header}.cellIndex].textContent.trim())"
    orders = []
    for order in ("ascending", "descending"):
        page.run(f"{header}.focus()")
        page.key("Enter")
        assert page.run(f"{header}.getAttribute('aria-sort')") == order, page.run("document.activeElement.outerHTML")[:300]
        orders.append(page.run(cells))
    assert orders[0] != orders[1] or len(set(orders[0])) == 1
