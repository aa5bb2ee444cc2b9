"""Compares the FMU with theory and measurements: `python -m pushbelt_validation --fmu … --output target/validate [--short]`.

Two processors take about a minute, less with --short.

Exit codes: 0 all theories are met in the limit in which they hold, 1 an error, 3 one of them is not (all files are written). A missed
measurement is a result.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from pushbelt import console, provenance
from pushbelt.fmu.unit import UnitError
from pushbelt.fmu.untrusted import InputFileError

from . import bands, report, results
from .bench import Plan
from .runs import SECTIONS, run_all

UNMET = 3
"""Exit code of a theory that is not met in its limit."""


def parser() -> argparse.ArgumentParser:
    """The command line."""
    found = argparse.ArgumentParser(
        prog="pushbelt_validation", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    found.add_argument("--fmu", type=Path, required=True, help="the FMU to run")
    found.add_argument("--output", type=Path, required=True, help="folder for report.html, results.json, tables.md and the CSV files")
    found.add_argument("--short", action="store_true", help="solve few points of each section")
    found.add_argument("--section", action="append", choices=SECTIONS, help="run only this section; can be repeated")
    found.add_argument("--bands", action="store_true", help="whether missed measurements are met within the band of the parameters, in ten minutes")
    found.add_argument("--pin", action="store_true", help=f"renew {results.PINNED.name}, the page {results.PAGE.name} of the book, and the numbers of goals in other pages")
    return found


def main(arguments: list[str] | None = None) -> int:
    """Solves, writes report, tables and verdicts, and prints what is missed."""
    options = parser().parse_args(arguments)
    options.bands |= options.pin
    if options.pin and (options.short or options.section):
        parser().error("--pin is for all sections with all points")
    provenance.begin("validate", arguments, "pushbelt_validation")
    begin = time.perf_counter()
    try:
        plan = Plan(options.short)
        run = run_all(options.fmu, plan, tuple(options.section or SECTIONS))
        misses = bands.deviations_of_misses(options.fmu, plan) if options.bands else None
    except (UnitError, InputFileError, OSError) as error:
        print(f"The validation failed: {error}", file=sys.stderr)
        return 1
    found = report.write(run, options.output, misses)
    for check in found["checks"]:
        if check["verdict"] == "missed":
            print(f"  missed, {check['part']}: {check['statement']}: {check['found']} ({check['goal']}); {check['by']}")
    if options.pin:
        results.pin(found)
        print(f"{results.PINNED}\n{results.PAGE}")
    print(f"{(options.output / 'report.html').resolve()} ({results.sentence(found)}; {time.perf_counter() - begin:.0f} s)")
    return 0 if found["verification"]["met"] == found["verification"]["goals"] else UNMET


if __name__ == "__main__":
    sys.exit(console.run(main))
