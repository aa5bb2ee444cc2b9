"""Takes the docs' picture of the demo's report: `cargo fmu demo`, then `target/venv/bin/python tests/python/pictures.py`.

It needs the distribution's Chromium. Options: the report, and the file to write.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import browser

ROOT = Path(__file__).parents[2]
WIDTH, HEIGHT = 1206, 1090
"""Size of the part of the page, px."""
MARGIN = 50
"""Empty height above the belt that is left out, px."""
SHOWN = 4.0
"""Time of the manoeuvre in the picture, s."""


def take(report: Path, picture: Path) -> None:
    """Saves the beginning of the manoeuvre's figures: the belt, and the first panels."""
    program = browser.find()
    if program is None:
        raise SystemExit("no Chromium on the search path: install the package chromium")
    with browser.page(program) as page:
        page.open(report, WIDTH)
        page.run(f"pushbelt.belts[0].show({SHOWN}, true)")
        top = page.run("document.querySelector('.belt').getBoundingClientRect().top + scrollY") + MARGIN
        page.picture(picture, clip={"x": 18, "y": top, "width": WIDTH - 36, "height": HEIGHT, "scale": 1})


def main(arguments: list[str] | None = None) -> int:
    """Takes the picture and prints its path."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("report", type=Path, nargs="?", default=ROOT / "target" / "demo" / "report.html")
    parser.add_argument("picture", type=Path, nargs="?", default=ROOT / "docs" / "report.png")
    options = parser.parse_args(arguments)
    if not options.report.is_file():
        print(f"{options.report} is missing: run `cargo fmu demo`", file=sys.stderr)
        return 1
    take(options.report, options.picture)
    print(options.picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
