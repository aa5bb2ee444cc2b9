"""Takes the docs' pictures of reports: `cargo fmu demo`, then `target/venv/bin/python fmu-build/python/pictures.py demo`; the same for paper,
validate, drive and live. `elements` draws from `elements/results`.

A picture carries a hash of the stored results that belong to what it shows, and a test compares it with those of today. It needs the distribution's Chromium. Options: the report, and the file to write, or the folder for the figures.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import struct
import sys
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path

from playwright.sync_api import Browser

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "python"), str(ROOT / "tests" / "python")]
import elements  # noqa: E402
import reports  # noqa: E402

WIDTH, HEIGHT = 1206, 1090  # Size of the part of the page, px
MARGIN = 50  # Empty height above the belt that is left out, px
FIGURES = {
    "paper": {f"#figure-{name}": f"paper-figure-{name}.png" for name in ("6-7", "7", "8ab", "8c", "8d", "9")},
    "validate": {"#steps-figure": "validation-steps.png"},
    "drive": {"#drive + figure": "drive.png"},
}
"""Figures of each report that the docs show, by selector, and their files."""
MODEL = "resources/reference/smoke-test-ref.csv"
"""Outputs of the model, renewed when its physics change."""
STORED = {
    "report.png": ("demo", MODEL), "live.png": ("live", MODEL), "drive.png": ("drive", MODEL), "validation-steps.png": ("validate", "validation/results.json"),
    "single-elements.png": ("elements", "elements/results/*.csv resources/tone.csv"), **dict.fromkeys(FIGURES["paper"].values(), ("paper", "paper/statements.csv")), "paper-figure-9.png": ("paper", "paper/figure-9.csv"),
}  # fmt: skip
"""Pictures, their report, and patterns of the stored results of its run; of the validation only the steps, which its picture shows."""
SIGNATURE, HEAD, KEY = b"\x89PNG\r\n\x1a\n", 33, b"Shows\0"  # Of a PNG; length of signature and first chunk; key of the hash
TITLE = 14  # Height by which the title of a first panel stands out of its figure, px
SHOWN = 4.0  # Time of the manoeuvre in the picture, s
LIVE_HEIGHT, LIVE_SHOWN = 868, 3000  # Height of the picture of the live page, px; time of its manoeuvre, ms


def shown(name: str) -> str:
    """The hash of the stored results that a picture shows, as they are today."""
    content = b"".join(path.read_bytes() for pattern in STORED[name][1].split() for path in sorted(ROOT.glob(pattern)))
    if name == "validation-steps.png":
        content = json.dumps(json.loads(content)["steps"], sort_keys=True).encode()
    return hashlib.sha256(content).hexdigest()[:16]


def chunks(picture: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Types and contents of the chunks of a PNG."""
    at = len(SIGNATURE)
    while at < len(picture):
        size, kind = struct.unpack_from(">I4s", picture, at)
        yield kind, picture[at + 8 : at + 8 + size]
        at += 12 + size


def stamp(picture: Path) -> None:
    """Writes the hash of what a picture shows into it, as text."""
    data, text = picture.read_bytes(), KEY + shown(picture.name).encode()
    check = zlib.crc32(b"tEXt" + text)
    picture.write_bytes(data[:HEAD] + struct.pack(">I", len(text)) + b"tEXt" + text + struct.pack(">I", check) + data[HEAD:])


def stamped(picture: Path) -> str | None:
    """The hash in a picture; None if it has none."""
    found = (text for kind, text in chunks(picture.read_bytes()) if kind == b"tEXt" and text.startswith(KEY))
    return next((text.removeprefix(KEY).decode() for text in found), None)


def take(report: Path, picture: Path, figures: Mapping[str, str] | None, browser: Browser | None = None) -> None:
    """Saves the beginning of the manoeuvre's figures: the belt, and the first panels. Or saves figures without their captions to a folder."""
    with reports.page(browser) as (page, _):
        reports.show(page, report, WIDTH)
        if figures is None:
            page.evaluate(f"pushbelt.belts[0].show({SHOWN}, true)")
            top = page.evaluate("document.querySelector('.belt').getBoundingClientRect().top + scrollY") + MARGIN
            page.screenshot(path=picture, full_page=True, clip={"x": 18, "y": top, "width": WIDTH - 36, "height": HEIGHT})
            stamp(picture)
            return
        page.add_style_tag(content="figcaption, .tools > button, .tools > output { display: none !important; }")
        for name, file in figures.items():
            box = page.locator(name).bounding_box()
            page.screenshot(path=picture / file, full_page=True, clip={**box, "y": box["y"] - TITLE})
            stamp(picture / file)


def take_live(live: Path, picture: Path) -> None:
    """Saves the beginning of the live page in a kick-down."""
    with reports.page() as (page, _):
        page.set_viewport_size({"width": WIDTH, "height": 900})
        page.goto(f"{live.resolve().as_uri()}#manoeuvre=Kick-down")
        page.wait_for_function("stats.frames > 3")
        page.evaluate(f"isRunning = false; while (step < {LIVE_SHOWN}) advance(); refresh(); showFacts()")
        page.evaluate("{ const frames = stats.frames; new Promise((done) => setInterval(() => stats.frames > frames + 3 && done(), 20)); }")
        top = page.evaluate("document.querySelector('.bench').getBoundingClientRect().top + scrollY - 12")
        page.screenshot(path=picture, full_page=True, clip={"x": 18, "y": top, "width": WIDTH - 36, "height": LIVE_HEIGHT})
    stamp(picture)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=["demo", "live", "elements", *FIGURES], help="which report")
    parser.add_argument("report", type=Path, nargs="?")
    parser.add_argument("picture", type=Path, nargs="?")
    options = parser.parse_args(arguments)
    name, figures = options.name, FIGURES.get(options.name)
    picture = options.picture or ROOT / "docs" / ("" if figures else "live.png" if name == "live" else "report.png")
    if name == "elements":
        picture = ROOT / "docs" / "single-elements.png"
        elements.draw(picture)
        stamp(picture)
        print(picture)
        return 0
    report = options.report or ROOT / "target" / ("live.html" if name == "live" else f"{name}/report.html")
    if not report.is_file():
        print(f"{report} is missing: run `cargo fmu {name}`", file=sys.stderr)
        return 1
    if name == "live":
        take_live(report, picture)
    else:
        take(report, picture, figures)
    print(picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
