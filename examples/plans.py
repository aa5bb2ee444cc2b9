"""Ten planned points against thirty points on a grid, over synthetic rigs with fixed seeds:

    PYTHONPATH=python python examples/plans.py [rigs, 20]

A rig varies friction of the pulleys, friction of the ring and play within twice their known deviations. Four points are planned for the parameter
set `bench168` with the lowest friction of these, and six more for the fit of the four. The grid has five ratios, three torques and two forces within
the same limits, at 200 rad/s; its largest torque is 0.65 of the capacity of `bench168` at the lower force and the highest ratio. All values have the
noise of the standard deviations that the tables state.
"""

import dataclasses
import itertools
import sys
from concurrent.futures import ProcessPoolExecutor

import numpy as np
from coverage import NAMES, NOISE, unpacked

import pushbelt
from pushbelt.calibrate import fit, model, parameters, plan, worker
from pushbelt.fmu.files import default_fmu
from pushbelt.fmu.start_values import checked
from pushbelt.tables.points import Measured, Point

WITHIN = {"ratio.geometric": (0.5, 2.0), "primary.speed": (100.0, 300.0), "primary.torque": (8.0, 120.0), "secondary.clampingForce": (8e3, 20e3)}
GRID = list(itertools.product(np.geomspace(0.5, 2.0, 5), (8.0, 20.0, 32.0), (8e3, 20e3)))  # Ratio, torque and force
MEASURED = tuple(Measured(name, np.nan, deviation, True) for name, deviation in NOISE.items())


class Rig:
    """A belt whose true parameters are drawn, and what is known of it before."""

    def __init__(self, seed: int) -> None:
        self.archive, self.random = unpacked(), np.random.default_rng(seed)
        self.base = checked(self.archive.variables, pushbelt.parameter_set("bench168"), {"parameter"})
        self.known = pushbelt.parameter_deviations("bench168")
        self.truth = {name: max(self.base[name] + self.random.uniform(-2.0, 2.0) * self.known[name], 0.1 * self.base[name]) for name in NAMES}

    def solve(self, jobs):
        return [worker.solve(default_fmu(), self.archive.directory, {**self.base, **values}, point) for values, point in jobs]

    def chosen(self, start=None):
        return parameters.choose(start or dict.fromkeys(NAMES), {}, self.archive.variables, self.base)

    def measure(self, points):
        """The points that the belt carries, with noise."""
        found = []
        for point, state in zip(points, self.solve([(self.truth, point) for point in points]), strict=True):
            if state.reason is None:
                noisy = (dataclasses.replace(one, value=state.values[one.quantity] + one.deviation * self.random.normal()) for one in point.measured)
                found.append(dataclasses.replace(point, line=len(found) + 2, measured=tuple(noisy)))
        return found

    def planned(self, table, count, start):
        values = {**self.base, **start}
        places = [dataclasses.replace(place, measured=MEASURED) for place in plan.candidates(WITHIN, values, table)]
        return plan.plan(model.Model([*table, *places], self.solve), len(table), self.chosen(start), values, count).points

    def fitted(self, table, start=None):
        """The fitted values, and half-widths of their intervals in per cent of the true ones; NaN for a parameter without an interval."""
        found = fit.fit(model.Model(table, self.solve), self.chosen(start)).estimates
        halves = [50.0 * np.ptp(one.interval) / self.truth[one.parameter.name] if one.interval else np.nan for one in found]
        return {one.parameter.name: one.value for one in found}, halves


def first(_: int = 0):
    """Four points for what is known of any rig."""
    rig = Rig(0)
    start = {name: rig.base[name] for name in NAMES}
    return rig.planned([], 4, start | {"friction.pulley": start["friction.pulley"] - 2.0 * rig.known["friction.pulley"]})


def compared(seed: int, points: list[Point]):
    """Half-widths with the planned points and with the grid, and numbers of points that the belt carries."""
    rig = Rig(seed)
    table = rig.measure(points)
    start, _ = rig.fitted(table)
    table += rig.measure(rig.planned(table, 6, start))
    grid = rig.measure([Point(0, "", ratio, None, 200.0, torque, force, None, MEASURED) for ratio, torque, force in GRID])
    return rig.fitted(table, start)[1], rig.fitted(grid)[1], (len(table), len(grid))


def main(rigs: int) -> None:
    with ProcessPoolExecutor() as pool:
        points = pool.submit(first).result()
        planned, grid, counts = zip(*pool.map(compared, range(rigs), itertools.repeat(points)), strict=True)
    print("| half-width of the 95 % interval | 10 planned, median | 30 on the grid, median | planned, largest | grid, largest | plan narrower |")
    print("|---|---|---|---|---|---|")
    for k, name in enumerate([*(f"`{name}`" for name in NAMES), "the widest of a rig"]):
        one, other = (np.nanmax(found, axis=1) if k == len(NAMES) else np.array(found)[:, k] for found in (planned, grid))
        shown = " | ".join(f"{value:.2g} %" for value in (np.nanmedian(one), np.nanmedian(other), np.nanmax(one), np.nanmax(other)))
        print(f"| {name} | {shown} | {(one < other).sum()} of {np.isfinite(one + other).sum()} |")
    for name, carried in zip(("planned", "on the grid"), np.transpose(counts), strict=True):
        print(f"Of the points {name}, the belts carry {carried.min()} to {carried.max()}.")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
