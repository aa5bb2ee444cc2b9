"""Solves for maps of the variator for vehicle simulations, and writes files for other tools and a report.

Steady states over clamping force, primary speed, ratio and torque utilisation are solved, and capacity and shift rates measured. The files
are maps.nc, maps.npz, maps.json, maps.mat, maps_combitable.txt, maps_combitable.mat, maps.csv, torque_loss.csv and report.html. An
interrupted run continues from its finished lines.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from pushbelt import console
from pushbelt.cli.options import add_sensitivities, add_short, add_study, numbers, program, sensitivities
from pushbelt.errors import ArgumentError, require
from pushbelt.study.tasks import variator

from .data import AXES, Maps
from .plan import COARSE, SHORT, Plan, collect

GIVEN = ("force", "speed", "ratio", "utilisation")  # Axes with an option


def parser() -> argparse.ArgumentParser:
    found = program("maps", __doc__, "maps, report and finished lines")
    add_short(found, "12 lines instead of 84")
    add_study(found)
    for name in GIVEN:
        text = f"{AXES[name].description}, {AXES[name].unit}; comma-separated numbers"
        found.add_argument(f"--{name}", type=numbers, metavar="A,B,…", help=text)
    found.add_argument("--ratios", type=int, metavar="N", help="number of ratios, evenly between the end stops [default: 7]")
    add_sensitivities(found)
    found.add_argument("--beside", type=Path, metavar="MAPS", help="maps of another variator, maps.nc, for the report")
    return found


@console.program("maps", "sweep")
def main(arguments: Sequence[str] | None = None) -> int | console.Done:
    options = parser().parse_args(arguments)
    require("sweep")
    given = {name: getattr(options, name) for name in (*GIVEN, "ratios") if getattr(options, name) is not None}
    if given.get("ratios", 2) < 2:
        raise ArgumentError("at least two ratios are needed")
    grid = replace(SHORT if options.short else COARSE, **given)
    parameters = variator(options.variator, options.ring, dict(options.set))
    plan = Plan(options.fmu, parameters, grid, *sensitivities(options))
    beside = Maps.read(options.beside) if options.beside else None
    # Imported here, so that the help needs no packages of the extras, and processes of a local cluster none of the report.
    from pushbelt.study.run import from_command_line

    from . import files, report

    rows, effort = from_command_line(plan, options, "lines")
    maps = collect(plan, rows)
    for written in files.write(maps, options.output):
        print(written.resolve())
    path = report.write(maps, options.output, effort, beside)
    gaps = int((~maps.valid).sum())
    print(f"{path.resolve()} ({maps.valid.size} points, {gaps} without a steady state, {effort})")
    return console.Done(0, maps)


if __name__ == "__main__":
    sys.exit(main())
