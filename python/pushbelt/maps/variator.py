"""Arrays of variators from maps: the equations of `PushbeltMap.fmu` in numpy, for sweeps and optimisation.

    variators = pushbelt.MapVariator(count=1000)
    variators.start(ratio=1.0, primary_speed=200.0)
    variators.step(0.01, primary_torque=60.0, secondary_torque=-49.0, primary_force=13e3, secondary_force=10e3)
    print(variators.ratio, variators.slip)

The tables are those of the FMU: monotone cubics in ratio and utilisation, linear in the force and in the square of the speed. Both shafts are driven
by torques and both sheaves by forces. A step is an implicit Euler step, so it is of first order; the FMU's steps are of second order.
"""

from __future__ import annotations

import json
import math
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator

from . import unit as map_unit
from ..errors import ArgumentError
from ..fmu.data import pitch_radius
from ..fmu.geometry import Array
from .data import MapError, Maps
from .plan import stops

SLIP_SPEED = 0.1
"""Regularisation speed of the slip, m/s."""
FADING_SPEED = 2.0
"""Speed below which drag and belt loss fade, rad/s."""
LEAST_FORCE = 1.0
"""Smallest force in a quotient of forces, N."""
RATIOS, UTILISATIONS, SHARES, EXCESSES, RADII = 65, 97, 257, 97, 257
"""Numbers of places of the refined tables and of the table of radii, as in the FMU."""
BLOCK = 2048
"""Variators that are computed together, so that intermediate arrays stay in the processor's cache."""
ITERATIONS = 3
"""Newton iterations for the sliding speed."""

ENDS = (slice(None, -1), slice(1, None))
"""Lower and upper ends of all intervals of an axis."""

Tables = Mapping[str, Any]


class _Sheet:
    """Refined tables with the same last axis. The sixteen corners of a cell are stored together."""

    def __init__(self, even: Array, *tables: Array) -> None:
        self.first, self.count = float(even[0]), len(even)
        self.per_step = (len(even) - 1) / (float(even[-1]) - float(even[0]))
        corners = [table[f, s, r, x] for table in tables for x in ENDS for f in ENDS for s in ENDS for r in ENDS]
        cells = np.stack(corners, axis=-1)
        self.rows = np.ascontiguousarray(cells.reshape(-1, 16 * len(tables)))

    def find(self, lines: Array, x: Array) -> tuple[Array, Array]:
        """Rows of the cells, and the places within them."""
        scaled = np.clip((x - self.first) * self.per_step, 0.0, self.count - 1.0)
        cell = np.minimum(scaled.astype(np.intp), self.count - 2)
        return self.rows.take(lines * (self.count - 1) + cell, axis=0), scaled - cell

    def at(self, lines: Array, weights: Array, x: Array, table: int = 0) -> tuple[Array, Array]:
        """Values and slopes along the last axis."""
        rows, t = self.find(lines, x)
        return self.of(rows, t, weights, table)

    def of(self, rows: Array, t: Array, weights: Array, table: int = 0) -> tuple[Array, Array]:
        """Values and slopes of a table in rows of cells."""
        low = np.einsum("nk,nk->n", rows[:, 16 * table : 16 * table + 8], weights)
        rise = np.einsum("nk,nk->n", rows[:, 16 * table + 8 : 16 * table + 16], weights) - low
        return low + t * rise, rise * self.per_step


