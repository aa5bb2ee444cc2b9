"""The live page: its module computes what the FMU's library computes, and the page shows it, takes what a user does, and fits a phone."""

import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import reports
from conftest import ROOT, cargo
from playwright.sync_api import Page

from pushbelt import tables
from pushbelt.fmu import data
from pushbelt.fmu.unit import Archive, Instance
from pushbelt.report import style

pytestmark = pytest.mark.full

STEPS, EVERY = 1000, 100
FINE = data.parameter_set("chain168") | {"solver.tolerance": 1e-6}
RINGS = {"ALE": ({"ring.model": 2}, 1e-8), "ALE0": ({"ring.model": 1}, 1e-4), "chain": (FINE, 1e-8)}
"""Parameters, and the largest difference relative to the range of an output. Rounding differs, and by it the steps of `ALE0` do, and
the remaining errors of Newton's method: in the chain's deflections they are 2e-8 with the default tolerance."""
COUNTS = ("solver.", "energy.residual")  # Outputs that count work, or are what is left of large numbers
LARGEST = 1_500_000  # Size of the page, bytes


@pytest.fixture(scope="module")
def live() -> Path:
    """The page, built from the sources. Without a compiler for WebAssembly its tests are skipped."""
    done = subprocess.run([cargo(), "fmu", "live"], cwd=ROOT, capture_output=True, text=True)
    if "there is no compiler for the live page" in done.stderr:
        pytest.skip(done.stderr.strip().splitlines()[-1])
    assert done.returncode == 0, done.stderr
    return ROOT / "target" / "live.html"


def test_the_page_is_one_small_file(live: Path) -> None:
    text = live.read_text(encoding="utf-8")
    assert len(text.encode()) <= LARGEST
    assert not any(word in text for word in (" src=", "<link", "url(", "@import", "{{"))
    assert json.dumps(style.COLOUR_SCALE) in text, "the colours are not those of the reports"


def loads(k: int) -> dict[str, float]:
    """Inputs of a fixed run: torque and primary force rise, the load with them."""
    return {"primary.torque": 50 + 0.04 * k, "secondary.torque": -49 - 0.04 * k, "primary.clampingForce": 13000 + 2.6 * k}


