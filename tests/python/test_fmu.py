"""Both FMUs in importers: archives, descriptions, the same run to the last bit, events, another importer."""

import ctypes
import math
import os
import re
import shutil
import struct
import subprocess
import sys
import zipfile
from collections import Counter
from enum import IntEnum
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from conftest import CHEAP, ROOT
from fmpy.validation import validate_fmu
from lxml import etree
from pushbelt_cosim.importers import load_tbb

from pushbelt.demo import simulate as demo
from pushbelt.fmu.data import manoeuvre_inputs
from pushbelt.fmu.enumerations import Axial, Drive, RingModel, StartState
from pushbelt.fmu.unit import Archive, Instance

FMPY = Path(fmpy.__file__).parent
BASE = {"1": {}, "N": {"kg": 1, "m": 1, "s": -2}, "Pa": {"kg": 1, "m": -1, "s": -2}, "J": {"kg": 1, "m": 2, "s": -2}, "W": {"kg": 1, "m": 2, "s": -3}}


@pytest.fixture(scope="module")
def unpacked(fmu3: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fmi3")
    shutil.unpack_archive(fmu3, folder, "zip")
    return folder


@pytest.mark.parametrize(("fixture", "checked_in"), [("fmu", "modelDescription.xml"), ("fmu3", "resources/modelDescription3.xml")])
def test_the_description_is_the_one_checked_in_and_fmpy_accepts_it(fixture: str, checked_in: str, request: pytest.FixtureRequest) -> None:
    path = request.getfixturevalue(fixture)
    assert validate_fmu(str(path)) == []
    inside = zipfile.Path(path, "modelDescription.xml").read_bytes()
    # The date is put in when the FMU is packed.
    assert re.sub(rb'generationDateAndTime="[-0-9T:]+Z" ', b"", inside, count=1) == (ROOT / checked_in).read_bytes()


def test_terminals_are_those_of_both_archives(fmu: Path, fmu3: Path) -> None:
    """FMI 2.0.4 has the file of FMI 3.0, unchanged. Its icons are there."""
    files = []
    for path in (fmu, fmu3):
        with zipfile.ZipFile(path) as archive:
            files.append({name: archive.read(name) for name in archive.namelist() if name.startswith("terminalsAndIcons/")})
    assert files[0] == files[1]
    terminals = etree.fromstring(files[0]["terminalsAndIcons/terminalsAndIcons.xml"])
    etree.XMLSchema(etree.parse(FMPY / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd")).assertValid(terminals)
    names = {terminal.get("name") for terminal in terminals.iter("Terminal")}
    assert names == {f"{pulley}{what}" for pulley in ("primary", "secondary") for what in ("Shaft", "Clamp", "Port")}
    for icon in {"icon"} | {node.get("iconBaseName") for node in terminals.iter("TerminalGraphicalRepresentation")}:
        etree.fromstring(files[0][f"terminalsAndIcons/{icon}.svg"])
        picture = files[0][f"terminalsAndIcons/{icon}.png"]
        assert picture.startswith(b"\x89PNG\r\n\x1a\n")
        assert min(struct.unpack(">II", picture[16:24])) >= 100


def test_every_function_of_the_standard_is_exported(unpacked: Path) -> None:
    (library,) = (unpacked / "binaries" / fmpy.platform_tuple).iterdir()
    loaded = ctypes.CDLL(str(library))
    for version, count in ((2, 44), (3, 75)):
        header = (FMPY / "c-code" / f"fmi{version}Functions.h").read_text()
        functions = set(re.findall(rf"^\s*#define (fmi{version}\w+)\s+fmi{version}FullName", header, re.M))
        assert len(functions) >= count and not [name for name in functions if not hasattr(loaded, name)]


def test_variables_are_those_of_fmi_2(unpacked: Path, description: Any) -> None:
    """Names, references, types, units, limits, start values; arrays in place of their elements."""
    types = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean", "Enumeration": "Enumeration"}
    alike = ("valueReference", "causality", "variability", "initial", "unit", "displayUnit", "min", "max", "nominal", "start")

    def attributes(variable: Any) -> tuple[Any, ...]:
        kind = variable.declaredType and [(item.name, item.value) for item in variable.declaredType.items or ()]
        return (types.get(variable.type, variable.type), kind, *(getattr(variable, name) for name in alike))

    first = {re.sub(r"\[1\]$", "", v.name): attributes(v) for v in description.modelVariables if not re.search(r"\[([2-9]|\d\d)\]$", v.name)}
    found = {variable.name: variable for variable in fmpy.read_model_description(str(unpacked)).modelVariables}
    time = found.pop("time")
    assert (time.type, time.causality, time.unit) == ("Float64", "independent", "s")
    assert {name: attributes(variable) for name, variable in found.items()} == first
    sizes = Counter(v.name.partition("[")[0] for v in description.modelVariables if "[" in v.name)
    assert {v.name: int(v.dimensions[0].start) for v in found.values() if v.dimensions} == sizes
    assert len(sizes) == 9 and set(sizes.values()) == {72}
    updated = etree.parse(unpacked / "modelDescription.xml").xpath("//*[@intermediateUpdate='true']/@name")
    assert set(updated) == {v.name for v in found.values() if v.type == "Float64" and v.causality in ("input", "output")}


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
        assert all(int(getattr(unit.baseUnit, base) or 0) == dimensions(name)[base] for base in ("kg", "m", "s", "rad")), name
    assert {v.displayUnit for v in description.modelVariables if v.unit == "rad/s"} == {"rpm"}


@pytest.mark.parametrize("enumeration", [RingModel, Drive, Axial, StartState])
def test_enumerations_are_those_of_the_package(description, enumeration: type[IntEnum]) -> None:
    (declared,) = (found for found in description.typeDefinitions if found.name == enumeration.__name__)
    items = {item.name.upper(): int(item.value) for item in declared.items}
    assert items == {member.name.replace("_", ""): member.value for member in enumeration}


@pytest.fixture(scope="module")
def default_run(fmu: Path, description: Any) -> np.ndarray:
    """The default experiment, without any wiring."""
    return fmpy.simulate_fmu(fmu, output=[*(v.name for v in description.modelVariables if v.causality == "output"), "energy.residual"])


def test_the_default_experiment_stays_in_the_ranges_of_its_outputs(default_run: np.ndarray, variables: dict[str, Any]) -> None:
    assert len(default_run) == 1001
    assert default_run["time"][-1] == pytest.approx(1.0)
    for name in default_run.dtype.names[1:]:
        one, values = variables[name], default_run[name].astype(float)
        low, high = float(one.min or -math.inf), float(one.max or math.inf)
        assert np.isfinite(values).all() and low <= values.min() and values.max() <= high, name


def test_it_gives_the_bits_of_the_rust_api(fmu: Path, default_run: np.ndarray) -> None:
    """The same run by `examples/default_run.rs`; its numbers are printed in full. Compiled as the FMU's library is."""
    example = os.environ.get("PUSHBELT_EXAMPLE")
    command = [example] if example else ["cargo", "run", "--release", "--quiet", "--example", "default_run", "--"]
    head, *rows = subprocess.run([*command, "100"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    names = head.split(",")[1:]
    rust = np.array([[float(cell) for cell in row.split(",")] for row in rows])
    result = default_run[: len(rust)]
    assert len(rust) == 101 and np.allclose(result["time"], rust[:, 0], rtol=0.0, atol=1e-12)
    portable = zipfile.Path(fmu, "binaries/win64/PushbeltVariator.dll").exists()
    for column, name in enumerate(names, start=1):
        if portable:
            # Without AVX2 packs have another width, and sums another order.
            assert result[name] == pytest.approx(rust[:, column], rel=1e-5, abs=1e-5 * np.max(np.abs(rust[:, column]))), name
        else:
            assert np.array_equal(result[name], rust[:, column]), name


def test_no_output_moves_at_once_when_an_input_does(archive: Archive) -> None:
    """Consistency with the empty dependencies of the model structure."""
    with Instance(archive, CHEAP) as unit:
        unit.initialise()
        unit.step_to(3e-3)
        calculated = unit.reals(v.name for v in unit.variables.values() if v.type == "Real" and v.initial == "calculated")
        before = unit.get_reals(calculated).tolist()
        for name, variable in unit.variables.items():
            if variable.causality == "input":
                unit.set({name: unit.get(name) * 1.1 + 1.0})
                assert unit.get_reals(calculated).tolist() == before, name


def test_a_controller_handles_slip_where_it_begins(fmu3: Path) -> None:
    """Over-torque from 20 ms on: the step ends at the event, off the grid of 1 ms."""
    torque = np.array([(0.0, 50.0), (0.02, 50.0), (0.02, 400.0), (0.05, 400.0)], dtype=[("time", float), ("primary.torque", float)])
    said = []

    def simulated(**modes: bool) -> np.ndarray:
        said.clear()
        return fmpy.simulate_fmu(
            str(fmu3), stop_time=0.05, output_interval=1e-3, input=torque, output=["macroSlip", "profile.pushForce"], debug_logging=True,
            start_values={**CHEAP, "secondary.torque": -49.0, "primary.clampingForce": 13e3, "secondary.clampingForce": 10e3},
            logger=lambda _environment, _status, _category, message: said.append(message.decode()), **modes,
        )  # fmt: skip

    result = simulated(use_event_mode=True, early_return_allowed=True)
    off = result["time"][np.abs(result["time"] * 1e3 - np.round(result["time"] * 1e3)) > 1e-6]
    assert len(set(off)) == 1 and 0.02 < off[0] < 0.03
    assert any(re.fullmatch(r"event at 0\.02\d* s: the belt begins to slip through \(macro-slip\)", s) for s in said)
    assert result["time"][result["macroSlip"]][0] == off[0], "the output changes at the event"
    assert result["profile.pushForce"].shape == (len(result), 72)
    plain = simulated()
    assert len(plain) == 51 and not any("event at" in message for message in said)
    assert plain["time"][plain["macroSlip"]][0] == np.ceil(off[0] * 1e3) * 1e-3


@pytest.mark.skipif(find_spec("ecospy") is None, reason="ecospy has no wheel for this Python and machine")
def test_ecos_finds_the_same_by_both_versions(fmu: Path, fmu3: Path) -> None:
    """Over the launch of the manoeuvre in steps of 1 ms."""
    load_tbb()
    from ecospy import EcosSimulation, EcosSimulationStructure

    inputs, found = manoeuvre_inputs(), []
    for path in (fmu, fmu3):
        with EcosSimulationStructure() as structure:
            structure.add_model("variator", str(path))
            start = {f"variator::{name}": value for name, value in {**demo.START_VALUES, **inputs.at(0.0)}.items()}
            structure.add_parameter_set("start", start)
            with EcosSimulation(structure=structure, step_size=1e-3) as simulation:
                assert simulation.init(parameter_set="start")
                for k in range(300):
                    for name, value in inputs.at(k * 1e-3).items():
                        simulation.set_real(f"variator::{name}", value)
                    simulation.step(1)
                    found.append([simulation.get_real(f"variator::{name}") for name in ("thrustRatio", "belt.speed", "slip", "pushForce.max")])
                simulation.terminate()
    two, three = np.split(np.array(found), 2)
    assert np.array_equal(two, three) and np.ptp(three, axis=0).min() > 0.0


@pytest.mark.parametrize(("file", "version"), [("fmu", "2.0"), ("fmu3", "3.0")])
def test_the_checker_of_the_manipulation_toolbox_finds_nothing(request: pytest.FixtureRequest, file: str, version: str) -> None:
    pytest.importorskip("fmu_manipulation_toolbox")
    words = [Path(sys.executable).with_name("fmutool"), "-input", request.getfixturevalue(file), "-check"]
    checked = subprocess.run(words, capture_output=True, text=True, check=True)
    said = checked.stdout + checked.stderr
    assert f"compliant with FMI-{version}" in said and "No semantic error" in said
    assert "ERROR" not in said and "WARNING" not in said, said
