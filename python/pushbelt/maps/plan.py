"""What is solved: an FMU, parameters and axes, with an identity of all that determines the results; and maps of the solved lines."""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property, partial
from typing import Any

import numpy as np

from pushbelt.errors import ArgumentError
from pushbelt.fmu import bands, gradients, steady, working_points
from pushbelt.fmu.data import pitch_radius, torque_capacity
from pushbelt.fmu.geometry import Array
from pushbelt.fmu.gradients import Asked
from pushbelt.fmu.start_values import checked
from pushbelt.fmu.steady import SteadyStates
from pushbelt.fmu.working_points import POINT_COLUMNS, SHAFTS, SHOWN, Along, Line, camel, drag, slope
from pushbelt.study.tasks import Row, Tasks, ascending, spread

from . import line
from .data import AT_SHARES, AXES, POINT, STATES, TABLES, Maps, Quantity

COLUMNS = {camel(name): name for name in POINT_COLUMNS if name != "pastPeak"}
"""Tables that are columns of the measured points: `lossSheaves` of `loss.sheaves`."""
MARGIN = 1.06
"""Factor between the ratios of the end stops and the outermost ratios. A loaded belt rests within it of the stops."""


@dataclass(frozen=True)
class Grid:
    """Axes of the maps, each ascending."""

    force: tuple[float, ...] = (2500.0, 6000.0, 15000.0, 40000.0)  # Secondary clamping force, N
    speed: tuple[float, ...] = (60.0, 200.0, 450.0)  # Primary speed, rad/s
    ratio: tuple[float, ...] = ()  # Geometric ratio; empty for `ratios` values between the end stops
    ratios: int = 7
    utilisation: tuple[float, ...] = (-0.9, -0.75, -0.6, -0.45, -0.3, -0.15, 0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9)
    """Torque utilisation; negative where the secondary pulley drives."""
    slip_share: tuple[float, ...] = (-1.0, -0.6, -0.35, -0.15, -0.05, 0.0, 0.05, 0.15, 0.35, 0.6, 1.0)
    """Slips of the traction, divided by the slip at capacity."""
    torque_share: tuple[float, ...] = (
        -1.0, -0.92, -0.8, -0.6, -0.4, -0.25, -0.16, -0.08, 0.0, 0.08, 0.16, 0.33, 0.5, 0.65, 0.78, 0.86, 0.92, 0.97, 1.0,
    )  # fmt: skip
    """Torques of the states for the FMU of maps, divided by that at capacity. The thrust ratio is steep near 0 and near the capacity."""
    shift_utilisation: tuple[float, ...] = (-0.5, 0.0, 0.5, 0.8)  # Torque utilisations at which shifts are measured
    excess: tuple[float, ...] = (-0.9, -0.5, -0.25, -0.1, 0.0, 0.1, 0.25, 0.5, 0.9)
    """ln(F_P/(κ F_S)) of the shifts, with 0."""

    def __post_init__(self) -> None:
        for one in fields(self):
            values = getattr(self, one.name)
            if one.name != "ratios" and (values or one.name != "ratio"):
                values = ascending(one.name, values, positive=one.name in ("force", "speed", "ratio"))
                object.__setattr__(self, one.name, values)
        if 0.0 not in self.excess:
            raise ArgumentError("0 must be among the values of excess")
        for name in ("slip_share", "torque_share"):
            values = getattr(self, name)
            if (values[0], values[-1]) != (-1.0, 1.0) or 0.0 not in values:
                raise ArgumentError(f"the values of {name} must begin with -1, contain 0 and end with 1")


COARSE = Grid()  # 84 lines with 13 points each
SHORT = Grid(force=(6000.0, 15000.0), speed=(100.0, 300.0), ratios=3)  # 12 lines


def stops(parameters: Mapping[str, float]) -> tuple[float, float]:
    """Geometric ratios of the unloaded belt at the end stops that it reaches first, lowest and highest."""

    def at(name: str) -> float:
        """Where a radius is at its limit. That of the primary pulley falls with the ratio, that of the secondary one rises."""
        low, high = 0.05, 20.0
        for _ in range(60):
            middle = math.sqrt(low * high)
            radius = pitch_radius(parameters, middle)
            beyond = radius < parameters[name] if name.startswith("primary") else middle * radius > parameters[name]
            low, high = (low, middle) if beyond else (middle, high)
        return math.sqrt(low * high)

    lowest = max(at("primary.maxRadius"), at("secondary.minRadius"))
    return lowest, min(at("primary.minRadius"), at("secondary.maxRadius"))


