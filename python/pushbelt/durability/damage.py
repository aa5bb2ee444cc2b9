"""Cycles of a revolution by rainflow counting, Miner's sum over a run, its parts, and the effect of the clamping forces."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import rainflow

from pushbelt.fmu.geometry import Array
from pushbelt.steel import Material

from .table import AMPLITUDE, FIELD, MEAN, PULLEYS, Table

CLAMPING = (0.9, 1.0, 1.1)  # Factors on the clamping forces
RATIOS = ((0.0, 0.8, "overdrive, ratio below 0.8"), (0.8, 1.25, "0.8 to 1.25"), (1.25, np.inf, "underdrive, above 1.25"))
AMPLITUDES = 1e6, 5e9  # Amplitudes of the stress of a ring that runs over pulleys, Pa. Bending alone is some 100 MPa
BANDS = ((0.0, 0.25), (0.25, 0.5), (0.5, 0.75), (0.75, np.inf))
"""Bands of torque and speed, relative to the largest value."""
OTHERS = "other cycles"  # Part of a stress along the ring, besides its largest cycle


@dataclass(frozen=True)
class Cycles:
    """Cycles of each revolution, arrays of shape (rows, cycles)."""

    amplitude: Array
    mean: Array
    count: Array
    column: str  # Column of the mean stress.


def count_loop(stress: Array) -> list[tuple[float, float, float]]:
    """Amplitude, mean and number of the cycles of a closed loop, largest first, by rainflow counting from its largest value around to it."""
    start = int(np.argmax(stress))
    loop = np.concatenate([stress[start:], stress[: start + 1]])
    found: Counter[tuple[float, float]] = Counter()
    for span, mean, count, _, _ in rainflow.extract_cycles(loop.tolist()):
        if span > 0.0:
            found[(0.5 * span, mean)] += count
    return [(*cycle, found[cycle]) for cycle in sorted(found, reverse=True)]


def cycles(table: Table) -> dict[str, Cycles]:
    """The cycles of a revolution at each row, by name of the part: from the outputs of each pulley, or counted on the stress
    along the ring. No cycle spans several revolutions."""
    if table.field is None:
        columns = {p: (AMPLITUDE.format(p), MEAN.format(p)) for p in PULLEYS}
        once = np.ones((len(table.lines), 1))
        return {f"{p} pulley": Cycles(table[a][:, None], table[m][:, None], once, m) for p, (a, m) in columns.items()}
    counted = [count_loop(row) for row in table.field]
    most = max(2, *map(len, counted))
    padded = np.array([row + [(0.0, 0.0, 0.0)] * (most - len(row)) for row in counted])
    parts = {"largest cycle": padded[:, :1], OTHERS: padded[:, 1:]}
    return {name: Cycles(part[..., 0], part[..., 1], part[..., 2], f"{FIELD}[…]") for name, part in parts.items()}


class Class(NamedTuple):
    kind: str
    name: str
    rows: Array  # Which rows belong to it.


class Damage:
    def __init__(self, table: Table, material: Material, parameters: Mapping[str, float], parts: Mapping[str, Cycles]) -> None:
        """`parameters` of the variator by name, with geometry.beltLength; `parts`: cycles of a revolution by name."""
        self.table, self.material, self.parameters, self.parts = table, material, parameters, parts
        # Revolutions of the ring that belong to each row.
        self.turns = table.times * np.abs(table["ring.speed"]) / parameters["geometry.beltLength"]
        equivalent = {name: material.equivalent(part.amplitude, part.mean) for name, part in parts.items()}
        # Largest equivalent amplitude of each part at each row, Pa, and the largest of all while the ring turns, relative to the fatigue limit.
        self.equivalent = {name: one.max(axis=1) for name, one in equivalent.items()}
        largest = max(one[self.turns > 0.0].max(initial=0.0) for one in self.equivalent.values())
        self.utilisation = float(largest) / material.allowed
        # Damage of each part at each row, with the fatigue limit and with a curve that continues below it, and Miner's sums.
        self.rows = {
            limited: {k: self.turns * (one.count * material.damage(equivalent[k], limited)).sum(axis=1) for k, one in parts.items()}
            for limited in (True, False)
        }
        self.total, self.total_without_limit = (float(sum(one.sum() for one in rows.values())) for rows in self.rows.values())
        # Shares are of the damage with the limit; without any such damage of the curve that continues below it.
        self.limited = self.total > 0.0

    def share(self, rows: Array | slice = slice(None), part: str | None = None) -> float:
        """Share of the damage of some rows or all, of one part or of all."""
        whole = self.total if self.limited else self.total_without_limit
        chosen = sum(one[rows].sum() for name, one in self.rows[self.limited].items() if part in (None, name))
        return float(chosen / whole) if whole > 0.0 else 0.0

    def life(self, damage: float) -> tuple[float, float | None]:
        """Hours and kilometres until the sum is 1; infinite without damage. Kilometres are None without distance."""
        distance, times = self.table.distance, 1.0 / damage if damage > 0.0 else np.inf
        return times * self.table.duration / 3600.0, None if distance is None else times * distance / 1000.0

    def classes(self) -> list[Class]:
        """Parts of the run by ratio, torque and speed of the ring, as far as the table has their columns."""
        found = [Class("speed of the ring", *band) for band in _bands(np.abs(self.table["ring.speed"]), "m/s")]
        if "ratio.geometric" in self.table.columns:
            ratio = self.table["ratio.geometric"]
            found += [Class("ratio", name, (ratio >= low) & (ratio < high)) for low, high, name in RATIOS]
        if (torque := self.table.torque) is not None:
            found.append(Class("torque", "overrun, below 0", torque < 0.0))
            found += [Class("torque", name, rows & (torque >= 0.0)) for name, rows in _bands(torque, "N·m")]
        return found

    def clamped(self, factor: float) -> Damage | None:
        """Estimate for clamping forces times a factor: the tension part of the stress, without the centrifugal one, is proportional to it,
        bending does not change. None if the table has no radii, or if the mean stress would reach the strength."""
        table, values = self.table, self.parameters
        if table.field is not None or any(f"{pulley}.radius" not in table.columns for pulley in PULLEYS):
            return None
        area = 2.0 * values["ring.layers"] * values["ring.layerWidth"] * values["ring.layerThickness"]
        bend = 0.5 * values["ring.axialStiffness"] / area * values["ring.layerThickness"]
        relaxed = values["ring.residualCurvature"]
        centrifugal = (values["ring.massPerLength"] + values["belt.massPerLength"]) * table["ring.speed"] ** 2 / area
        curvatures = [1.0 / (table[f"{pulley}.radius"] + values["belt.pitchOffset"]) for pulley in PULLEYS]
        # The outer face has the largest stress where the ring is bent more on the smaller pulley than it is bent back on a strand.
        face = np.where(np.maximum(*curvatures) > 2.0 * relaxed, 1.0, -1.0)
        parts = {}
        for (name, part), curvature in zip(self.parts.items(), curvatures, strict=True):
            amplitude, mean = part.amplitude[:, 0], part.mean[:, 0]
            bending_mean = face * bend * (0.5 * curvature - relaxed)
            amplitude = amplitude + (factor - 1.0) * np.maximum(amplitude - 0.5 * bend * curvature, 0.0)
            mean = mean + (factor - 1.0) * np.maximum(mean - bending_mean - centrifugal, 0.0)
            parts[name] = Cycles(amplitude[:, None], mean[:, None], part.count, part.column)
        if any((part.mean >= self.material.strength).any() for part in parts.values()):
            return None
        return Damage(table, self.material, values, parts)


def _bands(values: Array, unit: str) -> list[tuple[str, Array]]:
    most = float(values.max(initial=0.0))
    ends = [(low * most, high * most, f"{low * most:.3g} to {min(high, 1.0) * most:.3g} {unit}") for low, high in BANDS]
    return [(name, (values >= low) & (values < high)) for low, high, name in ends if most > 0.0]


def damage(table: Table, material: Material, parameters: Mapping[str, float]) -> Damage:
    """Damage of a run. Raises TableError by line and column for an amplitude that no running ring has, or a mean or largest
    stress above the strength."""
    parts = cycles(table)
    low, most = AMPLITUDES
    limits = f"Pa is not within {low:g} to {most:g} Pa, as that of any ring that moves"
    moving = np.abs(table["ring.speed"]) > 0.0
    for name, part in parts.items():
        sizes = part.amplitude.max(axis=1)
        impossible = moving & ~((low <= sizes) & (sizes <= most)) & (name != OTHERS)
        column = part.column.replace("Mean", "Amplitude")
        table.refuse(impossible, column, lambda row, sizes=sizes: f"an amplitude of {sizes[row]:.4g} {limits}")  # type: ignore[misc]
        for what, stress in (("mean", part.mean), ("largest", part.mean + part.amplitude)):
            sizes, text = stress.max(axis=1), f"the {what} stress, {{:.4g}} Pa, is not below the strength, {material.strength:.4g} Pa"
            table.refuse(sizes >= material.strength, part.column, lambda row, sizes=sizes, text=text: text.format(sizes[row]))  # type: ignore[misc]
    return Damage(table, material, parameters, parts)
