"""Times clamping forces and steady states: `cargo fmu bench --forces`.

For each point of ratio and torque `least_force` gives a force, and `steady` the state at that force. Solved initial states and processor
time of both are printed. Most of the last states of `least_force` are those of `steady`, which are not solved again.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from pushbelt import console
from pushbelt.fmu.unit import Instance
from pushbelt.points import SteadyStateError
from pushbelt.variator import Variator

RATIOS = (0.5, 0.8, 1.0, 1.5, 2.2)
TORQUES = (-100.0, -30.0, 30.0, 100.0, 150.0)  # Primary torque, N·m


@dataclass
class Work:
    """Work of one of the two parts."""

    states: int = 0  # Initial states that the FMU solved
    most: int = 0  # Of them at one point
    seconds: float = 0.0  # Processor time


class Counter:
    """Counts the initial states that are solved in this process."""

    def __init__(self) -> None:
        self.solved = 0

    @contextmanager
    def counting(self) -> Iterator[None]:
        """Counts inside the context."""
        original = Instance.initialise

        def counted(unit: Instance) -> None:
            self.solved += 1
            original(unit)

        Instance.initialise = counted  # type: ignore[method-assign]
        try:
            yield
        finally:
            Instance.initialise = original  # type: ignore[method-assign]

    @contextmanager
    def adding_to(self, work: Work) -> Iterator[None]:
        """Adds what happens inside the context."""
        begin, before = time.process_time(), self.solved
        try:
            yield
        finally:
            work.states += self.solved - before
            work.most = max(work.most, self.solved - before)
            work.seconds += time.process_time() - begin


def measure(
    fmu: Path, parameters: str = "bench168", ratios: Sequence[float] = RATIOS, torques: Sequence[float] = TORQUES
) -> tuple[dict[str, Work], int]:
    """Work of `least_force` and of `steady`, and the number of points without a steady state."""
    found, failed, counter = {"least_force": Work(), "steady": Work()}, 0, Counter()
    with Variator(parameters, fmu=fmu) as belt, counter.counting():
        for ratio in ratios:
            for torque in torques:
                try:
                    with counter.adding_to(found["least_force"]):
                        force = belt.least_force(ratio, torque)
                    with counter.adding_to(found["steady"]):
                        belt.steady(ratio, torque, force=force)
                except SteadyStateError:
                    failed += 1
    return found, failed


def main(arguments: Sequence[str] | None = None) -> int:
    """Measures and prints."""
    parser = argparse.ArgumentParser(prog="cargo fmu bench --forces", description=__doc__)
    parser.add_argument("--fmu", type=Path, required=True, help="the FMU to run")
    parser.add_argument("--output", type=Path, help="not used: nothing is written")
    parser.add_argument("--variator", default="bench168", help="name of a parameter set, or a file ….json")
    options = parser.parse_args(arguments)
    found, failed = measure(options.fmu, options.variator)
    points = len(RATIOS) * len(TORQUES)
    print(f"{points} points, {failed} without a steady state")
    print("              states   most at a point   processor time, s   a state, ms")
    for name, work in found.items():
        each = f"{1e3 * work.seconds / work.states:11.1f}" if work.states else f"{'–':>11}"
        print(f"{name:<12}{work.states:8}{work.most:18}{work.seconds:20.2f}   {each}")
    return 0 if failed < points else 1


if __name__ == "__main__":
    sys.exit(console.run(main))
