"""Runs a study: `python -m pushbelt.sweep --fmu target/PushbeltVariator.fmu --output target/sweep [--short]`."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from pushbelt import console, provenance
from pushbelt.arguments import add_cluster, numbers
from pushbelt.cluster import ClusterError
from pushbelt.fmu.untrusted import described
from pushbelt.progress import progress_bar
from pushbelt.rig.options import add_reading, reading
from pushbelt.slurm import HELP, Slurm

from . import measure, plausible
from .design import AXIS_OF, Design, Varied, crossed, listed, varied
from .run import Progress, sweep
from .store import Store, write_parquet
from .study import AXES, DEFAULT, SHORT, Study, variator


def parser() -> argparse.ArgumentParser:
    """The command line."""
    found = argparse.ArgumentParser(prog="pushbelt.sweep", description=__doc__)
    found.add_argument("--fmu", type=Path, required=True, help="the FMU to run")
    found.add_argument(
        "--output", type=Path, required=True, help="folder for report, maps, results and finished points"
    )
    found.add_argument("--short", action="store_true", help=f"{len(SHORT)} points instead of {len(DEFAULT)}")
    add_cluster(found)
    for name, axis in AXES.items():
        text = f"{axis.description}, {axis.unit}; comma-separated numbers"
        found.add_argument(f"--{name}", type=numbers, metavar="A,B,…", help=text)
    design = found.add_argument_group("designs of any parameters and inputs, in SI units, instead of the default grid")
    design.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="NAME=VALUES",
        help="a parameter or an input: A,B,C, or LOW:HIGH:N, or with --samples LOW:HIGH; can be repeated. All lists are combined",
    )
    design.add_argument("--samples", type=int, metavar="N", help="points of a Latin hypercube over the ranges")
    design.add_argument("--seed", type=int, default=0, metavar="N", help="of the Latin hypercube [default: 0]")
    design.add_argument("--points", type=Path, metavar="FILE", help="list of points, text or .xlsx; names and units in the header")
    add_reading(found)
    found.add_argument("--slurm", metavar="OPTIONS", help=f"jobs of Slurm as workers: {HELP}".replace("%", "%%"))
    found.add_argument("--print-job", action="store_true", help="with --slurm: print the job script and end")
    found.add_argument("--chunk", type=int, metavar="N", help="points per task of a worker")
    found.add_argument("--anew", action="store_true", help="discard stored points of an interrupted or finished run")
    found.add_argument("--measure", action="store_true", help="only measure points per second")
    return found


def main(arguments: list[str] | None = None) -> int:
    """Runs a study, writes results, maps and report, and prints their paths."""
    options = parser().parse_args(arguments)
    provenance.begin("sweep", arguments)
    try:
        slurm = Slurm.read(options.slurm) if options.slurm is not None else None
        if options.print_job:
            if slurm is None:
                raise ValueError("--print-job requires the options of --slurm")
            print(slurm.script())
            return 0
        if slurm is not None and (options.scheduler or options.workers):
            raise ValueError("--slurm excludes --scheduler and --workers")
        if options.vary or options.points or options.samples:
            if options.measure or options.short:
                raise ValueError("--vary, --samples and --points exclude --short and --measure")
            return _run(_design_study(options), options, slurm)
        grid = measure.GRID if options.measure else SHORT if options.short else DEFAULT
        grid = replace(grid, **{name: getattr(options, name) for name in AXES if getattr(options, name) is not None})
        study = Study(options.fmu, variator(options.variator, options.model, dict(options.set)), grid)
        if options.measure:
            print(measure.table(study, options.scheduler, options.workers))
            return 0
        return _run(study, options, slurm)
    except (ClusterError, ValueError, OSError) as error:
        print(f"The study failed: {error}", file=sys.stderr)
        return 1
    except ModuleNotFoundError as error:
        if error.name != "dask_jobqueue":
            raise
        print("--slurm needs dask-jobqueue: pip install 'pushbelt[slurm]'", file=sys.stderr)
        return 1


def _design_study(options: argparse.Namespace) -> Study:
    """The study of --vary, --samples and --points. Axes given by their options are columns of it."""
    variables = {variable.name: variable for variable in described(options.fmu).modelVariables}
    axes = [
        Varied(AXIS_OF.get(name, name), getattr(options, name)) for name in AXES if getattr(options, name) is not None
    ]
    if options.points:
        if options.vary or options.samples or axes:
            raise ValueError("--points has all columns: it excludes --vary, --samples and the axes")
        design, remarks = listed(options.points, variables, reading(options))
        for remark in remarks:
            print(f"  {options.points}: {remark}")
    else:
        design = crossed([*axes, *map(varied, options.vary)], options.samples, options.seed)
    return Study(options.fmu, variator(options.variator, options.model, dict(options.set), design.columns), design)


def _run(study: Study, options: argparse.Namespace, slurm: Slurm | None = None) -> int:
    for warning in plausible.check(study):
        print(f"  warning: {warning}", file=sys.stderr)
    # Imported here, because processes of a local cluster import this module and do not need matplotlib.
    from . import design_report, report

    store = Store(options.output, study)
    if options.anew:
        store.clear()
    before, begin = store.count(), time.perf_counter()
    if before:
        print(f"  {before} of {len(study.grid)} points are already stored")
    try:
        with progress_bar(len(study.grid), "steady states", before) as bar:
            table = sweep(
                study,
                options.output,
                scheduler=options.scheduler,
                workers=options.workers,
                slurm=slurm,
                chunk=options.chunk,
                progress=_shown(bar),
            )
    except KeyboardInterrupt:
        print(f"\n{store.count()} of {len(study.grid)} points are finished; the same command continues from them.")
        return 130
    seconds = time.perf_counter() - begin
    write_parquet(table, options.output / "results.parquet")
    effort = report.Effort(len(study.grid) - before, seconds)
    write = design_report.write if isinstance(study.grid, Design) else report.write
    path = write(study, table, options.output, effort)
    failed = len(table) - table["reason"].null_count
    print(f"{path.resolve()} ({len(table)} points, {failed} without a steady state, {seconds:.0f} s)")
    return 0 if failed < len(table) else 1


def _shown(bar) -> Callable[[Progress], None]:
    """Shows progress in a bar."""

    def show(progress: Progress) -> None:
        bar.set_postfix_str(f"{progress.failed} failed, {progress.workers} workers", refresh=False)
        bar.update(progress.done - bar.n)

    return show


if __name__ == "__main__":
    sys.exit(console.run(main))