class MapVariator:
    """`count` variators from maps. States are arrays of this length."""

    def __init__(
        self, maps: Maps | Path | str | None = None, parameters: Mapping[str, float] | None = None, *, count: int = 1
    ) -> None:
        """From maps, a file of maps (`maps.nc`) or a map FMU; by default from the tables of `bench168`.

        `parameters` are changes of the parameters that the FMU has as variables, such as `secondary.inertia`.
        """
        document = _document(maps)
        self.parameters: dict[str, float] = dict(document["startValues"])
        for name, value in (parameters or {}).items():
            if name not in self.parameters:
                raise ArgumentError(
                    f"{name} is no parameter of a variator from maps: {', '.join(sorted(self.parameters))}"
                )
            self.parameters[name] = float(value)
        self._geometry = document["parameters"]
        self._build(document)
        self.count = count
        self.primary_speed, self.secondary_speed, self.log_ratio = (np.zeros(count) for _ in range(3))

    @property
    def ratio(self) -> Array:
        """Geometric ratios r_S/r_P."""
        return np.exp(self.log_ratio)

    @property
    def slip(self) -> Array:
        """1 − (ω_S/ω_P) i; 0 at standstill."""
        running = np.abs(self.primary_speed) > 1e-3
        return np.where(
            running, 1.0 - self.secondary_speed * self.ratio / np.where(running, self.primary_speed, 1.0), 0.0
        )

    def start(self, ratio: ArrayLike = 1.0, primary_speed: ArrayLike = 200.0, slip: ArrayLike = 0.0) -> None:
        """Sets the states. Ratios beyond the end stops are set to them."""
        self.log_ratio = np.clip(np.log(np.broadcast_to(ratio, self.count)), *self._stops)
        self.primary_speed = np.broadcast_to(np.asarray(primary_speed, dtype=float), self.count).copy()
        self.secondary_speed = self.primary_speed * (1.0 - np.broadcast_to(slip, self.count)) / self.ratio

    def step(
        self,
        duration: float,
        primary_torque: ArrayLike,
        secondary_torque: ArrayLike,
        primary_force: ArrayLike,
        secondary_force: ArrayLike,
    ) -> None:
        """Advances by a duration (s) under torques (N·m) and clamping forces (N), which are numbers or arrays."""
        inputs = [
            np.broadcast_to(np.asarray(value, dtype=float), self.count)
            for value in (primary_torque, secondary_torque, primary_force, secondary_force)
        ]
        state = (self.primary_speed, self.secondary_speed, self.log_ratio)
        found = tuple(np.empty(self.count) for _ in state)
        for first in range(0, self.count, BLOCK):
            part = slice(first, first + BLOCK)
            values = self._step(duration, *(one[part] for one in state), *(one[part] for one in inputs))
            for target, value in zip(found, values, strict=True):
                target[part] = value
        self.primary_speed, self.secondary_speed, self.log_ratio = found

    # Equations

    def _step(
        self,
        h: float,
        primary: Array,
        secondary: Array,
        log_ratio: Array,
        into: Array,
        out: Array,
        closing: Array,
        force: Array,
    ) -> tuple[Array, Array, Array]:
        p = self.parameters
        lines, weights = self._place(force, primary, log_ratio)
        ratio, radius = np.exp(log_ratio), self._radius(log_ratio)
        around = radius * primary
        speed = np.sqrt(around * around + SLIP_SPEED * SLIP_SPEED)
        forward = 0.5 * (1.0 + np.clip(1.001 * around / speed, -1.0, 1.0))
        one_way = bool(np.all(forward == 1.0))
        sheet = self._limits.take(lines, axis=0)
        limits = [np.einsum("nk,nk->n", sheet[:, 8 * k : 8 * k + 8], weights) for k in range(4)]
        capacity = 2.0 * p["friction.pulley"] * radius * force / math.cos(self._geometry["geometry.wedgeAngle"])

        def ahead(v: Array) -> tuple[Array, Array]:
            return self._traction(lines, weights, limits, speed, v)

        def traction(v: Array) -> tuple[Array, Array]:
            if one_way:
                return ahead(v)
            (value, slope), (back, back_slope) = ahead(v), ahead(-v)
            return forward * value - (1.0 - forward) * back, forward * slope + (1.0 - forward) * back_slope

        def mean(of: Any, v: Array) -> tuple[Array, ...]:
            if one_way:
                return of(ahead(v)[0])
            pairs = zip(of(ahead(v)[0]), of(ahead(-v)[0]), strict=True)
            return tuple(forward * a + (1.0 - forward) * b for a, b in pairs)

        log_force = np.log(np.maximum(closing, LEAST_FORCE))

        def at(u: Array) -> tuple[Array, Array, Array]:
            """Belt torque loss, bearing load, shift rate."""
            rows, t = self._points.find(lines, u)
            thrust, lost, load = (self._points.of(rows, t, weights, k)[0] for k in range(3))
            excess = log_force - np.log(np.maximum(thrust * force, LEAST_FORCE))
            return lost, load, self._shift(lines, weights, u, excess)

        v = radius * (primary - ratio * secondary)
        lost, load, rate = mean(at, v)
        new_log = np.clip(log_ratio - h * np.abs(primary) * rate, *self._stops)
        # Speeds are linear in the torque T_P: v = v_0 − m u.
        ratio, radius = np.exp(new_log), self._radius(new_log)
        fading = np.tanh(primary / FADING_SPEED)
        free_p, per_p = self._shaft("primary", h, primary, into, load)
        free_s, per_s = self._shaft("secondary", h, secondary, out - ratio * fading * lost, load)
        free = radius * (free_p - ratio * free_s)
        m = radius * (per_p + ratio * ratio * per_s) * capacity
        low, high = free - 2.0 * m, free + 2.0 * m
        for _ in range(ITERATIONS):
            u, slope = traction(v)
            v = np.clip(v - (v - free + m * u) / np.maximum(1.0 + m * slope, 0.1), low, high)
        torque = capacity * traction(v)[0]
        return free_p - per_p * torque, free_s + per_s * ratio * torque, new_log

    def _shaft(self, pulley: str, h: float, speed: Array, torque: Array, load: Array) -> tuple[Array, Array]:
        """Speed without the belt's torque, and its change per torque."""
        p = self.parameters
        loaded = p[f"{pulley}.drag.constant"] + p[f"{pulley}.bearing.friction"] * p[f"{pulley}.bearing.radius"] * load
        direction = np.tanh(speed / FADING_SPEED)
        drag = direction * loaded + p[f"{pulley}.drag.viscous"] * speed
        slope = (1.0 - direction * direction) / FADING_SPEED * loaded + p[f"{pulley}.drag.viscous"]
        per = h / (p[f"{pulley}.inertia"] + h * slope)
        return speed + per * (torque - drag), per

    def _traction(
        self, lines: Array, weights: Array, limits: list[Array], speed: Array, v: Array
    ) -> tuple[Array, Array]:
        """Utilisation of forward running at sliding speeds, and its slope."""
        driving = v >= 0.0
        reach = np.where(driving, limits[3], -limits[2]) * speed
        share = v / reach
        value, slope = self._tractions.at(lines, weights, share)
        slope /= reach
        beyond = np.abs(share) > 1.0
        if beyond.any():
            fall, fall_speed = self._geometry["friction.fall"], self._geometry["friction.fallSpeed"]
            decay = np.exp(-np.maximum(np.abs(v) - reach, 0.0) / fall_speed)
            most = np.where(driving, limits[1], limits[0])
            value = np.where(beyond, most * (1.0 - fall * (1.0 - decay)), value)
            slope = np.where(beyond, -np.abs(most) * fall * decay / fall_speed, slope)
        return value, slope

    def _shift(self, lines: Array, weights: Array, u: Array, excess: Array) -> Array:
        axis = self._shift_utilisations
        rates = self._rates.find(lines, excess)
        values = [self._rates.of(*rates, weights, k)[0] for k in range(len(axis))]
        found = values[0]
        for k in range(len(axis) - 1):
            share = np.clip((u - axis[k]) / (axis[k + 1] - axis[k]), 0.0, 1.0)
            found = found + share * (values[k + 1] - values[k])
        return found

    def _place(self, force: Array, speed: Array, log_ratio: Array) -> tuple[Array, Array]:
        """Cells of force, speed and ratio, and the weights of their eight corners."""
        parts = [_interval(self._forces, force), _interval(self._squares, speed * speed)]
        scaled = np.clip((log_ratio - self._first) * self._per_step, 0.0, RATIOS - 1.0)
        cell = np.minimum(scaled.astype(np.intp), RATIOS - 2)
        (f, a), (s, b), c = *parts, scaled - cell
        lines = (f * (len(self._squares) - 1) + s) * (RATIOS - 1) + cell
        weights = np.empty((len(force), 8))
        for k, (x, y) in enumerate(((1.0 - a, 1.0 - b), (1.0 - a, b), (a, 1.0 - b), (a, b))):
            product = x * y
            weights[:, 2 * k] = product * (1.0 - c)
            weights[:, 2 * k + 1] = product * c
        return lines, weights

    def _radius(self, log_ratio: Array) -> Array:
        return np.interp(log_ratio, self._radii_places, self._radii)

    # Tables

    def _build(self, document: Tables) -> None:
        axes = {name: np.array(entry["values"], dtype=float) for name, entry in document["axes"].items()}
        tables = {name: np.array(entry["values"], dtype=float) for name, entry in document["tables"].items()}
        logs = np.log(axes["ratio"])
        places = np.linspace(logs[0], logs[-1], RATIOS)
        self._first, self._per_step = logs[0], (RATIOS - 1) / (logs[-1] - logs[0])
        self._forces, self._squares = _padded(axes["force"]), _padded(axes["speed"] ** 2)
        self._shift_utilisations = axes["shiftUtilisation"]

        def along_ratio(table: Array) -> Array:
            fine = _cubic(logs, table, places, axis=2)
            for axis, name in ((0, "force"), (1, "speed")):
                # A single value is constant: it is repeated, so that there is an interval.
                if len(axes[name]) == 1:
                    fine = np.repeat(fine, 2, axis=axis)
            return fine

        def refined(table: Array, along: Array, count: int, rising: bool = False) -> tuple[Array, Array]:
            even = np.linspace(along[0], along[-1], count)
            fine = along_ratio(_cubic(along, table, even, axis=-1))
            return even, np.maximum.accumulate(fine, axis=-1) if rising else fine

        utilisation = axes["utilisation"]
        points = [
            refined(tables[name], utilisation, UTILISATIONS)
            for name in ("thrustRatio", "beltTorqueLoss", "bearingLoad")
        ]
        self._points = _Sheet(points[0][0], *(fine for _, fine in points))
        self._tractions = _Sheet(*refined(tables["traction"], axes["slipShare"], SHARES, rising=True))
        rates = [
            refined(tables["shiftRate"][..., k, :], axes["excess"], EXCESSES, rising=True)
            for k in range(len(self._shift_utilisations))
        ]
        self._rates = _Sheet(rates[0][0], *(fine for _, fine in rates))
        pairs = np.concatenate([along_ratio(tables["capacity"]), along_ratio(tables["capacitySlip"])], axis=-1)
        corners = [pairs[f, s, r, k] for k in range(4) for f in ENDS for s in ENDS for r in ENDS]
        self._limits = np.ascontiguousarray(np.stack(corners, axis=-1).reshape(-1, 32))
        self._build_radii()

    def _build_radii(self) -> None:
        least, most = map(math.log, stops({**self._geometry, **self.parameters}))
        if least >= most:
            raise MapError("the radii at the end stops leave no range of ratios")
        self._stops = (least, most)
        self._radii_places = np.linspace(least - 0.05, most + 0.05, RADII)
        self._radii = np.array([pitch_radius(self._geometry, math.exp(place)) for place in self._radii_places])


