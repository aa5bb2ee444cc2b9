"""A small hydraulic circuit around the variator: pump, relief valve, two valves, compliance of the lines; steps of 1 ms.

The FMU takes the pressures of both cylinders, which ramp over each step, and returns the volumes of oil in them: their
change is the mean flow. It needs `pushbelt`, numpy and matplotlib, and writes hydraulics.png, or the file that is given.
With `--limits` it prints from which compliance on a circuit is stable, and what oil is lost, with either feedback.
"""

import sys
from dataclasses import dataclass, field

import matplotlib.pyplot as plt
import numpy as np

import pushbelt
from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.files import RESOURCES

STEP, PARTS, END = 1e-3, 20, 2.5  # s, parts of a step for the circuit, s
PULLEYS = ("primary", "secondary")
SECONDARY = 1.2e6  # Pa, set point of the secondary pressure
START = {**parameter_set(str(RESOURCES / "bench168-cylinders.json")), "ring.model": 1, "initial.equilibrium": True,
         "primary.drive": 2, "primary.speedSetpoint": 200.0, "secondary.torque": -60.0, "secondary.inertia": 2.0,
         "inputs.ramp": -1.0, "primary.clampingForce": 0.0, "secondary.clampingForce": 0.0,
         "primary.pressure": 1.05e6, "secondary.pressure": SECONDARY}  # fmt: skip


@dataclass
class Circuit:
    """Pressures of the supply and of both cylinders, Pa, and the energy that the oil has carried, J."""

    pressures: np.ndarray
    compliance: np.ndarray  # m³/Pa: oil, air in it, and walls of the lines
    energy: dict[str, float] = field(
        default_factory=lambda: dict.fromkeys(("pump", "relief", "valves", *PULLEYS), 0.0)
    )
    pump: float = 4e-4  # m³/s, 24 l/min
    limit: float = 3e6  # Pa, at which the relief valve opens
    override: float = 4e-9  # m³/s/Pa, its slope
    opening: float = 2e-6  # m², effective area of a valve that is fully open
    density: float = 850.0  # kg/m³

    def orifice(self, command: float, fall: float) -> float:
        """Flow through a valve under a fall of pressure, m³/s. It is linear below 0.1 bar."""
        return command * self.opening * np.sqrt(2.0 / self.density) * fall / np.sqrt(np.hypot(fall, 1e4))

    def advance(self, commands: tuple[float, float], drawn: np.ndarray) -> None:
        """A step with valve commands, −1 (to the tank) to 1 (from the pump), and the flows into the cylinders, m³/s."""
        dt = STEP / PARTS
        for _ in range(PARTS):
            supply, *cylinders = self.pressures
            relief = self.override * max(supply - self.limit, 0.0)
            falls = [supply - p if u > 0.0 else p for u, p in zip(commands, cylinders, strict=True)]
            flows = [self.orifice(u, fall) for u, fall in zip(commands, falls, strict=True)]
            net = np.array([self.pump - relief - sum(q for q in flows if q > 0.0), *(flows - drawn)])
            after = self.pressures + dt * net / self.compliance
            # Powers at the middle of the part, at which the compliance stores ½ C p² exactly.
            supply, *cylinders = 0.5 * (self.pressures + after)
            self.energy["pump"] += dt * supply * self.pump
            self.energy["relief"] += dt * supply * relief
            for pulley, q, p, flow in zip(PULLEYS, flows, cylinders, drawn, strict=True):
                self.energy["valves"] += dt * (q * (supply - p) if q > 0.0 else -q * p)
                self.energy[pulley] += dt * p * flow
            self.pressures = after

    @property
    def stored(self) -> float:
        """Energy of the compliances, J."""
        return float(0.5 * self.compliance @ self.pressures**2)


def of_both(name: str, values: dict[str, float]) -> np.ndarray:
    """Values of a variable of both pulleys."""
    return np.array([values[f"{pulley}.{name}"] for pulley in PULLEYS])


def command(time: float) -> float:
    """Command of the primary valve: it fills, holds, and drains."""
    return 0.4 if 0.3 <= time < 0.8 else -0.3 if 1.3 <= time < 1.9 else 0.0


