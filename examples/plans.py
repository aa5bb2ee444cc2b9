"""Ten planned points against thirty points on a grid, over synthetic rigs with fixed seeds:

    PYTHONPATH=python python examples/plans.py [rigs, 20]

A rig varies friction of the pulleys, friction of the ring and play within twice their known deviations. Four points are planned for the parameter set
`bench168`, and six more after a fit to these. The grid has five ratios, three torques and two forces within the same limits. All tables have the
noise of the standard deviations that they state.
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

WITHIN = {"ratio.geometric": (0.5, 2.0), "primary.speed": (100.0, 300.0), "secondary.clampingForce": (5e3, 20e3)}
TORQUES = (0.2, 0.4, 0.6)  # Shares of the capacity on the grid
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

    def planned(self, table, count, start, share):
        places = [dataclasses.replace(place, measured=MEASURED) for place in plan.candidates(WITHIN, {**self.base, **start}, table, share)]
        return plan.plan(model.Model([*table, *places], self.solve), len(table), self.chosen(start), {**self.base, **start}, count, share).points

    def fitted(self, table, start=None):
        """The fitted values, and the half-widths of their intervals relative to them; NaN for a parameter without one."""
        found = fit.fit(model.Model(table, self.solve), self.chosen(start)).estimates
        halves = [np.ptp(one.interval) / 2.0 / one.value if one.interval else np.nan for one in found]
        return {one.parameter.name: one.value for one in found}, halves


def first(_: int = 0):
    """Four points for what is known of any rig; the friction may be lower by twice its deviation."""
    rig = Rig(0)
    start = {name: rig.base[name] for name in NAMES}
    return rig.planned([], 4, start, plan.USED * (1.0 - 2.0 * rig.known["friction.pulley"] / start["friction.pulley"]))


def compared(seed: int, points: list[Point]):
    """Half-widths with the planned points and with the grid, and numbers of points that the belt carries."""
    rig = Rig(seed)
    table = rig.measure(points)
    start, _ = rig.fitted(table)
    table += rig.measure(rig.planned(table, 6, start, plan.USED))
    grid = itertools.product(np.geomspace(0.5, 2.0, 5), TORQUES, (5e3, 20e3))
    own = [Point(0, "", i, None, 200.0, share * torque_capacity(rig.base, i, force), force, None, MEASURED) for i, share, force in grid]
    other = rig.measure(own)
    return rig.fitted(table, start)[1], rig.fitted(other)[1], (len(table), len(other))


def main(rigs: int) -> None:
    with ProcessPoolExecutor(2) as pool:
        points = pool.submit(first).result()
        found = []
        for one in pool.map(compared, range(rigs), itertools.repeat(points)):
            print(*one, file=sys.stderr, flush=True)
            found.append(one)
    planned, grid, counts = zip(*found, strict=True)
    widths = 100.0 * np.array([planned, grid])
    shown = np.concatenate([widths, widths.max(axis=2, keepdims=True)], axis=2)
    print("| half-width of the 95 % interval, % | planned, median | grid, median | planned, largest | grid, largest | rigs in which the plan is narrower |\n|---|---|---|---|---|---|")
    for k, name in enumerate([*(f"`{name}`" for name in NAMES), "the widest of the rig"]):
        one, other = shown[:, :, k]
        print(f"| {name} | {np.median(one):.2f} | {np.median(other):.2f} | {one.max():.2f} | {other.max():.2f} | {(one < other).sum()} of {rigs} |")
    print(f"Points that the belts carry: {min(c[0] for c in counts)} to {max(c[0] for c in counts)} planned, {min(c[1] for c in counts)} to {max(c[1] for c in counts)} on the grid")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
