"""Maps of the variator for vehicle simulations: `python -m pushbelt.maps --fmu target/PushbeltVariator.fmu --output target/maps`.

Solves steady states over clamping force, primary speed, ratio and torque utilisation, and measures capacity and shift rates. Writes
maps.nc, maps.npz, maps.json, maps.mat, maps_combitable.txt, maps_combitable.mat, maps.csv, torque_loss.csv and report.html. An
interrupted run continues from its finished lines.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from pushbelt import console
from pushbelt.arguments import add_cluster, numbers
from pushbelt.cluster import ClusterError
from pushbelt.map_data import Maps
from pushbelt.map_lines import Store
from pushbelt.map_plan import COARSE, SHORT, Grid, Plan, variator
from pushbelt.progress import progress_bar

from .run import Progress, solve

AXES = {
    "force": "secondary clamping forces, N",
    "speed": "primary speeds, rad/s",
    "ratio": "geometric ratios [default: evenly between the end stops]",
    "utilisation": "torque utilisations, negative where the secondary pulley drives",
}
LOAD = hasattr(os, "getloadavg")
"""Whether the system has a load average; Windows has none."""


def parser() -> argparse.ArgumentParser:
    """The command line."""
    found = argparse.ArgumentParser(
        prog="pushbelt.maps", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    found.add_argument("--fmu", type=Path, required=True, help="the FMU to run")
    found.add_argument("--output", type=Path, required=True, help="folder for maps, report and finished lines")
    found.add_argument("--short", action="store_true", help="a few lines instead of the default")
    add_cluster(found)
    for name, text in AXES.items():
        found.add_argument(f"--{name}", type=numbers, metavar="A,B,…", help=f"{text}; comma-separated")
    found.add_argument("--ratios", type=int, metavar="N", help="number of ratios between the end stops")
    found.add_argument("--beside", type=Path, metavar="MAPS", help="maps of another variator, maps.nc, for the report")
    found.add_argument("--anew", action="store_true", help="discard finished lines of an interrupted or finished run")
    found.add_argument("--measure", action="store_true", help="print the time of the maps; no finished line is used")
    return found


def main(arguments: list[str] | None = None) -> int:
    """Solves the maps, writes files and report, and prints their paths."""
    options = parser().parse_args(arguments)
    try:
        return _run(_plan(options), options)
    except (ClusterError, ValueError, OSError) as error:
        print(f"The maps failed: {error}", file=sys.stderr)
        return 1


def _plan(options: argparse.Namespace) -> Plan:
    grid: Grid = SHORT if options.short else COARSE
    given = {name: getattr(options, name) for name in (*AXES, "ratios") if getattr(options, name) is not None}
    if "ratios" in given and given["ratios"] < 2:
        raise ValueError("at least two ratios are needed")
    return Plan(options.fmu, variator(options.variator, options.model, dict(options.set)), replace(grid, **given))


def _run(plan: Plan, options: argparse.Namespace) -> int:
    # Imported here, because processes of a local cluster import this module and do not need the reports.
    from . import files, report

    beside = Maps.read(options.beside) if options.beside else None
    store = Store(options.output, plan)
    if options.anew or options.measure:
        store.clear()
    before, begin = len(store.rows()), time.perf_counter()
    load = os.getloadavg()[0] if LOAD else 0.0
    if before:
        print(f"  {before} of {len(plan.lines)} lines are already stored")
    try:
        with progress_bar(len(plan.lines), "lines of steady states", before) as bar:
            maps, processor_time = solve(
                plan, options.output, scheduler=options.scheduler, workers=options.workers, progress=_shown(bar)
            )
    except KeyboardInterrupt:
        done = len(store.rows())
        print(f"\n{done} of {len(plan.lines)} lines are finished; the same command continues from them.")
        return 130
    seconds = time.perf_counter() - begin
    paths = files.write(maps, options.output)
    path = report.write(maps, options.output, report.Effort(len(plan.lines), processor_time), beside)
    for written in paths:
        print(written.resolve())
    gaps = int((~maps.valid).sum())
    print(f"{path.resolve()} ({maps.valid.size} points, {gaps} without a steady state, {seconds:.0f} s)")
    if options.measure:
        processors = f", {os.cpu_count()} processors, load average before {load:.1f}" if LOAD else ""
        print(f"{len(plan.lines)} lines: {seconds:.1f} s, processor time {processor_time:.1f} s{processors}")
    return 0


def _shown(bar) -> Callable[[Progress], None]:
    """Shows progress in a bar."""

    def show(progress: Progress) -> None:
        bar.set_postfix_str(f"{progress.failed} failed, {progress.workers} workers", refresh=False)
        bar.update(progress.done - bar.n)

    return show


if __name__ == "__main__":
    sys.exit(console.run(main))
