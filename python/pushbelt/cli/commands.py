"""The commands of `pushbelt` that are no programs: copies of FMUs with other values, variables, pages, the cache."""

import argparse
import shutil
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ..errors import ArgumentError, similar
from ..fmu import cache, copies, start_values
from ..fmu.data import parameter_set
from ..fmu.files import DOCS, EXAMPLES, default_fmu, found
from ..fmu.unit import Archive, Instance, UnitError
from ..fmu.untrusted import described
from ..maps import unit as map_unit
from ..maps.data import Maps


def write_fmu(options: argparse.Namespace) -> int:
    """`pushbelt fmu`: checks the values against the variable table and on the FMU itself, and writes the copy."""
    _check_name(options.copy)
    fmu = options.fmu or (found("PUSHBELT_FMU3", "PushbeltVariator3.fmu", "cargo fmu build --fmi3") if options.fmi3 else default_fmu())
    description = _check_version(fmu, options)
    if options.scalars and description.fmiVersion != "3.0":
        raise ArgumentError(f"--scalars: {fmu} is of FMI {description.fmiVersion}, which has no arrays; --fmi3 takes that of FMI 3.0")
    if options.arm:
        copies.check_arm(fmu, description.fmiVersion)
    has_values = options.set or options.variator or options.ssv
    if description.variableNamingConvention == "flat" and (has_values or options.scalars or options.real_outputs):
        raise ArgumentError(f"{fmu} has flat names: write a copy of the original, with --flat and the other options together")
    source, facts = fmu, []
    remarks: list[str] = []
    if has_values or not (options.flat or options.scalars or options.real_outputs or options.arm):
        values, remarks = _chosen(fmu, description, options)
        start_values.write_copy(fmu, options.copy, values)
        source, facts = options.copy, [f"{len(values)} start values"]
    changes = {
        "real outputs": options.real_outputs and copies.with_real_outputs, "scalars": options.scalars and copies.with_scalars,
        "flat names": options.flat and copies.with_flat_names,
    }  # fmt: skip
    if chosen := {name: change for name, change in changes.items() if change}:
        copies.write_copy(source, options.copy, *chosen.values())
        source, facts = options.copy, [*facts, *chosen]
    if options.arm:
        copies.write_arm_copy(source, options.copy)
        facts.append("linux64 for ARM")
    _print(options.copy, remarks, f" ({', '.join(facts)})")
    return 0


def _chosen(fmu: Path, description: Any, options: argparse.Namespace) -> tuple[dict[str, float], list[str]]:
    """The start values of the options, and the FMU's warnings about them."""
    # Values for FMI 3.0 are tried on the FMU of FMI 2.0, which has the same library and variables.
    archive = cache.unpacked(default_fmu() if description.fmiVersion == "3.0" else fmu)
    given: dict[str, Any] = parameter_set(options.variator) if options.variator else {}
    if options.ssv:
        given |= start_values.read_ssv(options.ssv, archive.variables)
    given |= dict(options.set)
    values = start_values.checked(archive.variables, given)
    return values, _tried(archive, values, "values")


def _check_version(fmu: Path, options: argparse.Namespace) -> Any:
    """The model description of an FMU. Raises ArgumentError if it is not of FMI 3.0 where that is wanted."""
    description = described(fmu)
    if options.fmi3 and description.fmiVersion != "3.0":
        raise ArgumentError(f"--fmi3: {fmu} is of FMI {description.fmiVersion}")
    return description


def _check_name(copy: Path) -> None:
    if copy.suffix != ".fmu":
        raise ArgumentError(f"{copy} does not end in .fmu: importers would not accept it")


def _tried(archive: Archive, values: Mapping[str, Any], what: str) -> list[str]:
    """Warnings of the FMU after a start with these values. Raises ArgumentError if it rejects them."""
    try:
        with Instance(archive, values) as unit:
            unit.initialise()
            return unit.warnings
    except UnitError as error:
        raise ArgumentError(f"the FMU rejects these {what}: {error}") from error


