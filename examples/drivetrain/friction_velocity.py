"""Influence of the friction velocity at and near standstill of the belt: for docs/drivetrain.md."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.enumerations import Drive
from pushbelt.fmu.unit import Archive, Instance

STEP = 1e-2
VELOCITIES = (5e-4, 2.5e-4, 5e-5)
"""Friction velocities, m/s; the first is the default."""
RATIO = 2.2
LAUNCH_TORQUE, LAUNCH_TIME, LAUNCH_READ = 80.0, 0.5, 0.6
"""Primary torque, N·m, its rise time, s, and the time at which the slip is read, s."""


@contextmanager
def at_rest(archive: Archive, velocity: float, start: dict[str, float]) -> Iterator[Instance]:
    """An initialised variator at standstill in underdrive."""
    values = {"friction.velocity": velocity, "initial.ratio": RATIO, "initial.primarySpeed": 0.0, **start}
    with Instance(archive, {**parameter_set("bench168"), **values}) as unit:
        unit.initialise()
        yield unit


def launch_slip(archive: Archive, velocity: float) -> float:
    """Slip shortly after a rise of the torque, with 100 kg·m² on the secondary shaft."""
    start = {"secondary.inertia": 100.0, "primary.torque": 0.0, "secondary.torque": 0.0}
    start |= {"primary.clampingForce": 20e3, "secondary.clampingForce": 20e3}
    with at_rest(archive, velocity, start) as unit:
        torque = unit.reals(["primary.torque"])
        rate = LAUNCH_TORQUE / LAUNCH_TIME
        for k in range(round(LAUNCH_READ / STEP)):
            rising = k * STEP < LAUNCH_TIME - 0.5 * STEP
            unit.set_ramps(torque, [min(rate * k * STEP, LAUNCH_TORQUE)], [rate if rising else 0.0])
            unit.step_to((k + 1) * STEP)
        return unit.get("slip")


def crept_ratio(archive: Archive, velocity: float) -> float:
    """Ratio after one minute at standstill under unbalanced clamping forces, with both shafts held."""
    start = {"primary.clampingForce": 4e3, "secondary.clampingForce": 7e3}
    start |= {"primary.drive": Drive.SPEED, "primary.speedSetpoint": 0.0}
    start |= {"secondary.drive": Drive.SPEED, "secondary.speedSetpoint": 0.0}
    with at_rest(archive, velocity, start) as unit:
        for k in range(round(60.0 / STEP)):
            unit.step_to((k + 1) * STEP)
        return unit.get("ratio.geometric")


def main() -> None:
    """Prints one line per friction velocity."""
    with Archive.unpack(Path("target/PushbeltVariator.fmu")) as archive:
        for velocity in VELOCITIES:
            slip, ratio = launch_slip(archive, velocity), crept_ratio(archive, velocity)
            print(
                f"{velocity:g} m/s: slip in a launch {100 * slip:.1f} %; ratio at rest {RATIO}, {ratio:.3f} after 60 s"
            )


if __name__ == "__main__":
    main()
