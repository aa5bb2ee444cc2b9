"""Sensitivity of outputs to parameters at one steady working point: for docs/calibrate.md."""

from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.files import default_fmu
from pushbelt.fmu.unit import Archive, Instance

POINT = {
    "initial.ratio": 1.5,
    "initial.primarySpeed": 200.0,
    "primary.torque": 60.0,
    "secondary.torque": -90.0,
    "secondary.clampingForce": 16e3,
}
CHANGES = {
    "friction.pulley": 1.1,
    "friction.ring": 1.5,
    "friction.velocity": 0.5,
    "friction.ringVelocity": 0.5,
    "tiltStiffness": 0.8,
    "tiltClearance": 0.8,
    "contact.stiffness": 0.5,
    "belt.pushStiffness": 0.5,
    "belt.play": 2.0,
    "belt.filmDamping": 2.0,
    "belt.squeezeDamping": 2.0,
    "ring.axialStiffness": 0.8,
}
"""Parameters and factors of their change. A name without a pulley means both pulleys."""
SHOWN = ("thrustRatio", "slip", "loss.sheaves", "loss.ring", "loss.layers", "loss.shafts", "spiral.primary")


def steady(archive: Archive, parameters: dict[str, float]) -> dict[str, float]:
    """Outputs of the steady state."""
    with Instance(archive, {**parameters, **POINT}) as unit:
        unit.initialise()
        return unit.outputs()


def main() -> None:
    """Prints one line per parameter: relative change of each output, %."""
    base = parameter_set("bench168")
    with Archive.unpack(default_fmu()) as archive:
        with Instance(archive, {}) as unit:
            known = {name: float(variable.start or 0.0) for name, variable in unit.variables.items()
                     if variable.type == "Real" and variable.causality == "parameter"}  # fmt: skip
        start = steady(archive, base)
        print("| parameter | factor | " + " | ".join(SHOWN) + " |")
        print("|---" * (len(SHOWN) + 2) + "|")
        print("| as it is | | " + " | ".join(f"{start[name]:.4g}" for name in SHOWN) + " |")
        for name, factor in CHANGES.items():
            names = [full for full in known if full == name or full.endswith("." + name)]
            changed = {full: factor * base.get(full, known[full]) for full in names}
            state = steady(archive, {**base, **changed})
            cells = (f"{100 * (state[shown] / start[shown] - 1):+.1f} %" for shown in SHOWN)
            print(f"| `{name}` | {factor} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
