"""Arrays of variators from maps: the equations of `PushbeltMap.fmu` in numpy, for sweeps and optimisation.

    variators = pushbelt.MapVariator(count=1000)
    variators.start(ratio=1.0, primary_speed=200.0)
    variators.step(0.01, primary_torque=60.0, secondary_torque=-49.0, primary_force=13e3, secondary_force=10e3)
    print(variators.ratio, variators.slip)

The tables are those of the FMU: monotone cubics in ratio and torque, linear in the force and in the square of the speed. Both shafts are driven
by torques and both sheaves by forces. A step is an implicit Euler step, so it is of first order; the FMU's steps are of second order.
"""

from __future__ import annotations

import json
import math
import os
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import checks, kind, mapping, number, optional, refused, whole
from ..errors import ArgumentError, package, warn
from ..fmu import capacity
from ..fmu.data import pitch_radius
from ..fmu.geometry import Array
from . import unit as map_unit
from .data import AT_SHARES, MapError, Maps, arrays_of
from .plan import stops

PchipInterpolator = package("scipy.interpolate", "MapVariator needs scipy", "maps").PchipInterpolator
map_coordinates = package("scipy.ndimage", "MapVariator needs scipy", "maps").map_coordinates
SLIP_SPEED = 0.1  # Regularisation speed of the slip, m/s
FADING_SPEED = 2.0  # Speed below which drag and belt loss fade, rad/s
LEAST_FORCE = 1.0  # Smallest force in a quotient of forces, N
RATIOS, TORQUES, SHARES, EXCESSES, RADII = 65, 97, 257, 97, 257
"""Numbers of places of the refined tables and of the table of radii, as in the FMU."""
ITERATIONS = 3  # Newton iterations for the sliding speed

Tables = Mapping[str, Any]


class _Table:
    """A refined table over force, speed, ratio and further axes, of which the last is evenly spaced."""

    def __init__(self, even: Array, values: Array) -> None:
        self.first, self.count, self.values = float(even[0]), len(even), values
        self.per_step = (len(even) - 1) / (float(even[-1]) - float(even[0]))

    def at(self, place: Sequence[Array], x: Array) -> Array:
        """Values at places along the first axes and values of the last one."""
        return _linear(self.values, [*place, (x - self.first) * self.per_step])

    def with_slopes(self, place: Sequence[Array], x: Array) -> tuple[Array, Array]:
        """The same, and slopes along the last axis."""
        scaled = np.clip((x - self.first) * self.per_step, 0.0, self.count - 1.0)
        cell = np.minimum(np.floor(scaled), self.count - 2)
        low, high = (_linear(self.values, [*place, cell + end]) for end in (0, 1))
        return low + (scaled - cell) * (high - low), (high - low) * self.per_step


def _linear(values: Array, places: Sequence[Array]) -> Array:
    """Linear interpolation between the indices of an array, constant beyond them."""
    return map_coordinates(values, places, order=1, mode="nearest")


