"""Influence of the communication step: importers compared with the loop through fmpy, for successively halved steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from pushbelt.drive import simulate
from pushbelt.drive.cycle import wltc_class_3b
from pushbelt.drive.measure import measure
from pushbelt.drive.thrust_map import ThrustMap
from pushbelt.drive.vehicle import demo_car
from pushbelt.fmu.geometry import Array
from pushbelt.fmu.unit import Archive, UnitError
from pushbelt.maps.data import Maps
from pushbelt.report.side_by_side import progress_bar, tick, worker_pool

from . import fmus, package
from .importers import IMPORTERS, Progress

SIGNALS = ("ratio.geometric", "primary.speed", "secondary.speed", "secondary.axialForce")
"""FMU variables that are compared."""


@dataclass(frozen=True)
class Plan:
    """Configuration of the study."""

    section: tuple[float, float]
    """Section of the WLTC, s."""
    steps: tuple[float, ...]
    """Communication steps, s, each half of the previous one."""
    strategy: str = "slip"

    @property
    def duration(self) -> float:
        """s."""
        return self.section[1] - self.section[0]


PACKAGE = "drive.ssp"
FULL = Plan((10.0, 30.0), (0.01, 0.005, 0.0025))
SHORT = Plan((10.0, 15.0), (0.01, 0.005, 0.0025))


@dataclass(frozen=True)
class Coupling:
    """Results by communication step: `SIGNALS` after each step, shape (steps, signals)."""

    plan: Plan
    importers: Mapping[str, Mapping[float, Array]]
    """Results by importer."""
    loop: Mapping[float, Array]
    """Results of the loop in which vehicle, control and variator step in sequence (Gauss-Seidel scheme)."""
    parallel: Mapping[float, Array]
    """Results of the loop in which they step in parallel (Jacobi scheme), as in an importer."""
    refusals: tuple[str, ...] = ()
    """Errors of importers that could not run the package."""

    def refinement(self, importer: str) -> Array:
        """Root mean square of x_h − x_{h/2} as a share of the signal's range, shape (steps − 1, signals)."""
        found, steps = self.importers[importer], self.plan.steps
        return np.array([self._difference(found[h], found[half], h, half) for h, half in pairwise(steps)])

    def against_loop(self, importer: str) -> Array:
        """Root mean square of the difference of importer and loop at the same step, as a share of the range, shape (steps, signals)."""
        found = self.importers[importer]
        return np.array([self._difference(found[h], self.loop[h], h, h) for h in self.plan.steps])

    def against_parallel(self, importer: str) -> float:
        """Largest difference between an importer and the loop that steps in parallel, as a share of a signal's range."""
        found = self.importers[importer]
        return max(
            float((np.abs(found[h] - self.parallel[h]) / np.ptp(self.parallel[h], axis=0)).max())
            for h in self.plan.steps
        )

    def _difference(self, one: Array, other: Array, step: float, other_step: float) -> Array:
        """Differences at the communication points of the coarsest step; row k is the state after k + 1 steps."""
        ranges = np.ptp(self.loop[self.plan.steps[-1]], axis=0)
        points = [_at(values, h, self.plan.steps[0]) for values, h in ((one, step), (other, other_step))]
        return np.sqrt(np.mean((points[0] - points[1]) ** 2, axis=0)) / ranges


def _at(values: Array, step: float, grid: float) -> Array:
    every = round(grid / step)
    return values[every - 1 :: every]


MESH = "accurate"
"""Beside the error of a variator of the drives, that of the smallest coupling step would not show."""


def orders(errors: Array) -> Array:
    """Orders of convergence from errors at halved steps, shape (steps − 1, signals)."""
    return np.log2(errors[:-1] / errors[1:])


def build(fmu: Path, maps: Maps, plan: Plan, folder: Path) -> Path:
    """Writes the package and the FMUs in it to a folder; returns its path."""
    vehicle, control = fmus.build(folder, maps)
    parameters = simulate.unit_parameters(demo_car(), "ALE", MESH)
    # libcosim does not support enumerations; ALE is the default of the FMU.
    del parameters["ring.model"]
    start, stop = plan.section
    assumed = {name: parameters[name] for name in ("friction.pulley", "geometry.wedgeAngle")}
    path = folder / PACKAGE
    components = {
        "variator": package.Component(fmu, {**parameters, **simulate.at_rest()}),
        "vehicle": package.Component(vehicle, {"cycle.start": start, "cycle.stop": stop}),
        "control": package.Component(control, {"slipControl": plan.strategy == "slip", **assumed}),
    }
    package.write(path, components, plan.duration)
    return path


def run(fmu: Path, plan: Plan, folder: Path, importers: Sequence[str] = tuple(IMPORTERS)) -> Coupling:
    """Builds the package in a folder and runs it in the installed importers and in the loop.

    Raises UnitError if none of them can run it.
    """
    parameters = simulate.unit_parameters(demo_car(), "ALE", MESH)
    total = (2 + len(importers)) * len(plan.steps) * plan.duration
    with Archive.unpack(fmu) as archive:
        maps = measure(fmu, parameters, folder)
        table = ThrustMap.of_maps(maps)
        ssp = build(fmu, maps, plan, folder)
        with progress_bar(round(total), "coupling") as bar:
            found, refusals = _run_importers(importers, ssp, plan, bar.update)
            loops = [
                {h: _loop(archive, table, plan, h, parallel, bar.update) for h in plan.steps}
                for parallel in (False, True)
            ]
    return Coupling(plan, found, *loops, tuple(refusals))


def _run_importers(
    importers: Sequence[str], ssp: Path, plan: Plan, progress: Progress
) -> tuple[dict[str, dict[float, Array]], list[str]]:
    """Results of the importers that can run the package, and the errors of the others."""
    found, refusals = {}, []
    for name in importers:
        try:
            found[name] = _in_process(name, ssp, plan, progress)
        except UnitError as error:
            refusals.append(f"{name}: {error}")
    if not found:
        raise UnitError("; ".join(refusals))
    return found, refusals


def _loop(
    archive: Archive, table: ThrustMap, plan: Plan, step: float, parallel: bool, progress: Progress
) -> Array:
    cycle = wltc_class_3b().section(*plan.section)
    setup = simulate.Setup(f"loop, {1e3 * step:g} ms", plan.strategy, cycle, mesh=MESH, step=step, parallel=parallel)
    run = simulate.run(archive, demo_car(), table, setup, progress)
    return np.column_stack([run[name][1:] for name in SIGNALS])


def _in_process(name: str, ssp: Path, plan: Plan, progress: Progress) -> dict[float, Array]:
    """Runs an importer in a separate process, so that a crash of its library does not end this process."""
    try:
        with worker_pool(1) as run:
            (found,) = run([(_work, (name, ssp, plan))], progress)
    except BrokenProcessPool:
        raise UnitError(f"{name} crashed while it ran {ssp.name}") from None
    return found


def _work(name: str, ssp: Path, plan: Plan) -> dict[float, Array]:
    # The loop records the start of each step, so the end of the last step is missing.
    counts = {h: round(plan.duration / h) - 1 for h in plan.steps}
    try:
        return {h: IMPORTERS[name](ssp, h, count, SIGNALS, tick) for h, count in counts.items()}
    except UnitError:
        raise
    except Exception as error:
        raise UnitError(f"{type(error).__name__}: {error}") from error
