"""Reproduces the paper's examples: `python -m pushbelt_paper --fmu … --rings … --output target/paper [--short]`.

A full run whose verdicts differ from the pinned ones ends with 3."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from pushbelt import console, provenance
from pushbelt.fmu.unit import UnitError
from pushbelt.fmu.untrusted import InputFileError

from . import report, runs, times
from .rings import RingsError
from .statements import PINNED, compared, evaluate, pin


def main(arguments: list[str] | None = None) -> int:
    """Simulates, writes report and tables, and prints their paths."""
    parser = argparse.ArgumentParser(prog="pushbelt_paper", description=__doc__)
    parser.add_argument("--fmu", type=Path, required=True, help="the FMU to run")
    parser.add_argument("--rings", type=Path, required=True, help="the compiled example `paper_rings`")
    parser.add_argument("--output", type=Path, required=True, help="folder for report.html and the CSV files")
    chosen = parser.add_mutually_exclusive_group()
    chosen.add_argument("--short", action="store_true", help="run two load cases and coarse tests of rings")
    text = f"also run with swinging loads, and store all computing times in paper/{times.STORED.name} and the verdicts in paper/{PINNED.name}"
    chosen.add_argument("--store", action="store_true", help=text)
    options = parser.parse_args(arguments)
    provenance.begin("paper", arguments, "pushbelt_paper")
    begin = time.perf_counter()
    options.output.mkdir(parents=True, exist_ok=True)
    path = options.output / "report.html"
    plan = runs.SHORT if options.short else runs.FULL._replace(swinging=options.store)
    try:
        results = runs.run_all(options.fmu, options.rings, options.output, plan)
    except (UnitError, RingsError, InputFileError) as error:
        print(f"The simulation failed: {error}", file=sys.stderr)
        return 1
    if options.store:
        times.write(results.times, results.fmu_version)
    statements = evaluate(results)
    report.write_tables(results, statements, options.output)
    report.write_html(results, statements, path)
    print(f"{path.resolve()} ({time.perf_counter() - begin:.0f} s)")
    if options.store:
        pin(statements)
        return 0
    return 0 if options.short else compared(statements)


if __name__ == "__main__":
    sys.exit(console.run(main))
