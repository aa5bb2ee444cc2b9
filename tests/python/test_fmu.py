"""The FMU in an importer: loaded, checked and run by fmpy."""

from __future__ import annotations

import math
import os
import re
import subprocess
import zipfile
from collections.abc import Callable
from enum import IntEnum
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from conftest import CHEAP, ROOT, readings, run
from fmpy.validation import validate_fmu

from pushbelt.fmu.enumerations import Axial, Drive, RingModel, StartState
from pushbelt.fmu.unit import Instance, UnitError

# ------------------------------------------------------------------------------------------------------ first use


def test_fmpy_finds_nothing_to_complain_about(fmu: Path) -> None:
    assert validate_fmu(fmu) == []


def test_the_default_experiment_runs_without_any_wiring(fmu: Path, description) -> None:
    names = [v.name for v in description.modelVariables if v.causality == "output"]
    result = fmpy.simulate_fmu(fmu, output=names)
    assert len(result) == 1001
    assert result["time"][-1] == pytest.approx(1.0)
    limits = {v.name: (v.min, v.max) for v in description.modelVariables}
    for name in names:
        assert np.all(np.isfinite(result[name].astype(float))), name
        low, high = limits[name]
        assert low is None or np.all(result[name] >= float(low)), name
        assert high is None or np.all(result[name] <= float(high)), name


def test_it_gives_the_bits_of_the_rust_api(fmu: Path) -> None:
    """The same run by `examples/default_run.rs`; its numbers are printed in full. Compiled as the FMU's library is."""
    steps = 100
    example = os.environ.get("PUSHBELT_EXAMPLE")
    command = [example] if example else ["cargo", "run", "--release", "--quiet", "--example", "default_run", "--"]
    printed = subprocess.run([*command, str(steps)], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    head, *rows = printed.splitlines()
    names = head.split(",")[1:]
    rust = np.array([[float(cell) for cell in row.split(",")] for row in rows])
    result = fmpy.simulate_fmu(fmu, stop_time=steps * 1e-3, output_interval=1e-3, output=names)
    assert np.allclose(result["time"], rust[:, 0], rtol=0.0, atol=1e-12)
    with zipfile.ZipFile(fmu) as archive:
        portable = "binaries/win64/PushbeltVariator.dll" in archive.namelist()
    for column, name in enumerate(names, start=1):
        if portable:
            # Without AVX2 packs have another width, and sums another order.
            assert result[name] == pytest.approx(rust[:, column], rel=1e-5, abs=1e-5 * np.max(np.abs(rust[:, column]))), name
        else:
            assert np.array_equal(result[name], rust[:, column]), name


# ------------------------------------------------------------------------------------------------------- instances

New = Callable[..., Instance]


def test_no_output_moves_at_once_when_an_input_does(variator: New) -> None:
    """Consistency with the empty dependencies of the model structure."""
    unit = variator()
    unit.initialise()
    run(unit, range(3))
    before = readings(unit)
    for name, variable in unit.variables.items():
        if variable.causality == "input":
            unit.set({name: unit.get(name) * 1.1 + 1.0})
            assert readings(unit) == before, name


# ------------------------------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("primary.clampingForce", -1.0, "primary.clampingForce = -1 is out of range: 0 to"),
        ("secondary.torque", math.nan, "secondary.torque = NaN is not a finite number"),
        ("primary.speedSetpoint", math.inf, "primary.speedSetpoint = inf is not a finite number"),
        ("mesh.strand", 0, "mesh.strand = 0 is out of range: 1 to"),
        ("ring.model", 5, "ring.model = 5 is out of range: 1 ALE0, 2 ALE"),
        ("geometry.beltLength", 0.3, "geometry.beltLength = 0.3 is out of range: between 0.34"),
        ("primary.minRadius", 0.09, "primary.minRadius = 0.09 is out of range: below primary.maxRadius"),
    ],
)
def test_a_bad_value_is_named_and_forgotten_after_reset(variator: New, name: str, value: float, said: str) -> None:
    unit = variator()
    with pytest.raises(UnitError, match=re.escape(said)):
        unit.set({name: value})
        unit.initialise()
    # A value out of its range is discarded; an inconsistent combination is detected at initialisation.
    assert unit.log[-1][:2] in ((2, "logStatusDiscard"), (3, "logStatusError"))
    unit.restart(CHEAP)
    unit.initialise()
    run(unit, range(2))


# ----------------------------------------------------------------------------------------------------- description


@pytest.fixture(scope="module")
def xml(fmu: Path) -> ElementTree.Element:
    with zipfile.ZipFile(fmu) as archive:
        return ElementTree.fromstring(archive.read("modelDescription.xml"))


def test_the_description_inside_is_the_one_checked_in(fmu: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        inside = archive.read("modelDescription.xml")
    # The date is put in when the FMU is packed.
    undated = re.sub(rb'generationDateAndTime="[^"]*" ', b"", inside)
    assert undated == (ROOT / "modelDescription.xml").read_bytes()


def test_units_are_declared_with_their_dimensions(xml: ElementTree.Element) -> None:
    declared = {
        unit.get("name"): {base: int(power) for base, power in unit.find("BaseUnit").attrib.items()}
        for unit in xml.iter("Unit")
    }
    used = {real.get("unit") for real in xml.iter("Real")}
    assert None not in used, "every real has a unit"
    assert used == set(declared)
    base = {"1": {}, "rad": {"rad": 1}, "s": {"s": 1}, "m": {"m": 1}, "kg": {"kg": 1}}
    base |= {
        "N": {"kg": 1, "m": 1, "s": -2},
        "Pa": {"kg": 1, "m": -1, "s": -2},
        "J": {"kg": 1, "m": 2, "s": -2},
        "W": {"kg": 1, "m": 2, "s": -3},
    }

    def dimensions(name: str) -> dict[str, int]:
        """From the name, by the rules of the standard: `.` multiplies, `/` divides, a digit is a power."""
        total: dict[str, int] = {}
        for place, factor in enumerate(name.split("/")):
            for part in factor.split("."):
                symbol, power = (part[:-1], int(part[-1])) if part[-1] in "23" else (part, 1)
                for unit, exponent in base[symbol].items():
                    total[unit] = total.get(unit, 0) + exponent * power * (-1 if place else 1)
        return {unit: exponent for unit, exponent in total.items() if exponent}

    for name, found in declared.items():
        assert found == (base["1"] if name == "1" else dimensions(name)), name
    (rpm,) = (unit for unit in xml.iter("DisplayUnit") if unit.get("name") == "rpm")
    assert float(rpm.get("factor")) * 209.43951023931953 == pytest.approx(2000.0)
    for real in xml.iter("Real"):
        assert (real.get("displayUnit") == "rpm") == (real.get("unit") == "rad/s")


@pytest.mark.parametrize("enumeration", [RingModel, Drive, Axial, StartState])
def test_enumerations_are_those_of_the_package(xml: ElementTree.Element, enumeration: type[IntEnum]) -> None:
    (declared,) = (found for found in xml.iter("SimpleType") if found.get("name") == enumeration.__name__)
    items = {item.get("name").upper(): int(item.get("value")) for item in declared.iter("Item")}
    assert items == {member.name.replace("_", ""): member.value for member in enumeration}
