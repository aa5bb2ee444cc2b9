"""What a drivetrain model has to get right, shown on the FMU: signs, inertias, step sizes."""

from pushbelt.fmu.enumerations import Axial
from pushbelt.fmu.files import default_fmu
from pushbelt.fmu.unit import Archive, Instance

START = {
    "initial.ratio": 1.5,
    "initial.primarySpeed": 200.0,
    "primary.torque": 60.0,
    "secondary.torque": -60.0,
    "secondary.clampingForce": 16e3,
    "secondary.inertia": 4.0,
    "primary.inertia": 0.18,
}


def run(archive: Archive, step: float, changes: dict[str, float], duration: float = 0.5) -> dict[str, float]:
    """Outputs after a while with the sheave held at its ratio."""
    with Instance(archive, {**START, "primary.axial": Axial.HELD, **changes}) as unit:
        unit.initialise()
        for k in range(round(duration / step)):
            unit.step_to((k + 1) * step)
        return unit.outputs()


def powers(state: dict[str, float]) -> str:
    """Powers into the variator, in words."""
    return ", ".join(f"{name} {state[name]:.0f} W" for name in ("primary.power", "secondary.power"))


def main() -> None:
    """Prints powers, an acceleration and the effect of the step size (docs/tools.md)."""
    with Archive.unpack(default_fmu()) as archive:
        state = run(archive, 0.01, {})
        print("engine drives: " + powers(state))
        speed = START["initial.primarySpeed"]
        reflected = START["primary.inertia"] + START["secondary.inertia"] / 1.5**2
        lever = START["primary.torque"] + START["secondary.torque"] / 1.5
        acceleration = (state["primary.speed"] - speed) / 0.5
        print(f"acceleration {acceleration:.2f} rad/s², of a lossless drive {lever / reflected:.2f}")
        state = run(archive, 0.01, {"primary.torque": -20.0, "secondary.torque": 20.0})
        print("car drives: " + powers(state))
        for step in (0.02, 0.01, 0.005, 0.001):
            end = run(archive, step, {})["primary.speed"]
            print(f"communication step {1e3 * step:2.0f} ms: primary speed {end:.4f} rad/s")


if __name__ == "__main__":
    main()
