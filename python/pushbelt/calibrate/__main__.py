"""Fits parameters of the FMU to a table of measured steady points.

The table is CSV as rigs and spreadsheets write it, or .xlsx, with one row per point: ratio, speed, torque and force, and any of thrust ratio, slip,
efficiency, forces, torques and shift rates. --template FILE writes one with the meaning of each column; --check prints what is understood.
With the columns series and time, each series is a recorded shift and its rows are the samples.

A solution takes about 0.01 s of processor time per point, the first one and one without a state near by 0.03 s. A fit takes about eleven
solutions per point and parameter, and ten more. A speed ratio takes 1.2 times as long, a shift rate about fifteen times.

--plan N writes the N points that narrow the intervals of the fitted parameters most to plan.csv, a table to fill in. They add to TABLE, if there is
one, at the parameters of --variator. Their limits are those of TABLE or of --within.

--hold-out SET scores a parameter set on the table instead, beside that of --variator; --set holds for both.

Exit codes: 0 the model fits, 1 an error, 3 it does not fit (all files are written).
"""

import argparse
import math
import re
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from pushbelt import console
from pushbelt.cli.options import add_reading, add_set, add_variator, count, program, reading
from pushbelt.errors import require
from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.files import default_fmu
from pushbelt.fmu.start_values import checked
from pushbelt.fmu.unit import belt_described
from pushbelt.tables import columns, points
from pushbelt.tables.sheet import TableError, same

from . import parameters

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
SUSPECT = 1.5  # Root mean square of the residuals, in standard deviations, above which a fit is bad if a cause halves it
MISFIT = 3  # Exit code of a bad fit
PLANNED = 0.012  # Processor time of a steady state of a planned point, s
SOLUTION = 0.008  # Processor time of a steady state near another one, s
SHIFT_COST, SPEED_RATIO_COST, SAMPLE_COST = 15.0, 1.2, 4.0
"""Cost of a shift rate, of the search for a speed ratio, and of a sample of a recorded shift, in steady states."""


def wanted(text: str) -> dict[str, float | None]:
    """Comma-separated names, each with or without `=value`."""
    return {name: float(value) if sign else None for name, sign, value in (p.partition("=") for p in text.split(","))}


def limits(text: str) -> tuple[str, tuple[float, float]]:
    """`name=low:high`."""
    found = re.fullmatch(r"([^=]+)=(.*?):(.*)", text)
    if not found:
        raise argparse.ArgumentTypeError(f"{text} is not of the form name=low:high")
    return found[1], (float(found[2]), float(found[3]))


def prior(text: str) -> tuple[str, tuple[float, float]]:
    """`name=value±sd`."""
    found = re.fullmatch(rf"(.+?)=\s*({NUMBER})\s*(?:±|\+/?-)\s*({NUMBER})\s*", text)
    if not found or not 0.0 < float(found[3]) < math.inf:
        raise argparse.ArgumentTypeError(f"{text} is not of the form name=value±sd, with sd above 0")
    return found[1], (float(found[2]), float(found[3]))


def accuracy(text: str) -> tuple[str, str]:
    """`name=number` or `name=number%`."""
    found = re.fullmatch(rf"(.+?)=\s*({NUMBER})\s*(%?)\s*", text)
    if not found or not 0.0 < float(found[2]) < math.inf:
        raise argparse.ArgumentTypeError(f"{text} is not of the form name=sd or name=sd%, with sd above 0")
    return found[1], found[2] + found[3]


def parser() -> argparse.ArgumentParser:
    found = program("calibrate", __doc__, "report.html, parameters.json and residuals.csv", needed=False)
    found.add_argument("table", type=Path, nargs="?", metavar="TABLE", help="the measured points")
    found.add_argument("--check", action="store_true", help="only print what is understood of the table, without a fit")
    found.add_argument("--hold-out", metavar="SET", help="no fit: score a parameter set on a table that it was not fitted to, a name or a file ….json")
    found.add_argument("--plan", type=count, metavar="N", help="no fit: plan N points to be measured next; TABLE may be absent")
    text = "limits of the planned points, SI: ratio.geometric, primary.speed, primary.torque or secondary.clampingForce"
    found.add_argument("--within", type=limits, action="append", default=[], metavar="NAME=LOW:HIGH", help=text)
    found.add_argument("--template", type=Path, metavar="FILE", help="write an example table and exit")
    default = ",".join(parameters.DEFAULT)
    found.add_argument("--fit", type=wanted, default=dict.fromkeys(parameters.DEFAULT), metavar="NAME[=START],…",
                       help=f"fitted parameters, any real ones of the FMU; tiltStiffness means that of both pulleys [default: {default}]")
    found.add_argument("--bounds", type=limits, action="append", default=[], metavar="NAME=LOW:HIGH", help="narrower bounds than the FMU's")
    known = "what is known of a fitted parameter without the table, value and standard deviation; also VALUE+-SD"
    found.add_argument("--prior", type=prior, action="append", default=[], metavar="NAME=VALUE±SD", help=known)  # fmt: skip
    text = "fit a friction.pulley that is a linear function of a column, such as T_oil, about its mean"
    found.add_argument("--friction-over", metavar="COLUMN", help=text)
    text = "fit a friction.pulley of each group of points with the same cell in a column, such as an oil or a day"
    found.add_argument("--friction-by", metavar="COLUMN", help=text)
    found.add_argument("--accept-misfit", action="store_true", help="exit code 0 also for a fit that is bad, instead of 3")
    add_variator(found)
    add_set(found, "fixed value of a parameter")
    found.add_argument("--workers", type=count, default=2, metavar="N", help="processes [default: 2]")
    text = "take values that are not plausible on a variator as they are written"
    group = add_reading(found)
    group.add_argument("--as-written", action="store_true", help=text)
    text = "standard deviation of a column without .sd, in its unit or as a share of the value, such as T_P=0.3 or F_P=0.5%%; can be repeated"
    group.add_argument("--accuracy", type=accuracy, action="append", default=[], metavar="NAME=SD", help=text)
    return found


