"""Copies of the FMU for importers that are stricter than the standard: flat names, outputs that are all Real, scalars instead of arrays."""

import keyword
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from conftest import CHEAP, pip_of
from fmpy.validation import validate_fmu
from lxml import etree

from pushbelt import cli
from pushbelt.fmu.copies import ARM, DESCRIPTION, LINUX, REALS, SCALARS, TERMINALS, flat
from pushbelt.fmu.unit import TRUTHS, Archive, Instance
from pushbelt.whole_file import copy_archive

OVER = {"primary.torque": 400.0, "secondary.torque": -49.0, "primary.clampingForce": 13e3, "secondary.clampingForce": 10e3}
"""Inputs at which the belt slips through."""
SHOWN = ("profile.pushForce[1]", "profile.pushForce[72]", "profile.gap[7]", "thrustRatio")
KEYWORDS = {*keyword.kwlist, *"algorithm block connector constant equation external final function initial input model output when".split()}
"""Of Python, Modelica and MATLAB; no FMU has a variable of such a name."""
RUN = {"stop_time": 0.02, "step_size": 1e-3, "output_interval": 1e-3, "start_values": {"ring.model": 1, "primary.clampingForce": 15e3}}


def written(copy: Path, fmu: Path, *words: str) -> Path:
    assert cli.main(["fmu", str(copy), "--fmu", str(fmu), *words]) == 0
    assert validate_fmu(copy) == []
    with zipfile.ZipFile(fmu) as one, zipfile.ZipFile(copy) as other:
        differing = {name for name in one.namelist() if one.read(name) != other.read(name)}
    assert DESCRIPTION in differing and differing <= {DESCRIPTION, TERMINALS}
    return copy


def description_of(path: Path) -> etree._Element:
    return etree.fromstring(zipfile.Path(path, DESCRIPTION).read_bytes())


def token(root: etree._Element) -> str:
    return root.get("guid") or root.get("instantiationToken")


def unknowns(root: etree._Element) -> dict[str, list[tuple[str, ...]]]:
    """The entries of the model structure by tag or list: name of the variable, and its dependencies."""
    variables = list(root.find("ModelVariables"))
    by_reference = {one.get("valueReference"): one.get("name") for one in variables}
    found: dict[str, list[tuple[str, ...]]] = {}
    for one in root.find("ModelStructure").iter("Unknown", "Output", "InitialUnknown"):
        named = by_reference.get(one.get("valueReference")) or variables[int(one.get("index")) - 1].get("name")
        known = tuple(one.get("dependencies", "of all").split(" "))
        found.setdefault(one.tag if one.tag != "Unknown" else one.getparent().tag, []).append((named, *known))
    return found


