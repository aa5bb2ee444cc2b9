"""Common checks of what programs write: reports are self-contained and drawn without complaints, columns of runs have the FMU's units.

The browser is the distribution's Chromium without a window, controlled by playwright."""

import csv
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Page, Request, sync_playwright

from pushbelt.fmu.untrusted import described
from pushbelt.tables import read, sheet, split, units
from pushbelt.tables.names import Column

NAMES = ("chromium", "chromium-browser", "google-chrome")
PATIENCE = 120e3  # Timeout, ms. It only ends tests that hang.
CHECKS = Path(__file__).with_name("legible.js").read_text(encoding="utf-8")


@contextmanager
def chromium() -> Iterator[Browser]:
    """The browser. Without it the rest of a test is skipped, or fails in CI."""
    program = next((found for name in NAMES if (found := shutil.which(name))), None)
    if program is None:
        (pytest.fail if os.environ.get("CI") else pytest.skip)("no Chromium on the search path: install the package chromium")
    with sync_playwright() as playwright, playwright.chromium.launch(executable_path=program) as browser:
        yield browser


@contextmanager
def page(browser: Browser | None = None) -> Iterator[tuple[Page, list[str]]]:
    """A page, and its complaints: errors and warnings of its console, and requests for what is elsewhere."""
    complaints: list[str] = []

    def said(message: ConsoleMessage) -> None:
        if message.type in ("error", "warning", "assert"):
            complaints.append(message.text)

    def asked(request: Request) -> None:
        if not request.url.startswith(("file:", "data:", "blob:")):
            complaints.append(request.url)

    with nullcontext(browser) if browser else chromium() as found, found.new_page() as opened:
        opened.set_default_timeout(PATIENCE)
        opened.on("console", said)
        opened.on("pageerror", lambda error: complaints.append(str(error)))
        opened.on("request", asked)
        yield opened, complaints


def show(page: Page, file: Path, width: int) -> None:
    """Opens a report at a width, px, and waits until its figures are drawn."""
    page.set_viewport_size({"width": width, "height": 900})
    page.goto(file.resolve().as_uri())
    page.evaluate("document.querySelectorAll('details:not(.notices)').forEach((one) => { one.open = true; })")
    page.evaluate("pushbelt.ready.then(() => pushbelt.draw())")


def faults(page: Page, *checks: str) -> list[str]:
    """What checks of `legible.js` find on a page."""
    return [fault for check in checks for fault in page.evaluate(f"{CHECKS}.{check}()")]


def look_at(report: Path, browser: Browser | None = None) -> None:
    """Opens the report in a browser: its figures are drawn, without a complaint and without a request. This must be the last call of a test,
    because it is skipped without a browser. `test_reports` looks closer, at a page with every kind of figure."""
    with page(browser) as (opened, complaints):
        show(opened, report, 1280)
        found = faults(opened, "missing", "empty") + complaints
        assert not found, found


def stands_alone(report: Path) -> str:
    """The report's text, after checks that it has no external resources and contains its library once."""
    text = report.read_text(encoding="utf-8")
    packed = '<script type="application/gzip" id="plotly">'
    assert text.count(packed) == 1 and text.count("</main>") == 1
    own = re.sub(r"<pre>.*?</pre>", "", text.split(packed)[0], flags=re.DOTALL)
    assert not re.search(r"""(?:src|href|action|data)\s*=\s*["']?(?:https?:)?//|url\(|@import""", own)
    return text


def figures(text: str) -> int:
    return text.count('<div class="panel">')


def by_name(path: Path) -> list[dict[str, str]]:
    """Rows by the names of the columns without their units."""
    names, rows = read(path)
    return [dict(zip(names, row, strict=True)) for row in rows]


def units_are_those_of(fmu: Path, *paths: Path) -> None:
    """Every column of numbers has a unit, and that of a variable is the FMU's. Readers of tables take all titles."""
    known = {one.name: one.unit or "1" for one in described(fmu).modelVariables}
    for path in paths:
        with path.open(encoding="utf-8", newline="") as file:
            titles = next(csv.reader(file))
        found = [split(title) for title in titles]
        assert all(unit is not None for name, unit in found if name not in ("case", "run", "name")), titles
        assert {name: unit for name, unit in found if name in known} == {name: known[name] for name, _ in found if name in known}
        columns = {name: Column(units.OF_FMU[unit], -1e99, 1e99, "") for name, unit in found if unit is not None}
        found = sheet.read(path, columns, misspelled=False)
        assert set(found.taken) == set(columns), path
