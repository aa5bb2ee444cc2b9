"""Solved lines of a plan, collected to maps."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from operator import itemgetter
from typing import Any

import numpy as np

from pushbelt.errors import ArgumentError
from pushbelt.fmu.data import torque_capacity
from pushbelt.fmu.geometry import Array
from pushbelt.fmu.working_points import FADING_SPEED, POINT_COLUMNS
from pushbelt.maps.data import AXES, POINT, STATES, TABLES, Maps
from pushbelt.maps.plan import Plan
from pushbelt.study.tasks import Row

COLUMNS = {re.sub(r"\.(.)", lambda dot: dot[1].upper(), name): name for name in POINT_COLUMNS if name != "macroSlip"}
"""Tables that are columns of the measured points: `lossSheaves` of `loss.sheaves`."""


def collect(plan: Plan, rows: Mapping[int, Row]) -> Maps:
    """The maps of all lines. Lines without results have those of the nearest line."""
    found = {index: row for index, row in rows.items() if "points" in row}
    if not found:
        raise ArgumentError(f"no line has a steady state: {'; '.join(sorted({row.get('reason', '') for row in rows.values()}))}")
    grid = plan.grid
    values = (grid.force, grid.speed, plan.ratios, grid.utilisation, (-1.0, 1.0), grid.slip_share, grid.shift_utilisation, grid.excess)
    axes = dict(zip(AXES, map(np.array, values), strict=True))
    route = tuple(len(axes[name]) for name in POINT[:3])
    sources = [index if index in found else _nearest(index, found, route) for index in range(len(plan.tasks()))]

    def gathered(get: Callable[[Mapping[str, Any]], Any]) -> Array:
        values = np.array([get(found[source]) for source in sources], dtype=float)
        return values.reshape(*route, *values.shape[1:])

    raw = {name: gathered(lambda row, name=name: row["points"][name]) for name in POINT_COLUMNS}  # type: ignore[misc]
    state, reasons = _states(plan, rows, raw["macroSlip"], axes["utilisation"])
    tables = {name: filled(raw[column]) for name, column in COLUMNS.items()}
    tables["state"], tables["valid"] = state, (state <= STATES.index("slips_through")).astype(float)
    tables |= {name: gathered(itemgetter(name)) for name in ("capacity", "capacitySlip", "traction", "shiftRate")}
    tables["shiftRate"] = monotone(tables["shiftRate"], axes["excess"])
    # The slope over the two intervals about excess 0; over one at the border of the axis.
    zero = int(np.flatnonzero(axes["excess"] == 0.0)[0])
    ends = [max(zero - 1, 0), min(zero + 1, len(axes["excess"]) - 1)]
    tables["shiftGain"] = np.diff(tables["shiftRate"][..., ends])[..., 0] / (np.diff(axes["excess"][ends])[0] or 1.0)
    tables |= with_shafts(plan.full, axes, tables)
    description = plan.description
    source = {"model": description.modelName, "version": description.version or "", "guid": description.guid}
    assert tables.keys() == TABLES.keys()
    return Maps(axes, tables, {name: float(value) for name, value in plan.full.items()}, source, reasons)


def _nearest(index: int, found: Iterable[int], shape: tuple[int, ...]) -> int:
    """The nearest line with results, by indices of the axes; a step along the ratio counts least."""
    weights = np.array([3.0, 2.0, 1.0])
    place = np.array(np.unravel_index(index, shape))
    return min(found, key=lambda other: float(weights @ np.abs(np.array(np.unravel_index(other, shape)) - place)))


def _states(plan: Plan, rows: Mapping[int, Row], slipping: Array, utilisations: Array) -> tuple[Array, dict[str, str]]:
    """The table `state`, and the reasons for missing steady states."""
    state, reasons = np.where(slipping > 0.0, 1.0, 0.0), {}
    for index in range(len(plan.tasks())):
        place = np.unravel_index(index, state.shape[:3])
        row = rows.get(index, {})
        for k, utilisation in enumerate(utilisations):
            why = row["reasons"].get(f"{utilisation:g}") if "points" in row else row.get("reason", "not solved")
            if why is not None:
                beyond = why.startswith("beyond the capacity")
                state[(*place, k)] = STATES.index("beyond_capacity" if beyond else "not_found")
                reasons["/".join(map(str, (*place, k)))] = why
    return state, reasons


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
    """Primary torque, and what follows from the drag of the shafts: T_d = tanh(ω/ω_0) (T_0 + μ r R) + b ω."""
    force, speed, ratio, utilisation = np.meshgrid(*(axes[name] for name in POINT), indexing="ij")
    per_force = np.array([torque_capacity(parameters, i, 1.0) for i in axes["ratio"]])
    torque = utilisation * force * per_force[None, None, :, None]
    # The secondary shaft turns at speed/ratio, the primary one faster by the slip.
    turning = {"primary": speed / (1.0 - tables["slip"]), "secondary": speed / ratio}
    drag = {}
    for pulley, omega in turning.items():
        lever = parameters[f"{pulley}.bearing.friction"] * parameters[f"{pulley}.bearing.radius"]
        loaded = parameters[f"{pulley}.drag.constant"] + lever * tables["bearingLoad"]
        drag[pulley] = np.tanh(omega / FADING_SPEED) * loaded + parameters[f"{pulley}.drag.viscous"] * omega
    into = torque + drag["primary"]
    out = ratio * (torque - tables["beltTorqueLoss"]) - drag["secondary"]
    power_in, power_out = into * turning["primary"], out * turning["secondary"]
    driving, driven = np.where(power_in > 0.0, (power_in, power_out), (-power_out, -power_in))
    efficiency = np.divide(driven, driving, out=np.zeros_like(driven), where=(driving > 0.0) & (driven > 0.0))
    shafts = sum(drag[pulley] * turning[pulley] for pulley in turning)
    return {"primaryTorque": torque, "lossShafts": shafts, "torqueLoss": into - out / ratio, "efficiency": efficiency}
