"""What cannot be on a variator, before anything is solved, and the reading of the columns that would be plausible.

A doubt is a property that the whole table has, such as a belt speed of 1 m/s. The readings are the inverse of a ratio, other signs and
units, and exchanged columns. A reading is named if it removes doubts and adds none.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

from ..fmu.capacity import BELT_SPEED, BEYOND
from ..fmu.data import parameter_set, pitch_radius, torque_capacity
from ..fmu.geometry import Array
from . import units
from .columns import POWER, SHIFTS
from .sheet import MOST, Fault, Sheet, TableError, Taken

Values = Mapping[str, Array]

USUAL = "bench168"
"""Parameter set for radii and capacity. Those of other variators for cars differ by less than the limits allow."""
SLOWEST = 3.0  # Belt speed that the fastest point of a table has at least, m/s: about 500 rpm
UNCERTAIN = frozenset({"slip sign", "small slip", "thrust law"})
"""Doubts that count only if another reading removes them."""
CARRIED = 1.5 * BEYOND  # Largest utilisation at the usual friction
IDLE = 0.0012  # Largest utilisation of a table whose torques are in a wrong unit
LOADED = 0.1  # Utilisation above which slip, thrust ratio and efficiency have the sign of the torque
FORCES = (300.0, 150e3)
THRUST = (0.2, 5.0)
SLIP = 0.05
EFFICIENCY = (0.3, 1.005)
AGREE = 0.1  # Difference of the logarithms of a ratio and the speeds' ratio
OFF = 0.3
"""Root mean square difference of the logarithms of measured and usual thrust ratios above which other readings are tried."""


def check(sheet: Sheet, values: Values, rebuilt: Callable[[Sheet], Values], as_written: bool) -> list[str]:
    """Warnings about a table. `values` are its columns with computed ones, which `rebuilt` gives for a changed sheet. Raises
    TableError with what is not plausible, and how else the columns could be read, unless the table is taken `as_written`."""
    p = _Points(values, len(sheet))
    found = doubts(p)
    others = _better(sheet, rebuilt, p, found) if found else []
    certain = [text for kind, text in found.items() if kind not in UNCERTAIN]
    texts = certain or list(found.values()) if certain or others else []
    if texts and not as_written:
        fault = f"not plausible: {'; '.join(texts)}. "
        fault += f"Plausible is: {', or '.join(map(str, others))}. " if others else "No other unit, sign or exchange of a column explains it. "
        raise TableError([Fault(fault + "--as-written takes the table as it is"), *sheet.faults], sheet.path, sheet)
    return [f"warning: {text}" for text in texts]


@cache
def _curves() -> tuple[Array, Array, Array]:
    """Ratios, with the primary pitch radius, m, and the torque capacity per clamping force, m."""
    parameters, ratios = parameter_set(USUAL), np.geomspace(0.4, 2.5, 15)
    found = [(ratio, pitch_radius(parameters, ratio), torque_capacity(parameters, ratio, 1.0)) for ratio in ratios.tolist()]
    return tuple(np.array(found).T)


class _Points:
    """Columns of steady points; NaN where a value is unknown."""

    def __init__(self, values: Values, count: int) -> None:
        def get(name: str) -> Array:
            return values.get(name, np.full(count, np.nan))

        ratios, radii, carried = _curves()
        self.geometric, self.speed_ratio = get("ratio.geometric"), get("ratio.speed")
        self.ratio = np.where(np.isfinite(self.geometric), self.geometric, self.speed_ratio)
        self.speeds = get("primary.speed") / get("secondary.speed")
        self.torque, self.force = get("primary.torque"), get("secondary.clampingForce")
        self.efficiency, self.slip = get(POWER), get("slip")
        self.belt_speed = np.abs(get("primary.speed")) * np.interp(self.ratio, ratios, radii)
        with np.errstate(divide="ignore", invalid="ignore"):
            self.used = self.torque / (np.interp(self.ratio, ratios, carried) * self.force)
            thrust = get("thrustRatio")
            self.thrust = np.where(np.isfinite(thrust), thrust, get("primary.clampingForce") / self.force)
        self.loaded = np.abs(self.used) > LOADED
        if any(name in values for name in SHIFTS):
            self.thrust = np.full(count, np.nan)

    def thrust_off(self) -> float:
        """Root mean square difference of the logarithms of the thrust ratios and usual ones, which rise to overdrive and with the torque."""
        known = self.loaded & (self.thrust > 0.0) & (self.ratio > 0.0)
        if known.sum() < 4:
            return 0.0
        usual = -0.4 * np.log(self.ratio) + 0.25 * np.sign(self.used) + 0.2 * np.clip(self.used, -1.0, 1.0)
        return float(np.sqrt(np.mean((np.log(self.thrust) - usual)[known] ** 2)))


def _mostly(bad: Array, known: Array) -> bool:
    return bool(known.any()) and bool(bad[known].mean() > MOST)


def _outside(values: Array, limits: tuple[float, float]) -> Array:
    return (values < limits[0]) | (values > limits[1])


def _extent(values: Array) -> str:
    values = values[np.isfinite(values)]
    return f"{values.min():.3g} to {values.max():.3g}"


def doubts(p: _Points) -> dict[str, str]:
    """What the whole table has that no variator has, by kind."""
    found = {}
    speeds = p.belt_speed[np.isfinite(p.belt_speed)]
    if speeds.size and (speeds.max() < SLOWEST or np.median(speeds) > BELT_SPEED):
        found["speed"] = f"belt speeds of {_extent(speeds)} m/s; usual are {SLOWEST:g} to {BELT_SPEED:g} m/s"
    used = np.abs(p.used[np.isfinite(p.used) & (p.torque != 0.0)])
    if used.size and np.median(used) > CARRIED:
        found["capacity"] = f"torques of {_extent(used)} times the capacity of the clamping forces"
    if used.size and used.max() < IDLE:
        found["idle"] = f"torques of at most {used.max():.2g} times the capacity of the clamping forces"
    for kind, own, limits, unit, text in (
        ("force", p.force, FORCES, " N", "secondary clamping forces"),
        ("thrust", p.thrust, THRUST, "", "thrust ratios (primary/secondary force)"),
    ):
        if _mostly(_outside(own, limits), np.isfinite(own)):
            found[kind] = f"{text} of {_extent(own)}; usual are {limits[0]:g} to {limits[1]:g}{unit}"
    for kind, ratio in (("ratio.geometric", p.geometric), ("ratio.speed", p.speed_ratio)):
        with np.errstate(divide="ignore", invalid="ignore"):
            apart = np.abs(np.log(ratio / p.speeds))
        known = np.isfinite(apart) & ((np.abs(np.log(p.speeds)) > AGREE) | (apart > AGREE))
        if _mostly(apart > AGREE, known):
            row = int(np.argmax(known & (apart > AGREE)))
            found[kind] = f"{kind} is {ratio[row]:.4g} where the speeds give {p.speeds[row]:.4g}"
    known = p.loaded & np.isfinite(p.efficiency)
    if _mostly(_outside(p.efficiency, EFFICIENCY), known):
        found["power"] = f"driven over driving power is {_extent(p.efficiency[known])} with the direction of the primary torque"
    known = p.loaded & np.isfinite(p.slip)
    several, slips = known.sum() >= 4, 100.0 * p.slip[known]
    if _mostly(np.abs(p.slip) > SLIP, known):
        found["slip"] = f"slips of {_extent(slips)} %; usual are at most {100.0 * SLIP:g} %"
    elif several and _mostly(p.slip * p.used < 0.0, known & (np.abs(p.slip) > 3e-4)):
        found["slip sign"] = "slips have the opposite sign of the primary torque"
    elif several and np.abs(slips).max() < 0.02:
        found["small slip"] = f"slips of at most {np.abs(slips).max():.2g} %"
    if p.thrust_off() > OFF:
        found["thrust law"] = "thrust ratios do not rise to overdrive and with the primary torque as usual"
    return found


class Other(NamedTuple):
    text: str
    columns: Mapping[str, Taken]  # What columns would be, by the known names that they have now
    unit: bool = False  # Whether it is another unit

    @property
    def options(self) -> list[str]:
        """Its `--map` options."""
        pairs = [(one, f" [{one.unit}]" if one.unit and one.turned != "1/" else "") for one in self.columns.values()]
        return [f'--map "{one.title}={one.turned}{one.name}{unit}"' for one, unit in pairs]

    def changed(self, sheet: Sheet) -> Sheet:
        new = {one.name: one.si(sheet.taken[name].written(sheet.values[name])) for name, one in self.columns.items()}
        others = {name: column for name, column in sheet.values.items() if name not in self.columns}
        return replace(sheet, values={**others, **new}, faults=[], left_out=[], remarks=[])

    def __str__(self) -> str:
        return f"{self.text} ({' '.join(self.options)})"


def _others(sheet: Sheet, found: Mapping[str, str]) -> Iterator[Other]:
    there = {name: one for name, one in sheet.taken.items() if name in sheet.values}
    inverted, signed = ("ratio.geometric", "ratio.speed", "thrustRatio"), ("primary.torque", "slip")
    for names, prefix, text in ((inverted, "1/", ", if it is the inverse of {}"), (signed, "-", " with the other sign")):
        for name in (name for name in names if name in there):
            one = there[name]
            yield Other(one.title + text.format(name), {name: replace(one, turned="" if one.turned == prefix else prefix)})
    if "ratio.geometric" in there and "ratio.speed" not in there and "small slip" in found:
        one = there["ratio.geometric"]
        yield Other(f"{one.title} as the ratio of speeds", {one.name: replace(one, name="ratio.speed")})
    # Other units of all columns of a quantity that have the same one, or of one of them.
    groups: dict[tuple[str, str], list[Taken]] = {}
    for name, one in there.items():
        if (one.column.dimension in ("speed", "torque", "force", "pressure") or name in ("slip", "efficiency")) and not one.turned:
            groups.setdefault((name if one.column.dimension == "ratio" else one.column.dimension, one.unit), []).append(one)
    for some in (some for own in groups.values() for some in [own, *([one] for one in own if len(own) > 1)]):
        dimension, titles = some[0].column.dimension, " and ".join(one.title for one in some)
        for unit in units.confused(dimension):
            if (other := units.find(unit, dimension)) not in (None, some[0].scale):
                yield Other(f"{titles} in {unit}", {one.name: replace(one, unit=unit, scale=other) for one in some}, unit=True)
    pairs = [quantity for quantity in ("speed", "torque", "clampingForce", "pressure") if {f"primary.{quantity}", f"secondary.{quantity}"} <= there.keys()]
    for quantities in [*([quantity] for quantity in pairs), *[["speed", "torque"]] * ({"speed", "torque"} <= set(pairs))]:
        sides = [(f"{one}.{q}", f"{other}.{q}") for q in quantities for one, other in (("primary", "secondary"), ("secondary", "primary"))]
        titles = " and ".join(there[name].title for name, _ in sides)
        yield Other(f"{titles} exchanged (P and S)", {name: replace(there[name], name=other) for name, other in sides})


def _better(sheet: Sheet, rebuilt: Callable[[Sheet], Values], now: _Points, found: Mapping[str, str]) -> Sequence[Other]:
    """The readings that remove most doubts and add none."""
    better: list[tuple[int, Other]] = []
    for other in _others(sheet, found):
        # The law is too rough to tell units.
        if not other.unit or set(found) != {"thrust law"}:
            new = _Points(rebuilt(other.changed(sheet)), len(sheet))
            left = doubts(new)
            if set(left) < set(found) and new.thrust_off() <= max(1.2 * now.thrust_off(), OFF):
                better.append((len(left), other))
    fewest = min((left for left, _ in better), default=0)
    best = [other for left, other in better if left == fewest]
    # A reading of more columns is named only if none of its parts is enough.
    return [one for one in best if not any(set(other.options) < set(one.options) for other in best)]
