"""Takes the docs' pictures of reports: `cargo fmu demo`, then `target/venv/bin/python tests/python/pictures.py`; `cargo fmu paper`, then the same
with `--paper`; and `cargo fmu validate`, then the same with `--validation`.

It needs the distribution's Chromium. Options: the report, and the file to write, or the folder for the figures.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import browser

ROOT = Path(__file__).parents[2]
WIDTH, HEIGHT = 1206, 1090
"""Size of the part of the page, px."""
MARGIN = 50
"""Empty height above the belt that is left out, px."""
PAPER = {f"figure-{name}": f"paper-figure-{name}.png" for name in ("6-7", "7", "8ab", "8c", "8d", "9")}
"""Figures of the report on the paper that docs/paper.md shows, and their files."""
VALIDATION = {"steps-figure": "validation-steps.png"}
"""The same of docs/validation.md."""
SHOWN = 4.0
"""Time of the manoeuvre in the picture, s."""


@contextmanager
def opened(report: Path) -> Iterator[browser.Page]:
    """The report in Chromium."""
    program = browser.find()
    if program is None:
        raise SystemExit("no Chromium on the search path: install the package chromium")
    with browser.page(program) as page:
        page.open(report, WIDTH)
        yield page


def take(report: Path, picture: Path) -> None:
    """Saves the beginning of the manoeuvre's figures: the belt, and the first panels."""
    with opened(report) as page:
        page.run(f"pushbelt.belts[0].show({SHOWN}, true)")
        top = page.run("document.querySelector('.belt').getBoundingClientRect().top + scrollY") + MARGIN
        page.picture(picture, clip={"x": 18, "y": top, "width": WIDTH - 36, "height": HEIGHT, "scale": 1})


def take_figures(report: Path, folder: Path, figures: Mapping[str, str]) -> None:
    """Saves figures of a report without their captions."""
    with opened(report) as page:
        page.run("document.querySelectorAll('figcaption, .tools').forEach((one) => { one.style.display = 'none'; })")
        for name, file in figures.items():
            box = f"document.querySelector('#{name}').getBoundingClientRect()"
            clip = {key: page.run(f"{box}.{key}") for key in ("x", "width", "height")}
            page.picture(folder / file, clip={**clip, "y": page.run(f"{box}.top + scrollY"), "scale": 1})


def main(arguments: list[str] | None = None) -> int:
    """Takes the picture and prints its path."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--paper", action="store_true", help="the figures of the report on the paper")
    parser.add_argument("--validation", action="store_true", help="the steps from the theory to the belt")
    parser.add_argument("report", type=Path, nargs="?")
    parser.add_argument("picture", type=Path, nargs="?")
    options = parser.parse_args(arguments)
    name = "paper" if options.paper else "validate" if options.validation else "demo"
    figures = {"paper": PAPER, "validate": VALIDATION}.get(name)
    picture = options.picture or (ROOT / "docs" if figures else ROOT / "docs" / "report.png")
    report = options.report or ROOT / "target" / name / "report.html"
    if not report.is_file():
        print(f"{report} is missing: run `cargo fmu {name}`", file=sys.stderr)
        return 1
    if figures:
        take_figures(report, picture, figures)
    else:
        take(report, picture)
    print(picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
