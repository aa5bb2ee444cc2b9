"""The thrust-ratio map: what holds the ratio, and how much slip goes with it, from the FMU's own steady states."""

from __future__ import annotations

import csv
import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pushbelt_demo.data import torque_capacity
from pushbelt_demo.geometry import Array
from pushbelt_demo.unit import Archive, UnitError, Variator

RATIOS = (0.45, 0.6, 0.8, 1.0, 1.3, 1.7, 2.2)
UTILISATIONS = (-0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.8, 0.9, 0.97)
SPEED = 200.0
"""Primary speed of the map, rad/s: it moves the thrust ratio by little."""
FORCE = 12e3
"""Secondary clamping force of the map, N."""
SHIFT_EXCESS, SHIFT_TIME = 1500.0, 0.1
"""Primary force above equilibrium with which the shift gain is measured, N, and for how long, s."""

Parameters = Mapping[str, float]


@dataclass(frozen=True)
class ThrustMap:
    """Steady states over ratio × torque utilisation; between the points bilinear, beyond them constant."""

    ratios: Array
    """Shape (m,), ascending."""
    utilisations: Array
    """Shape (n,), ascending; positive where the primary pulley drives."""
    thrust: Array
    """Thrust ratio, shape (m, n)."""
    slips: Array
    """Slip, shape (m, n)."""
    shift_gains: Array
    """g of d(ln i)/dt = −g ω_P (F_P − κ F_S) at the ratios, 1/(N·rad), shape (m,)."""

    def shift_gain(self, ratio: float) -> float:
        """Shift gain at a ratio, 1/(N·rad): a power law between the points, constant beyond them."""
        return float(np.exp(np.interp(np.log(ratio), np.log(self.ratios), np.log(self.shift_gains))))

    def thrust_ratio(self, ratio: float, utilisation: float) -> float:
        """Thrust ratio that holds a ratio."""
        return self._at(self.thrust, ratio, utilisation)

    def slip(self, ratio: float, utilisation: float) -> float:
        """Slip in the steady state."""
        return self._at(self.slips, ratio, utilisation)

    def _at(self, table: Array, ratio: float, utilisation: float) -> float:
        m, p = _place(self.ratios, ratio)
        n, q = _place(self.utilisations, utilisation)
        low = (1.0 - q) * table[m, n] + q * table[m, n + 1]
        high = (1.0 - q) * table[m + 1, n] + q * table[m + 1, n + 1]
        return float((1.0 - p) * low + p * high)

    def write(self, path: Path, key: str) -> None:
        """Writes it as CSV, to the last bit: a comment with key and shift gains, then one row a point."""
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("w", encoding="utf-8", newline="") as file:
            file.write("# " + json.dumps({"key": key, "shiftGains": self.shift_gains.tolist()}) + "\n")
            writer = csv.writer(file)
            writer.writerow(["ratio", "utilisation", "thrustRatio", "slip"])
            for m, ratio in enumerate(self.ratios):
                for n, utilisation in enumerate(self.utilisations):
                    writer.writerow([repr(float(x)) for x in (ratio, utilisation, self.thrust[m, n], self.slips[m, n])])

    @classmethod
    def read(cls, path: Path, key: str | None = None) -> ThrustMap | None:
        """Reads what `write` wrote; none if there is none or it was made with another key than the one given."""
        try:
            with path.open(encoding="utf-8", newline="") as file:
                head = json.loads(file.readline().removeprefix("#"))
                rows = np.array(list(csv.reader(file))[1:], dtype=float)
        except (OSError, ValueError):
            return None
        if (key is not None and head.get("key") != key) or "shiftGains" not in head:
            return None
        ratios, utilisations = np.unique(rows[:, 0]), np.unique(rows[:, 1])
        shape = (len(ratios), len(utilisations))
        gains = np.array(head["shiftGains"])
        return cls(ratios, utilisations, rows[:, 2].reshape(shape), rows[:, 3].reshape(shape), gains)


