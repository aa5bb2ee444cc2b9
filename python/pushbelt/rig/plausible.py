"""What cannot be on a variator, before anything is solved, and the reading of the columns that would be plausible.

A doubt is a property that the whole table has, such as a belt speed of 1 m/s. The readings are the inverse of a ratio, other signs and
units, and exchanged columns. A reading is named if it removes doubts and adds none.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from pushbelt.fmu.capacity import BELT_SPEED, BEYOND
from pushbelt.fmu.data import parameter_set, pitch_radius, torque_capacity

from . import units
from .sheet import Sheet

Array = np.ndarray
Values = Mapping[str, Array]

USUAL = "bench168"
"""Parameter set for radii and capacity. Those of other variators for cars differ by less than the limits allow."""
SLOWEST = 3.0
"""Belt speed that the fastest point of a table has at least, m/s: about 500 rpm."""
FASTEST = 40.0
"""Median belt speed above which another unit of speed is likely, m/s."""
UNCERTAIN = frozenset({"fast", "slip sign", "small slip", "thrust law"})
"""Doubts that count only if another reading removes them."""
CARRIED = 1.5 * BEYOND
"""Largest utilisation at the usual friction."""
IDLE = 0.0012
"""Largest utilisation of a table whose torques are in a wrong unit."""
LOADED = 0.1
"""Utilisation above which slip, thrust ratio and efficiency have the sign of the torque."""
FORCES = (300.0, 150e3)
THRUST = (0.2, 5.0)
SLIP = 0.05
EFFICIENCY = (0.3, 1.005)
AGREE = 0.1
"""Difference of the logarithms of a ratio and the speeds' ratio."""
MOST = 0.5
"""Share of the points above which the whole table has a fault."""
OFF = 0.3
"""Root mean square difference of the logarithms of measured and usual thrust ratios above which other readings are tried."""
READ_AS = ("speed", "torque", "force", "pressure")
"""Dimensions of which other units are tried."""
PAIRS = ("speed", "torque", "clampingForce", "pressure")


@dataclass(frozen=True)
class Reading:
    """Another reading of the columns."""

    text: str
    options: Mapping[str, str]
    """Its `--map` options."""
    change: Callable[[Values], dict[str, Array]]
    """Changed columns."""
    unit: bool = False
    """Whether it is another unit."""

    def __str__(self) -> str:
        options = " ".join(f'--map "{title}={name}"' for title, name in self.options.items())
        return f"{self.text} ({options})"


@cache
def _curves() -> tuple[Array, Array, Array]:
    """Ratios, with the primary pitch radius, m, and the torque capacity per clamping force, m."""
    parameters, ratios = parameter_set(USUAL), np.geomspace(0.4, 2.5, 15)
    radii = [pitch_radius(parameters, float(ratio)) for ratio in ratios]
    return ratios, np.array(radii), np.array([torque_capacity(parameters, float(ratio), 1.0) for ratio in ratios])


class _Points:
    """Columns of steady points; NaN where a value is unknown."""

    def __init__(self, values: Values, count: int) -> None:
        def get(name: str) -> Array:
            return values.get(name, np.full(count, np.nan))

        ratios, radii, carried = _curves()
        self.geometric, self.speed_ratio = get("ratio.geometric"), get("ratio.speed")
        self.ratio = np.where(np.isfinite(self.geometric), self.geometric, self.speed_ratio)
        self.speeds = get("primary.speed") / get("secondary.speed")
        self.torque, self.force, self.efficiency = (
            get("primary.torque"),
            get("secondary.clampingForce"),
            get("power ratio"),
        )
        self.belt_speed = np.abs(get("primary.speed")) * np.interp(self.ratio, ratios, radii)
        with np.errstate(divide="ignore", invalid="ignore"):
            self.used = self.torque / (np.interp(self.ratio, ratios, carried) * self.force)
            self.thrust = np.where(
                np.isfinite(get("thrustRatio")), get("thrustRatio"), get("primary.clampingForce") / self.force
            )
        self.slip = get("slip")
        self.loaded = np.abs(self.used) > LOADED
        if "di/dt" in values or "ds/dt" in values:
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


def _extent(values: Array, unit: str = "") -> str:
    values = values[np.isfinite(values)]
    return f"{values.min():.3g} to {values.max():.3g}{unit}"