@console.program("calibrate", "tables")
def main(arguments: Sequence[str] | None = None) -> int | console.Done:
    options = parser().parse_args(arguments)
    if options.template is not None:
        options.template.write_text(columns.template(), encoding="utf-8")
        print(options.template.resolve())
        return 0
    if options.table is None and options.plan is not None:
        return _run(options, None)
    if options.table is None:
        raise TableError("a table is required; --template FILE writes an example")
    changes = _changes(options)
    sets = dict.fromkeys(name for name in (options.hold_out, options.variator) if name is not None)
    given = {name: {**parameter_set(name), **changes} for name in sets}
    try:
        # Cylinders are those of the first set and of --set; the geometry is that of `bench168`, the FMU's default, unless they have one.
        own = replace(reading(options), accuracy=dict(options.accuracy))
        rig = points.read(options.table, own, {**parameter_set("bench168"), **next(iter(given.values()))})
    except TableError as error:
        # The faults come after what is understood in spite of them.
        if options.check and error.found is not None:
            print("\n".join(points.described(error.found)))
        raise
    if options.hold_out is not None and not options.check:
        require("tables")  # The help needs no packages of the extras.
        from . import report

        begin = time.perf_counter()
        belt_described(fmu := options.fmu or default_fmu())
        for one in report.hold_out(fmu, rig, given, options.workers, options.output):
            lost = f", {one.lost} values without a steady state" if one.lost else ""
            size, bias = report.short(one.relative), report.short(one.bias)
            print(f"  {one.quantity}, {one.variator}: {size} standard deviations, bias {bias}{lost}")
        print(f"{(options.output / 'report.html').resolve()} ({time.perf_counter() - begin:.0f} s)")
        return 0
    rig = once(rig)
    if not options.check:
        return _run(options, rig)
    print("\n".join([*points.understood(rig), f"  {_effort(rig, len(options.fit), options.workers)}"]))
    return 0


def _changes(options: argparse.Namespace) -> dict[str, float]:
    """Values of --set. Without an FMU, which --check does not need, only numbers."""
    changes = dict(options.set)
    if options.fmu is not None:
        return checked({variable.name: variable for variable in belt_described(options.fmu).modelVariables}, changes, {"parameter"})
    return {name: float(value) for name, value in changes.items() if re.fullmatch(NUMBER, value)}


def once(rig: points.Rig) -> points.Rig:
    """A table without rows that repeat all values of an earlier one, and with a remark about them."""
    first: dict[points.Point, points.Point] = {}
    repeated = []
    for point in rig.points:
        earlier = first.setdefault(replace(point, line=0, name=""), point)
        if earlier is not point:
            repeated.append(f"{point.line} (as {earlier.line})")
    if repeated:
        rig.sheet.remarks.append(f"{len(repeated)} rows repeat all values of an earlier one and count once: lines {', '.join(repeated)}")
    return replace(rig, points=list(first.values()))


def _effort(rig: points.Rig, parameters: int, workers: int) -> str:
    """Number of points, and the time that a fit takes."""
    seconds = SOLUTION * solutions(rig, parameters) / workers
    text = f"{seconds:.0f} s" if seconds < 100.0 else f"{seconds / 60.0:.0f} min" if seconds < 6000.0 else f"{seconds / 3600.0:.0f} h"
    return f"{len(rig.points)} points: a fit of {parameters} parameters takes about {text} on {workers} processors"


