"""Compares two runs, or two calibrations, and writes a report and the differences.

A and B are CSV files with a column `time`, or folders with such files, as written by demo and drive; or parameter sets ….json, as written by
calibrate, whose differences are compared with their 95 % intervals. If all values are equal, it writes no report.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

from pushbelt import console
from pushbelt.cli.options import add_variator, program
from pushbelt.errors import ArgumentError, require
from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.untrusted import described

from . import runs


@console.program("compare", "reports")
def main(arguments: Sequence[str] | None = None) -> int:
    """Compares two runs, writes the report and prints its path. Runs that differ are not a failure of the program, equal ones need no report."""
    parser = program("compare", __doc__, "report.html and differences.csv", "the FMU, for its variables; it does not run", needed=False)
    parser.add_argument("a", type=Path, metavar="A", help="result file, folder of result files, or parameter set")
    parser.add_argument("b", type=Path, metavar="B", help="what is compared with A")
    columns = "columns of the figures, in this order"
    parser.add_argument("--variables", type=lambda text: tuple(text.split(",")), default=(), metavar="A,B,…", help=columns)
    add_variator(parser)
    options = parser.parse_args(arguments)
    if ".json" in (options.a.suffix, options.b.suffix):
        return _sets(options.a, options.b, options.output)
    variables = described(options.fmu).modelVariables if options.fmu else ()
    pairs = runs.pairs(options.a, options.b, {one.name: one.unit for one in variables if one.unit})
    wanted = {name for pair in pairs for name in pair.names}
    unknown = [name for name in options.variables if name not in wanted]
    if unknown:
        raise ArgumentError(f"no pair of runs has a column {', '.join(unknown)}")
    if all(pair.equal for pair in pairs):
        of = f"{len(pairs)} runs of the same name in " if options.a.is_dir() else ""
        print(f"{of}{options.a} and {options.b} are equal in all {len(wanted)} columns")
        return 0
    require("reports")  # The help needs no packages of the extras.
    from . import report

    path = report.write(pairs, options.output, options.variables, parameter_set(options.variator))
    for pair in pairs:
        differing = pair.differing
        worst = f", most in {differing[0].name}: {100.0 * differing[0].share:.3g} % of its range" if differing else ""
        print(f"  {pair.name}: {len(differing)} of {len(pair.names)} columns differ{worst}")
    print(path.resolve())
    return 0


def _sets(a: Path, b: Path, folder: Path) -> int:
    """Compares two parameter sets."""
    require("reports")
    from . import report, sets

    found = sets.differences(a, b)
    if not any(row.size for row in found):
        print(f"{a} and {b} are equal in all {len(found)} common parameters")
        return 0
    path = report.write_sets(found, (a, b), folder)
    print(f"{sets.verdict(found)}\n{path.resolve()}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
