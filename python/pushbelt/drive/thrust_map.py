"""The thrust-ratio map: thrust ratio and slip over ratio and torque, from the FMU's steady states."""

from __future__ import annotations

import csv
import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from operator import mul
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pushbelt import tables
from pushbelt.fmu.data import torque_capacity
from pushbelt.fmu.geometry import Array
from pushbelt.fmu.unit import Archive, UnitError, Variator

from .piecewise import clip, interpolate, interval

if TYPE_CHECKING:
    from pushbelt.map_data import Maps

RATIOS = (0.45, 0.6, 0.8, 1.0, 1.3, 1.7, 2.2)
UTILISATIONS = (-0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.8, 0.9, 0.97)
SPEED = 200.0
"""Primary speed of the map, rad/s. The thrust ratio depends on it only weakly."""
FORCE = 12e3
"""Secondary clamping force of the map, N."""
SHIFT_SHARES = (0.3, 0.4, 0.55, 0.75, 1.3, 1.8, 2.4, 3.0)
"""Primary forces at which the shift rate is measured, relative to the force that holds the ratio."""
SHIFT_UTILISATIONS = (-0.3, 0.3)
"""Torque utilisations at which the shift rate is measured."""
OTHER_FORCE = 5e3
"""Second secondary clamping force at which the shift rate is measured, N. It determines the dependence on force."""
OTHER_SHARES, OTHER_UTILISATION = (0.75, 1.3), 0.3
"""Primary forces, relative to the force that holds the ratio, and torque utilisation at `OTHER_FORCE`."""
STILL = 1e-4
"""Least change of slip over an interval of the utilisation whose ends are both steady states."""
NEARBY = 0.2
"""Range of the excess about its expected value in which the shift gain is taken."""
SHIFT_TIME, SHIFT_STEP, SHIFT_REACH = 0.1, 0.005, 0.05
"""Duration, s, step, s, and largest change of ln i of a shift measurement."""

Parameters = Mapping[str, float]


class _Plain(NamedTuple):
    """The tables of a map as plain numbers."""

    ratios: list[float]
    utilisations: list[float]
    thrust: list[list[float]]
    slips: list[list[float]]
    excesses: list[float]
    shift_rates: list[list[list[float]]]


def _steepest_falls(places: Array, thrust: Array, slips: Array) -> tuple[list[float], list[float]]:
    """Utilisations up to the last steady state, and the steepest −dκ/du up to each of them, of a row of a map."""
    # Points without a steady state have the values of their neighbour, so the slip does not change there.
    steady = 1 + int(np.sum(np.diff(slips) > STILL))
    slopes = np.diff(thrust[:steady]) / np.diff(places[:steady])
    middles = 0.5 * (places[: steady - 1] + places[1:steady])
    falls = np.maximum.accumulate(-np.append(slopes, slopes[-1]))
    return np.append(middles, places[steady - 1]).tolist(), falls.tolist()


