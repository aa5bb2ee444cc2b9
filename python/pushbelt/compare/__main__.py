"""Compares two runs: `python -m pushbelt.compare A B --output target/compare`.

A and B are CSV files with a column `time`, or folders with such files, as written by demo and drive. If all values are equal, it writes no
report.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pushbelt import console, provenance
from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.untrusted import InputFileError, described

from . import report, runs


def main(arguments: list[str] | None = None) -> int:
    """Compares two runs, writes the report and prints its path. Runs that differ are not a failure of the program, equal ones need no report."""
    parser = argparse.ArgumentParser(prog="pushbelt.compare", description=__doc__)
    parser.add_argument("a", type=Path, metavar="A", help="result file, or folder of result files")
    parser.add_argument("b", type=Path, metavar="B", help="result file or folder to compare with A")
    parser.add_argument("--output", type=Path, required=True, help="folder for report.html and differences.csv")
    parser.add_argument("--fmu", type=Path, help="the FMU, for the units of its variables")
    parser.add_argument(
        "--variables", type=lambda text: tuple(text.split(",")), default=(), help="columns of the figures, in this order"
    )
    parser.add_argument(
        "--variator",
        default="bench168",
        help="parameter set of the runs, or its file, ….json; required to show the belt if both files have the columns profile.…",
    )
    options = parser.parse_args(arguments)
    provenance.begin("compare", arguments)
    try:
        pairs = runs.pairs(options.a, options.b)
        wanted = {name for pair in pairs for name in pair.names}
        unknown = [name for name in options.variables if name not in wanted]
        if unknown:
            raise runs.CompareError(f"no pair of runs has a column {', '.join(unknown)}")
        if all(pair.equal for pair in pairs):
            of = f"{len(pairs)} runs of the same name in " if options.a.is_dir() else ""
            print(f"{of}{options.a} and {options.b} are equal in all {len(wanted)} columns")
            return 0
        units = _units(options.fmu) if options.fmu else {}
        path = report.write(pairs, units, options.output, options.variables, parameter_set(options.variator))
    except (runs.CompareError, InputFileError, OSError) as error:
        print(f"The comparison failed: {error}", file=sys.stderr)
        return 1
    for pair in pairs:
        differing = pair.differing
        worst = f", most in {differing[0].name}: {100.0 * differing[0].share:.3g} % of its range" if differing else ""
        print(f"  {pair.name}: {len(differing)} of {len(pair.names)} columns differ{worst}")
    print(path.resolve())
    return 0


def _units(fmu: Path) -> dict[str, str]:
    description = described(fmu)
    return {variable.name: variable.unit for variable in description.modelVariables if variable.unit not in (None, "1")}


if __name__ == "__main__":
    sys.exit(console.run(main))