def _document(maps: Maps | Path | str | None) -> Tables:
    """The tables of maps, of a file of maps or of a map FMU."""
    if maps is None:
        return json.loads(map_unit.default_maps().read_bytes())
    if isinstance(maps, Maps):
        return json.loads(map_unit.tables_of(maps))
    path = Path(maps)
    if path.suffix != ".fmu":
        return json.loads(map_unit.tables_of(Maps.read(path)))
    try:
        with zipfile.ZipFile(path) as archive:
            return json.loads(archive.read(map_unit.TABLES_FILE))
    except (zipfile.BadZipFile, KeyError, ValueError) as error:
        raise MapError(f"{path} is no FMU of maps: {error}") from error


def _cubic(x: Array, y: Array, at: Array, axis: int) -> Array:
    if len(x) == 1:
        return np.repeat(y, len(at), axis=axis)
    return PchipInterpolator(x, y, axis=axis)(np.clip(at, x[0], x[-1]))


def _padded(axis: Array) -> Array:
    return axis if len(axis) > 1 else np.array([axis[0], axis[0] + 1.0])


def _interval(axis: Array, at: Array) -> tuple[Array, Array]:
    """Indices of the intervals, and the places within them, 0 to 1."""
    cell = np.zeros(len(at), dtype=np.intp)
    for border in axis[1:-1]:
        cell += at > border
    low = axis.take(cell)
    return cell, np.clip((at - low) / (axis.take(cell + 1) - low), 0.0, 1.0)
