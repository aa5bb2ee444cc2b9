"""Takes the docs' pictures of reports: `cargo fmu demo`, then `target/venv/bin/python tests/python/pictures.py demo`; the same for paper,
validate and drive.

It needs the distribution's Chromium. Options: the report, and the file to write, or the folder for the figures.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path

import reports
from playwright.sync_api import Browser

ROOT = Path(__file__).parents[2]
WIDTH, HEIGHT = 1206, 1090  # Size of the part of the page, px
MARGIN = 50  # Empty height above the belt that is left out, px
FIGURES = {
    "paper": {f"#figure-{name}": f"paper-figure-{name}.png" for name in ("6-7", "7", "8ab", "8c", "8d", "9")},
    "validate": {"#steps-figure": "validation-steps.png"},
    "drive": {"#drive + figure": "drive.png"},
}
"""Figures of each report that the docs show, by selector, and their files."""
TITLE = 14  # Height by which the title of a first panel stands out of its figure, px
SHOWN = 4.0  # Time of the manoeuvre in the picture, s


def take(report: Path, picture: Path, figures: Mapping[str, str] | None, browser: Browser | None = None) -> None:
    """Saves the beginning of the manoeuvre's figures: the belt, and the first panels. Or saves figures without their captions to a folder."""
    with reports.page(browser) as (page, _):
        reports.show(page, report, WIDTH)
        if figures is None:
            page.evaluate(f"pushbelt.belts[0].show({SHOWN}, true)")
            top = page.evaluate("document.querySelector('.belt').getBoundingClientRect().top + scrollY") + MARGIN
            page.screenshot(path=picture, full_page=True, clip={"x": 18, "y": top, "width": WIDTH - 36, "height": HEIGHT})
            return
        page.add_style_tag(content="figcaption, .tools > button, .tools > output { display: none !important; }")
        for name, file in figures.items():
            box = page.locator(name).bounding_box()
            page.screenshot(path=picture / file, full_page=True, clip={**box, "y": box["y"] - TITLE})


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=["demo", *FIGURES], help="which report")
    parser.add_argument("report", type=Path, nargs="?")
    parser.add_argument("picture", type=Path, nargs="?")
    options = parser.parse_args(arguments)
    name, figures = options.name, FIGURES.get(options.name)
    picture = options.picture or (ROOT / "docs" if figures else ROOT / "docs" / "report.png")
    report = options.report or ROOT / "target" / name / "report.html"
    if not report.is_file():
        print(f"{report} is missing: run `cargo fmu {name}`", file=sys.stderr)
        return 1
    take(report, picture, figures)
    print(picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
