"""Compares the FMU with theory and measurements: `python -m pushbelt.validate --fmu … --output target/validate
[--short]`.

Two processors take two to three minutes, with --short less than one.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from pushbelt import console, provenance
from pushbelt.cli.options import count
from pushbelt.fmu.unit import UnitError
from pushbelt.fmu.untrusted import InputFileError
from pushbelt.rig import options as reading_options

from .bench import Plan
from .runs import SECTIONS, run_all


def main(arguments: list[str] | None = None) -> int:
    """Solves, writes report and tables, and prints their paths.

    A missed goal is not a failure of the program.
    """
    parser = argparse.ArgumentParser(prog="pushbelt.validate", description=__doc__)
    parser.add_argument("--fmu", type=Path, required=True, help="the FMU to run")
    parser.add_argument(
        "--output", type=Path, required=True, help="folder for report.html, tables.md and the CSV files"
    )
    parser.add_argument("--short", action="store_true", help="solve few points of each section")
    parser.add_argument("--section", action="append", choices=SECTIONS, help="run only this section; can be repeated")
    parser.add_argument("--table", type=Path, help="score a parameter set on a rig's table, instead of the sections")
    parser.add_argument("--variator", default="bench168", help="with --table: a parameter set, or a file ….json")
    parser.add_argument("--workers", type=count, default=2, metavar="N", help="with --table: processes [default: 2]")
    reading_options.add(parser)
    options = parser.parse_args(arguments)
    provenance.begin("validate", arguments)
    if options.table is not None:
        return _hold_out(options)
    from . import report
    from .outcome import Verdict

    begin = time.perf_counter()
    try:
        results = run_all(options.fmu, Plan(options.short), tuple(options.section or SECTIONS))
    except (UnitError, InputFileError, OSError) as error:
        print(f"The validation failed: {error}", file=sys.stderr)
        return 1
    path = report.write(results, options.output)
    found = report.counts(results)
    for section in results.sections:
        for check in section.checks:
            if check.verdict is Verdict.MISSES:
                print(f"  misses: {check.statement}: {check.found} ({check.goal}); {check.by}")
    words = ", ".join(f"{verdict.value} {found[verdict]}" for verdict in Verdict)
    print(f"{path.resolve()} ({words}; {time.perf_counter() - begin:.0f} s)")
    return 0


def _hold_out(options: argparse.Namespace) -> int:
    """Scores of a parameter set on a table."""
    from . import holdout

    begin = time.perf_counter()
    try:
        held = holdout.hold_out(
            options.fmu, options.table, options.variator, reading_options.reading(options), reading_options.oil(options), options.workers
        )  # fmt: skip
    except (ValueError, UnitError, OSError) as error:
        print(f"The validation failed: {error}", file=sys.stderr)
        return 1
    path = holdout.write(held, options.output)
    for score in held.scores():
        print(f"  {holdout.sentence(score)}")
    print(f"{path.resolve()} ({time.perf_counter() - begin:.0f} s)")
    return 0


if __name__ == "__main__":
    sys.exit(console.run(main))
