"""Errors of a table, each as one more fitted coordinate: its size."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from pushbelt.fmu.geometry import Array
from pushbelt.tables.columns import COLUMNS, POWER, QUANTITIES, REQUIRED, SURE
from pushbelt.tables.names import DEVIATION
from pushbelt.tables.points import Point, Rig

from .model import Model
from .parameters import Parameter, additional
from .worker import Found, Job

FIELDS = ("ratio", "speed_ratio", "speed", "torque", "force", "primary_force")  # Conditions of a point
Values = Mapping[str, float]


@dataclass(frozen=True)
class Cause:
    """An error of a table, or a law that the parameters lack."""

    size: Parameter
    change: Callable[[Values, Point, float], Job]  # Values and point without it, if it has a size
    columns: tuple[str, ...] = ()  # Those with the factor
    advice: str = ""  # What to do, or where a law holds
    begin: float | None = None  # Size from which it is fitted, whatever the derivatives say; None: the start


def with_causes(model: Model, causes: Sequence[Cause]) -> Model:
    """The model with the sizes of causes as further variables. What a cause changes of a measured value and its deviation is in the
    model's one, so that the residuals are right."""

    def changed(values: Values, point: Point) -> Job:
        for cause in causes:
            size = values.get(cause.size.name)
            if size is not None:
                values, point = cause.change({name: value for name, value in values.items() if name != cause.size.name}, point, size)
        return values, point

    def solve(jobs: Sequence[Job]) -> list[Found]:
        new, found = [changed(*job) for job in jobs], []
        # A size that some points do not have gives equal jobs.
        keys = [(tuple(values.items()), point) for values, point in new]
        distinct = dict(zip(keys, new, strict=True))
        solved = dict(zip(distinct, model.solve(list(distinct.values())), strict=True))
        for key, (_, point), (_, measured) in zip(keys, jobs, new, strict=True):
            values = dict(solved[key].values)
            for one, other in zip(point.measured, measured.measured, strict=True):
                if (name := one.key or one.quantity) in values:
                    values[name] = one.value + one.deviation / other.deviation * (values[name] - other.value)
            found.append(solved[key]._replace(values=values))
            solved[key] = solved[key]._replace(solves=0)
        return found

    return Model(model.points, solve, model.most_solves)


