"""Drives: `python -m pushbelt.drive --fmu target/PushbeltVariator.fmu --output target/drive [--short]`."""

from __future__ import annotations

import argparse
import dataclasses
import sys
import time
from pathlib import Path

from pushbelt import console, provenance
from pushbelt.fmu.enumerations import RingModel
from pushbelt.fmu.unit import UnitError

from . import report, runs, simulate
from .cycle import CycleMissingError, wltc_class_3b

FULL = {"wltc": runs.FULL, "nedc": runs.FULL_NEDC}
SHORT = {"wltc": runs.SHORT, "nedc": runs.SHORT_NEDC}


def default_cycle() -> str:
    """`wltc`, or `nedc` with a message if the table of the WLTC is not installed."""
    try:
        wltc_class_3b()
    except CycleMissingError as error:
        print(f"  the NEDC is driven, not the WLTC: {error}", file=sys.stderr)
        return "nedc"
    return "wltc"


def main(arguments: list[str] | None = None) -> int:
    """Simulates, writes the report and prints its path."""
    parser = argparse.ArgumentParser(prog="pushbelt.drive", description=__doc__)
    parser.add_argument("--fmu", type=Path, required=True, help="the FMU to run")
    parser.add_argument("--output", type=Path, required=True, help="folder for report.html and the results")
    parser.add_argument("--short", action="store_true", help="simulate 30 s of the cycle and 10 s of close-up")
    parser.add_argument(
        "--cycle", choices=list(FULL), help="which cycle [default: wltc, or nedc without the package wltp that contains the WLTC]"
    )
    parser.add_argument("--until", type=float, metavar="SECONDS", help="simulate only the first seconds of the cycle")
    parser.add_argument(
        "--ring",
        choices=list(RingModel.__members__),
        default="ALE",
        help="ring model of the whole cycle",
    )
    parser.add_argument(
        "--clamping",
        type=float,
        default=1.0,
        metavar="FACTOR",
        help="factor on the secondary clamping force that both strategies demand [default: 1]",
    )
    parser.add_argument("--variator", default=simulate.VARIATOR, help="name of a parameter set, or a file ….json")
    parser.add_argument(
        "--maps", type=Path, metavar="FILE", help="maps.nc of `pushbelt maps` for the controllers [default: measured on the FMU]"
    )
    options = parser.parse_args(arguments)
    provenance.begin("drive", arguments)
    if not 0.5 <= options.clamping <= 2.0:
        parser.error(f"--clamping {options.clamping:g} is not within 0.5 to 2")
    if options.cycle is None:
        options.cycle = default_cycle()
    plan = dataclasses.replace(
        (SHORT if options.short else FULL)[options.cycle],
        ring=options.ring,
        variator=options.variator,
        clamping=options.clamping,
        maps=options.maps,
    )
    if options.until is not None:
        plan = dataclasses.replace(plan, cycle=(plan.cycle[0], plan.cycle[0] + options.until))
    begin = time.perf_counter()
    try:
        results = runs.run_all(options.fmu, plan, options.output)
    except (UnitError, ValueError, OSError) as error:
        print(f"The simulation failed: {error}", file=sys.stderr)
        return 1
    options.output.mkdir(parents=True, exist_ok=True)
    for run in results.runs:
        report.write_trace(run, results.units, options.output / f"{run.setup.name.replace(',', '').replace(' ', '-')}.csv")
    path = options.output / "report.html"
    report.write_html(results, path)
    print(f"{path.resolve()} ({time.perf_counter() - begin:.0f} s)")
    return 0


if __name__ == "__main__":
    sys.exit(console.run(main))