def doubts(values: Values, count: int) -> dict[str, str]:
    """What the whole table has that no variator has, by kind."""
    p, found = _Points(values, count), {}
    speeds = p.belt_speed[np.isfinite(p.belt_speed)]
    if speeds.size and (speeds.max() < SLOWEST or np.median(speeds) > BELT_SPEED):
        found["speed"] = f"belt speeds of {_extent(speeds)} m/s; usual are {SLOWEST:g} to {BELT_SPEED:g} m/s"
    elif speeds.size and np.median(speeds) > FASTEST:
        found["fast"] = f"belt speeds of {_extent(speeds)} m/s"
    used = np.abs(p.used[np.isfinite(p.used) & (p.torque != 0.0)])
    if used.size and np.median(used) > CARRIED:
        found["capacity"] = f"torques of {_extent(used)} times the capacity of the clamping forces"
    if used.size and used.max() < IDLE:
        found["idle"] = f"torques of at most {used.max():.2g} times the capacity of the clamping forces"
    for name in ("force", "thrust"):
        own, (low, high) = getattr(p, name), FORCES if name == "force" else THRUST
        if _mostly((own < low) | (own > high), np.isfinite(own)):
            text = "secondary clamping forces" if name == "force" else "thrust ratios (primary/secondary force)"
            found[name] = f"{text} of {_extent(own)}; usual are {low:g} to {high:g}{' N' if name == 'force' else ''}"
    for name, ratio in (("ratio.geometric", p.geometric), ("ratio.speed", p.speed_ratio)):
        with np.errstate(divide="ignore", invalid="ignore"):
            apart = np.abs(np.log(ratio / p.speeds))
        known = np.isfinite(apart) & ((np.abs(np.log(p.speeds)) > AGREE) | (apart > AGREE))
        if _mostly(apart > AGREE, known):
            row = int(np.flatnonzero(known & (apart > AGREE))[0])
            found[name] = f"{name} is {ratio[row]:.4g} where the speeds give {p.speeds[row]:.4g}"
    known = p.loaded & np.isfinite(p.efficiency)
    low, high = EFFICIENCY
    if _mostly((p.efficiency < low) | (p.efficiency > high), known):
        found["power"] = (
            f"driven over driving power is {_extent(p.efficiency[known])} with the direction of the primary torque"
        )
    known = p.loaded & np.isfinite(p.slip)
    if _mostly(np.abs(p.slip) > SLIP, known):
        found["slip"] = f"slips of {_extent(100.0 * p.slip[known], ' %')}; usual are at most {100.0 * SLIP:g} %"
    elif _mostly(p.slip * p.used < 0.0, known & (np.abs(p.slip) > 3e-4)) and known.sum() >= 4:
        found["slip sign"] = "slips have the opposite sign of the primary torque"
    elif known.sum() >= 4 and np.abs(p.slip[known]).max() < 2e-4:
        found["small slip"] = f"slips of at most {100.0 * np.abs(p.slip[known]).max():.2g} %"
    if p.thrust_off() > OFF:
        found["thrust law"] = "thrust ratios do not rise to overdrive and with the primary torque as usual"
    return found


def single_rows(values: Values, lines: Array) -> list[str]:
    """Warnings about lines that no variator has."""
    p = _Points(values, len(lines))
    kinds = (
        (f"the belt speed is above {BELT_SPEED:g} m/s", p.belt_speed > BELT_SPEED),
        (f"the torque is above {CARRIED:.3g} times the capacity of the clamping force", np.abs(p.used) > CARRIED),
        (
            f"the thrust ratio is not within {THRUST[0]:g} to {THRUST[1]:g}",
            (p.thrust < THRUST[0]) | (p.thrust > THRUST[1]),
        ),
        (f"the slip is above {100.0 * SLIP:g} %", np.abs(p.slip) > SLIP),
    )
    return [f"warning: {text}: {_places(lines[bad])}" for text, bad in kinds if bad.any()]


def _places(lines: Array) -> str:
    return f"line {', '.join(map(str, lines[:10]))}{' …' if len(lines) > 10 else ''}"


# Other readings


