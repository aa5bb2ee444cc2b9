"""A parameter set from the dimensions of a belt: formulas, checks, and the set in the FMU and the programs."""

import json
import math
import warnings
from pathlib import Path

import pytest

import pushbelt
from pushbelt import cli
from pushbelt.belt.__main__ import OUT_OF_LIMITS, main
from pushbelt.belt.geometry import Belt, Dimensions
from pushbelt.fmu import data

BENCH = Dimensions(width=0.024, layers=9, length=0.703, center_distance=0.168)
PUBLISHED = {one["id"]: one["published"] for one in data.published_data()["variators"]}
GIVEN = PUBLISHED["belt155"]
BELT155 = Dimensions(
    width=0.0255, layers=GIVEN["ringLayers"], length=GIVEN["beltLength"], center_distance=GIVEN["centerDistance"], elements=GIVEN["elements"],
    element_mass=GIVEN["elementMass"], layer_width=GIVEN["ringWidth"], young=GIVEN["ringYoung"], density=GIVEN["ringDensity"],
)  # fmt: skip
WIDE = ["--width", "30", "--layers", "12", "--element-thickness", "1.5", "--length", "0.70", "--center-distance", "0.17"]


# The published numbers of `bench168` are rounded to three digits. Pushing stiffness, film and contact of `belt155` are those of elements
# of 24 mm, and its thickness is the nominal one.
@pytest.mark.parametrize(("name", "dimensions", "tolerance"), [("bench168", BENCH, 6e-3), ("belt155", BELT155, 8e-2)])
def test_formulas_give_the_published_sets(name: str, dimensions: Dimensions, tolerance: float) -> None:
    published = data.parameter_set(name)
    entries = Belt(dimensions).entries
    stops = {key for key in entries if key.endswith("Radius")}
    compared = entries.keys() & published.keys() - stops
    assert len(compared) >= 17
    for key in compared:
        assert entries[key].value == pytest.approx(published[key], rel=tolerance), key
    if name == "bench168":
        assert {key: entries[key].value for key in stops} == pytest.approx({key: published[key] for key in stops})


def test_what_is_given_is_met_exactly() -> None:
    published, entries = data.parameter_set("belt155"), Belt(BELT155).entries
    for key in ("ring.axialStiffness", "ring.bendingStiffness", "ring.massPerLength", "belt.massPerLength"):
        assert entries[key].value == pytest.approx(published[key], rel=1e-4 if "belt" in key else 2e-5)
        assert entries[key].origin == "geometry"
    assert entries["belt.elementInertia"].origin == "typical"
    for name in ("bench168", "belt155"):
        for variable, key in (("geometry.centerDistance", "centerDistance"), ("friction.pulley", "frictionPulley")):
            assert data.parameter_set(name)[variable] == PUBLISHED[name][key]


def test_elements_fill_the_pitch_line() -> None:
    """The line is 700 mm − 2π (0.17 + 12 × 0.185/2) mm."""
    wide = Dimensions(width=0.03, layers=12, length=0.7, center_distance=0.17, element_thickness=1.5e-3)
    belt = Belt(wide)
    line = 0.7 - 2 * math.pi * 1.28e-3
    assert belt.elements == round((line - 2e-4) / 1.5e-3) == 461
    assert belt.elements * belt.element_thickness + belt.play == pytest.approx(line)
    assert belt.play == pytest.approx(2e-4)
    assert belt.element_thickness == pytest.approx(1.5e-3, rel=2e-3)
    counted = Belt(Dimensions(**{**vars(wide), "elements": 460}))
    assert (counted.element_thickness, counted.play) == (1.5e-3, pytest.approx(line - 0.69))
    loose = Belt(Dimensions(**{**vars(wide), "elements": 460, "element_thickness": None, "play": 5e-4}))
    assert loose.element_thickness == pytest.approx((line - 5e-4) / 460)


