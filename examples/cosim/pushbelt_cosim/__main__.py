"""Builds a co-simulation of FMUs, couples them in other importers, and compares."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from pushbelt import console, provenance

from . import importers, report, study


@console.program("drive --cosim", "reports")
def main(arguments: Sequence[str] | None = None) -> int:
    """Builds the package, runs it in the importers, writes the results and prints their paths."""
    parser = argparse.ArgumentParser(prog="cargo fmu drive --cosim", description=__doc__)
    parser.add_argument("--fmu", type=Path, required=True, help="the variator's FMU")
    parser.add_argument("--output", type=Path, required=True, help="folder for drive.ssp, its FMUs and coupling.html")
    parser.add_argument("--short", action="store_true", help="a first look: 5 s of the cycle instead of 20")
    options = parser.parse_args(arguments)
    provenance.begin("coupling", arguments, "pushbelt_cosim")
    result = study.run(options.fmu, study.SHORT if options.short else study.FULL, options.output)
    for refusal in result.refusals:
        print(f"skipped: {refusal}", file=sys.stderr)
    print(report.text(result))
    path = options.output / "coupling.html"
    report.write_html(result, path)
    print(f"{(options.output / study.PACKAGE).resolve()}\n{path.resolve()}")
    return 0


if __name__ == "__main__":
    importers.leave(main())