@dataclass(frozen=True)
class Plan(Tasks):
    """The lines of a grid, for an FMU and a variator."""

    grid: Grid = COARSE
    deviations: Mapping[str, float] = field(default_factory=dict)  # Standard deviations of parameters, for bands
    asked: Asked = gradients.NOTHING

    def __post_init__(self) -> None:
        object.__setattr__(self, "parameters", checked(self.variables, self.parameters, {"parameter"}))
        object.__setattr__(self, "asked", self.asked.checked(self.variables))

    @cached_property
    def full(self) -> dict[str, float]:
        """All parameters of the FMU: those that are given, and the defaults of the others."""
        parameters = {name: one.start for name, one in self.variables.items() if one.causality == "parameter"}
        defaults = {name: start for name, start in parameters.items() if not name.startswith(("initial.", "solver."))}
        return {**checked(self.variables, defaults, {"parameter"}), **self.parameters}

    @cached_property
    def ratios(self) -> tuple[float, ...]:
        """Geometric ratios: those of the grid, or evenly spaced in ln i between the end stops."""
        if self.grid.ratio:
            return self.grid.ratio
        low, high = stops(self.full)
        return spread(low * MARGIN, high / MARGIN, self.grid.ratios)

    procedure = (line, working_points, steady, bands, gradients)

    @property
    def measure(self) -> Callable[[SteadyStates, Line], Row]:
        excesses = tuple(excess for excess in self.grid.excess if excess != 0.0)
        shafts = {name: one for name, one in self.full.items() if ".drag." in name or ".bearing." in name}
        grid = self.grid
        along = Along(grid.utilisation, grid.slip_share, shafts, self.deviations, self.asked)
        return partial(line.measure, along=along, shares=grid.torque_share, shifted=grid.shift_utilisation, excesses=excesses)

    @property
    def common(self) -> Mapping[str, float]:  # type: ignore[override]
        # The forces of the maps are whole ones. The driven shaft is so light that it does not load the belt in a shift.
        whole = {name: 0.0 for name in self.full if ".cylinder." in name}
        return {**self.full, **SHAFTS, **whole, "secondary.inertia": 0.003}

    def tasks(self) -> list[Line]:
        """All lines; the ratio varies fastest."""
        return [Line(*values) for values in itertools.product(self.grid.force, self.grid.speed, self.ratios)]

    def document(self) -> dict[str, Any]:
        grid = {**asdict(self.grid), "ratio": self.ratios}
        return {"parameters": dict(self.full), "grid": grid, "deviations": dict(self.deviations), "gradient": self.asked}

    @property
    def added(self) -> dict[str, Quantity]:
        """Tables of standard deviations and derivatives."""
        units = {name: TABLES[name].unit for name in SHOWN}
        slopes = self.asked.columns(units, self.variables)
        banded = units.items() if self.deviations else ()
        found = {f"{name}Deviation": Quantity(unit, f"Standard deviation of {name}", POINT) for name, unit in banded}
        return found | {slope(name, over): Quantity(unit, text, POINT) for name, over, unit, text in slopes}


# Solved lines


