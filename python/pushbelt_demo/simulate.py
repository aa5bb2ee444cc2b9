"""Runs all simulations of the demo, side by side in processes, with a progress bar."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from pathlib import Path
from typing import Any

from tqdm import tqdm

from . import load_cases, manoeuvre, reference_case
from .data import load_cases as all_load_cases
from .data import manoeuvre_inputs, parameter_set
from .results import DemoResults, LoadCase, LoadCaseResult, ManoeuvreResult, ReferenceResult
from .unit import Archive

VARIATOR = "bench168"
"""Parameter set of the load cases and the manoeuvre."""

_ticks: Any = None
"""In a worker: where it reports progress, in hundredths of the manoeuvre."""


def _prepare_worker(ticks: Any) -> None:
    global _ticks
    _ticks = ticks


def _run_manoeuvre(archive: Archive, duration: float) -> ManoeuvreResult:
    done = 0.0
    told = 0

    def progress(seconds: float) -> None:
        nonlocal done, told
        done += seconds
        due = int(100.0 * done / duration + 1e-9)
        if due > told:
            _ticks.put(due - told)
            told = due

    return manoeuvre.run(archive, parameter_set(VARIATOR), manoeuvre_inputs(), progress, duration)


def _run_case(archive: Archive, case: LoadCase) -> LoadCaseResult:
    result = load_cases.run(archive, parameter_set(VARIATOR), case)
    _ticks.put(_CASE_TICKS)
    return result


def _run_reference(archive: Archive) -> ReferenceResult:
    return reference_case.run(archive, lambda: _ticks.put(_CASE_TICKS))


_CASE_TICKS = 5
_MANOEUVRE_TICKS = 100


def run_all(fmu: Path) -> DemoResults:
    """Runs everything with an FMU."""
    archive = Archive.unpack(fmu)
    try:
        return _run_all(archive)
    finally:
        archive.remove()


def _run_all(archive: Archive) -> DemoResults:
    parameters = parameter_set(VARIATOR)
    cases = all_load_cases(parameters)
    duration = float(manoeuvre_inputs().time[-1])
    context = multiprocessing.get_context("spawn")
    ticks = context.Queue()
    workers = max(1, min(os.cpu_count() or 1, 4))
    total = _MANOEUVRE_TICKS + _CASE_TICKS * (len(cases) + reference_case.SOLVES)
    with (
        tqdm(
            total=total,
            disable=None,
            desc="load cases and manoeuvre",
            bar_format="  {desc} {bar:32} {percentage:3.0f} % [{elapsed}<{remaining}]",
        ) as bar,
        ProcessPoolExecutor(workers, context, _prepare_worker, (ticks,)) as pool,
    ):
        # The manoeuvre takes longest and can't be divided: it starts first.
        run = pool.submit(_run_manoeuvre, archive, duration)
        reference = pool.submit(_run_reference, archive)
        states = [pool.submit(_run_case, archive, case) for case in cases]
        try:
            _follow([run, reference, *states], ticks, bar.update)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return DemoResults(
        fmu_version=archive.description.version or "",
        cases=tuple(state.result() for state in states),
        reference=reference.result(),
        manoeuvre=run.result(),
        parameters=parameters,
    )


def _follow(futures: list[Future[Any]], ticks: Any, update: Callable[[int], object]) -> None:
    """Waits for all, passing progress on; the first failure is raised at once."""
    waiting = set(futures)
    while waiting:
        finished, waiting = wait(waiting, timeout=0.1, return_when=FIRST_COMPLETED)
        while not ticks.empty():
            update(ticks.get())
        for future in finished:
            future.result()
    while not ticks.empty():
        update(ticks.get())