def causes(rig: Rig, model: Model) -> list[Cause]:
    """What can be wrong with the columns of a table, and what the model leaves out."""
    sheet, found = rig.sheet, list[Cause]()
    values = {name: column for name, column in rig.values.items() if name in COLUMNS}
    taken = {name: one for name, one in sheet.taken.items() if name in values}

    def add(size: Parameter, without: Callable[[float], Mapping[str, Array]], columns: Sequence[str] = (), begin: float | None = None) -> None:
        """A cause, with the columns that a table of a size has without it."""

        @lru_cache(4)
        def points(size: float) -> dict[int, Point]:
            with np.errstate(all="ignore"):
                new = {name: np.clip(column, COLUMNS[name].low, COLUMNS[name].high) for name, column in without(size).items() if name in COLUMNS}
                return {point.line: point for point in rig.changed({**without(size), **new})}

        def change(values: Values, point: Point, size: float) -> Job:
            new = points(size).get(point.line, point)
            known = {one.quantity: one for one in new.measured}
            measured = tuple(known.get(one.quantity, one) for one in point.measured)
            return values, replace(point, measured=measured, **{name: getattr(new, name) for name in FIELDS})

        found.append(Cause(size, change, tuple(columns), begin=begin))

    def add_weighted(name: str, unit: str, scale: float, weights: Mapping[str, Array | float], begin: float | None = None) -> None:
        add(additional(name, unit, scale), lambda size: {name: values[name] - size * weight for name, weight in weights.items()}, (), begin)

    def add_factor(name: str, powers: Mapping[str, Array | float]) -> None:
        size = Parameter(name, (), "1", 1.0, 0.1, 10.0)
        # A deviation has the factor of its value.
        scaled = {name: (values[name], power) for name, power in powers.items()}
        for name, power in powers.items():
            if name + DEVIATION in rig.values:
                scaled[name + DEVIATION] = rig.values[name + DEVIATION], power
            elif name in QUANTITIES:
                scaled[name + DEVIATION] = np.hypot(QUANTITIES[name].absolute, QUANTITIES[name].relative * values[name]), power
        add(size, lambda size: {name: column / size**power for name, (column, power) in scaled.items()}, list(powers))

    rms = {name: float(np.sqrt(np.nanmean(values[name] ** 2))) or 1.0 for name in taken if np.isfinite(values[name]).any()}
    for name, one in ((name, taken[name]) for name in rms):
        add_weighted(f"offset of {one.title}", one.unit or "1", rms[name] / one.scale.factor, {name: one.scale.factor})
        add_factor(f"factor of {one.title}", {name: 1.0})
    for quantity in ("torque", "clampingForce", "pressure"):
        both = {f"{pulley}.{quantity}": 1.0 for pulley in ("primary", "secondary")}
        if rms.keys() >= both.keys():
            add_factor(f"factor of {' and '.join(taken[name].title for name in both)}", both)
    speed, torque, force = (values[name] for name in REQUIRED)
    ratio = values.get("ratio.geometric", values.get("ratio.speed", np.ones(len(sheet))))
    name, driving = sheet.title("primary.torque"), np.sign(torque)
    power = additional(f"power of the ratio in {name} (1: it is that of the other shaft)", "1", 2.0)
    add(power, lambda size: {"primary.torque": torque / ratio**size})
    if "efficiency" in taken:
        pump = additional(f"torque of a pump or gear in {name} and the efficiency", "N.m", rms["primary.torque"])
        add(pump, lambda size: {
            "primary.torque": torque - size, "efficiency": values["efficiency"] * np.abs(torque / (torque - size)) ** driving
        })  # fmt: skip
    elif "secondary.torque" in taken:
        add_factor("efficiency of a gear on the secondary shaft", {"secondary.torque": driving})
    slips = np.zeros(len(sheet))
    slips[rig.rows] = [point.slip for point in model.points]
    if "ratio.geometric" in taken:
        title = f"share of the slip in {sheet.title('ratio.geometric')} (1: it is the ratio of speeds)"
        add_weighted(title, "1", 2.0, {"ratio.geometric": ratio * slips})
    squares = {"secondary.clampingForce": -((speed / ratio) ** 2), "primary.clampingForce": -(speed**2)}
    for names in (("secondary.clampingForce",), tuple(squares)):
        if values.keys() >= set(names):
            title = f"missing centrifugal force of the oil of {'both pulleys' if len(names) > 1 else 'the secondary pulley'}"
            add_weighted(title, "N.s2/rad2", float(np.nanmean(force) / np.nanmean((speed / ratio) ** 2)), {name: squares[name] for name in names})
    thrust = next((name for name in ("thrustRatio", "primary.clampingForce") if name in values), None)
    if thrust and len(sheet) > 2:
        moving = values[thrust] * np.gradient(np.log(ratio))
        add_weighted("change of the thrust ratio by that of ln i from row to row (points while shifting)", "1", 1.0, {thrust: moving})
    slipping = {point.line: abs(one.value) / one.deviation for point in model.points for one in point.measured
                if one.quantity == "slip" and one.value * point.torque < 0.0}  # fmt: skip
    gaining = np.isfinite(rig.values.get(POWER, np.full(len(sheet), np.nan))) & ~np.isfinite(values.get("efficiency", torque))
    wrong = np.isin(sheet.lines, list(slipping)) | gaining
    if gaining.any() or max(slipping.values(), default=0.0) > SURE:
        title = f"opposite sign of {name} in {wrong.sum()} rows, lines {', '.join(map(str, sheet.lines[wrong]))} (1: it is opposite)"
        add_weighted(title, "1", 2.0, {"primary.torque": 2.0 * torque * wrong}, 1.0)
    return found