@dataclass(frozen=True)
class ThrustMap:
    """Steady states over ratio × torque utilisation. Values are bilinear between the points and constant beyond them."""

    ratios: Array
    """Shape (m,), ascending."""
    utilisations: Array
    """Torque utilisations, shape (n,), ascending; positive where the primary pulley drives."""
    thrust: Array
    """Thrust ratio, shape (m, n)."""
    slips: Array
    """Slip, shape (m, n)."""
    excesses: Array
    """ε = ln(F_P/(κ F_S)), shape (k,), ascending, 0 among them."""
    shift_rates: Array
    """R of d(ln i)/dt = −ω_P F R(ε) at the utilisations `SHIFT_UTILISATIONS`, 1/(N·rad), shape (m, 2, k), ascending along
    ε, 0 at ε = 0. F is the acting force."""
    clearance_force: float = 0.0
    """F_c, N. The shift rate is proportional to the tilt of the sheaves, which is their clearance plus bending that grows with
    force. At F_c bending is as large as the clearance. With F_c = 0 the shift rate is proportional to force."""

    @cached_property
    def _plain(self) -> _Plain:
        fields = (self.ratios, self.utilisations, self.thrust, self.slips, self.excesses, self.shift_rates)
        return _Plain(*(field.tolist() for field in fields))

    @cached_property
    def _falls(self) -> list[tuple[list[float], list[float]]]:
        """For each ratio: positive utilisations, and the largest −dκ/du up to each of them."""
        driving = self.utilisations >= 0.0
        rows = zip(self.thrust[:, driving], self.slips[:, driving], strict=True)
        return [_steepest_falls(self.utilisations[driving], *row) for row in rows]

    def acting_force(self, secondary: float) -> float:
        """F of the shift law, N, at a secondary clamping force, N: F_S at the force of the map, F_0 (F_S + F_c)/(F_0 + F_c)."""
        return FORCE * (secondary + self.clearance_force) / (FORCE + self.clearance_force)

    def excess(self, ratio: float, utilisation: float, rate: float) -> float:
        """ε for a shift rate R, 1/(N·rad); linear between the points, constant beyond them."""
        return interpolate(rate, self._rates(ratio, utilisation), self._plain.excesses)

    def shift_gain(self, ratio: float, utilisation: float, excess: float = 0.0, secondary: float = FORCE) -> float:
        """g of d(ln i)/dt = −g ω_P ΔF_P about an excess, 1/(N·rad): the steepest R within ±`NEARBY` of it.

        `secondary` is the secondary clamping force, N.
        """
        low, high = excess - NEARBY, excess + NEARBY
        points = list(zip(self._plain.excesses, self._rates(ratio, utilisation), strict=True))
        steepest = max(
            # F_P = κ F_S exp ε
            (rate - rate_before) / (end - start) / math.exp(clip(0.5 * (start + end), low, high))
            for (start, rate_before), (end, rate) in pairwise(points)
            if end > low and start < high
        )
        return steepest / self.thrust_ratio(ratio, utilisation) * self.acting_force(secondary) / secondary

    def _rates(self, ratio: float, utilisation: float) -> list[float]:
        """R at the excesses, of length k."""
        m, p = interval(self._plain.ratios, ratio)
        n, q = interval(SHIFT_UTILISATIONS, utilisation)
        (a, b), (c, d) = self._plain.shift_rates[m][n : n + 2], self._plain.shift_rates[m + 1][n : n + 2]
        shares = (1.0 - p) * (1.0 - q), (1.0 - p) * q, p * (1.0 - q), p * q
        return [sum(map(mul, shares, corners)) for corners in zip(a, b, c, d, strict=True)]

    def stable_utilisation(self, ratio: float, flywheel: float) -> float:
        """Largest positive torque utilisation that has a steady state and at which −dκ/du · `flywheel` ≥ 0 is below 1.

        The thrust ratio falls towards capacity. Its slopes are taken at the middle of their intervals and interpolated linearly.
        """
        m, p = interval(self._plain.ratios, ratio)
        low, high = (
            interpolate(1.0, [flywheel * fall for fall in falls], places) for places, falls in self._falls[m : m + 2]
        )
        return (1.0 - p) * low + p * high

    def thrust_ratio(self, ratio: float, utilisation: float) -> float:
        """Thrust ratio that holds a ratio."""
        return self._at(self._plain.thrust, ratio, utilisation)

    def slip(self, ratio: float, utilisation: float) -> float:
        """Slip in the steady state."""
        return self._at(self._plain.slips, ratio, utilisation)

    def _at(self, table: Sequence[Sequence[float]], ratio: float, utilisation: float) -> float:
        m, p = interval(self._plain.ratios, ratio)
        n, q = interval(self._plain.utilisations, utilisation)
        low, high = ((1.0 - q) * row[n] + q * row[n + 1] for row in table[m : m + 2])
        return (1.0 - p) * low + p * high

    def write(self, path: Path, key: str) -> None:
        """Writes the map as CSV without loss of digits: a comment with key and shift rates, then one row per point."""
        path.parent.mkdir(parents=True, exist_ok=True)
        shifting = {
            "excesses": self.excesses.tolist(),
            "shiftRates": self.shift_rates.tolist(),
            "clearanceForce": self.clearance_force,
        }
        rows = (
            (ratio, utilisation, self.thrust[m, n], self.slips[m, n])
            for m, ratio in enumerate(self.ratios)
            for n, utilisation in enumerate(self.utilisations)
        )
        header = [tables.title(name, "1") for name in ("ratio", "utilisation", "thrustRatio", "slip")]
        tables.write(path, header, rows, digits=None, remark=json.dumps({"key": key, **shifting}))

    @classmethod
    def of_maps(cls, maps: Maps) -> ThrustMap:
        """The map at `SPEED` and `FORCE` of the maps of `pushbelt maps`, which need these shift utilisations.

        Tables are interpolated linearly in the force and in the square of the speed.
        """
        axes = maps.axes
        if tuple(axes["shiftUtilisation"]) != SHIFT_UTILISATIONS:
            raise ValueError(f"the maps have no shifts at the torque utilisations {SHIFT_UTILISATIONS}")

        def at(name: str, force: float) -> Array:
            (f, a), (s, b) = _within(axes["force"], force), _within(axes["speed"] ** 2, SPEED**2)
            low, high = ((1.0 - b) * maps[name][k, s[0]] + b * maps[name][k, s[1]] for k in f)
            return (1.0 - a) * low + a * high

        rates = at("shiftRate", FORCE) / FORCE
        below = int(np.flatnonzero(axes["excess"] == 0.0)[0])
        near = slice(max(below - 1, 0), below + 2)
        quotients = at("shiftRate", OTHER_FORCE)[..., near] / np.where(rates == 0.0, np.inf, rates * FORCE)[..., near]
        clearance = _clearance_of(float(np.median(quotients[quotients > 0.0])))
        return cls(
            axes["ratio"], axes["utilisation"], at("thrustRatio", FORCE), at("slip", FORCE), axes["excess"], rates, clearance
        )

    @classmethod
    def read(cls, path: Path, key: str | None = None) -> ThrustMap | None:
        """Reads a file of `write`. Returns None if it is missing or damaged, or if its key differs from the given one."""
        try:
            with path.open(encoding="utf-8", newline="") as file:
                head = json.loads(file.readline().removeprefix("#"))
                if key is not None and head["key"] != key:
                    return None
                rows = np.array(list(csv.reader(file))[1:], dtype=float)
            ratios, utilisations = np.unique(rows[:, 0]), np.unique(rows[:, 1])
            shape = (len(ratios), len(utilisations))
            thrust, slips = (rows[:, k].reshape(shape) for k in (2, 3))
            excesses, rates = (np.array(head[name], dtype=float) for name in ("excesses", "shiftRates"))
            return cls(ratios, utilisations, thrust, slips, excesses, rates, float(head["clearanceForce"]))
        except (OSError, ValueError, LookupError, TypeError, RecursionError):
            return None