def main(
    path: str = "hydraulics.png", compliance: float = 3e-12
) -> tuple[np.ndarray, np.ndarray, dict[str, float]]:
    """Shifts by the valves, writes the picture and prints the balances.

    Returns the outputs of the variator, the pressures (supply, primary, secondary), and the energies, J: those of the
    circuit, and of each pulley the work on its sheave.
    """
    with pushbelt.Variator("bench168", START) as variator:
        state = variator.start()
        circuit = Circuit(np.array([3e6, *of_both("pressure", START)]), np.full(3, compliance))
        begin, work, pressures = circuit.stored, np.zeros(2), [circuit.pressures]
        before = of_both("cylinder.volume", state)
        for k in range(round(END / STEP)):
            place, volume = of_both("position", state), of_both("cylinder.volume", state)
            hold = np.clip((SECONDARY - circuit.pressures[2]) / 2e5, -1.0, 1.0)
            circuit.advance((command(k * STEP), hold), (volume - before) / STEP)
            before = volume
            given = zip(PULLEYS, circuit.pressures[1:], strict=True)
            state = variator.step(STEP, {f"{pulley}.pressure": pressure for pulley, pressure in given})
            # In the FMU pressures are linear over a step.
            mean = 0.5 * (pressures[-1] + circuit.pressures)[1:]
            work += mean * of_both("cylinder.area", START) * (of_both("position", state) - place)
            pressures.append(circuit.pressures)
        energies = {**circuit.energy, "stored": circuit.stored - begin, "belt": variator["energy.residual"],
                    **{f"{pulley} sheave": done for pulley, done in zip(PULLEYS, work, strict=True)}}  # fmt: skip
        trace = variator.outputs
    spent = ("relief", "valves", *PULLEYS, "stored")
    parts = " + ".join(f"{name} {energies[name]:.1f}" for name in spent)
    rest = energies["pump"] - sum(energies[name] for name in spent)
    print(f"oil: pump {energies['pump']:.1f} J = {parts} J, but for {rest:.0e} J")
    for pulley in PULLEYS:
        taken = energies[f"{pulley} sheave"]
        print(f"{pulley} cylinder: the oil gives {energies[pulley]:.2f} J, its sheave takes {taken:.2f} J")
    supplied = STEP * trace["primary.power"].sum()
    print(f"belt and sheaves: {energies['belt']:.2f} J of {supplied:.0f} J are not accounted for")
    plot(trace, np.array(pressures), path)
    return trace, np.array(pressures), energies


def plot(trace: np.ndarray, pressures: np.ndarray, path: str) -> None:
    """Commands, pressures, flows and ratio over time."""
    time = trace["time"]
    panels = {"command of the\nprimary valve": {"": np.vectorize(command)(time)},
              "pressure, bar": dict(zip(("supply", *PULLEYS), 1e-5 * pressures.T, strict=True)),
              "flow, l/min": {pulley: 6e4 * trace[f"{pulley}.cylinder.flow"] for pulley in PULLEYS},
              "ratio": {"": trace["ratio.geometric"]}}  # fmt: skip
    figure, axes = plt.subplots(len(panels), sharex=True, figsize=(7, 7), layout="constrained")
    for axis, (name, lines) in zip(axes, panels.items(), strict=True):
        for label, line in lines.items():
            axis.plot(time, line, label=label)
        axis.set(ylabel=name)
        if len(lines) > 1:
            axis.legend()
    axes[-1].set(xlabel="time, s")
    figure.savefig(path, dpi=100)


FEEDBACK = {"ΔV/h, whole-step ramps": (True, -1.0), "cylinder.flow, whole-step ramps": (False, -1.0),
            "cylinder.flow, held inputs": (False, 0.0)}  # fmt: skip


def coupled(
    step: float, compliance: float, feedback: tuple[bool, float], supply: float = 0.0, end: float = 0.2
) -> tuple[np.ndarray, float, float]:
    """A compliance alone at the primary cylinder, from 1 bar more than in the equilibrium on, and a constant pressure at
    the secondary one. The supply, m³/s, pulsates at 25 Hz. The feedback: whether it is ΔV/h, and `inputs.ramp`.

    Returns the primary pressures, Pa, the oil that was supplied, and that which compliance and cylinder took, m³.
    """
    exact, ramp = feedback
    with pushbelt.Variator("bench168", {**START, "inputs.ramp": ramp}) as variator:
        state = variator.start()
        first = before = state["primary.cylinder.volume"]
        pressures, supplied = [START["primary.pressure"] + 1e5], 0.0
        for k in range(round(end / step)):
            state = variator.step(step, {"primary.pressure": pressures[-1]})
            volume = state["primary.cylinder.volume"]
            drawn = (volume - before) / step if exact else state["primary.cylinder.flow"]
            before, flow = volume, supply if (k * step + 1e-6) % 0.04 < 0.02 else 0.0
            supplied += step * flow
            pressures.append(pressures[-1] + step * (flow - drawn) / compliance)
            if not 0.0 < pressures[-1] < 4e6:
                break
    return np.array(pressures), supplied, volume - first + compliance * (pressures[-1] - pressures[0])


def is_stable(step: float, compliance: float, feedback: tuple[bool, float]) -> bool:
    """Whether the ripple of the pressure has fallen to a tenth over 200 ms, or 40 steps."""
    end = max(0.2, 40.0 * step)
    pressures, *_ = coupled(step, compliance, feedback, end=end)
    ripple = np.abs(np.diff(pressures, 2))
    part = len(ripple) // 3
    return len(pressures) > end / step and ripple[-part:].max() < 0.1 * ripple[:part].max()


def limits() -> None:
    """Prints from which compliance on the circuit is stable, to a tenth, and what oil is lost in steps of 5 ms."""
    for name, feedback in FEEDBACK.items():
        for step in (0.5e-3, 1e-3, 2e-3, 5e-3):
            low, high = 5e-14, 2e-11
            while high > 1.1 * low:
                middle = np.sqrt(low * high)
                low, high = (low, middle) if is_stable(step, middle, feedback) else (middle, high)
            print(f"{name}: steps of {1e3 * step} ms are stable from {high:.1e} m³/Pa on")
        _, supplied, taken = coupled(5e-3, 3e-12, feedback, 3e-4, 0.4)
        print(f"{name}: at 3e-12 m³/Pa {1e6 * supplied:.1f} cm³ are supplied, {1e6 * taken:.1f} taken")


if __name__ == "__main__":
    if sys.argv[1:] == ["--limits"]:
        limits()
    else:
        main(*sys.argv[1:])