def readings(sheet: Sheet) -> Iterator[Reading]:
    """Other readings of the columns of a table."""
    taken = sheet.taken
    there = [name for name in taken if name in sheet.values]
    for name in ("ratio.geometric", "ratio.speed", "thrustRatio"):
        if name in there:
            prefix = "" if taken[name].turned == "1/" else "1/"
            yield Reading(
                f"{taken[name].title}, if it is the inverse of {name}",
                {taken[name].title: f"{prefix}{name}"},
                _inverse(name),
            )
    for name in ("primary.torque", "slip"):
        if name in there:
            prefix = "" if taken[name].turned == "-" else "-"
            yield Reading(
                f"{taken[name].title} with the other sign",
                {taken[name].title: prefix + _named(name, taken[name].unit)},
                _scaled([name], -1.0),
            )
    yield from _units(sheet, there)
    pairs = [quantity for quantity in PAIRS if {f"primary.{quantity}", f"secondary.{quantity}"} <= set(there)]
    for some in ([quantity] for quantity in pairs):
        yield _exchanged(sheet, some)
    if {"speed", "torque"} <= set(pairs):
        yield _exchanged(sheet, ["speed", "torque"])


def _units(sheet: Sheet, there: Sequence[str]) -> Iterator[Reading]:
    """Other units of all columns of a quantity that have the same one, or of one of them."""
    groups: dict[tuple[str, str], list[str]] = {}
    for name in there:
        one = sheet.taken[name]
        if (one.column.dimension in READ_AS or name in ("slip", "efficiency")) and not one.turned:
            group = name if one.column.dimension == "ratio" else one.column.dimension
            groups.setdefault((group, one.unit), []).append(name)
    for names in groups.values():
        for some in [names, *([name] for name in names if len(names) > 1)]:
            one = sheet.taken[some[0]]
            for unit in units.CONFUSED[one.column.dimension]:
                scale = units.find(unit, one.column.dimension)
                if scale is not None and scale != one.scale:
                    titles = " and ".join(sheet.title(name) for name in some)
                    options = {sheet.title(name): f"{name} [{unit}]" for name in some}
                    yield Reading(
                        f"{titles} in {unit}", options, _scaled(some, scale.factor / one.scale.factor), unit=True
                    )


def _exchanged(sheet: Sheet, quantities: Sequence[str]) -> Reading:
    """Columns of both pulleys exchanged."""
    names = {
        f"{pulley}.{q}": f"{other}.{q}"
        for q in quantities
        for pulley, other in (("primary", "secondary"), ("secondary", "primary"))
    }
    options = {sheet.title(name): _named(other, sheet.taken[name].unit) for name, other in names.items()}
    text = f"{' and '.join(sheet.title(name) for name in names)} exchanged (P and S)"
    return Reading(text, options, lambda values: {other: values[name] for name, other in names.items()})


def _named(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _inverse(name: str) -> Callable[[Values], dict[str, Array]]:
    return lambda values: {name: 1.0 / values[name]}


def _scaled(names: Sequence[str], factor: float) -> Callable[[Values], dict[str, Array]]:
    return lambda values: {name: factor * values[name] for name in names}


def plausible(
    sheet: Sheet, rebuilt: Callable[[Sheet], Values], values: Values, found: Mapping[str, str]
) -> list[Reading]:
    """The readings that remove most doubts and add none, best first. `rebuilt` computes the values of a changed sheet."""
    count = len(sheet)
    before = _Points(values, count).thrust_off()
    better = []
    for reading in readings(sheet):
        if set(found) == ({"thrust law"} if reading.unit else {"fast"}):
            # The law is too rough to tell units, and a fast belt can only have another unit.
            continue
        changed = replace(sheet, values={**sheet.values, **reading.change(sheet.values)}, faults=[], left_out=[])
        other = rebuilt(changed)
        left, off = doubts(other, count), _Points(other, count).thrust_off()
        if set(left) < set(found) and off <= max(1.2 * before, OFF):
            better.append((len(left), len(reading.options), off, reading))
    fewest = min((left for left, *_ in better), default=0)
    best = [one for one in better if one[0] == fewest]
    closest = min((off for _, _, off, _ in best), default=0.0)
    best = [one for one in best if one[2] <= 1.5 * closest + 0.05]
    # A reading of more columns is named only if none of its parts is enough.
    return [
        one[3] for one in best if not any(set(other[3].options.items()) < set(one[3].options.items()) for other in best)
    ]