def collect(plan: Plan, rows: Mapping[int, Row]) -> Maps:
    """The maps of all lines. Lines without results have those of the nearest line."""
    found = {index: row for index, row in rows.items() if "points" in row}
    if not found:
        raise ArgumentError(f"no line has a steady state: {'; '.join(sorted({row.get('reason', '') for row in rows.values()}))}")
    grid = plan.grid
    values = (
        grid.force, grid.speed, plan.ratios, grid.utilisation, (-1.0, 1.0), grid.slip_share, grid.torque_share,
        grid.shift_utilisation, grid.excess,
    )  # fmt: skip
    axes = dict(zip(AXES, map(np.array, values), strict=True))
    route = tuple(len(axes[name]) for name in POINT[:3])
    places, lines = np.array(list(np.ndindex(route))), []
    for index in range(len(places)):
        row = rows.get(index, {})
        if "points" not in row:
            # By indices of the axes; a step along the ratio counts least.
            near = found[min(found, key=lambda other: float(np.abs(places[other] - places[index]) @ (3.0, 2.0, 1.0)))]
            row = {**near, "points": [{**one, "reason": row.get("reason", "not solved")} for one in near["points"]]}
        lines.append(row)
    points = list(itertools.chain.from_iterable(line["points"] for line in lines))
    state, reasons, by = np.zeros((*route, len(grid.utilisation))), dict[str, str](), defaultdict[str, dict[str, str]](dict)
    for place, one in zip(np.ndindex(state.shape), points, strict=True):
        key, why = "/".join(map(str, place)), one.get("reason")
        if why is None:
            state[place] = one["pastPeak"]
            for name, text in one.get("by", {}).items():
                by[name][key] = text
        else:
            state[place] = STATES.index("beyond_capacity" if why.startswith("beyond the capacity") else "not_found")
            reasons[key] = why

    def over_points(name: str) -> Array:
        return np.array([one.get(name) for one in points], dtype=float).reshape(state.shape)

    def over_lines(name: str) -> Array:
        values = np.array([line[name] for line in lines], dtype=float)
        return values.reshape(*route, *values.shape[1:])

    tables = {name: filled(over_points(column)) for name, column in COLUMNS.items()}
    tables["state"], tables["valid"] = state, (state <= STATES.index("slips_through")).astype(float)
    tables |= {name: over_lines(name) for name in ("capacity", "capacitySlip", "traction", "shiftRate")}
    tables["shiftRate"] = monotone(tables["shiftRate"], axes["excess"])
    for name, column in AT_SHARES.items():
        loaded = [[math.nan if one is None else one[column] for one in row["shares"]] for row in lines]
        tables[name] = filled(np.array(loaded).reshape(*route, -1))
    # The slope over the two intervals about excess 0; over one at the border of the axis.
    zero = int(np.flatnonzero(axes["excess"] == 0.0)[0])
    ends = [max(zero - 1, 0), min(zero + 1, len(axes["excess"]) - 1)]
    tables["shiftGain"] = np.diff(tables["shiftRate"][..., ends])[..., 0] / (np.diff(axes["excess"][ends])[0] or 1.0)
    tables |= with_shafts(plan.full, axes, tables)
    tables |= {name: np.where(tables["valid"] > 0.0, over_points(name), np.nan) for name in plan.added}
    description = plan.description
    source = {"model": description.modelName, "version": description.version or "", "guid": description.guid}
    assert tables.keys() == TABLES.keys() | plan.added.keys()
    return Maps(axes, tables, {name: float(value) for name, value in plan.full.items()}, source, reasons, by, plan.added)


def filled(values: Array) -> Array:
    """Values with gaps (NaN) filled with the nearest value along the last axis."""
    there = np.isfinite(values)
    if not there.any(axis=-1).all():
        raise ArgumentError("a line has no steady state")
    places = np.arange(values.shape[-1])
    away = np.where(there[..., None, :], np.abs(places[:, None] - places), values.shape[-1])
    return np.take_along_axis(values, away.argmin(axis=-1), axis=-1)


def monotone(rates: Array, excesses: Array) -> Array:
    """Shift rates with 0 inserted at excess 0, made to grow with the excess; missing ones (NaN) are those of the nearest excess."""
    zero = int(np.flatnonzero(excesses == 0.0)[0])
    full = filled(np.insert(rates, zero, 0.0, axis=-1))
    scale = 1e-6 * np.max(np.abs(full), axis=-1, keepdims=True) * np.abs(excesses)
    above = np.maximum.accumulate(np.maximum(full, scale)[..., zero:], axis=-1)
    below = np.maximum.accumulate(np.maximum(-full, scale)[..., zero::-1], axis=-1)[..., ::-1]
    return np.concatenate([-below[..., :-1], above], axis=-1)


def with_shafts(parameters: Mapping[str, float], axes: Mapping[str, Array], tables: Mapping[str, Array]) -> dict[str, Array]:
    """Primary torque, and what follows from the drag of the shafts."""
    force, speed, ratio, utilisation = np.meshgrid(*(axes[name] for name in POINT), indexing="ij")
    per_force = np.array([torque_capacity(parameters, i, 1.0) for i in axes["ratio"]])
    torque = utilisation * force * per_force[None, None, :, None]
    # The secondary shaft turns at speed/ratio, the primary one faster by the slip.
    turning = {"primary": speed / (1.0 - tables["slip"]), "secondary": speed / ratio}
    lost = {pulley: drag(parameters, pulley, omega, tables["bearingLoad"]) for pulley, omega in turning.items()}
    into = torque + lost["primary"]
    out = ratio * (torque - tables["beltTorqueLoss"]) - lost["secondary"]
    power_in, power_out = into * turning["primary"], out * turning["secondary"]
    driving, driven = np.where(power_in > 0.0, (power_in, power_out), (-power_out, -power_in))
    efficiency = np.divide(driven, driving, out=np.zeros_like(driven), where=(driving > 0.0) & (driven > 0.0))
    shafts = sum(lost[pulley] * turning[pulley] for pulley in turning)
    return {"primaryTorque": torque, "lossShafts": shafts, "torqueLoss": into - out / ratio, "efficiency": efficiency}