@pytest.mark.parametrize("kind", ["fmu", "fmu3", "map_fmu", "map_fmu3"])
def test_all_outputs_of_the_copy_are_real(kind: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    original = request.getfixturevalue(kind)
    copy = written(tmp_path / "real.fmu", original, "--real-outputs")
    before, after = (fmpy.read_model_description(str(path)).modelVariables for path in (original, copy))
    added = {one.name: one for one in after[len(before) :]}
    truths = [one.name for one in before if one.causality == "output" and one.type == "Boolean"]
    assert [one.valueReference for one in added.values()] == [REALS + one.valueReference for one in before if one.name in truths]
    assert list(added) == [f"{name}Real" for name in truths] and "macroSlip" in truths
    for one, other in zip(before, after[: len(before)], strict=True):
        is_other = one.causality == "output" and one.type not in ("Real", "Float64")
        assert other.causality == ("local" if is_other else one.causality)
        kept = ("name", "type", "valueReference", "variability", "initial", "start", "unit", "description")
        assert [getattr(one, name) for name in kept] == [getattr(other, name) for name in kept]
    outputs = {one.name for one in after if one.causality == "output"}
    assert outputs >= set(added) and {one.type for one in after if one.name in outputs} <= {"Real", "Float64"}
    # The model structure lists them, with the dependencies of before.
    roots = [description_of(path) for path in (original, copy)]
    assert token(roots[0]) == token(roots[1])
    lists = [unknowns(root) for root in roots]
    assert lists[0].keys() == lists[1].keys() and len(lists[0]) == 2
    for name, entries in lists[1].items():
        assert {entry[0] for entry in entries} == outputs, name
        known = {entry[0].removesuffix("Real"): entry[1:] for entry in entries}
        assert known == {entry[0]: entry[1:] for entry in lists[0][name] if entry[0] in known}


def test_a_host_that_reads_all_outputs_as_real_runs_the_copy(fmu: Path, tmp_path: Path) -> None:
    """Truth values are 0 or 1. The other outputs are those of the original, to the last bit."""
    copy = written(tmp_path / "own.fmu", fmu, "--real-outputs", "--set", "initial.ratio=1.2")
    values = []
    for path in (fmu, copy):
        with Archive.unpack(path) as archive, Instance(archive, {**CHEAP, "initial.ratio": 1.2}) as unit:
            outputs = unit.reals(one.name for one in archive.variables.values() if one.causality == "output" and one.type == "Real")
            unit.initialise()
            run = []
            for step in range(30):
                unit.set(OVER if step == 10 else {})
                unit.step_to((step + 1) * 1e-3)
                run.append(dict(zip(outputs.names, unit.get_reals(outputs), strict=True)) | {name: unit.get(name) for name in TRUTHS})
            values.append(run)
    expected, found = values
    slips = [[row.pop(f"{name}Real") for name in TRUTHS] for row in found]
    assert found == expected
    assert slips == [[row[name] for name in TRUTHS] for row in found] and {slip for slip, _ in slips} == {0.0, 1.0}


@pytest.mark.parametrize("words", [(), ("--flat",), ("--flat", "--real-outputs")], ids=" ".join)
def test_elements_of_arrays_are_scalars_with_their_own_references(words: tuple[str, ...], fmu: Path, fmu3: Path, tmp_path: Path) -> None:
    copy = written(tmp_path / "scalars.fmu", fmu3, "--scalars", *words)
    named = flat if "--flat" in words else str
    names = {name: named(name) for name in SHOWN}
    before, after = ({one.name: one for one in fmpy.read_model_description(str(path)).modelVariables} for path in (fmu3, copy))
    assert token(description_of(copy)) == token(description_of(fmu3))
    arrays = [one for one in before.values() if one.dimensions]
    assert len(arrays) == 9 and not any(one.dimensions for one in after.values())
    assert len(after) == len(before) + 71 * len(arrays) + len(TRUTHS) * ("--real-outputs" in words)
    references = [one.valueReference for one in after.values()]
    assert len(set(references)) == len(references) and not {one.valueReference for one in arrays}.intersection(references)
    last = after[names["profile.pushForce[72]"]]
    assert last.valueReference == SCALARS + before["profile.pushForce"].valueReference + 71
    assert (last.unit, last.nominal, last.causality) == ("N", before["profile.pushForce"].nominal, "local")
    # The names and values are those of FMI 2.0.
    expected = fmpy.simulate_fmu(str(fmu), output=SHOWN, **RUN)
    given = {**RUN, "start_values": {named(name): value for name, value in RUN["start_values"].items()}}
    found = fmpy.simulate_fmu(str(copy), output=list(names.values()), **given)
    for name in SHOWN:
        assert np.array_equal(found[names[name]], expected[name]), name
    assert np.ptp(expected["profile.pushForce[72]"]) > 0.0


def variables(root: etree._Element) -> list[etree._Element]:
    return [*root.find("ModelVariables"), *root.iter("Alias")]


@pytest.mark.parametrize("kind", ["fmu", "fmu3", "map_fmu", "map_fmu3"])
def test_only_the_names_of_a_flat_copy_differ(kind: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    original = request.getfixturevalue(kind)
    copy = written(tmp_path / "flat.fmu", original, "--flat")
    with zipfile.ZipFile(original) as one, zipfile.ZipFile(copy) as other:
        assert one.namelist() == other.namelist()
        terminals = [etree.fromstring(z.read(TERMINALS)) for z in (one, other) if TERMINALS in z.namelist()]
    before, after = (description_of(path) for path in (original, copy))
    names = {a.get("name"): b.get("name") for a, b in zip(variables(before), variables(after), strict=True)}
    assert len(set(names.values())) == len(names) and not KEYWORDS.intersection(names.values())
    assert all(name.isidentifier() and name.isascii() and len(name) <= 63 for name in names.values())
    assert names["primary.torque"] == "primary_torque" and names["initial.ratio"] == "initial_ratio"
    # With the names put back, everything is as before: the GUID, references, units, descriptions.
    assert after.get("variableNamingConvention") == "flat"
    after.set("variableNamingConvention", "structured")
    for element, name in zip(variables(after), names, strict=True):
        element.set("name", name)
    assert etree.tostring(after) == etree.tostring(before)
    if terminals:
        members = [[m.get("variableName") for m in root.iter("TerminalMemberVariable")] for root in terminals]
        assert members[1] == [names[name] for name in members[0]] and len(members[0]) > 5


def test_start_values_hold_under_flat_names(fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    copy = written(tmp_path / "own.fmu", fmu, "--flat", "--set", "initial.ratio=1.4", "--set", "ring.model=ALE0")
    assert "2 start values, flat names" in capsys.readouterr().out
    assert not list(tmp_path.glob("*.partial"))
    assert cli.main(["variables", "--kind", "output", "--fmu", str(copy)]) == 0
    said = capsys.readouterr().out
    assert "ratio_geometric" in said and "profile_pushForce" not in said, "listed without the fields"
    result = fmpy.simulate_fmu(str(copy), stop_time=2e-3, step_size=1e-3, output=["ratio_geometric"], apply_default_start_values=True)
    assert result["ratio_geometric"][0] == pytest.approx(1.4, rel=1e-6)
    # They can't be written afterwards: the library reads them by their names with dots.
    assert cli.main(["fmu", str(tmp_path / "again.fmu"), "--fmu", str(copy), "--set", "initial_ratio=1.2"]) == 1
    said = capsys.readouterr().err
    assert "own.fmu" in said and "--flat" in said and "original" in said and said.count("\n") == 1


def test_a_copy_for_arm_has_its_library_in_linux64(fmu: Path, tmp_path: Path) -> None:
    copy_archive(fmu, both := tmp_path / "both.fmu", {}, {f"{LINUX}other.so": b"x86", f"{ARM}PushbeltVariator.so": b"ARM"})
    assert cli.main(["fmu", str(copy := tmp_path / "copy.fmu"), "--fmu", str(both), "--arm", "--flat"]) == 0
    with zipfile.ZipFile(copy) as archive:
        assert {name: archive.read(name) for name in archive.namelist() if name.startswith(LINUX)} == {f"{LINUX}PushbeltVariator.so": b"ARM"}


def test_copies_that_cannot_be_are_refused(fmu: Path, fmu3: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with_flat = written(tmp_path / "flat.fmu", fmu3, "--flat")
    copy_archive(fmu, without := tmp_path / "x86.fmu", {}, {f"{ARM}PushbeltVariator.so": None})
    capsys.readouterr()
    for source, words, why in (
        (with_flat, ["--scalars"], "flat.fmu has flat names"),
        (with_flat, ["--real-outputs"], "with --flat and the other options together"),
        (without, ["--arm"], "no library for Linux on ARM; `cargo"), (fmu3, ["--arm"], "FMI 3.0, in which importers on ARM look in aarch64-linux"),
    ):  # fmt: skip
        assert cli.main(["fmu", str(tmp_path / "none.fmu"), "--fmu", str(source), *words]) == 1
        said = capsys.readouterr().err
        assert why in said and said.count("\n") == 1
    assert not (tmp_path / "none.fmu").exists()


INPUTS = {"primary.torque": 60.0, "secondary.torque": -58.0, "primary.clampingForce": 14e3, "secondary.clampingForce": 10e3}
PATHSIM = f"""
import sys
from pathsim import Connection, Simulation
from pathsim.blocks import Constant
from pathsim_fmi import CoSimulationFMU
fmu = CoSimulationFMU(sys.argv[1], dt=1e-3)
sources = {{name: Constant(value) for name, value in {INPUTS}.items()}}
Simulation([fmu, *sources.values()], [Connection(one, fmu[name]) for name, one in sources.items()], dt=1e-3).run(0.0385)
found = dict(zip(fmu.fmu_wrapper.output_refs, fmu.outputs.to_array()))
print(found["ratio.geometric"], found["macroSlipReal"])
"""
COFMPY = f"""
import sys
from cofmupy import Coordinator
belt = {{"id": "belt", "path": sys.argv[1], "initialization": {INPUTS}}}
coordinator = Coordinator()
coordinator.start({{"fmus": [belt], "connections": [], "cosim_method": "jacobi", "root": "", "loop_solver": "jacobi", "edge_sep": " -> ", "iterative": False}})
for _ in range(40):
    coordinator.do_step(1e-3)
print(*(coordinator.get_variable(("belt", name))[0] for name in ("ratio.geometric", "macroSlipReal")))
"""
HOSTS = {
    "PathSim": ("pathsim-fmi==0.1.1", PATHSIM, "fmu"), "PathSim, FMI 3.0": ("pathsim-fmi==0.1.1", PATHSIM, "fmu3"),
    "CoFMPy": ("cofmupy==1.0.0", COFMPY, "fmu"),
}  # fmt: skip
"""Package, program and kind of FMU."""


@pytest.mark.full
@pytest.mark.parametrize("host", HOSTS)
def test_hosts_that_refuse_the_original_run_the_copy(host: str, fmu: Path, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    package, program, kind = HOSTS[host]
    original: Any = request.getfixturevalue(kind)
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", tmp_path / "venv"], check=True)
    python = tmp_path / "venv" / "bin" / "python"
    installed = subprocess.run([*pip_of(python), "install", "--no-compile", package], capture_output=True, text=True)
    if installed.returncode != 0:
        pytest.skip(f"{package} can't be installed: {installed.stderr.strip().splitlines()[-1]}")
    copy = written(tmp_path / "real.fmu", original, "--real-outputs")
    runs = [subprocess.run([python, "-c", program, path], cwd=tmp_path, capture_output=True, text=True) for path in (original, copy)]
    assert runs[0].returncode != 0, "the original runs, too"
    assert runs[1].returncode == 0, runs[1].stderr
    ratio, slips = map(float, runs[1].stdout.split()[-2:])
    # CoFMPy sets the inputs before the initialisation, PathSim after it.
    with Archive.unpack(fmu) as archive, Instance(archive, INPUTS if host == "CoFMPy" else {}) as unit:
        unit.initialise()
        unit.set(INPUTS)
        for step in range(40):
            unit.step_to((step + 1) * 1e-3)
        assert (ratio, slips) == (pytest.approx(unit.get("ratio.geometric"), rel=1e-12), 0.0)
