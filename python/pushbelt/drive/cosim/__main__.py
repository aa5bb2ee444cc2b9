"""Couples FMUs: `python -m pushbelt.drive.cosim --fmu target/PushbeltVariator.fmu --output target/drive [--short]`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pushbelt import console, provenance
from pushbelt.fmu.unit import UnitError

from . import masters, report, study


def main(arguments: list[str] | None = None) -> int:
    """Builds the package, runs it in the masters, writes the results and prints their paths."""
    parser = argparse.ArgumentParser(prog="pushbelt.drive.cosim", description=__doc__)
    parser.add_argument("--fmu", type=Path, required=True, help="the variator's FMU")
    parser.add_argument("--output", type=Path, required=True, help="folder for drive.ssp, its FMUs and coupling.html")
    parser.add_argument("--short", action="store_true", help="5 s of the cycle instead of 20")
    options = parser.parse_args(arguments)
    provenance.begin("drive", arguments, "pushbelt.drive.cosim")
    try:
        result = study.run(options.fmu, study.SHORT if options.short else study.FULL, options.output)
    except (UnitError, ValueError) as error:
        print(f"The co-simulation failed: {error}", file=sys.stderr)
        return 1
    for refusal in result.refusals:
        print(f"skipped: {refusal}", file=sys.stderr)
    print(report.text(result))
    path = options.output / "coupling.html"
    report.write_html(result, path)
    print(f"{(options.output / study.PACKAGE).resolve()}\n{path.resolve()}")
    return 0


if __name__ == "__main__":
    masters.leave(console.run(main))
