"""Influence of the friction velocity at and near standstill of the belt: for docs/drivetrain.md."""

from collections.abc import Iterator
from contextlib import contextmanager

from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.enumerations import Drive
from pushbelt.fmu.files import default_fmu
from pushbelt.fmu.unit import Archive, Instance

STEP, LAUNCH_STEP = 1e-2, 1e-3
"""Communication steps, s."""
VELOCITIES = (5e-4, 2.5e-4, 5e-5)
"""Friction velocities, m/s; the first is the default."""
RATIO = 2.2
LAUNCHES = {"heavy": (100.0, 80.0, 0.5, 1.5), "light": (0.5, 50.0, 0.05, 1.0)}
"""Launches: inertia of the secondary shaft, kg·m², primary torque, N·m, its rise time, s, duration, s."""


@contextmanager
def at_rest(archive: Archive, velocity: float, start: dict[str, float]) -> Iterator[Instance]:
    """An initialised variator at standstill in underdrive."""
    values = {"friction.velocity": velocity, "initial.ratio": RATIO, "initial.primarySpeed": 0.0, **start}
    with Instance(archive, {**parameter_set("bench168"), **values}) as unit:
        unit.initialise()
        yield unit


def launch_loss(archive: Archive, velocity: float, inertia: float, torque: float, rise: float, duration: float) -> float:
    """Energy lost in a launch, J."""
    start = {"secondary.inertia": inertia, "primary.torque": 0.0, "secondary.torque": 0.0}
    start |= {"primary.clampingForce": 20e3, "secondary.clampingForce": 20e3}
    lost = 0.0
    with at_rest(archive, velocity, start) as unit:
        references = unit.reals(["primary.torque"])
        for k in range(round(duration / LAUNCH_STEP)):
            time = k * LAUNCH_STEP
            rate = torque / rise if time < rise - 0.5 * LAUNCH_STEP else 0.0
            unit.set_ramps(references, [min(torque / rise * time, torque)], [rate])
            unit.step_to(time + LAUNCH_STEP)
            lost += unit.get("loss.total") * LAUNCH_STEP
    return lost


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
    with Archive.unpack(default_fmu()) as archive:
        for velocity in VELOCITIES:
            losses = [f"{name} launch {launch_loss(archive, velocity, *launch):.1f} J" for name, launch in LAUNCHES.items()]
            ratio = crept_ratio(archive, velocity)
            print(f"{velocity:g} m/s: lost in a {', in a '.join(losses)}; ratio at rest {RATIO}, {ratio:.3f} after 60 s")


if __name__ == "__main__":
    main()
