"""From the continuum theory to the default belt: what the theory leaves out is switched on, one effect after another.

The first steady state of the FMU is in the theory's limit. Its sheaves tilt in proportion to their moment, as far as those of the default
belt in the same state. Each further state has one more effect of `limit.EFFECTS`; the last one is the default belt.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from pushbelt.fmu.steady import StartValues, driven_at_speed, driven_by_torque
from pushbelt.report.charts import Chart, Panel

from ..bench import Bench, Plan
from ..limit import EFFECTS, PULLEYS, QUICK, belt_of, deviation
from ..outcome import Column, Part, Section, Unit, curve, table
from ..tilt import moment_of
from .continuum import (
    IDLE_SPEED,
    LOADS,
    SHIFT_FORCE,
    SHIFT_PLACES,
    SHIFT_SPEED,
    SLOPE_FORCE,
    shift_gain,
    slope,
    slope_of_theory,
)

THEORY, LIMIT = "theory", "limit"
STAGES = (THEORY, LIMIT, *(f"+ {name}" for name in EFFECTS))
FORCE = 15e3
IDLE = ((2.25, FORCE), (1.0, FORCE), (0.444, 5e3), (0.444, FORCE), (0.444, 30e3))
LOADED = (2.25, 1.0, 0.444)
LOAD = 0.6
"""Torque as a share of that of full slip."""
TOLD = "idle", "r_S/r_P 0.444, 15 kN"
"""The line whose steps the verdict names."""


@dataclass(frozen=True)
class Line:
    """A quantity of one state over all stages; None without a steady state."""

    quantity: str
    state: str
    values: tuple[float | None, ...]


QUANTITIES: Mapping[str, tuple[str, Unit]] = {
    "idle": ("Thrust ratio without torque", Unit("", 3)),
    "thrust": (f"Thrust ratio at {LOAD:g} of the torque of full slip", Unit("", 3)),
    "slip": (f"Slip at {LOAD:g} of the torque of full slip (%)", Unit("", 2, 100.0)),
    "gain": ("Speed of ratio change against the theory (%)", Unit("", 1, 100.0)),
    "slope": ("Slope d ln(F_P/F_S)/d ln s near s = 1, no torque", Unit("", 2)),
}


def run(bench: Bench, plan: Plan) -> Section:
    """Solves all stages of all states."""
    lines = [_idle(bench, *state) for state in plan.thin(IDLE, 1)]
    for ratio in plan.thin(LOADED, 1):
        lines += _loaded(bench, ratio)
    lines += [_gain(bench, s, load) for s in plan.thin(SHIFT_PLACES, 1) for load in (0.0, *plan.thin(LOADS, 1)[:1])]
    lines += [_slope(bench, "", {}), _slope(bench, ", ring without friction", {"friction.ring": 0.0})]
    columns = (Column("Quantity"), Column("State"), *(Column(stage) for stage in STAGES))
    rows = [[QUANTITIES[line.quantity][0], line.state, *shown(line)] for line in lines]
    return Section(
        "steps",
        Part.STEPS,
        "Why a belt is not the theory",
        told(lines),
        (),
        (table("steps", "From the theory to the default belt", columns, rows, NOTE),),
        (_chart(lines),),
    )


NOTE = (
    f"Each stage has one more effect than the one before, so a step depends on the order. Without torque: 2000 rpm; with torque: 2000 rpm, "
    f"{FORCE / 1e3:g} kN; shifts: {SHIFT_FORCE / 1e3:g} kN, 1000 rpm, against the theory at the tilt of the same state. "
    "Losses, with the fall of friction over sliding, come last, and with them the inertia of the driven shaft and the damping of the sheaves."
)


def shown(line: Line) -> list[str]:
    """The values of a line as text."""
    unit = QUANTITIES[line.quantity][1]
    return ["–" if value is None else unit.show(value) for value in line.values]


def told(lines: Sequence[Line]) -> str:
    """The largest steps of one line, in a sentence."""
    line = next((one for one in lines if (one.quantity, one.state) == TOLD and None not in one.values), None)
    if line is None:
        return "Effects that the theory leaves out are switched on, one after another."
    first, *others = line.values
    steps = sorted(zip(STAGES[1:], (b - a for a, b in zip(line.values, others, strict=False)), strict=True), key=lambda s: -abs(s[1]))  # type: ignore[operator]
    named = ", ".join(f"{name.removeprefix('+ ')} {size:+.2f}".replace("-", "\N{MINUS SIGN}") for name, size in steps[:4])
    return f"Without torque at {line.state} the theory's thrust ratio is {first:.2f} and the belt's {others[-1]:.2f}. The largest steps: {named}."


# States. Each stage is solved with what its later effects change.


def _stages(bench: Bench, start: StartValues, solve: Callable[[dict[str, float]], object], more: Mapping[str, float] | None = None) -> list:
    """Results from the limit to the default belt. `more` is changed until the last effect."""
    changes = [dict(change) for change in EFFECTS.values()]
    changes[-1] |= more or {}
    linear = _linear_tilt(bench, start)
    if linear is None:
        return [None] * (len(EFFECTS) + 1)
    changes[list(EFFECTS).index("tilt clearance")] = linear
    return [solve({name: value for change in changes[k:] for name, value in change.items()}) for k in range(len(changes) + 1)]


def _linear_tilt(bench: Bench, start: StartValues) -> dict[str, float] | None:
    """Tilt stiffnesses without clearance at which the default belt's sheaves tilt as far as they do."""
    out = bench.steady(start, "default belt")
    if out is None:
        return None
    found: dict[str, float] = {}
    for pulley in PULLEYS:
        stiffness, clearance = (bench.given(f"{pulley}.{name}") for name in ("tiltStiffness", "tiltClearance"))
        tilt = out[f"{pulley}.tilt"]
        found |= {f"{pulley}.tiltStiffness": moment_of(tilt, stiffness, clearance) / tilt, f"{pulley}.tiltClearance": 0.0}
    return found


