"""How often the 95 % intervals of a calibration contain the true value, over synthetic rigs with fixed seeds:

    PYTHONPATH=python python examples/coverage.py [rigs, 200]

A rig varies friction of the pulleys, friction of the ring and play within twice their known deviations. Its table has twelve points with thrust
ratio, slip and efficiency, with noise of the standard deviations that it states.
"""

import dataclasses
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import cache

import numpy as np

import pushbelt
from pushbelt.calibrate import fit, model, parameters, worker
from pushbelt.fmu.data import torque_capacity
from pushbelt.fmu.files import default_fmu
from pushbelt.fmu.start_values import checked
from pushbelt.fmu.unit import Archive
from pushbelt.tables.points import Measured, Point

NAMES = ("friction.pulley", "friction.ring", "belt.play")
NOISE = {"thrustRatio": 0.005, "slip": 1e-4, "efficiency": 2e-3}
FORCE, SPEED = 12e3, 200.0


@cache
def unpacked() -> Archive:
    return Archive.unpack(default_fmu()).__enter__()


def planned(base, ratio: float, share: float) -> Point:
    measured = tuple(Measured(name, 0.0, deviation, True) for name, deviation in NOISE.items())
    return Point(0, f"{ratio:g} {share:g}", ratio, None, SPEED, share * torque_capacity(base, ratio, FORCE), FORCE, None, measured)


def rig(seed: int) -> list[str]:
    """For each parameter `inside`, `above` or `below` its interval, `bound` or `undetermined`."""
    archive, random = unpacked(), np.random.default_rng(seed)
    variables, known = archive.variables, pushbelt.parameter_deviations("bench168")
    base = checked(variables, pushbelt.parameter_set("bench168"), {"parameter"})
    truth = {name: max(base[name] + random.uniform(-2.0, 2.0) * known[name], 0.1 * base[name]) for name in NAMES}

    def solve(jobs):
        return [worker.solve(default_fmu(), archive.directory, {**base, **values}, point) for values, point in jobs]

    points = []
    for point in (planned(base, ratio, share) for ratio in (0.5, 1.0, 2.0) for share in (0.15, 0.3, 0.45, 0.6)):
        (found,) = solve([(truth, point)])
        if found.reason is None:
            noisy = (dataclasses.replace(one, value=found.values[one.quantity] + one.deviation * random.normal()) for one in point.measured)
            points.append(dataclasses.replace(point, line=len(points) + 2, measured=tuple(noisy)))
    chosen = parameters.choose(dict.fromkeys(NAMES), {}, variables, base)
    verdicts = []
    for estimate in fit.fit(model.Model(points, solve), chosen).estimates:
        if estimate.interval is None:
            verdicts.append("bound" if estimate.at_bound else "undetermined")
        else:
            low, high = estimate.interval
            true = truth[estimate.parameter.name]
            verdicts.append("inside" if low <= true <= high else "above" if true > high else "below")
    return verdicts


def main(rigs: int) -> None:
    with ProcessPoolExecutor() as pool:
        found = np.array(list(pool.map(rig, range(rigs))))
    print("| parameter | intervals | contain the true value | at a bound | not determined |\n|---|---|---|---|---|")
    for name, column in zip(NAMES, found.T, strict=True):
        inside, outside = (column == "inside").sum(), ((column == "above") | (column == "below")).sum()
        share = 100.0 * inside / max(inside + outside, 1)
        print(f"| `{name}` | {inside + outside} | {share:.0f} % | {(column == 'bound').sum()} | {(column == 'undetermined').sum()} |")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
