"""`pushbelt fmu` and `pushbelt map-fmu`: copies of FMUs with other values."""

from __future__ import annotations

import argparse
import importlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ArgumentError

if TYPE_CHECKING:
    from ..maps.data import Maps


def write_fmu(options: argparse.Namespace) -> int:
    """`pushbelt fmu`: checks the values against the variable table and on the FMU itself, and writes the copy."""
    from ..fmu import cache, flat, start_values
    from ..fmu.data import parameter_set
    from ..fmu.files import default_fmu
    from ..fmu.unit import Instance, UnitError
    from ..fmu.untrusted import described

    if options.copy.suffix != ".fmu":
        raise ArgumentError(f"{options.copy} does not end in .fmu: importers would not accept it")
    fmu = options.fmu or default_fmu()
    if options.flat and not (options.set or options.variator or options.ssv):
        described(fmu)
        flat.write_copy(fmu, options.copy)
        print(f"{options.copy.resolve()} (flat names)")
        return 0
    archive = cache.unpacked(fmu)
    if archive.description.variableNamingConvention == "flat":
        raise ArgumentError(f"{fmu} has flat names: write its start values together with --flat into a copy of the original")
    variables = {variable.name: variable for variable in archive.description.modelVariables}
    given: dict[str, Any] = parameter_set(options.variator) if options.variator else {}
    if options.ssv:
        from ..fmu import ssv

        given |= ssv.read(options.ssv, variables)
    given |= dict(options.set)
    values = start_values.checked(variables, given)
    try:
        with Instance(archive, values) as unit:
            unit.initialise()
            remarks = unit.warnings
    except UnitError as error:
        raise ArgumentError(f"the FMU rejects these values: {error}") from error
    start_values.write_copy(fmu, options.copy, values)
    if options.flat:
        flat.write_copy(options.copy, options.copy)
    for remark in remarks:
        print(f"  warning of the FMU: {remark}", file=sys.stderr)
    print(f"{options.copy.resolve()} ({len(values)} start values{', flat names' if options.flat else ''})")
    return 0


def write_map_fmu(options: argparse.Namespace) -> int:
    """`pushbelt map-fmu`: writes tables and start values into a copy of the FMU of maps, and starts the copy once."""
    from ..maps import unit as map_unit
    from ..fmu.unit import Archive, Instance, UnitError
    from ..maps.data import Maps

    if options.copy.suffix != ".fmu":
        raise ArgumentError(f"{options.copy} does not end in .fmu: importers would not accept it")
    if options.maps and options.variator:
        raise ArgumentError("--maps and --variator exclude each other: a file of maps has its variator's parameters")
    if options.short and not options.variator:
        raise ArgumentError("--short is for maps that are solved for: it needs --variator")
    if options.variator:
        maps: Maps | bytes = _solved_maps(options.variator, options.copy.parent, short=options.short)
    else:
        maps = Maps.read(options.maps) if options.maps else map_unit.default_maps().read_bytes()
    map_unit.write_fmu(options.copy, maps, options.fmu, dict(options.set))
    try:
        with Archive.unpack(options.copy) as archive, Instance(archive, {}) as unit:
            unit.initialise()
            remarks = unit.warnings
    except UnitError as error:
        options.copy.unlink()
        raise ArgumentError(f"the FMU rejects these maps or values: {error}") from error
    for remark in remarks:
        print(f"  warning of the FMU: {remark}", file=sys.stderr)
    print(options.copy.resolve())
    return 0


def _solved_maps(variator: str, folder: Path, *, short: bool) -> Maps:
    """The default maps of a parameter set, or a few lines of them. Finished lines remain in a folder beside the FMU."""
    from ..fmu.files import default_fmu
    from ..maps.data import Maps

    output = folder / "pushbelt-maps"
    program = importlib.import_module("pushbelt.maps.__main__")
    words = ["--fmu", str(default_fmu()), "--output", str(output), "--variator", variator, *["--short"] * short]
    if program.main(words) != 0:
        raise ArgumentError("there are no maps")
    return Maps.read(output / "maps.nc")
