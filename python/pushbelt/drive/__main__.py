"""Drives a car with the FMU on the WLTC or the NEDC, and writes a report."""

import argparse
import dataclasses
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from pushbelt import console
from pushbelt.cli.options import add_ring, add_short, add_variator, program
from pushbelt.errors import ArgumentError, MissingPackageError, require

from .cycle import CYCLES, wltc_class_3b
from .vehicle import RANGES, demo_car


def default_cycle() -> str:
    """`wltc`, or `nedc` with a message if the table of the WLTC is not installed."""
    try:
        wltc_class_3b()
    except MissingPackageError as error:
        print(f"  the NEDC is driven, not the WLTC: {error}", file=sys.stderr)
        return "nedc"
    return "wltc"


def parser() -> argparse.ArgumentParser:
    found = program("drive", __doc__, "report.html and the results")
    add_short(found, "30 s of the cycle and 10 s of close-up")
    text = "which cycle; a file has the columns time [s] and speed [km/h] [default: wltc, or nedc without the package wltp of the WLTC]"
    found.add_argument("--cycle", metavar="wltc|nedc|FILE.csv", help=text)
    found.add_argument("--until", type=float, metavar="SECONDS", help="simulate only the first seconds of the cycle")
    add_ring(found)
    text = "factor on the secondary clamping force that both strategies demand [default: 1]"
    found.add_argument("--clamping", type=float, default=1.0, metavar="FACTOR", help=text)
    add_variator(found)
    text = "maps.nc of `pushbelt maps` for the controllers [default: measured on the FMU]"
    found.add_argument("--maps", type=Path, metavar="FILE", help=text)
    found.add_argument("--bands", action="store_true", help="standard deviation of the losses by those known of the parameter set, in half a minute")
    for name, (_, _, unit) in RANGES.items():
        shown = f"{name.replace('_', ' ')} of the car, {unit} [default: {getattr(demo_car(), name):g}]"
        found.add_argument(f"--{name.replace('_', '-')}", type=float, metavar="X", help=shown)
    return found


@console.program("drive", "reports")
def main(arguments: Sequence[str] | None = None) -> console.Done:
    options = parser().parse_args(arguments)
    if not 0.5 <= options.clamping <= 2.0:
        raise ArgumentError(f"--clamping {options.clamping:g} is not within 0.5 to 2")
    options.cycle = options.cycle or default_cycle()
    require("reports" if options.cycle in CYCLES else "tables")  # The help needs no packages of the extras.
    from . import report, runs

    given = {name: getattr(options, name) for name in ("ring", "variator", "clamping", "maps")}
    car = {name: value for name in RANGES if (value := getattr(options, name)) is not None}
    plan = dataclasses.replace(runs.plan(options.cycle, options.short), car=demo_car(**car))
    end = plan.cycle[1] if options.until is None else plan.cycle[0] + options.until
    plan = dataclasses.replace(plan, cycle=(plan.cycle[0], end), **given)
    begin = time.perf_counter()
    results = runs.run_all(options.fmu, plan, options.output)
    for run in results.runs:
        report.write_trace(run, results.units, options.output / f"{run.setup.name.replace(',', '').replace(' ', '-')}.csv")
    for run in results.runs[:2] if options.bands else ():
        share, most = runs.band_of_losses(options.fmu, run)
        print(f"  {run.setup.name}: losses of the variator {1e-3 * run.variator_loss:.4g} kJ ± {100.0 * share:.0f} %, most by {', '.join(most)}")
    path = report.write_html(results, options.output / "report.html")
    print(f"{path.resolve()} ({time.perf_counter() - begin:.0f} s)")
    return console.Done(0, results)


if __name__ == "__main__":
    sys.exit(main())
