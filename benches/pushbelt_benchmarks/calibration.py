"""Times a calibration: `cargo fmu bench --calibrate`.

The table has 30 points with the speed ratio, thrust ratio and efficiency of a variator with other parameters, and noise. Six
parameters are fitted. Processor time and solutions are printed.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pushbelt import console, tables
from pushbelt.calibrate import __main__ as program
from pushbelt.calibrate import worker
from pushbelt.fmu.data import parameter_set, torque_capacity
from pushbelt.fmu.unit import Archive
from pushbelt.tables.points import Measured, Point

FACTORS = {
    "friction.pulley": 1.09, "friction.ring": 1.4, "belt.play": 3.0, "belt.pushStiffness": 1.25,
    "primary.tiltStiffness": 0.8, "secondary.tiltStiffness": 0.8, "contact.stiffness": 1.2,
}  # fmt: skip
"""Parameters of the measured variator, relative to `bench168`."""
FITTED = "friction.pulley,friction.ring,belt.play,belt.pushStiffness,tiltStiffness,contact.stiffness"
RATIOS = (2.2, 1.6, 1.2, 1.0, 0.7, 0.5)
LOADS = ((0.15, 8e3), (0.4, 16e3), (0.6, 10e3), (0.75, 14e3), (-0.3, 12e3))
"""Torque utilisation, and secondary force, N."""
SPEED = 209.0
NOISE = {"thrustRatio": 0.004, "efficiency": 0.001}
"""Standard deviations: relative for the thrust ratio, absolute for the efficiency."""
HEADER = (
    "ratio.speed [1]", "primary.speed [rad/s]", "primary.torque [N.m]", "secondary.clampingForce [N]", "thrustRatio [1]", "efficiency [1]",
)  # fmt: skip


def write_table(fmu: Path, path: Path) -> int:
    """Writes the table; returns the number of its points."""
    base = parameter_set("bench168")
    truth = {**base, **{name: factor * base[name] for name, factor in FACTORS.items()}}
    random, rows = np.random.default_rng(52), []
    with Archive.unpack(fmu) as archive:
        for ratio in RATIOS:
            for utilisation, force in LOADS:
                torque = round(utilisation * torque_capacity(base, ratio, force), 2)
                point = Point(0, "", ratio, None, SPEED, torque, force, None, (Measured("slip", 0.0, 1.0, True),))
                found = worker.solve(fmu, archive.directory, truth, point)
                if found.reason is None:
                    thrust = found.values["thrustRatio"] * (1.0 + NOISE["thrustRatio"] * random.standard_normal())
                    efficiency = found.values["efficiency"] + NOISE["efficiency"] * random.standard_normal()
                    rows.append((ratio / (1.0 - found.values["slip"]), SPEED, torque, force, thrust, efficiency))
    tables.write(path, HEADER, rows)
    return len(rows)


def main(arguments: Sequence[str] | None = None) -> int:
    """Makes the table, fits, and prints times."""
    parser = argparse.ArgumentParser(prog="cargo fmu bench --calibrate", description=__doc__)
    parser.add_argument("--fmu", type=Path, required=True, help="the FMU to run")
    parser.add_argument("--output", type=Path, required=True, help="folder for the table and the report")
    parser.add_argument("--workers", type=int, default=2, help="processes [default: 2]")
    options = parser.parse_args(arguments)
    options.output.mkdir(parents=True, exist_ok=True)
    table = options.output / "points.csv"
    count = write_table(options.fmu, table)
    begin, before = time.perf_counter(), os.times()
    words = [str(table), "--fmu", str(options.fmu), "--output", str(options.output), "--fit", FITTED]
    words += ["--workers", str(options.workers)]
    code = program.main(words)
    after = os.times()
    used = sum(after[:4]) - sum(before[:4])
    print(f"{count} points, six parameters: {time.perf_counter() - begin:.0f} s, {used:.0f} s of processor time, {options.workers} processes")
    return code


if __name__ == "__main__":
    sys.exit(console.run(main))
