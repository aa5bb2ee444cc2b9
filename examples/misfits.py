"""What a calibration names as the cause of a misfit, on synthetic tables with one known fault each, and on clean ones:

    PYTHONPATH=python python examples/misfits.py [clean tables, 20] [faults, all]

A table has 16 points of a rig whose friction of the pulleys, friction of the ring and play vary within their known deviations, with noise of the
stated accuracy. The seeds are fixed.
"""

import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path

import numpy as np

import pushbelt
from pushbelt import tables
from pushbelt.calibrate import fit, misfit, model, parameters, worker
from pushbelt.fmu.data import torque_capacity
from pushbelt.fmu.files import default_fmu
from pushbelt.fmu.start_values import checked
from pushbelt.fmu.unit import Archive
from pushbelt.tables import points
from pushbelt.tables.points import Measured, Point
from pushbelt.tables.sheet import Reading

NAMES = ("friction.pulley", "friction.ring", "belt.play")
ACCURACY = {"F_P": "0.5%", "T_S": "0.2%", "slip": "0.01", "eta": "0.2"}
COLUMNS = {"i_geo": "-", "n_P": "rad/s", "T_P": "Nm", "T_S": "Nm", "F_S": "N", "F_P": "N", "slip": "%", "eta": "%", "T_oil": "°C"}
SHARES = (-0.25, 0.1, 0.25, 0.4)  # Of the torque capacity
OIL = 0.02  # Centrifugal force of the oil, N.s2/rad2
MESH = {"mesh.primaryArc": 8, "mesh.secondaryArc": 8, "mesh.strand": 4}  # A coarse one, of the rig and of the model


def speeds(c):
    """Of the measured ratio and slip."""
    return c | {"i_geo": c["i_geo"] / (1.0 - 0.01 * c["slip"])}


def both_speeds(c):
    return speeds(c) | {"n_S": c["n_P"] / speeds(c)["i_geo"]}


def without_oil(c):
    return c | {"F_P": c["F_P"] - OIL * c["n_P"] ** 2, "F_S": c["F_S"] - OIL * (c["n_P"] / c["i_geo"]) ** 2}


def pump(c):
    sign = np.sign(c["T_P"])
    return c | {"T_P": c["T_P"] + 3.0, "eta": c["eta"] * (c["T_P"] / (c["T_P"] + 3.0)) ** sign}


def scaled(**factors):
    return lambda c: c | {name: c[name] * factor for name, factor in factors.items()}


WITH_EFFICIENCY = {"torque of the other shaft", "pump torque of 3 N.m"}  # Tables that have the efficiency in place of the secondary torque
FAULTS = {
    "ratio of speeds": speeds,
    "ratio of speeds, with both of them": both_speeds,
    "ratio + 0.8 %": scaled(i_geo=1.008),
    "torque + 2 N.m": lambda c: c | {"T_P": c["T_P"] + 2.0},
    "torque of the other shaft": lambda c: c | {"T_P": c["T_P"] * c["i_geo"] * 0.01 * c["eta"]},
    "half forces": scaled(F_P=0.5, F_S=0.5),
    "forces + 10 %": scaled(F_P=1.1, F_S=1.1),
    "no centrifugal force": without_oil,
    "gear losses of 2 %": lambda c: c | {"T_S": c["T_S"] * 0.98 ** np.sign(c["T_P"])},
    "pump torque of 3 N.m": pump,
    "oil from 60 to 110 °C": lambda c: c,
    "overrun without its sign": lambda c: c | {"T_P": np.abs(c["T_P"])},
    "commanded force, 400 N higher": lambda c: c | {"F_S": c["F_S"] + 400.0},
    "points while shifting": lambda c: c | {"F_P": c["F_P"] * np.exp(0.1 * np.gradient(np.log(c["i_geo"])))},
}


@cache
def unpacked() -> Archive:
    return Archive.unpack(default_fmu()).__enter__()


