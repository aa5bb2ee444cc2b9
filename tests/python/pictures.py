"""Takes the docs' pictures of reports: `cargo fmu demo`, then `target/venv/bin/python tests/python/pictures.py`; and `cargo fmu paper`, then the
same with `--paper`.

It needs the distribution's Chromium. Options: the report, and the file to write, or the folder for the paper's figures.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import browser

ROOT = Path(__file__).parents[2]
WIDTH, HEIGHT = 1206, 1090
"""Size of the part of the page, px."""
MARGIN = 50
"""Empty height above the belt that is left out, px."""
FIGURES = ("figure-6-7", "figure-7", "figure-8ab", "figure-8c", "figure-8d", "figure-9")
"""Figures of the report on the paper that docs/paper.md shows."""
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


def take_figures(report: Path, folder: Path) -> None:
    """Saves the figures of the report on the paper, without their captions."""
    with opened(report) as page:
        page.run("document.querySelectorAll('figcaption').forEach((one) => { one.style.display = 'none'; })")
        for name in FIGURES:
            box = f"document.querySelector('#{name}').getBoundingClientRect()"
            clip = {key: page.run(f"{box}.{key}") for key in ("x", "width", "height")}
            page.picture(folder / f"paper-{name}.png", clip={**clip, "y": page.run(f"{box}.top + scrollY"), "scale": 1})


def main(arguments: list[str] | None = None) -> int:
    """Takes the picture and prints its path."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--paper", action="store_true", help="the figures of the report on the paper")
    parser.add_argument("report", type=Path, nargs="?")
    parser.add_argument("picture", type=Path, nargs="?")
    options = parser.parse_args(arguments)
    name, picture, save = ("paper", ROOT / "docs", take_figures) if options.paper else ("demo", ROOT / "docs" / "report.png", take)
    report = options.report or ROOT / "target" / name / "report.html"
    if not report.is_file():
        print(f"{report} is missing: run `cargo fmu {name}`", file=sys.stderr)
        return 1
    save(report, options.picture or picture)
    print(options.picture or picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
