"""Standard deviations of steady outputs by chords (`Variator.bands`) beside those of samples, at nine points with half the torque of full slip:

    python examples/bands.py [samples at each point, 400]

A sample draws all parameters of `bench168` with a known deviation from independent normal distributions.
"""

import sys
import time

import numpy as np

import pushbelt
from pushbelt.fmu.steady import SteadyStates, driven_by_torque
from pushbelt.fmu.unit import Archive, UnitError
from pushbelt.fmu.files import default_fmu

OUTPUTS = ("thrustRatio", "slip", "loss.total")


def main(samples: int) -> None:
    deviations, values = pushbelt.parameter_deviations("bench168"), pushbelt.parameter_set("bench168")
    random = np.random.default_rng(1)
    print(f"| ratio | torque, N·m | {' | '.join(OUTPUTS)} | time of chords, of samples, s | samples without a steady state |\n|---|---|---|---|---|---|---|")
    with Archive.unpack(default_fmu()) as archive, pushbelt.Variator("bench168") as variator, SteadyStates(archive, values) as states:
        for ratio in (0.5, 1.0, 2.0):
            for torque in (20.0, 40.0, 60.0):
                force = variator.least_force(ratio, torque, safety=2.0)
                begin = time.perf_counter()
                bands = variator.bands(ratio, torque, deviations, force=force)
                middle, found = time.perf_counter(), []
                near = states.at(driven_by_torque({}, ratio, 200.0, torque, force)).state()
                for _ in range(samples):
                    drawn = {name: max(values[name] + deviation * random.normal(), 0.0) for name, deviation in deviations.items()}
                    try:
                        unit = states.at(driven_by_torque(drawn, ratio, 200.0, torque, force), near)
                    except UnitError:
                        continue
                    found.append([unit.get(name) for name in OUTPUTS])
                spread = np.std(found, axis=0)
                texts = [f"{bands[name]:.3g}, {one:.3g} ({100.0 * (bands[name] / one - 1.0):+.0f} %)" for name, one in zip(OUTPUTS, spread, strict=True)]
                times = f"{middle - begin:.1f}, {time.perf_counter() - middle:.1f}"
                print(f"| {ratio:g} | {torque:g} | {' | '.join(texts)} | {times} | {samples - len(found)} |", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 400)