def _idle(bench: Bench, ratio: float, force: float) -> Line:
    state = f"r_S/r_P {ratio:g}, {force / 1e3:g} kN"

    def start(changed: Mapping[str, float]) -> StartValues:
        return driven_at_speed({**bench.parameters, **changed}, ratio, IDLE_SPEED, 0.0, force, held=True)

    outs = _stages(bench, start({}), lambda changed: bench.steady(start(changed), f"steps without torque, {state}"))
    return Line("idle", state, (math.exp(belt_of(bench).equilibrium(1.0 / ratio)), *(out and out["thrustRatio"] for out in outs)))


def _loaded(bench: Bench, ratio: float) -> list[Line]:
    state = f"r_S/r_P {ratio:g}"

    def start(changed: Mapping[str, float]) -> StartValues:
        torque = LOAD * bench.capacity(ratio, FORCE, changed)
        return driven_by_torque({**bench.parameters, **changed}, ratio, IDLE_SPEED, torque, FORCE)

    limits: list[StartValues] = []

    def solve(changed: dict[str, float]) -> dict[str, float] | None:
        limits.append(start(changed))
        return bench.steady(limits[-1], f"steps under torque, {state}")

    outs = _stages(bench, start({}), solve)
    theory = deviation(bench, limits[0], outs[0]) if outs[0] else None
    thrust = theory and float(theory.theory.thrust_ratio)
    return [
        Line("thrust", state, (thrust, *(out and out["thrustRatio"] for out in outs))),
        Line("slip", state, (theory and theory.theory_slip, *(out and out["slip"] for out in outs))),
    ]


def _gain(bench: Bench, s: float, load: float) -> Line:
    def solve(changed: dict[str, float]) -> float | None:
        found = shift_gain(bench, s, changed, "steps", load)
        return found and found[0] / found[1] - 1.0

    torque = load * bench.capacity(1.0 / s, SHIFT_FORCE)
    start = driven_at_speed(bench.parameters, 1.0 / s, SHIFT_SPEED, -torque / s, SHIFT_FORCE)
    return Line("gain", f"s {s:g}" + (f", r {load:g}" if load else ""), (0.0, *_stages(bench, start, solve, QUICK)))


def _slope(bench: Bench, what: str, always: Mapping[str, float]) -> Line:
    start = driven_at_speed({**bench.parameters, **always}, 1.0, IDLE_SPEED, 0.0, SLOPE_FORCE, held=True)
    found = _stages(bench, start, lambda changed: slope(bench, {**changed, **always}, f"steps{what}"))
    return Line("slope", f"{SLOPE_FORCE / 1e3:g} kN{what}", (slope_of_theory(bench), *found))


def _chart(lines: Sequence[Line]) -> Chart:
    """A panel for each quantity: stages from top to bottom."""
    panels = []
    rows = [-float(k) for k in range(len(STAGES))]
    for key, (title, unit) in QUANTITIES.items():
        curves = [
            curve(one.state, [math.nan if v is None else unit.scale * v for v in one.values], rows, colour, "o-", labels=STAGES)
            for colour, one in enumerate(line for line in lines if line.quantity == key)
        ]
        ticks = tuple((row, stage) for row, stage in zip(rows, STAGES, strict=True))
        panels.append(Panel(title, curves, y_ticks=ticks, y_range=(rows[-1] - 0.5, 0.5), height=250))
    return Chart(panels, "From the theory, at the top, to the default belt, at the bottom: each row has one more effect.", columns=2, least_width=420)