def test_reach_is_where_a_stop_is_met() -> None:
    """The ratio of the FMU, that of the pitch radii: at the largest one the primary radius is the least."""
    belt = Belt(BENCH)
    values = {name: entry.value for name, entry in belt.entries.items()}
    assert data.pitch_radius(values, belt.reach) == pytest.approx(0.03)
    assert data.pitch_radius(values, 1 / belt.reach) == pytest.approx(belt.reach * 0.03)
    assert belt.reach * 0.03 < 0.082


@pytest.fixture(scope="module")
def wide(fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The set of a belt of 30 mm with twelve layers."""
    folder = tmp_path_factory.mktemp("belt")
    assert main(["--fmu", str(fmu), "--output", str(folder), "--name", "wide", *WIDE, "--set", "friction.pulley=0.1"]) == 0
    return folder / "wide.json"


def test_command_writes_a_set_that_says_where_values_come_from(wide: Path) -> None:
    entries = json.loads(wide.read_text(encoding="utf-8"))["parameters"]
    assert entries.keys() >= data.parameter_set("bench168").keys()
    assert {entry["origin"] for entry in entries.values()} == {"given", "typical", "geometry"}
    assert all(entry["unit"] for entry in entries.values())
    assert entries["friction.pulley"] == {"value": 0.1, "origin": "given", "unit": "1"}
    assert entries["friction.ring"]["origin"] == "typical"
    assert entries["friction.ring"]["note"] == "as bench168"
    assert entries["geometry.beltLength"] == {"value": 0.7, "origin": "given", "unit": "m"}


def test_command_prints_checks_and_marks(fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--fmu", str(fmu), "--output", str(tmp_path), *WIDE]
    assert main(options) == 0
    shown = capsys.readouterr().out
    assert all(part in shown for part in ("* contact.stiffness", "  geometry.beltLength", "0.386 to 2.591")) and shown.count("passes") == 3
    assert main([*options, "--limit", "300"]) == OUT_OF_LIMITS
    assert "FAILS" in capsys.readouterr().out
    assert (tmp_path / "belt.json").is_file()


def test_units_may_follow_a_length(fmu: Path, tmp_path: Path, wide: Path) -> None:
    options = ["--fmu", str(fmu), "--output", str(tmp_path), "--width", "0.03m", "--layers", "12"]
    assert main([*options, "--length", "700mm", "--center-distance", "17cm", "--set", "friction.pulley=0.1"]) == 0
    written, other = (json.loads(path.read_text(encoding="utf-8")) for path in (tmp_path / "belt.json", wide))
    values, others = ({k: e["value"] for k, e in d["parameters"].items()} for d in (written, other))
    assert values == pytest.approx(others)


def test_layers_alone_are_a_warning(fmu: Path, wide: Path) -> None:
    for parameters, changes, count in (("bench168", {}, 0), (str(wide), {"initial.ratio": 0.5}, 0), ("bench168", {"ring.layers": 12}, 1)):
        with warnings.catch_warnings(record=True) as found, pushbelt.Variator(parameters, changes, fmu=fmu) as variator:
            warnings.simplefilter("always")
            variator.start()
        assert ["ring.layers" in str(warning.message) for warning in found] == [True] * count


@pytest.mark.slow
def test_set_runs_in_the_programs(fmu: Path, wide: Path, tmp_path: Path) -> None:
    grid = ["--ratio", "0.6,1,1.6", "--utilisation", "0.4,0.6", "--friction", "0.1", "--speed", "200", "--workers", "1"]
    point = ["initial.ratio=1", "primary.torque=100", "initial.primarySpeed=200", "--safety", "1.3"]
    cycle, results = ["--short", "--until", "4"], [str(tmp_path / "drive")]
    words = {"sweep": grid, "linearize": point, "demo": ["--short"], "drive": cycle, "durability": results}
    for name, more in words.items():
        assert cli.main([name, "--fmu", str(fmu), "--variator", str(wide), "--output", str(tmp_path / name), *more]) == 0