def _print(copy: Path, remarks: list[str], more: str = "") -> None:
    for remark in remarks:
        print(f"  warning of the FMU: {remark}", file=sys.stderr)
    print(f"{copy.resolve()}{more}")


def write_map_fmu(options: argparse.Namespace) -> int:
    """`pushbelt map-fmu`: writes tables and start values into a copy of the FMU of maps, and starts the copy once."""
    _check_name(options.copy)
    packed = ("PUSHBELT_MAP_FMU3", "PushbeltMap3.fmu", "cargo fmu build --map --fmi3")
    fmu = options.fmu or (found(*packed) if options.fmi3 else map_unit.default_fmu())
    description = _check_version(fmu, options)
    if all(one.name != "map.outside" for one in description.modelVariables):
        raise ArgumentError(f"{fmu} is no FMU of maps such as PushbeltMap.fmu")
    # Maps for FMI 3.0 are tried in the FMU of FMI 2.0.
    tried = map_unit.default_fmu() if description.fmiVersion == "3.0" else fmu
    maps = Maps.read(options.maps) if options.maps else map_unit.default_maps().read_bytes()
    with TemporaryDirectory() as folder:
        map_unit.write_fmu(trial := Path(folder) / "trial.fmu", maps, tried, dict(options.set))
        with Archive.unpack(trial) as archive:
            remarks = _tried(archive, {}, "maps or values")
    map_unit.write_fmu(options.copy, maps, fmu, dict(options.set))
    _print(options.copy, remarks)
    return 0


def show_cache(options: argparse.Namespace) -> int:
    folder = cache.folder()
    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) if folder.is_dir() else 0
    if options.clear and folder.is_dir():
        shutil.rmtree(folder)
    print(f"{'removed ' if options.clear else ''}{folder} ({size / 1e6:.1f} MB)")
    return 0


def show_variables(options: argparse.Namespace) -> int:
    words = [word.lower() for word in options.words]
    variables = start_values.Variables(described(options.fmu or default_fmu()).modelVariables)
    fields = "profile." in " ".join(words)
    kinds = [one for one in variables.values() if options.kind in (None, one.causality)]
    named = [one for one in kinds if all(word in f"{one.name} {one.description}".lower() for word in words)]
    found = [one for one in named if fields or not one.name.startswith(("profile.", "profile_"))]
    if not found:
        what, near = f"no {options.kind or 'variable'} has {' and '.join(options.words)}", similar(" ".join(options.words), variables)
        raise ArgumentError(f"{what} in its name or description{near}")
    for one in found:
        print(f"{one.name}\n    {', '.join([one.causality, *one.facts])}\n    {one.description}")
    print(f"{len(found)} of {len(variables)} variables" + ("" if fields else "; `pushbelt variables profile.` lists the fields"))
    return 0


def write_examples(options: argparse.Namespace) -> int:
    """`pushbelt examples`: copies those that need no Rust."""
    if options.folder.exists():
        raise ArgumentError(f"{options.folder} is there already: name a new folder")
    shutil.copytree(EXAMPLES, options.folder, ignore=shutil.ignore_patterns("*.rs", "cosim", "__pycache__"))
    print(options.folder.resolve())
    return 0


def show_docs(options: argparse.Namespace) -> int:
    # Pages that consist of a file of the source tree are left out.
    texts = {path.stem: path.read_text(encoding="utf-8") for path in DOCS.glob("*.md")}
    pages = sorted(name for name, text in texts.items() if "{{#include ../" not in text and name != "SUMMARY")
    if options.page is None:
        print(f"{DOCS}: {', '.join(pages)}\n`pushbelt docs PAGE` prints a page.")
        return 0
    name = options.page.removesuffix(".md")
    if name not in pages:
        raise ArgumentError(f"no page {name}{similar(name, pages) or '; there are ' + ', '.join(pages)}")
    print(texts[name])
    typeset = DOCS / f"{name}.html"  # In the wheel, of a page with equations.
    if typeset.is_file():
        print(f"Typeset: {typeset.resolve().as_uri()}")
    return 0