def solutions(rig: points.Rig, parameters: int) -> float:
    """Number of steady states in a fit, or their cost: six of derivatives and five of trials for each parameter, and those of the tests of residuals."""
    return (10 + 11 * parameters) * sum(
        SAMPLE_COST * len(point.measured) if point.samples
        else SHIFT_COST if point.shifting else SPEED_RATIO_COST if point.ratio is None else 1.0
        for point in rig.points
    )  # fmt: skip


def _run(options: argparse.Namespace, rig: points.Rig | None) -> console.Done:
    require("tables")  # The help needs no packages of the extras.
    from . import friction, misfit, model, report
    from .causes import with_causes
    from .fit import fit

    fmu = options.fmu or default_fmu()
    description = belt_described(fmu)
    variables = {variable.name: variable for variable in description.modelVariables}
    base = checked(variables, {**parameter_set(options.variator), **dict(options.set)}, {"parameter"})
    chosen = parameters.choose(options.fit, dict(options.bounds), variables, base, dict(options.prior))
    if rig is None or options.plan is not None:
        return _plan(options, fmu, base, chosen, rig.points if rig else [])
    laws = [friction.over_column(rig, options.friction_over, chosen)] if options.friction_over else []
    groups = friction.by_group(rig, options.friction_by, chosen) if options.friction_by else None
    laws += groups.causes if groups else []
    used = [name for name in (options.friction_over, options.friction_by) if name]
    rig.sheet.ignored = [title for title in rig.sheet.ignored if not any(same(name, title) for name in used)]
    chosen += [law.size for law in laws]
    begin = time.perf_counter()
    warnings = [remark for remark in rig.sheet.remarks if remark.startswith("warning")]
    print("\n".join([*warnings, _effort(rig, len(chosen), options.workers)]), file=sys.stderr)
    with model.opened(fmu, base, rig.points, options.workers, solutions(rig, len(chosen))) as opened:
        fitted = with_causes(opened, laws)
        found = fit(fitted, chosen)
        trends = [] if rig.recorded else misfit.trends(rig, fitted, found)
        certain = [] if rig.recorded else misfit.ratio_of_speeds(rig, found)
        causes = [] if rig.recorded or certain else misfit.search(rig, fitted, chosen, found)
    said = certain or [misfit.sentence(rig, found, cause) for cause in causes]
    if not found.misfit and causes and found.rms[1] > SUSPECT and causes[0].fit.rms[1] < 0.5 * found.rms[1]:
        found = found._replace(misfit=f"an error of the table leaves {causes[0].fit.rms[1]:.3g} standard deviations in place of {found.rms[1]:.3g}")
    holding = [*filter(None, (law.advice for law in laws)), *(friction.compared(groups, found) if groups else [])]
    about = (time.perf_counter() - begin, points.notes(rig.sheet), said, trends, holding)
    results = report.Results(options.table.name, description.version or "", options.variator, base, fitted, found, *about)
    report.write_residuals(results, options.output / "residuals.csv")
    report.write_parameters(results, options.output / "parameters.json")
    path = report.write_html(results, options.output / "report.html")
    if found.misfit:
        print(f"does not fit: {found.misfit}")
    if left_out := report.outliers(results):
        print(left_out)
    for start, text in zip(["possible cause", *["or as likely"] * len(said)], said, strict=False):
        print(f"{start}: {text}")
    for one in results.trends[:1]:
        print(f"trend: {misfit.trend(one)}")
    for line in (*results.notes, *results.laws, *map(report.sentence, found.estimates)):
        print(f"  {line}")
    for lost in results.lost.itertuples():
        print(f"  no steady state, not used: {lost.name}: {lost.reason}", file=sys.stderr)
    print(f"{path.resolve()} ({time.perf_counter() - begin:.0f} s)")
    return console.Done(0 if not found.misfit or options.accept_misfit else MISFIT, results)


def _plan(options: argparse.Namespace, fmu: Path, base: dict[str, float], chosen: list[parameters.Parameter], table: list[points.Point]) -> console.Done:
    """Plans points, writes them and prints the expected intervals."""
    from . import model, plan

    values = {**parameter_set("bench168"), **base}
    places = plan.candidates(plan.limits(dict(options.within), values, table), values, table)
    solutions = (1 + 2 * len(chosen)) * (len(table) + len(places))
    seconds = solutions * PLANNED / options.workers
    print(f"{len(places)} places, {len(chosen)} parameters: about {seconds:.0f} s on {options.workers} processors", file=sys.stderr)
    with model.opened(fmu, base, [*table, *places], options.workers, solutions) as opened:
        found = plan.plan(opened, len(table), chosen, values, options.plan)
    for line in plan.write(found, path := options.output / "plan.csv"):
        print(f"  {line}")
    print(path.resolve())
    return console.Done(0, found)


if __name__ == "__main__":
    sys.exit(main())
