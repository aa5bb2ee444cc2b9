"""Derivatives of the outputs of steady states `driven_by_torque`."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from ..arguments import refused
from ..errors import ArgumentError
from .geometry import Array
from .results import item
from .unit import Instance

CONDITIONS = {"ratio": "1", "torque": "N.m", "speed": "rad/s", "force": "N"}
"""Conditions of a steady state, with their units. The secondary speed follows from `ratio` and `speed`."""
HELD = {"ratio": "", "speed ratio": "ratio.speed", "forces": "primary.axialForce"}
"""What changed steady states keep, and the output that the ratio then keeps constant."""
Rates = Mapping[str, float]  # Derivatives of start values over a condition, a parameter or an input


class Asked(NamedTuple):
    """Conditions, parameters and inputs over which derivatives are taken, and what the changed states keep."""

    names: tuple[str, ...] = ()
    hold: str | None = None

    def checked(self, variables: Mapping[str, Any], held: Collection[str] = HELD) -> Asked:
        """With the first of `held`, if none is chosen. Raises UnknownNameError or ArgumentError for what has no derivative."""
        hold = self.hold or next(iter(held))
        if hold not in held:
            raise ArgumentError(refused("hold", hold, f"one of {', '.join(held)} at these points"))
        if hold != "ratio" and "ratio" in self.names:
            raise ArgumentError(f"with hold = {hold!r} the ratio follows: it is no variable")
        real = {name for name, one in variables.items() if one.type == "Real" and one.causality in ("parameter", "input")}
        for name in self.names:
            item(CONDITIONS | dict.fromkeys(real), name, "FMU", "real parameter or input")
        return Asked(self.names, hold)

    def columns(self, outputs: Mapping[str, str], variables: Mapping[str, Any]) -> Iterator[tuple[str, str, str, str]]:
        """Output, what it is derived over, unit and description of each derivative, by outputs with their units."""
        units = units_of(variables)
        for over, (output, unit) in itertools.product(self.names, outputs.items()):
            yield output, over, _quotient(unit, units[over]), f"Derivative of {output} over {over}, the {self.hold} kept"

    def of(self, unit: Instance, rates: Callable[[str], Rates]) -> dict[str, Array]:
        """Derivatives of each real output, one for each name, NaN where there is none. Raises UnitError if the state has no gradient."""
        columns = [rates(name) for name in (*self.names, *(("ratio",) if HELD[self.hold or "ratio"] else ()))]
        variables = list({of: None for column in columns for of in column})
        found = unit.gradient(variables)
        outputs = [one["name"] for one in found["outputs"]]
        by_variable = np.array([[column.get(of, 0.0) for of in variables] for column in columns]).reshape(len(columns), len(variables))
        slopes = np.array(found["gradient"], dtype=float).reshape(len(outputs), len(variables)) @ by_variable.T
        if len(columns) > len(self.names) and found["held"] == "ratio":
            # The ratio follows: dy = ∂y/∂p dp + ∂y/∂i di, where di keeps what is held.
            row = slopes[outputs.index(HELD[self.hold or "ratio"])]
            slopes = slopes - np.outer(slopes[:, -1], row / row[-1])
        return dict(zip(outputs, slopes[:, : len(self.names)], strict=True))


NOTHING = Asked()


def rates(values: Mapping[str, float], name: str) -> Rates:
    """Rates of start values of `driven_by_torque` without pressures."""
    ratio, speed = values["initial.ratio"], values["initial.primarySpeed"]
    of_conditions: dict[str, Rates] = {
        "ratio": {"initial.ratio": 1.0, "secondary.speedSetpoint": -speed / ratio**2}, "torque": {"primary.torque": 1.0},
        "speed": {"initial.primarySpeed": 1.0, "secondary.speedSetpoint": 1.0 / ratio}, "force": {"secondary.clampingForce": 1.0},
    }  # fmt: skip
    return of_conditions.get(name, {name: 1.0})


def units_of(variables: Mapping[str, Any]) -> dict[str, str]:
    return {name: one.unit or "1" for name, one in variables.items()} | CONDITIONS


def _quotient(above: str, below: str) -> str:
    if below in (above, "1"):
        return "1" if below == above else above
    return f"{above}/({below})" if {*"./"} & {*below} else f"{above}/{below}"
