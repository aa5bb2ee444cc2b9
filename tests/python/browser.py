"""The distribution's Chromium without a window, controlled by playwright."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from playwright.sync_api import ConsoleMessage, Page, Request, sync_playwright

NAMES = ("chromium", "chromium-browser", "google-chrome")
PATIENCE = 120e3  # Timeout, ms. It only ends tests that hang.


@contextmanager
def page() -> Iterator[tuple[Page, list[str]]]:
    """A page, and its complaints: errors and warnings of its console, and requests for what is elsewhere. Without a browser it skips the
    rest of a test, or fails in CI."""
    program = next((found for name in NAMES if (found := shutil.which(name))), None)
    if program is None:
        (pytest.fail if os.environ.get("CI") else pytest.skip)("no Chromium on the search path: install the package chromium")
    complaints: list[str] = []

    def said(message: ConsoleMessage) -> None:
        if message.type in ("error", "warning", "assert"):
            complaints.append(message.text)

    def asked(request: Request) -> None:
        if not request.url.startswith(("file:", "data:", "blob:")):
            complaints.append(request.url)

    with sync_playwright() as playwright, playwright.chromium.launch(executable_path=program) as browser:
        opened = browser.new_page()
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