@pytest.mark.parametrize("ring", RINGS)
def test_the_module_computes_what_the_library_computes(live: Path, archive: Archive, ring: str) -> None:
    node = shutil.which("node") or (pytest.fail if os.environ.get("CI") else pytest.skip)("no node on the search path: install the package nodejs")
    parameters, tolerance = RINGS[ring]
    variables = archive.description.modelVariables
    index = {variable.name: k for k, variable in enumerate(variables)}
    by_index = [[(index[name], value) for name, value in values.items()] for values in (parameters, *map(loads, range(STEPS)))]
    words = json.dumps({"settings": by_index[0], "steps": by_index[1:], "every": EVERY})
    done = subprocess.run([node, Path(__file__).with_name("live.mjs"), live], input=words, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    print(f"{ring}: start {found['start']:.2f} s, {1e-3 * STEPS / found['run']:.1f} x real time of the processor")

    read = [one for one in variables if one.causality in ("output", "local") and one.type == "Real" and not one.name.startswith(COUNTS)]
    with Instance(archive, parameters) as instance:
        instance.initialise()
        reals, expected = instance.reals(one.name for one in read), []
        for k in range(STEPS):
            instance.set(loads(k))
            instance.step_to((k + 1) / 1000)
            if (k + 1) % EVERY == 0:
                expected.append(instance.get_reals(reals))
    expected, other = np.array(expected), np.array(found["found"])[:, [index[one.name] for one in read]]
    size = np.maximum(np.abs(expected).max(axis=0), [float(one.nominal or 0.0) for one in read])
    difference = (np.abs(other - expected) / np.where(size > 0.0, size, 1.0)).max(axis=0)
    worst = int(np.argmax(difference))
    print(f"largest difference {difference[worst]:.1e} of the range, of {read[worst].name}")
    assert difference[worst] <= tolerance, read[worst].name


@contextmanager
def shown(live: Path, settings: str = "", width: int = 1280) -> Iterator[Page]:
    """The page in Chromium with the settings of a link. At the end it has no complaint, and shows no fault."""
    with reports.page() as (page, complaints):
        page.set_viewport_size({"width": width, "height": 900})
        page.goto(f"{live.as_uri()}#{settings}")
        page.wait_for_function("stats.frames > 3 || !$('fault').hidden")
        yield page
        assert not complaints and page.locator("#fault").is_hidden(), complaints


def value(page: Page, name: str) -> float:
    return page.evaluate("(name) => model.value(name)", name)


def wait(page: Page, milliseconds: int) -> None:
    """Waits until so much of the run is computed."""
    page.wait_for_function("(end) => step >= end", arg=milliseconds)


def test_a_launch_shifts_and_is_drawn(live: Path) -> None:
    with shown(live, "manoeuvre=Launch") as page:
        first = value(page, "ratio.geometric")
        drawn = page.locator(".belt svg .element").first.get_attribute("d")
        wait(page, 3000)
        stats = page.evaluate("({...stats, wall: performance.now()})")
        print(f"first picture after {1e-3 * stats['first']:.2f} s, {1e3 * stats['frames'] / (stats['wall'] - stats['first']):.0f} frames/s, "
              f"{stats['milliseconds'] / stats['computing']:.1f} x real time while computing")
        assert first == pytest.approx(2.2, abs=0.02) and value(page, "ratio.geometric") < 1.6
        assert value(page, "secondary.speed") > 200.0
        assert page.locator(".belt svg .element").first.get_attribute("d") != drawn
        assert page.evaluate("plots.every(({ canvas }) => canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.some((one) => one))")


@pytest.mark.parametrize("settings", ["manoeuvre=Reverse", "variator=chain168&manoeuvre=Kick-down", "variator=belt155&ring.model=1", "manoeuvre=Macro-slip&clamp=pressure"])
def test_belts_and_manoeuvres_run(live: Path, settings: str) -> None:
    with shown(live, settings) as page:
        wait(page, 700)
        assert page.evaluate("location.hash.slice(1) === address() && address()") == settings
        assert np.isfinite(value(page, "thrustRatio"))
        assert (value(page, "secondary.speed") < 0.0) == ("Reverse" in settings)


def test_a_phone_shows_all_of_its_width(live: Path) -> None:
    with shown(live, width=390) as page:
        page.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
        assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_hands_on_the_controls(live: Path, tmp_path: Path, fmu: Path) -> None:
    with shown(live) as page:
        page.keyboard.press("Space")
        begun = page.evaluate("step")
        page.keyboard.press(".")
        assert page.evaluate("[step, isRunning]") == [begun + 1, False]
        page.locator("[id='primary.torque'] input[type=number]").fill("80")
        page.get_by_text("Parameters", exact=True).click()
        page.locator("#name").fill("friction.ring")
        page.keyboard.press("Enter")
        page.get_by_label("friction.ring", exact=True).fill("0.06")
        page.keyboard.press("Tab")
        page.locator("#record").click()
        page.locator("#pause").click()
        wait(page, begun + 60)
        with page.expect_download() as download:
            page.locator("#record").click()
        download.value.save_as(tmp_path / "run.csv")
        assert value(page, "primary.externalTorque") == pytest.approx(80.0) and value(page, "friction.ring") == 0.06
        link = page.evaluate("address()")
    assert link == "manoeuvre=&primary.torque=80&friction.ring=0.06"
    reports.units_are_those_of(fmu, tmp_path / "run.csv")
    names, rows = tables.read(tmp_path / "run.csv")
    assert next(iter(names)) == "time" and len(rows) > 20 and np.allclose(np.diff([float(row[0]) for row in rows]), 1e-3)
    with shown(live, link) as page:
        assert page.locator("[id='primary.torque'] input[type=number]").input_value() == "80"
        assert page.evaluate("parameters['friction.ring']") == 0.06


@pytest.mark.parametrize(("settings", "reason"), [("friction.pulley=0.5", "friction angle"), ("belt.colour=1", "no variable belt.colour"), ("primary.inertia=-1", "out of range")])
def test_the_reason_of_a_failure_is_shown(live: Path, settings: str, reason: str) -> None:
    with shown(live, settings) as page:
        assert reason in page.locator("#fault").inner_text()
        page.evaluate("settings.set = {}")
        page.locator("#again").click()
        wait(page, 20)


def test_a_slow_machine_says_so(live: Path) -> None:
    with shown(live) as page:
        page.evaluate("{ const own = advance; advance = () => { const end = performance.now() + 20; while (performance.now() < end); own(); }; }")
        page.wait_for_function("$('clock').textContent.includes('slow motion')")
