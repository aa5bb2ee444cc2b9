"""Ten planned points against thirty points on each of two grids, over synthetic rigs with fixed seeds:

    PYTHONPATH=python python examples/plans.py [rigs, 20] [first seed, 100]

A rig varies friction of the pulleys, friction of the ring and play within twice their known deviations. Four points are planned for the parameter
set `bench168` with the lowest friction of these, and six more for the fit of the four. A grid has five ratios, three torques and two forces within
the same limits. The torques of the first one are the same everywhere, at most 0.65 of the capacity of `bench168` at the lower force and the highest
ratio, at 200 rad/s. Those of the second one are shares of the capacity, at 100 and 300 rad/s in turn. All values have the noise of the standard
deviations that the tables state.

Expected widths are those of the true parameters and the true scatter, with slopes over 5 %.
"""

import dataclasses
import itertools
import sys
from concurrent.futures import ProcessPoolExecutor

import numpy as np
from coverage import NAMES, NOISE, unpacked

import pushbelt
from pushbelt.calibrate import fit, model, parameters, plan, worker
from pushbelt.fmu.data import torque_capacity
from pushbelt.fmu.files import default_fmu
from pushbelt.fmu.start_values import checked
from pushbelt.tables.points import Measured, Point

WITHIN = {"ratio.geometric": (0.5, 2.0), "primary.speed": (100.0, 300.0), "primary.torque": (8.0, 120.0), "secondary.clampingForce": (8e3, 20e3)}
RATIOS, FORCES = np.geomspace(0.5, 2.0, 5), (8e3, 20e3)
FIRST = [(ratio, 200.0, torque, force) for ratio, torque, force in itertools.product(RATIOS, (8.0, 20.0, 32.0), FORCES)]
SECOND = [
    (ratio, (100.0, 300.0)[k % 2], share * torque_capacity(pushbelt.parameter_set("bench168"), ratio, force), force)
    for k, (ratio, share, force) in enumerate(itertools.product(RATIOS, (0.2, 0.45, 0.7), FORCES))
]
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
        """The fitted values, and the half-width of the widest interval in per cent of the true value; NaN if a parameter has none."""
        found = fit.fit(model.Model(table, self.solve), self.chosen(start)).estimates
        halves = [50.0 * np.ptp(one.interval) / self.truth[one.parameter.name] if one.interval else np.nan for one in found]
        return {one.parameter.name: one.value for one in found}, np.max(halves)

    def expected(self, table):
        """Half-width of the widest interval, and that without any one point, in per cent."""
        opened, chosen, at = model.Model(table, self.solve), self.chosen(self.truth), np.ones(len(NAMES))
        slopes = opened.slopes(chosen, {}, at, opened.states(self.truth), plan.WIDTH)
        some = [slopes[opened.values["point"] != k] for k in range(-1, len(table))]
        whole, *lost = (100.0 * plan.halves(one).max() for one in some)
        return whole, max(lost)


def first(_: int = 0):
    """Four points for what is known of any rig."""
    rig = Rig(0)
    start = {name: rig.base[name] for name in NAMES}
    return rig.planned([], 4, start | {"friction.pulley": start["friction.pulley"] - 2.0 * rig.known["friction.pulley"]})


def compared(seed: int, points: list[Point]):
    """Widths with the planned points and with the grids, and numbers of points that the belt carries."""
    rig = Rig(seed)
    table = rig.measure(points)
    start, _ = rig.fitted(table)
    table += rig.measure(rig.planned(table, 6, start))
    grids = [rig.measure([Point(0, "", *place[:1], None, *place[1:], None, MEASURED) for place in grid]) for grid in (FIRST, SECOND)]
    every = [(table, start), *((grid, None) for grid in grids)]
    return [(rig.fitted(one, begin)[1], *rig.expected(one)) for one, begin in every], [len(one) for one, _ in every]


def main(rigs: int, seed: int) -> None:
    with ProcessPoolExecutor(2) as pool:
        points = pool.submit(first).result()
        widths, counts = map(np.array, zip(*pool.map(compared, range(seed, seed + rigs), itertools.repeat(points)), strict=True))
    print("| half-width of the widest 95 % interval | 10 planned, median | 30 on the grid, median | planned, largest | grid, largest | plan narrower |")
    print("|---|---|---|---|---|---|")
    for k, name in enumerate(("of the fit", "expected", "expected without any one point")):
        for m, grid in enumerate(("first", "second"), 1):
            one, other = widths[:, 0, k], widths[:, m, k]
            shown = " | ".join(f"{value:.2g} %" for value in (np.nanmedian(one), np.nanmedian(other), np.nanmax(one), np.nanmax(other)))
            print(f"| {name}, {grid} grid | {shown} | {(one < other).sum()} of {np.isfinite(one + other).sum()} |")
    print(np.round(widths.reshape(rigs, 9), 2).tolist(), file=sys.stderr)
    for name, carried in zip(("planned", "on the first grid", "on the second grid"), counts.T, strict=True):
        print(f"Of the points {name}, the belts carry {carried.min()} to {carried.max()}.")


if __name__ == "__main__":
    main(*map(int, [*sys.argv[1:], *("20", "100")[len(sys.argv) - 1 :]]))
