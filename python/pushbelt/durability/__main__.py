"""Fatigue of the ring over runs: `python -m pushbelt.durability RUN.csv --output target/durability`.

RUN.csv is a result of drive or any table of outputs in SI units, or the folder of a drive, of which the runs over the whole cycle are
taken. The damage of each run is Miner's sum over the cycles of the ring's stress, one on each pulley and revolution.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pushbelt import console, provenance
from pushbelt.arguments import stress
from pushbelt.fmu.data import BELT_LENGTH, is_chain, parameter_set
from pushbelt.fmu.untrusted import described
from pushbelt.steel import RANGES, Material

from . import report
from .damage import damage
from .table import DurabilityError, read

DRIVES = ("fixed-safety-factor.csv", "slip-control.csv")
"""Runs over the whole cycle in the folder of a drive."""
MATERIAL = {
    "strength": "tensile strength R_m, MPa or with its unit",
    "limit": "fatigue limit: amplitude without mean stress that half of the specimens bear, MPa or with its unit",
    "knee": "cycles to failure at the fatigue limit",
    "slope": "exponent of the S-N curve above the limit",
    "safety": "factor by which the limit is reduced",
}


def main(arguments: list[str] | None = None) -> int:
    """Computes the damage, writes the report and prints its path."""
    parser = argparse.ArgumentParser(prog="pushbelt.durability", description=__doc__)
    parser.add_argument("runs", type=Path, nargs="+", metavar="RUN", help="table of outputs, or folder of a drive")
    parser.add_argument("--output", type=Path, required=True, help="folder for report.html, durability.json and .csv")
    parser.add_argument("--fmu", type=Path, help="the FMU, for the default values of its parameters; it does not run")
    parser.add_argument("--variator", help="parameter set of the runs, or its file, ….json [default: start values of the FMU]")
    parser.add_argument("--hours", action="store_true", help="life in hours only: no column distance is required")
    parser.add_argument("--profile", action="store_true", help="count the cycles on profile.ringStress[…]")
    for name, text in MATERIAL.items():
        default, scale = getattr(Material, name), 1e-6 if RANGES[name][2] else 1.0
        names = [f"--{name}", *["--stress-safety"] * (name == "safety")]
        text = f"{text} [default: {scale * default:g}]"
        parser.add_argument(*names, type=float if scale == 1.0 else stress, default=default, metavar=name.upper(), help=text)
    options = parser.parse_args(arguments)
    provenance.begin("durability", arguments)
    try:
        material = Material(**{name: getattr(options, name) for name in MATERIAL})
        parameters = _parameters(options.fmu, options.variator)
        paths = [path for given in options.runs for path in _files(given)]
        tables = [read(path, not options.hours, options.profile) for path in paths]
        results = [damage(table, material, parameters) for table in tables]
        options.output.mkdir(parents=True, exist_ok=True)
        path = report.write(results, options.output)
    except (ValueError, OSError) as error:
        print(f"The durability computation failed: {error}", file=sys.stderr)
        return 1
    for result in results:
        print(f"  {result.table.name}: {report.summary(result)}")
    print(path.resolve())
    return 0


def _files(path: Path) -> list[Path]:
    """The file itself, or the runs of a drive's folder."""
    if not path.is_dir():
        return [path]
    found = [path / name for name in DRIVES if (path / name).is_file()]
    if not found:
        raise DurabilityError(f"{path} has no {' or '.join(DRIVES)}: name a file, or the folder of `drive`")
    return found


def _parameters(fmu: Path | None, variator: str | None) -> dict[str, float]:
    """Parameters of the variator by name: start values of the FMU, and above them those of the parameter set."""
    values = {}
    if fmu is not None:
        started = [one for one in described(fmu).modelVariables if one.causality == "parameter" and one.start is not None]
        values = {one.name: float(one.start) for one in started if one.type in ("Real", "Integer")}
    if variator is not None or fmu is None:
        values |= parameter_set(variator or "bench168")
    if is_chain(values):
        raise DurabilityError(f"{variator or fmu}: belt.kind = 2 is a pull chain, which has no ring layers")
    length, (low, high) = values.get("geometry.beltLength"), BELT_LENGTH
    if not isinstance(length, (int, float)) or not low <= length <= high:
        raise DurabilityError(f"geometry.beltLength is {length}, not within {low:g} to {high:g} m")
    return values


if __name__ == "__main__":
    sys.exit(console.run(main))