def table(seed: int, fault: str | None) -> dict[str, np.ndarray]:
    """The columns of a table, as a rig measures them."""
    random, known = np.random.default_rng(seed), pushbelt.parameter_deviations("bench168")
    base = {**pushbelt.parameter_set("bench168"), **MESH}
    truth = {name: max(base[name] + random.uniform(-1.0, 1.0) * known[name], 0.3 * base[name]) for name in NAMES}
    rows = []
    for ratio in (2.0, 1.3, 0.8, 0.5):
        for k, share in enumerate(SHARES):
            force, speed = (8e3, 12e3, 16e3)[(k + round(ratio)) % 3], (120.0, 300.0)[(k + round(2.0 * ratio)) % 2]
            oil = 60.0 + 50.0 * len(rows) / 15.0
            own = truth | ({"friction.pulley": 0.088 - 0.014 * (oil - 60.0) / 50.0} if fault == "oil from 60 to 110 °C" else {})
            torque = share * torque_capacity(base, ratio, force)
            point = Point(0, "", ratio, None, speed, torque, force, None, (Measured("slip", 0.0, 1.0, True),))
            found = worker.solve(default_fmu(), unpacked().directory, {**base, **own}, point)
            if found.reason is None:
                thrust, slip, efficiency = (found.values[name] for name in ("thrustRatio", "slip", "efficiency"))
                driven = efficiency ** np.sign(torque) * torque * ratio / (1.0 - slip)
                rows.append([ratio, speed, torque, driven, force, thrust * force, 100.0 * slip, 100.0 * efficiency, oil])
    c = dict(zip(COLUMNS, np.transpose(rows), strict=True))
    for name, accuracy in ACCURACY.items():
        size = 0.01 * float(accuracy[:-1]) * np.abs(c[name]) if accuracy[-1] == "%" else float(accuracy)
        c[name] = c[name] + size * random.standard_normal(len(rows))
    c = FAULTS[fault](c) if fault else c
    return {name: column for name, column in c.items() if name != ("T_S" if fault in WITH_EFFICIENCY else "eta")}


def examined(seed: int, fault: str | None) -> tuple[str, float, list[str], list[str]]:
    """Fault, root mean square of the residuals, causes and trends."""
    columns = table(seed, fault)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "table.csv"
        titles = [f"{name} [{COLUMNS.get(name, 'rad/s')}]" for name in columns]
        tables.write(path, titles, np.column_stack(list(columns.values())).tolist(), digits=None)
        accuracy = {name: size for name, size in ACCURACY.items() if name in columns}
        rig = points.read(path, Reading(accuracy=accuracy, as_written=True))
    archive = unpacked()
    base = checked(archive.variables, {**pushbelt.parameter_set("bench168"), **MESH}, {"parameter"})

    def solve(jobs):
        return [worker.solve(default_fmu(), archive.directory, {**base, **values}, point) for values, point in jobs]

    chosen, opened = parameters.choose(dict.fromkeys(NAMES), {}, archive.variables, base), model.Model(rig.points, solve)
    opened.most_solves = 100 * len(rig.points)
    found = fit.fit(opened, chosen)
    trends = [misfit.trend(one) for one in misfit.trends(rig, opened, found) if one.significant]
    named = misfit.ratio_of_speeds(rig, found) or [misfit.sentence(rig, found, one) for one in misfit.search(rig, opened, chosen, found)]
    return fault or "none", found.rms[1], named, trends


def main(clean: int, faults: list[str]) -> None:
    jobs = [*((1, fault) for fault in faults), *((seed, None) for seed in range(clean))]
    print("| fault | residuals, standard deviations | named |\n|---|---|---|")
    with ProcessPoolExecutor(2) as pool:
        for fault, rms, named, trends in pool.map(examined, *zip(*jobs, strict=True)):
            if named or fault != "none":
                print(f"| {fault} | {rms:.3g} | {'<br>'.join(named) or '–'} |", flush=True)
            for text in trends[:1]:
                print(f"{fault}: {text}", file=sys.stderr)
    print(f"{clean} clean tables")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20, sys.argv[2:] or list(FAULTS))
