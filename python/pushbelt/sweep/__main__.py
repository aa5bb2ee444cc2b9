"""Solves for steady states over a grid or a design of points, and writes maps, results and a report.

An interrupted study continues from its finished points.
"""

import argparse
import shutil
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pushbelt import console
from pushbelt.cli.options import add_reading, add_sensitivities, add_short, add_study, numbers, program, reading, sensitivities
from pushbelt.errors import ArgumentError, require
from pushbelt.fmu.unit import belt_described
from pushbelt.study.tasks import variator

from .design import AXIS_OF, Design, Varied, crossed, listed, varied
from .study import AXES, CHUNK, DEFAULT, MEASURED, SHORT, Grid, Study, warnings_of


def parser() -> argparse.ArgumentParser:
    found = program("sweep", __doc__, "report, maps, results and finished points")
    add_short(found, f"{len(SHORT)} points instead of {len(DEFAULT)}")
    add_study(found)
    for name, axis in AXES.items():
        text = f"{axis.description}, {axis.unit}; comma-separated numbers"
        found.add_argument(f"--{name}", type=numbers, metavar="A,B,…", help=text)
    design = found.add_argument_group("designs of any parameters and inputs, in SI units, instead of the default grid")
    text = "a parameter or an input: A,B,C, or LOW:HIGH:N, or with --samples LOW:HIGH; can be repeated. All lists are combined"
    design.add_argument("--vary", action="append", default=[], metavar="NAME=VALUES", help=text)
    design.add_argument("--samples", type=int, metavar="N", help="points of a Latin hypercube over the ranges")
    design.add_argument("--seed", type=int, default=0, metavar="N", help="of the Latin hypercube [default: 0]")
    design.add_argument("--points", type=Path, metavar="FILE", help="list of points, text or .xlsx; names and units in the header")
    add_reading(found)
    text = "jobs of Slurm as workers: arguments of dask-jobqueue's SLURMCluster such as queue=normal walltime=02:00:00 cores=16, and jobs=4"
    found.add_argument("--slurm", metavar="OPTIONS", help=text)
    found.add_argument("--print-job", action="store_true", help="with --slurm: print the job script and end")
    add_sensitivities(found)
    found.add_argument("--chunk", type=int, metavar="N", help="points per task of a worker")
    return found


@console.program("sweep", "sweep")
def main(arguments: Sequence[str] | None = None) -> int | console.Done:
    options = parser().parse_args(arguments)
    require("sweep" if options.slurm is None else "slurm")
    if options.slurm is None and options.print_job:
        raise ArgumentError("--print-job requires the options of --slurm")
    if options.slurm is not None and (options.scheduler or options.workers):
        raise ArgumentError("--slurm excludes --scheduler and --workers")
    if options.slurm is None:
        return _run(_study(options), options, None)
    from pushbelt.study.cluster import slurm

    queue, jobs = slurm(options.slurm)
    with queue:
        if options.print_job:
            print(queue.job_script())
            return 0
        if shutil.which("sbatch") is None:
            raise ArgumentError("--slurm: sbatch is not on the path: this machine submits no jobs to Slurm")
        # Jobs that end are replaced.
        queue.adapt(minimum_jobs=jobs, maximum_jobs=jobs)
        return _run(_study(options), options, queue)


def _study(options: argparse.Namespace) -> Study:
    """A grid, or the design of --vary, --samples and --points. Axes given by their options are columns of it."""
    axes = {name: getattr(options, name) for name in AXES if getattr(options, name) is not None}
    if (options.vary or options.points or options.samples) and (options.measure or options.short):
        raise ArgumentError("--vary, --samples and --points exclude --short and --measure")
    if options.points and (options.vary or options.samples or axes):
        raise ArgumentError("--points has all columns: it excludes --vary, --samples and the axes")
    if options.points:
        variables = {variable.name: variable for variable in belt_described(options.fmu).modelVariables}
        grid: Grid | Design
        grid, remarks = listed(options.points, variables, reading(options))
        for remark in remarks:
            print(f"  {options.points}: {remark}")
    elif options.vary or options.samples:
        columns = [Varied(AXIS_OF.get(name, name), values) for name, values in axes.items()]
        grid = crossed([*columns, *map(varied, options.vary)], options.samples, options.seed)
    else:
        grid = replace(MEASURED if options.measure else SHORT if options.short else DEFAULT, **axes)
    parameters = variator(options.variator, options.ring, dict(options.set), grid.columns)
    return Study(options.fmu, parameters, grid, *sensitivities(options))


def _run(study: Study, options: argparse.Namespace, scheduler: Any) -> console.Done:
    # Imported here, so that the help needs no packages of the extras, and processes of a local cluster none of the report.
    from pushbelt.study.run import from_command_line

    from . import report
    from .results import table, write_parquet

    for warning in warnings_of(study):
        print(f"  warning: {warning}", file=sys.stderr)
    rows, effort = from_command_line(study, options, "points", options.chunk or CHUNK, scheduler)
    results = table(study, rows)
    write_parquet(results, options.output / "results.parquet")
    path = report.write(study, results, options.output, effort)
    failed = len(results) - results["reason"].null_count
    print(f"{path.resolve()} ({len(results)} points, {failed} without a steady state, {effort})")
    found = results.to_pandas()
    found.attrs["units"] = {one.name: one.metadata[b"unit"].decode() for one in results.schema}
    return console.Done(0 if failed < len(results) else 1, found)


if __name__ == "__main__":
    sys.exit(main())
