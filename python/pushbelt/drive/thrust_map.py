"""The thrust-ratio map of the controllers: thrust ratio and slip over ratio and torque, and shift rates."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from operator import mul
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np

from pushbelt.errors import ArgumentError
from pushbelt.fmu.geometry import Array

from .piecewise import clip, interpolate, interval

if TYPE_CHECKING:
    from pushbelt.maps.data import Maps

SPEED = 200.0  # Primary speed of the map, rad/s. The thrust ratio depends on it only weakly
FORCE = 12e3  # Secondary clamping force of the map, N
SHIFT_UTILISATIONS = (-0.3, 0.3)  # Torque utilisations at which the shift rate is measured
OTHER_FORCE = 5e3  # Secondary clamping force of the second shift rates, N. They determine the dependence on force
STILL = 1e-4  # Least change of slip over an interval of the utilisation whose ends are both steady states
NEARBY = 0.2  # Range of the excess about its expected value in which the shift gain is taken


@dataclass(frozen=True)
class ThrustMap:
    """Steady states over ratio × torque utilisation. Values are bilinear between the points and constant beyond them."""

    ratios: Array  # Shape (m,), ascending
    utilisations: Array  # Torque utilisations, shape (n,), ascending; positive where the primary pulley drives
    thrust: Array  # Thrust ratio, shape (m, n)
    slips: Array  # Slip, shape (m, n)
    excesses: Array  # ε = ln(F_P/(κ F_S)), shape (k,), ascending, 0 among them
    shift_rates: Array
    """R of d(ln i)/dt = −ω_P F R(ε) at the utilisations `SHIFT_UTILISATIONS`, 1/(N·rad), shape (m, 2, k), ascending along
    ε, 0 at ε = 0. F is the acting force."""
    clearance_force: float = 0.0
    """F_c, N. The shift rate is proportional to the tilt of the sheaves, which is their clearance plus bending that grows with
    force. At F_c bending is as large as the clearance. With F_c = 0 the shift rate is proportional to force."""

    @cached_property
    def _plain(self) -> SimpleNamespace:
        """The tables as plain numbers."""
        return SimpleNamespace(**{name: field.tolist() for name, field in vars(self).items() if isinstance(field, np.ndarray)})

    @cached_property
    def _falls(self) -> list[tuple[list[float], list[float]]]:
        """For each ratio: positive utilisations up to the last steady state, and the largest −dκ/du up to each of them."""
        driving, found = self.utilisations >= 0.0, []
        for thrust, slips in zip(self.thrust[:, driving], self.slips[:, driving], strict=True):
            # Points without a steady state have the values of their neighbour, so the slip does not change there.
            steady = 1 + int(np.sum(np.diff(slips) > STILL))
            places = self.utilisations[driving][:steady]
            slopes = np.diff(thrust[:steady]) / np.diff(places)
            falls = np.maximum.accumulate(-np.append(slopes, slopes[-1]))
            found.append((np.append(0.5 * (places[:-1] + places[1:]), places[-1]).tolist(), falls.tolist()))
        return found

    def acting_force(self, secondary: float) -> float:
        """F of the shift law, N, at a secondary clamping force, N: F_S at the force of the map, F_0 (F_S + F_c)/(F_0 + F_c)."""
        return FORCE * (secondary + self.clearance_force) / (FORCE + self.clearance_force)

    def excess(self, ratio: float, utilisation: float, rate: float) -> float:
        """ε for a shift rate R, 1/(N·rad); linear between the points, constant beyond them."""
        return interpolate(rate, self._rates(ratio, utilisation), self._plain.excesses)

    def shift_gain(self, ratio: float, utilisation: float, excess: float = 0.0, secondary: float = FORCE) -> float:
        """g of d(ln i)/dt = −g ω_P ΔF_P about an excess, 1/(N·rad), at a secondary force, N: the steepest R within ±`NEARBY` of it."""
        low, high = excess - NEARBY, excess + NEARBY
        points = list(zip(self._plain.excesses, self._rates(ratio, utilisation), strict=True))
        near = (pair for pair in pairwise(points) if pair[1][0] > low and pair[0][0] < high)
        # F_P = κ F_S exp ε
        slopes = ((0.5 * (start + end), (rate - before) / (end - start)) for (start, before), (end, rate) in near)
        steepest = max(slope / math.exp(clip(middle, low, high)) for middle, slope in slopes)
        return steepest / self.thrust_ratio(ratio, utilisation) * self.acting_force(secondary) / secondary

    def _rates(self, ratio: float, utilisation: float) -> list[float]:
        """R at the excesses, of length k."""
        m, p = interval(self._plain.ratios, ratio)
        n, q = interval(SHIFT_UTILISATIONS, utilisation)
        (a, b), (c, d) = self._plain.shift_rates[m][n : n + 2], self._plain.shift_rates[m + 1][n : n + 2]
        shares = (1.0 - p) * (1.0 - q), (1.0 - p) * q, p * (1.0 - q), p * q
        return [sum(map(mul, shares, corners)) for corners in zip(a, b, c, d, strict=True)]

    def stable_utilisation(self, ratio: float, flywheel: float) -> float:
        """Largest positive torque utilisation that has a steady state and at which −dκ/du · `flywheel` ≥ 0 is below 1. The
        thrust ratio falls towards capacity. Its slopes are taken at the middle of their intervals and interpolated linearly."""
        m, p = interval(self._plain.ratios, ratio)
        low, high = (interpolate(1.0, [flywheel * fall for fall in falls], places) for places, falls in self._falls[m : m + 2])
        return (1.0 - p) * low + p * high

    def thrust_ratio(self, ratio: float, utilisation: float) -> float:
        """Thrust ratio that holds a ratio."""
        return self._at(self._plain.thrust, ratio, utilisation)

    def slip(self, ratio: float, utilisation: float) -> float:
        return self._at(self._plain.slips, ratio, utilisation)

    def _at(self, table: Sequence[Sequence[float]], ratio: float, utilisation: float) -> float:
        m, p = interval(self._plain.ratios, ratio)
        n, q = interval(self._plain.utilisations, utilisation)
        low, high = ((1.0 - q) * row[n] + q * row[n + 1] for row in table[m : m + 2])
        return (1.0 - p) * low + p * high

    @classmethod
    def of_maps(cls, maps: Maps) -> ThrustMap:
        """The map at `SPEED` and `FORCE` of the maps of `pushbelt maps`, whose shifts must include these utilisations. Tables are
        interpolated linearly in the force, in the square of the speed, and in the utilisation of shifts."""
        axes, shifted = maps.axes, maps.axes["shiftUtilisation"]
        if shifted[0] > SHIFT_UTILISATIONS[0] or shifted[-1] < SHIFT_UTILISATIONS[-1]:
            raise ArgumentError(f"the maps have no shifts between the torque utilisations {SHIFT_UTILISATIONS}")

        def at(name: str, force: float) -> Array:
            table = maps[name]
            for axis, value in ((axes["force"], force), (axes["speed"] ** 2, SPEED**2)):
                place = float(np.interp(value, axis, np.arange(len(axis))))
                low, high = table[math.floor(place)], table[math.ceil(place)]
                table = low + place % 1.0 * (high - low)
            return table

        def shift_rates(force: float) -> Array:
            places, table = np.interp(SHIFT_UTILISATIONS, shifted, np.arange(len(shifted))), at("shiftRate", force)
            low, high = (table[:, ends.astype(int)] for ends in (np.floor(places), np.ceil(places)))
            return low + (places % 1.0)[:, None] * (high - low)

        rates = shift_rates(FORCE) / FORCE
        below = int(np.flatnonzero(axes["excess"] == 0.0)[0])
        near = slice(max(below - 1, 0), below + 2)
        quotients = shift_rates(OTHER_FORCE)[..., near] / np.where(rates == 0.0, np.inf, rates * FORCE)[..., near]
        # The quotient is 1 for a tilt by clearance alone, and the quotient of the forces for a tilt by bending alone.
        share = clip(float(np.median(quotients[quotients > 0.0])), OTHER_FORCE / FORCE, 0.98)
        clearance = (share * FORCE - OTHER_FORCE) / (1.0 - share)
        return cls(axes["ratio"], axes["utilisation"], at("thrustRatio", FORCE), at("slip", FORCE), axes["excess"], rates, clearance)
