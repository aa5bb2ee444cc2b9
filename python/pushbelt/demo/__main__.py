"""Simulates published load cases and a manoeuvre with the FMU, and writes a report."""

import sys
import time
from collections.abc import Sequence

from pushbelt import console
from pushbelt.cli.options import add_short, add_variator, program
from pushbelt.errors import require


@console.program("demo", "reports")
def main(arguments: Sequence[str] | None = None) -> int:
    parser = program("demo", __doc__, "report.html, results.csv and cases.csv")
    add_short(parser, "three load cases and 1 s of the manoeuvre")
    add_variator(parser)
    options = parser.parse_args(arguments)
    require("reports")  # The help needs no packages of the extras.
    from . import report, simulate

    begin = time.perf_counter()
    results = simulate.run_all(options.fmu, options.variator, short=options.short)
    report.write_trace(results, options.output / "results.csv")
    report.write_cases(results, options.output / "cases.csv")
    path = report.write_html(results, options.output / "report.html")
    print(f"{path.resolve()} ({time.perf_counter() - begin:.0f} s)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
