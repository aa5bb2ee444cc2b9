"""The FMU in an importer: loaded, checked and run by fmpy."""

from __future__ import annotations

import math
import os
import re
import subprocess
import zipfile
from collections import Counter
from collections.abc import Callable
from enum import IntEnum
from pathlib import Path

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
    ("name", "value"),
    [
        ("primary.clampingForce", -1.0),
        ("secondary.torque", math.nan),
        ("primary.speedSetpoint", math.inf),
        ("mesh.strand", 0),
        ("ring.model", 5),
        ("geometry.beltLength", 0.3),
        ("primary.minRadius", 0.09),
    ],
)
def test_a_bad_value_is_named_and_forgotten_after_reset(variator: New, name: str, value: float) -> None:
    unit = variator()
    with pytest.raises(UnitError, match=re.escape(f"{name} = {value:g}") if math.isfinite(value) else name):
        unit.set({name: value})
        unit.initialise()
    # A value out of its range is discarded; an inconsistent combination is detected at initialisation.
    assert unit.log[-1][:2] in ((2, "logStatusDiscard"), (3, "logStatusError"))
    unit.restart(CHEAP)
    unit.initialise()
    run(unit, range(2))


# ----------------------------------------------------------------------------------------------------- description


def test_the_description_inside_is_the_one_checked_in(fmu: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        inside = archive.read("modelDescription.xml")
    # The date is put in when the FMU is packed.
    undated = re.sub(rb'generationDateAndTime="[^"]*" ', b"", inside)
    assert undated == (ROOT / "modelDescription.xml").read_bytes()


BASE = {"1": {}, "N": {"kg": 1, "m": 1, "s": -2}, "Pa": {"kg": 1, "m": -1, "s": -2}, "J": {"kg": 1, "m": 2, "s": -2}, "W": {"kg": 1, "m": 2, "s": -3}}


def dimensions(name: str) -> Counter[str]:
    """From the name, by the rules of the standard: `.` multiplies, `/` divides, a digit is a power."""
    total: Counter[str] = Counter()
    for place, factor in enumerate(name.split("/")):
        for part in factor.split(".") if name != "1" else ():
            symbol, power = (part[:-1], int(part[-1])) if part[-1] in "23" else (part, 1)
            for unit, exponent in BASE.get(symbol, {symbol: 1}).items():
                total[unit] += exponent * power * (-1 if place else 1)
    return total


def test_units_are_declared_with_their_dimensions(description) -> None:
    declared = {unit.name: unit for unit in description.unitDefinitions}
    assert {v.unit for v in description.modelVariables if v.type == "Real"} == set(declared)
    for name, unit in declared.items():
        assert {base: int(getattr(unit.baseUnit, base) or 0) for base in ("kg", "m", "s", "rad")} == {
            base: dimensions(name)[base] for base in ("kg", "m", "s", "rad")
        }, name
    (rpm,) = declared["rad/s"].displayUnits
    assert float(rpm.factor) * 209.43951023931953 == pytest.approx(2000.0)
    assert {v.displayUnit for v in description.modelVariables if v.unit == "rad/s"} == {rpm.name} == {"rpm"}


@pytest.mark.parametrize("enumeration", [RingModel, Drive, Axial, StartState])
def test_enumerations_are_those_of_the_package(description, enumeration: type[IntEnum]) -> None:
    (declared,) = (found for found in description.typeDefinitions if found.name == enumeration.__name__)
    items = {item.name.upper(): int(item.value) for item in declared.items}
    assert items == {member.name.replace("_", ""): member.value for member in enumeration}
