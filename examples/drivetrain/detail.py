"""Levels of detail on the same 20 s of the WLTC: for docs/levels.md."""

from pathlib import Path

from pushbelt.drive import report, simulate
from pushbelt.drive.cycle import wltc_class_3b
from pushbelt.drive.measure import measure
from pushbelt.drive.thrust_map import ThrustMap
from pushbelt.drive.vehicle import demo_car
from pushbelt.fmu.files import default_fmu
from pushbelt.fmu.unit import Archive

LEVELS = (("ALE0", "coarse"), ("ALE", "coarse"), ("ALE", "default"))


def main() -> None:
    """Drives with the fixed safety factor and prints one line per level."""
    fmu = default_fmu()
    car, cycle = demo_car(), wltc_class_3b().section(10.0, 30.0)
    print("| ring | mesh | shift gain 1e-6/(N·rad) | thrust ratio at the end | variator loss J | ratio error % | s/s |")
    print("|---" * 7 + "|")
    with Archive.unpack(fmu) as archive:
        for ring, mesh in LEVELS:
            parameters = simulate.unit_parameters(car, ring, "coarse")
            table = ThrustMap.of_maps(measure(fmu, parameters, Path("target/drive")))
            run = simulate.run(archive, car, table, simulate.Setup("detail", "safety", cycle, ring, mesh))
            cells = (ring, mesh, f"{1e6 * table.shift_gain(1.0, 0.3):.3f}", f"{run['thrustRatio'][-1]:.2f}",
                     f"{run.variator_loss:.0f}", f"{100 * report.ratio_error(run):.1f}",
                     f"{run.processor_time / cycle.duration:.2f}")  # fmt: skip
            print("| " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