class MapVariator:
    """`count` variators from maps. States are arrays of this length."""

    @checks(maps=optional(kind("maps or a path", Maps, str, os.PathLike)), parameters=optional(mapping), count=whole)
    def __init__(
        self, maps: Maps | str | os.PathLike[str] | None = None, parameters: Mapping[str, float] | None = None, *, count: int = 1
    ) -> None:
        """From maps, a file of maps (`maps.nc`) or a map FMU; by default from the tables of `bench168`.

        `parameters` are changes of the parameters that the FMU has as variables, such as `secondary.inertia`.
        """
        document = _document(maps)
        self.parameters: dict[str, float] = dict(document["startValues"])
        if unknown := [name for name in parameters or () if name not in self.parameters]:
            raise ArgumentError(f"{unknown[0]} is no parameter of a variator from maps: {', '.join(sorted(self.parameters))}")
        for name, value in (parameters or {}).items():
            self.parameters[name] = (number(above=0.0) if name.endswith("inertia") else number(least=0.0))(name, value)
        self._geometry = document["parameters"]
        self._build(document)
        self.count = count
        self.primary_speed, self.secondary_speed, self.log_ratio = (np.zeros(count) for _ in range(3))
        self._started = False  # Whether a step has been taken since the start

    @property
    def ratio(self) -> Array:
        """Geometric ratios r_S/r_P."""
        return np.exp(self.log_ratio)

    @property
    def slip(self) -> Array:
        """1 − (ω_S/ω_P) i; 0 at standstill."""
        running = np.abs(self.primary_speed) > 1e-3
        return np.where(running, 1.0 - self.secondary_speed * self.ratio / np.where(running, self.primary_speed, 1.0), 0.0)

    def _each(self, name: str, value: ArrayLike) -> Array:
        """A value of each variator."""
        try:
            return np.broadcast_to(value, self.count)
        except ValueError:
            raise ArgumentError(refused(name, value, f"a number or {self.count} of them")) from None

    @checks(ratio=number(above=0.0, several=True), primary_speed=number("rad/s", several=True))
    def start(self, ratio: ArrayLike = 1.0, primary_speed: ArrayLike = 200.0) -> None:
        """Sets the states, without slip. Ratios beyond the end stops are set to them."""
        self.log_ratio = np.clip(np.log(self._each("ratio", ratio)), *self._stops)
        self.primary_speed = self._each("primary_speed", primary_speed).copy()
        self.secondary_speed = self.primary_speed / self.ratio
        self._started = False

    @checks(
        duration=number("s", above=0.0),
        **{f"{pulley}_torque": number("N·m", several=True) for pulley in ("primary", "secondary")},
        **{f"{pulley}_force": number("N", least=0.0, several=True) for pulley in ("primary", "secondary")},
    )
    def step(
        self, duration: float, primary_torque: ArrayLike, secondary_torque: ArrayLike, primary_force: ArrayLike,
        secondary_force: ArrayLike,
    ) -> None:  # fmt: skip
        """Advances by a duration (s) under torques (N·m) and whole clamping forces (N), which are numbers or arrays.

        A force that seems to be in kN is an ArgumentError in the first step after the start, and a VariatorWarning later.
        """
        loads = {"primary_torque": primary_torque, "secondary_torque": secondary_torque, "primary_force": primary_force}
        into, out, closing, force = (self._each(*load) for load in (loads | {"secondary_force": secondary_force}).items())
        h, primary, secondary, p = duration, self.primary_speed, self.secondary_speed, self.parameters
        place = list(map(_places, (force, primary * primary, self.log_ratio), self._axes))
        ratio, radius = self.ratio, self._radius(self.log_ratio)
        around = radius * primary
        speed = np.sqrt(around * around + SLIP_SPEED * SLIP_SPEED)
        forward = 0.5 * (1.0 + np.clip(1.001 * around / speed, -1.0, 1.0))
        one_way = bool(np.all(forward == 1.0))
        limits = [_linear(one, place) for one in self._limits]
        capacity = 2.0 * p["friction.pulley"] * radius * force / math.cos(self._geometry["geometry.wedgeAngle"])
        self._check_units(into, force, capacity)

        def ahead(v: Array) -> tuple[Array, Array]:
            return self._traction(place, limits, speed, v)

        def traction(v: Array) -> tuple[Array, Array]:
            if one_way:
                return ahead(v)
            (value, slope), (back, back_slope) = ahead(v), ahead(-v)
            return forward * value - (1.0 - forward) * back, forward * slope + (1.0 - forward) * back_slope

        log_force = np.log(np.maximum(closing, LEAST_FORCE))

        def at(u: Array) -> tuple[Array, Array, Array]:
            """Belt torque loss, bearing load, shift rate."""
            share = u / np.where(u < 0.0, -limits[0], limits[1])
            thrust, lost, load = (table.at(place, share) for table in self._points)
            excess = log_force - np.log(np.maximum(thrust * force, LEAST_FORCE))
            return lost, load, self._rates.at([*place, _places(u, self._shift_utilisations)], excess)

        v = radius * (primary - ratio * secondary)
        lost, load, rate = at(ahead(v)[0])
        if not one_way:
            behind = at(ahead(-v)[0])
            lost, load, rate = (forward * a + (1.0 - forward) * b for a, b in zip((lost, load, rate), behind, strict=True))
        new_log = np.clip(self.log_ratio - h * np.abs(primary) * rate, *self._stops)
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
        self.primary_speed, self.secondary_speed = free_p - per_p * torque, free_s + per_s * ratio * torque
        self.log_ratio = new_log

    def _check_units(self, torques: Array, forces: Array, carried: Array) -> None:
        """Refuses a load in a wrong unit, or warns of it later, by the first variator whose belt does not carry its torque."""
        for k in np.flatnonzero(np.abs(torques) > capacity.BEYOND * carried + capacity.DRAG)[:1]:
            if hint := capacity.wrong_unit(torques[k], forces[k], carried[k]):
                why = f"secondary_force = {forces[k]:g} N carries {carried[k]:.3g} N·m, primary_torque is {torques[k]:g} N·m{hint}"
                if not self._started:
                    raise ArgumentError(why)
                warn(why)
        self._started = True

    def _shaft(self, pulley: str, h: float, speed: Array, torque: Array, load: Array) -> tuple[Array, Array]:
        """Speed without the belt's torque, and its change per torque."""
        p = self.parameters
        loaded = p[f"{pulley}.drag.constant"] + p[f"{pulley}.bearing.friction"] * p[f"{pulley}.bearing.radius"] * load
        direction = np.tanh(speed / FADING_SPEED)
        drag = direction * loaded + p[f"{pulley}.drag.viscous"] * speed
        slope = (1.0 - direction * direction) / FADING_SPEED * loaded + p[f"{pulley}.drag.viscous"]
        per = h / (p[f"{pulley}.inertia"] + h * slope)
        return speed + per * (torque - drag), per

    def _traction(self, place: Sequence[Array], limits: Sequence[Array], speed: Array, v: Array) -> tuple[Array, Array]:
        """Utilisation of forward running at sliding speeds, and its slope."""
        driving = v >= 0.0
        reach = np.where(driving, limits[3], -limits[2]) * speed
        share = v / reach
        value, slope = self._tractions.with_slopes(place, share)
        slope = slope / reach
        beyond = np.abs(share) > 1.0
        if beyond.any():
            fall, fall_speed = self._geometry["friction.fall"], self._geometry["friction.fallSpeed"]
            decay = np.exp(-np.maximum(np.abs(v) - reach, 0.0) / fall_speed)
            most = np.where(driving, limits[1], limits[0])
            value = np.where(beyond, most * (1.0 - fall * (1.0 - decay)), value)
            slope = np.where(beyond, -np.abs(most) * fall * decay / fall_speed, slope)
        return value, slope

    def _radius(self, log_ratio: Array) -> Array:
        return np.interp(log_ratio, self._radii_places, self._radii)

    # Tables

    def _build(self, document: Tables) -> None:
        axes, tables = arrays_of(document)
        logs = np.log(axes["ratio"])
        places = np.linspace(logs[0], logs[-1], RATIOS)
        self._axes = axes["force"], axes["speed"] ** 2, places
        self._shift_utilisations = axes["shiftUtilisation"]

        def refined(values: Array) -> Array:
            return _cubic(logs, values, places, axis=2)

        def sheet(name: str, along: str, count: int, rising: bool = False) -> _Table:
            even = np.linspace(axes[along][0], axes[along][-1], count)
            fine = refined(_cubic(axes[along], tables[name], even, axis=-1))
            return _Table(even, np.maximum.accumulate(fine, axis=-1) if rising else fine)

        self._points = [sheet(name, "torqueShare", TORQUES) for name in AT_SHARES]
        self._tractions = sheet("traction", "slipShare", SHARES, rising=True)
        self._rates = sheet("shiftRate", "excess", EXCESSES, rising=True)
        # Least and greatest utilisation at capacity, and the slips there.
        self._limits = [refined(tables[name][..., end]) for name in ("capacity", "capacitySlip") for end in (0, 1)]
        least, most = map(math.log, stops({**self._geometry, **self.parameters}))
        if least >= most:
            raise MapError("the radii at the end stops leave no range of ratios")
        self._stops = (least, most)
        self._radii_places = np.linspace(least - 0.05, most + 0.05, RADII)
        self._radii = np.array([pitch_radius(self._geometry, math.exp(place)) for place in self._radii_places])


def _document(maps: Maps | str | os.PathLike[str] | None) -> Tables:
    """The tables of maps, of a file of maps or of a map FMU."""
    if maps is None:
        return json.loads(map_unit.default_maps().read_bytes())
    if isinstance(maps, Maps) or Path(maps).suffix != ".fmu":
        return json.loads(map_unit.tables_of(maps if isinstance(maps, Maps) else Maps.read(Path(maps))))
    try:
        with zipfile.ZipFile(maps) as archive:
            return json.loads(archive.read(map_unit.TABLES_FILE))
    except (zipfile.BadZipFile, KeyError, ValueError) as error:
        raise MapError(f"{maps} is no FMU of maps: {error}") from error


def _places(values: Array, axis: Array) -> Array:
    """Places of values along an axis, by its indices."""
    return np.interp(values, axis, np.arange(len(axis)))


def _cubic(x: Array, y: Array, at: Array, axis: int) -> Array:
    if len(x) == 1:
        return np.repeat(y, len(at), axis=axis)
    return PchipInterpolator(x, y, axis=axis)(np.clip(at, x[0], x[-1]))
