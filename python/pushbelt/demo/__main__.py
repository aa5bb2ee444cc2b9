"""Runs the demo: `python -m pushbelt.demo --fmu target/PushbeltVariator.fmu --output target/demo [--short]`."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from pushbelt import console, provenance
from pushbelt.fmu.load_cases import NotFoundError
from pushbelt.fmu.unit import UnitError
from pushbelt.fmu.untrusted import InputFileError

from . import events, report, simulate


def main(arguments: list[str] | None = None) -> int:
    """Simulates, writes the report and prints its path."""
    parser = argparse.ArgumentParser(prog="pushbelt.demo", description=__doc__)
    parser.add_argument("--fmu", type=Path, required=True, help="the FMU to run")
    parser.add_argument("--output", type=Path, required=True, help="folder for report.html, results.csv and cases.csv")
    parser.add_argument("--short", action="store_true", help="run three load cases and 1 s of the manoeuvre")
    parser.add_argument("--variator", default=simulate.VARIATOR, help="name of a parameter set, or a file ….json")
    options = parser.parse_args(arguments)
    provenance.begin("demo", arguments)
    begin = time.perf_counter()
    try:
        results = simulate.run_all(options.fmu, simulate.SHORT if options.short else simulate.FULL, options.variator)
    except (UnitError, NotFoundError, InputFileError, OSError) as error:
        print(f"The simulation failed: {error}", file=sys.stderr)
        return 1
    options.output.mkdir(parents=True, exist_ok=True)
    report.write_trace(results, options.output / "results.csv")
    report.write_cases(results, options.output / "cases.csv")
    path = options.output / "report.html"
    report.write_html(results, path)
    missing = [event for event in events.detect(results.manoeuvre.trace) if not event.occurred]
    for event in missing:
        print(f"  missing in the manoeuvre: {event.name}: {event.evidence}", file=sys.stderr)
    print(f"{path.resolve()} ({time.perf_counter() - begin:.0f} s)")
    return 0


if __name__ == "__main__":
    sys.exit(console.run(main))
