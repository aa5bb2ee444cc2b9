"""Standard deviations of steady outputs (`Variator.bands`) beside those of samples, at nine points:

    python examples/bands.py [samples at each point, 400] [safety factor of the clamping force, 2]

A sample draws all parameters of `bench168` with a known deviation from independent normal distributions. Then the bands of three figures of the
README and of the book.
"""

import sys
import time

import numpy as np

import pushbelt
from pushbelt.fmu.steady import SteadyStates, driven_by_torque
from pushbelt.fmu.unit import Archive, UnitError
from pushbelt.fmu.files import default_fmu

OUTPUTS = ("thrustRatio", "slip", "loss.total")


def main(samples: int, safety: float) -> None:
    deviations, values = pushbelt.parameter_deviations("bench168"), pushbelt.parameter_set("bench168")
    random = np.random.default_rng(1)
    print(f"| ratio | torque, N·m | {' | '.join(OUTPUTS)} | time of both, s | samples without a steady state |\n|---|---|---|---|---|---|---|")
    with Archive.unpack(default_fmu()) as archive, pushbelt.Variator("bench168") as variator, SteadyStates(archive, values) as states:
        for ratio in (0.5, 1.0, 2.0):
            for torque in (20.0, 40.0, 60.0):
                force = variator.least_force(ratio, torque, safety=safety)
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


def figures() -> None:
    """Bands of figures that are no predictions."""
    at = {"force": 15e3, "speed": 209.44}
    with pushbelt.Variator("bench168") as variator:
        idle = variator.bands(0.444, 0.0, **at)
        # The slope over the ratio has the differences of the chords.
        ends = [variator.bands(1.0 / s, 0.0, **at) for s in (0.95, 1.05)]
        values = [[np.log(one.outputs["thrustRatio"]), *(one.chords["thrustRatio"] / one.outputs["thrustRatio"])] for one in ends]
        slope, *chords = np.diff(values, axis=0)[0] / np.log(1.05 / 0.95)
        low = variator.bands(0.5, 10.0, force=8e3, speed=209.44)
    print(f"thrust ratio without torque at ratio 0.444: {idle.outputs['thrustRatio']:.2f} ± {idle['thrustRatio']:.2f}")
    print(f"d ln(thrust ratio)/d ln s near ratio 1 without torque: {slope:.2f} ± {np.linalg.norm(chords):.2f}")
    print(f"efficiency at ratio 0.5, 10 N·m and 8 kN: {low.outputs['efficiency']:.3f} ± {low['efficiency']:.3f}")


if __name__ == "__main__":
    words = dict(enumerate(sys.argv))
    main(int(words.get(1, "400")), float(words.get(2, "2")))
    figures()