def _place(grid: Array, value: float) -> tuple[int, float]:
    """Interval of a grid that holds a value, and the share of the way through it, 0 to 1."""
    index = int(np.clip(np.searchsorted(grid, value) - 1, 0, len(grid) - 2))
    return index, float(np.clip((value - grid[index]) / (grid[index + 1] - grid[index]), 0.0, 1.0))


def map_key(fmu: Path, parameters: Parameters) -> str:
    """What a cached map depends on: the FMU's bytes, the parameters and the grid."""
    text = json.dumps([dict(parameters), RATIOS, UTILISATIONS, SPEED, FORCE, SHIFT_EXCESS, SHIFT_TIME], sort_keys=True)
    return hashlib.sha256(fmu.read_bytes() + text.encode()).hexdigest()


def torque_at(parameters: Parameters, ratio: float, utilisation: float) -> float:
    """Primary torque of a utilisation under the map's clamping force, N·m."""
    return utilisation * torque_capacity(parameters, ratio, FORCE)


def _start(archive: Archive, parameters: Parameters, ratio: float, torque: float) -> Variator:
    unit = Variator(
        archive,
        {
            **parameters,
            "initial.ratio": ratio,
            "initial.primarySpeed": SPEED,
            "initial.steady": True,
            "primary.torque": torque,
            "secondary.torque": -torque * ratio,
            "secondary.clampingForce": FORCE,
        },
    )
    unit.initialise()
    return unit


def _row(archive: Archive, parameters: Parameters, ratio: float) -> tuple[Array, Array]:
    """Thrust ratio and slip over the utilisations at one ratio."""
    found = []
    for utilisation in UTILISATIONS:
        wanted = torque_at(parameters, ratio, utilisation)
        try:
            with _start(archive, parameters, ratio, wanted) as unit:
                state, steady = unit.outputs(), unit.not_steady is None
        except UnitError:
            continue
        if steady and not state["macroSlip"]:
            share = -state["primary.shaftTorque"] / torque_at(parameters, ratio, 1.0)
            found.append((share, state["thrustRatio"], state["slip"]))
    if len(found) < 3:
        raise UnitError(f"hardly a steady state at ratio {ratio:g}: {len(found)} of {len(UTILISATIONS)}")
    share, thrust, slip = np.array(sorted(found)).T
    return np.interp(UTILISATIONS, share, thrust), np.interp(UTILISATIONS, share, slip)


def _shift_gain(archive: Archive, parameters: Parameters, ratio: float) -> float:
    """Mean shift gain at a ratio at 30 % utilisation, over a step of the primary force up and one down."""
    gains = []
    for excess in (SHIFT_EXCESS, -SHIFT_EXCESS):
        with _start(archive, parameters, ratio, torque_at(parameters, ratio, 0.3)) as unit:
            reader = unit.reader(["primary.axialForce", "ratio.geometric"])
            unit.set({"primary.clampingForce": unit.read(reader)[0] + excess})
            unit.step_to(0.5 * SHIFT_TIME)
            before = unit.read(reader)[1]
            unit.step_to(SHIFT_TIME)
            rate = math.log(unit.read(reader)[1] / before) / (0.5 * SHIFT_TIME)
        gains.append(-rate / (SPEED * excess))
    return float(np.mean(gains))


def compute(archive: Archive, parameters: Parameters) -> ThrustMap:
    """Solves for the map. Points that slip through are left out and filled from their neighbour."""
    rows = [_row(archive, parameters, ratio) for ratio in RATIOS]
    gains = np.array([_shift_gain(archive, parameters, ratio) for ratio in RATIOS])
    thrust, slip = (np.array([row[k] for row in rows]) for k in (0, 1))
    return ThrustMap(np.array(RATIOS), np.array(UTILISATIONS), thrust, slip, gains)


def load(fmu: Path, archive: Archive, parameters: Parameters, cache: Path) -> ThrustMap:
    """The map from its cache, or solved for and put there."""
    key = map_key(fmu, parameters)
    found = ThrustMap.read(cache, key)
    if found is None:
        found = compute(archive, parameters)
        found.write(cache, key)
    return found
