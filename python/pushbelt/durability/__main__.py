"""Computes the fatigue of the ring over runs, and writes a report.

RUN is a result of drive or any table of outputs in SI units, or the folder of a drive, of which the runs over the whole cycle are
taken. The damage of each run is Miner's sum over the cycles of the ring's stress, one on each pulley and revolution.

A table with a column hours is a load collective: its rows are steady states that last so long, each with outputs, or with ratio.geometric,
primary.torque, primary.speed and secondary.clampingForce, for which the FMU is solved.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from pushbelt import console
from pushbelt.cli.options import add_material, add_variator, material, program
from pushbelt.errors import ArgumentError, require
from pushbelt.fmu.bands import SAMPLES, increased, samples
from pushbelt.fmu.data import BELT_LENGTH, is_chain, parameter_deviations, parameter_set
from pushbelt.fmu.files import default_fmu
from pushbelt.fmu.geometry import Array
from pushbelt.fmu.results import largest
from pushbelt.fmu.unit import belt_described
from pushbelt.points import SteadyStateError
from pushbelt.variator import Variator

from .table import COLUMNS, POINT, Table, read

if TYPE_CHECKING:
    from .damage import Damage

DRIVES = ("fixed-safety-factor.csv", "slip-control.csv")  # Runs over the whole cycle in the folder of a drive


@console.program("durability", "durability")
def main(arguments: Sequence[str] | None = None) -> int:
    parser = program("durability", __doc__, "report.html, durability.json and .csv", "the FMU, for its variables and for collectives", needed=False)
    parser.add_argument("runs", type=Path, nargs="+", metavar="RUN", help="table of outputs, or folder of a drive")
    add_variator(parser, None)
    parser.add_argument("--hours", action="store_true", help="life in hours only: no column distance is required")
    parser.add_argument("--profile", action="store_true", help="count the cycles on profile.ringStress[…]")
    text = f"scatter of the life over {SAMPLES} belts, by the deviations that are known of the parameter set; for collectives of working points"
    parser.add_argument("--bands", action="store_true", help=text)
    add_material(parser, "--safety")
    options = parser.parse_args(arguments)
    require("durability")  # The help needs no packages of the extras.
    from . import report
    from .damage import damage

    steel, parameters = material(options), _parameters(options.fmu, options.variator)
    paths = [path for given in options.runs for path in _files(given)]

    def solved(path: Path, changes: Mapping[str, float] = MappingProxyType({})) -> Damage:
        return damage(read(path, not options.hours, options.profile, partial(_solved, options, changes)), steel, parameters)

    results = [solved(path) for path in paths]
    path = report.write(results, options.output)
    for result in results:
        print(f"  {result.table.name}: {report.summary(result)}")
        if options.bands:
            print(f"    {_scatter(options, result.table, partial(solved, result.table.path))}")
    print(path.resolve())
    return 0


def _solved(options: argparse.Namespace, changes: Mapping[str, float], points: Mapping[str, Array]) -> dict[str, Array]:
    """Outputs in the steady states of working points. Raises SteadyStateError for the first one that has none."""
    with Variator(options.variator or "bench168", changes, fmu=options.fmu) as belt:
        rows = zip(*(points[name].tolist() for name in POINT), strict=True)
        states = [belt.steady(ratio, torque, speed=speed, force=force).outputs for ratio, torque, speed, force in rows]
    return {name: np.array([state[name] for state in states]) for name in COLUMNS if name in states[0]}


def _scatter(options: argparse.Namespace, table: Table, solved: Callable[[Mapping[str, float]], Damage]) -> str:
    """Lives of belts whose parameters are drawn from independent normal distributions. A damage is far from linear in them."""
    name = options.variator or "bench168"
    values, deviations = parameter_set(name), parameter_deviations(name)
    if not table.solved or not deviations:
        raise ArgumentError(f"{table.name}: --bands needs a collective of working points, and a parameter set with known deviations")
    variables = {one.name: one for one in belt_described(options.fmu or default_fmu()).modelVariables}
    lives, used = [], []
    for changes in samples(deviations, SAMPLES):
        try:
            found = solved(increased(variables, values, changes))
        except SteadyStateError:
            continue
        lives.append(found.life(found.total)[0])
        used.append([*changes.values(), found.utilisation])
    if len(lives) < SAMPLES // 2:
        raise ArgumentError(f"{table.name}: only {len(lives)} of {SAMPLES} belts carry all rows")
    low, middle, high = (f"{life:.3g} h" if np.isfinite(life) else "unlimited" for life in np.quantile(lives, (0.16, 0.5, 0.84), method="nearest"))
    shares, amplitudes = np.abs(np.corrcoef(np.transpose(used))[-1, :-1]), 100.0 * np.array(used)[:, -1]
    most = ", ".join(largest(deviations, shares))
    scatter = f"of {len(lives)} belts 16 % live at most {low}, half {middle}, 84 % {high}"
    return f"{scatter}; largest amplitude {amplitudes.mean():.0f} ± {amplitudes.std():.0f} % of the limit, most by {most}"


def _files(path: Path) -> list[Path]:
    """The file itself, or the runs of a drive's folder."""
    if not path.is_dir():
        return [path]
    if found := [path / name for name in DRIVES if (path / name).is_file()]:
        return found
    raise ArgumentError(f"{path} has no {' or '.join(DRIVES)}: name a file, or the folder of `drive`")


def _parameters(fmu: Path | None, variator: str | None) -> dict[str, float]:
    """Parameters of the variator by name: start values of the FMU, and above them those of the parameter set."""
    started = [one for one in (belt_described(fmu).modelVariables if fmu else ()) if one.causality == "parameter" and one.start is not None]
    values = {one.name: float(one.start) for one in started if one.type in ("Real", "Integer")}
    if variator is not None or fmu is None:
        values |= parameter_set(variator or "bench168")
    if is_chain(values):
        raise ArgumentError(f"{variator or fmu}: belt.kind = 2 is a pull chain, which has no ring layers")
    length, (low, high) = values.get("geometry.beltLength"), BELT_LENGTH
    if not isinstance(length, (int, float)) or not low <= length <= high:
        raise ArgumentError(f"geometry.beltLength is {length}, not within {low:g} to {high:g} m")
    return values


if __name__ == "__main__":
    sys.exit(main())
