"""Lays two runs over each other: `python -m pushbelt.compare A B --output target/compare`.

A and B are CSV files with a column `time`, or folders that hold such files, as demo and drive write them.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.untrusted import InputFileError, described

from . import report, runs


def main(arguments: list[str] | None = None) -> int:
    """Compares, writes the report and says where it is. That the runs differ is a result, no failure."""
    parser = argparse.ArgumentParser(prog="pushbelt.compare", description=__doc__)
    parser.add_argument("a", type=Path, metavar="A", help="a result file, or a folder of them")
    parser.add_argument("b", type=Path, metavar="B", help="what it is compared with")
    parser.add_argument("--output", type=Path, required=True, help="folder for report.html and differences.csv")
    parser.add_argument("--fmu", type=Path, help="the FMU, for the units of its variables")
    parser.add_argument(
        "--variables", type=lambda text: tuple(text.split(",")), default=(), help="draw these, in this order"
    )
    parser.add_argument(
        "--variator",
        default="bench168",
        help="parameter set of the runs, or its file, ….json: for the belt, where both files have the columns profile.…",
    )
    options = parser.parse_args(arguments)
    try:
        pairs = runs.pairs(options.a, options.b)
        wanted = {name for pair in pairs for name in pair.names}
        unknown = [name for name in options.variables if name not in wanted]
        if unknown:
            raise runs.CompareError(f"no pair of runs has a column {', '.join(unknown)}")
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
    sys.exit(main())