def map_key(fmu: Path, parameters: Parameters) -> str:
    """Hash of everything that a cached map depends on: the FMU's bytes, the parameters and the grid."""
    text = json.dumps(
        [
            dict(parameters),
            RATIOS,
            UTILISATIONS,
            SPEED,
            FORCE,
            SHIFT_UTILISATIONS,
            SHIFT_SHARES,
            SHIFT_TIME,
            SHIFT_STEP,
            SHIFT_REACH,
            OTHER_FORCE,
            OTHER_SHARES,
            OTHER_UTILISATION,
        ],
        sort_keys=True,
    )
    return hashlib.sha256(fmu.read_bytes() + text.encode()).hexdigest()


def torque_at(parameters: Parameters, ratio: float, utilisation: float, force: float = FORCE) -> float:
    """Primary torque for a utilisation under a secondary clamping force in N, N·m."""
    return utilisation * torque_capacity(parameters, ratio, force)


def _start(archive: Archive, parameters: Parameters, ratio: float, torque: float, force: float = FORCE) -> Variator:
    unit = Variator(
        archive,
        {
            **parameters,
            "initial.ratio": ratio,
            "initial.primarySpeed": SPEED,
            "initial.steady": True,
            "primary.torque": torque,
            "secondary.torque": -torque * ratio,
            "secondary.clampingForce": force,
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
        raise UnitError(f"too few steady states at ratio {ratio:g}: {len(found)} of {len(UTILISATIONS)}")
    share, thrust, slip = np.array(sorted(found)).T
    return np.interp(UTILISATIONS, share, thrust), np.interp(UTILISATIONS, share, slip)


def measured_shift_rates(
    archive: Archive,
    parameters: Parameters,
    ratio: float,
    utilisation: float,
    force: float = FORCE,
    shares: Sequence[float] = SHIFT_SHARES,
) -> Array:
    """Shift speeds over ω_P and a secondary force, N, after a jump of the primary force from its value in the steady state."""
    rates = []
    with (
        _start(archive, parameters, ratio, torque_at(parameters, ratio, utilisation, force), force) as unit,
        unit.stored() as restore,
    ):
        outputs = unit.reals(["primary.axialForce", "ratio.geometric"])
        holding, begin = unit.get_reals(outputs)
        for share in shares:
            restore()
            unit.set({"primary.clampingForce": share * holding})
            logs = [math.log(begin)]
            while abs(logs[-1] - logs[0]) < SHIFT_REACH and len(logs) * SHIFT_STEP <= SHIFT_TIME:
                unit.step_to(len(logs) * SHIFT_STEP)
                logs.append(math.log(unit.get_reals(outputs)[1]))
            # The first half of the time contains the transient after the jump.
            half = (len(logs) - 1) // 2
            rates.append((logs[half] - logs[-1]) / ((len(logs) - 1 - half) * SHIFT_STEP * SPEED * force))
    return np.array(rates)


def _clearance_force(archive: Archive, parameters: Parameters) -> float:
    """F_c, N, from shift rates at the map's force and at `OTHER_FORCE`: the median over ratios and forces."""
    at_map, at_other = (
        np.array(
            [
                measured_shift_rates(archive, parameters, r, OTHER_UTILISATION, force, OTHER_SHARES) * force
                for r in RATIOS
            ]
        )
        for force in (FORCE, OTHER_FORCE)
    )
    return _clearance_of(float(np.median(at_other / at_map)))


def _clearance_of(quotient: float) -> float:
    """F_c, N, from the quotient of the shift rates at `OTHER_FORCE` and at the map's force."""
    # The quotient is 1 for a tilt by clearance alone, and the quotient of the forces for a tilt by bending alone.
    share = clip(quotient, OTHER_FORCE / FORCE, 0.98)
    return (share * FORCE - OTHER_FORCE) / (1.0 - share)


def _within(axis: Array, at: float) -> tuple[tuple[int, int], float]:
    """Indices of the neighbours on an ascending axis, and the share of the upper one; constant beyond it."""
    upper = int(np.clip(np.searchsorted(axis, at), 1, max(len(axis) - 1, 1)))
    if len(axis) == 1:
        return (0, 0), 0.0
    return (upper - 1, upper), float(np.clip((at - axis[upper - 1]) / (axis[upper] - axis[upper - 1]), 0.0, 1.0))


def _ascending(rates: Array, excesses: Array) -> Array:
    """Signed rates, made monotone in the excess. Where a larger excess shows no larger rate, the rate is constant."""
    zero = int(np.argmin(np.abs(excesses)))
    least = 1e-6 * np.abs(rates).max() * np.abs(excesses)
    rising = np.maximum.accumulate(np.maximum(rates[zero:], least[zero:]))
    falling = np.maximum.accumulate(np.maximum(-rates[zero::-1], least[zero::-1]))[::-1]
    return np.concatenate([-falling[:-1], rising])


def compute(archive: Archive, parameters: Parameters) -> ThrustMap:
    """Solves for the map. Points at which the belt slips through get the values of their neighbour."""
    rows = [_row(archive, parameters, ratio) for ratio in RATIOS]
    thrust, slip = (np.array([row[k] for row in rows]) for k in (0, 1))
    below = sum(share < 1.0 for share in SHIFT_SHARES)
    excesses = np.insert(np.log(SHIFT_SHARES), below, 0.0)

    def rates(ratio: float, utilisation: float) -> Array:
        return _ascending(
            np.insert(measured_shift_rates(archive, parameters, ratio, utilisation), below, 0.0), excesses
        )

    found = np.array([[rates(ratio, utilisation) for utilisation in SHIFT_UTILISATIONS] for ratio in RATIOS])
    clearance_force = _clearance_force(archive, parameters)
    return ThrustMap(np.array(RATIOS), np.array(UTILISATIONS), thrust, slip, excesses, found, clearance_force)


def load(fmu: Path, archive: Archive, parameters: Parameters, cache: Path) -> ThrustMap:
    """The map from its cache file. If the file is missing, the map is solved for and written."""
    key = map_key(fmu, parameters)
    found = ThrustMap.read(cache, key)
    if found is None:
        found = compute(archive, parameters)
        found.write(cache, key)
    return found
