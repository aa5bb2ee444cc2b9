"""Speed of ratio change: comparison of the FMU with the laboratory rig's law, without load.

    ds/dt = ω_P a Δ(F_S) g(s) [ln(F_P/F_S) − ln(F_P/F_S)_eq],   a = (1 + cos²β)/sin 2β,   s = r_P/r_S

Δ was fitted to shifts measured at 20 and 30 kN; g is from the continuum theory. The law is evaluated like the FMU: by a
step of 0.3 in ln F_P, and the mean of ds/dt from 60 to 120 ms after it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pushbelt.fmu import shift
from pushbelt.fmu.shift import ShiftRun
from pushbelt.fmu.starts import driven_at_speed
from pushbelt.theory.shifting import ShiftLaw

from ..against_theory import belt_of
from ..bench import Bench, Plan
from ..measured import Source, opening, source
from ..outcome import (
    PERCENT,
    PLAIN,
    Check,
    Column,
    Curve,
    Panel,
    Picture,
    Section,
    Table,
    reported,
    share,
    table,
    within,
)

PLACES = (0.6, 0.8, 1.0, 1.25, 1.5, 1.8)
"""Speed ratios s."""
FORCES = (10e3, 20e3, 30e3)
"""Secondary forces, N; 20 and 30 kN were measured."""
SPEEDS = (1000.0, 2000.0)
"""Primary speeds, rpm."""
BETWEEN = (0.5, 0.65, 0.85, 1.0, 1.2, 1.5, 1.9, 2.3)
"""Speed ratios at which the theory is solved. Values in between are interpolated by splines."""
TILT_FORCES = (5e3, 10e3, 15e3, 20e3, 25e3, 30e3)
LINEAR_STEPS = (-0.3, -0.2, -0.1, 0.1, 0.2, 0.3)
"""Steps of ln F_P for linearity."""
STEP_PLACES = (0.85, 0.9, 0.95, 0.98, 1.0, 1.02, 1.05, 1.1, 1.15)
"""Speed ratios about the step at s = 1."""
NEAR = 0.04
"""Half-width of the range about s = 1 that is excluded from the linear fits on both sides."""
TILT_TOLERANCE = 0.05
GAIN_TOLERANCE, RATIO_TOLERANCE, DOUBLING_TOLERANCE, LINE_TOLERANCE, SAME = 0.2, 0.06, 0.1, 0.05, 0.05
LIGHT = 0.1
"""Factor of the driven shaft's inertia in runs in which its acceleration must not load the belt."""
SYMMETRY = (0.8, 1.25)
"""Upshift over downshift for small equal steps, where the law is linear."""

Key = tuple[float, float, float]
"""s, force in N, speed in rpm."""


def rad(rpm: float) -> float:
    """rad/s."""
    return rpm * math.pi / 30.0


@dataclass(frozen=True)
class Gains:
    """Runs at all places, forces and speeds, and ds/dt of the law, evaluated in the same way."""

    runs: Mapping[Key, ShiftRun | None]
    """Run at each key; None without a steady state."""
    law: Mapping[Key, float]
    """ds/dt per unit of ln F_P, 1/s."""

    @property
    def places(self) -> list[float]:
        """Speed ratios, ascending."""
        return sorted({s for s, *_ in self.runs})

    def error(self, key: Key) -> float | None:
        """Relative difference of the gain to the law's."""
        found = self.runs[key]
        return found.gain / self.law[key] - 1.0 if found else None

    def ratios(self, of: tuple[float, float], to: tuple[float, float]) -> list[tuple[str, float | None]]:
        """Quotient of the gains at two pairs of force (N) and speed (rpm), at each place; None if one is missing."""
        pairs = [(s, self.runs[(s, *of)], self.runs[(s, *to)]) for s in self.places]
        return [(f"s {s:g}", one.gain / other.gain if one and other else None) for s, one, other in pairs]


def count(plan: Plan) -> int:
    """Approximate number of points."""
    return 26 if plan.short else 12 + 36 + 6 + 18 + 9 + 4


def run(bench: Bench, plan: Plan) -> Section:
    """Runs the shifts and evaluates the checks."""
    law = ShiftLaw(belt_of(bench), tuple(plan.thin(BETWEEN, 4)))
    gains = _gains(bench, plan, law)
    light_check = _doubling_of_a_light_shaft(bench, plan)
    tilts, tilt_check = _tilts(bench, plan)
    lines, line_checks, line_curves = _linearity(bench, plan)
    step, step_check = _step(bench, plan, law)
    symmetry, symmetry_checks = _symmetry(bench)
    return Section(
        "shift-law",
        "Speed of ratio change",
        "The law fitted to a rig's shifts (the laboratory variator bench168). Its opening Δ(F) is from a later "
        "text, and g(s) is from "
        "the continuum theory. At 10 kN it is an extrapolation.",
        (
            tilt_check,
            *_gain_checks(gains),
            light_check,
            *line_checks,
            *_equilibrium_checks(gains),
            step_check,
            *symmetry_checks,
        ),
        (_gain_table(gains), tilts, lines, step, symmetry),
        (_picture(gains, line_curves),),
        (
            "The law is evaluated over the same 60 ms as the FMU, so both include the change of g with the ratio. "
            "The FMU has two additional effects that slow fast shifts: the driven shaft's inertia requires torque, and the "
            "movable sheaves are damped.",
        ),
    )


def _start(bench: Bench, s: float, force: float, rpm: float) -> dict[str, float]:
    return driven_at_speed(bench.parameters, 1.0 / s, rad(rpm), 0.0, force)


def _gains(bench: Bench, plan: Plan, law: ShiftLaw) -> Gains:
    runs, expected = {}, {}
    for s, force, rpm in itertools.product(plan.thin(PLACES), FORCES, SPEEDS):
        key = (s, force, rpm)
        runs[key] = bench.shift(_start(bench, *key), what=_name(key))
        path = law.run(s, shift.LOG_STEP, rad(rpm), opening(force), shift.times())
        expected[key] = shift.mean_rate(shift.times(), path) / shift.LOG_STEP
    return Gains(runs, expected)


def _name(key: Key) -> str:
    s, force, rpm = key
    return f"s {s:g}, {force / 1e3:g} kN, {rpm:g} rpm"


def _gain_checks(gains: Gains) -> list[Check]:
    fitted = source("shiftLaw")
    beyond = Source(fitted.text, "extrapolation of the fitted law to 10 kN")
    slow, fast = SPEEDS
    low, middle, high = FORCES

    def absolute(forces: tuple[float, ...], where: Source, what: str) -> Check:
        errors = [(_name(key), gains.error(key)) for key in gains.runs if key[1] in forces]
        return within(
            f"Speed of ratio change per unit of ln F_P agrees with the law, {what}",
            where, errors, -GAIN_TOLERANCE, GAIN_TOLERANCE, PERCENT,
        )  # fmt: skip

    def ratio(of: float, to: float, expected: float, where: Source) -> Check:
        pairs = [
            (f"{name}, {rpm:g} rpm", value) for rpm in SPEEDS for name, value in gains.ratios((of, rpm), (to, rpm))
        ]
        statement = f"From {to / 1e3:g} to {of / 1e3:g} kN it changes by a factor of {expected:.2f}"
        return within(statement, where, pairs, expected - RATIO_TOLERANCE, expected + RATIO_TOLERANCE)

    doubling = [
        (f"{name}, {force / 1e3:g} kN", value)
        for force in (middle, high)
        for name, value in gains.ratios((force, fast), (force, slow))
    ]
    return [
        absolute((middle, high), fitted, "20 and 30 kN"),
        absolute((low,), beyond, "10 kN"),
        ratio(high, middle, 1.2, fitted),
        ratio(low, middle, 0.8, beyond),
        within(
            f"From {slow:g} to {fast:g} rpm it doubles",
            fitted, doubling, 2.0 - DOUBLING_TOLERANCE, 2.0 + DOUBLING_TOLERANCE,
        ),
    ]  # fmt: skip


def _doubling_of_a_light_shaft(bench: Bench, plan: Plan) -> Check:
    """Runs in which the driven shaft's acceleration, which grows with the square of the speed, requires little torque."""
    light = {"secondary.inertia": LIGHT * bench.given("secondary.inertia")}
    found = []
    for s in plan.thin(PLACES):
        starts = [_start(bench, s, FORCES[1], rpm) | light for rpm in SPEEDS]
        slow, fast = (bench.shift(start, what=f"light shaft, s {s:g}") for start in starts)
        found.append((f"s {s:g}", fast.gain / slow.gain if slow and fast else None))
    return within(
        "The same at 20 kN with a tenth of the inertia on the driven shaft",
        Source(source("shiftLaw").text, f"{source('shiftLaw').certainty}; the rig's inertia is unknown"),
        found,
        2.0 - DOUBLING_TOLERANCE,
        2.0 + DOUBLING_TOLERANCE,
    )


def _gain_table(gains: Gains) -> Table:
    columns = (
        Column("s = r_P/r_S", digits=2),
        Column("F_S", "kN", 0, 1e-3),
        Column("Speed", "rpm", 0),
        Column("FMU", "1/s"),
        Column("Law", "1/s"),
        share("Difference"),
        Column("ln(F_P/F_S) at rest", digits=4, signed=True),
    )
    rows = [
        [*key, found.gain, gains.law[key], gains.error(key), found.log_thrust_ratio]
        for key, found in gains.runs.items()
        if found
    ]
    return table("shift-gains", "Shift gains: ds/dt per unit of ln F_P", columns, rows)


def _tilts(bench: Bench, plan: Plan) -> tuple[Table, Check]:
    rows, errors = [], []
    for force in plan.thin(TILT_FORCES):
        out = bench.steady(_start(bench, 1.0, force, SPEEDS[0]), f"tilt, {force / 1e3:g} kN")
        error = None
        if out:
            found = 0.5 * (out["primary.tilt"] + out["secondary.tilt"])
            expected = 1.02 * opening(force)
            error = found / expected - 1.0
            rows.append([force, found, expected, error])
        errors.append((f"{force / 1e3:g} kN", error))
    check = within(
        "Tilt of the sheaves at ratio 1 is 1.02 Δ(F), 5 to 30 kN",
        source("shiftLaw"), errors, -TILT_TOLERANCE, TILT_TOLERANCE, PERCENT,
    )  # fmt: skip
    columns = (
        Column("F_S", "kN", 0, 1e-3),
        Column("Tilt", "mrad", 3, 1e3),
        Column("1.02 Δ(F)", "mrad", 3, 1e3),
        share("Difference"),
    )
    note = "Without load, 1000 rpm; mean of both pulleys. The law was fitted at 20 and 30 kN."
    return table("tilt", "Tilt of the sheaves", columns, rows, note), check


def _deviation_from_a_line(x: list[float], y: list[float]) -> float:
    """Largest distance from the best line, relative to the range of y."""
    line = np.polynomial.Polynomial.fit(x, y, 1)
    return float(np.abs(np.array(y) - line(np.array(x))).max() / np.ptp(y))


def _linearity(bench: Bench, plan: Plan) -> tuple[Table, list[Check], tuple[Curve, ...]]:
    """ds/dt over ln(F_P/F_S), and over the force difference, at 20 kN and 1000 rpm."""
    rows, curves, by_log = [], [], []
    for colour, s in enumerate(plan.thin((0.6, 1.0, 1.8))):
        start = _start(bench, s, FORCES[1], SPEEDS[0])
        runs = [bench.shift(start, step, f"s {s:g}, step {step:+g}") for step in plan.thin(LINEAR_STEPS, 4)]
        found = [(r.log_step, r.log_thrust_ratio, r.rate) for r in runs if r]
        if len(found) < 3:
            continue
        steps, rests, rates = map(list, zip(*found, strict=True))
        differences = [math.exp(rest) * (math.exp(step) - 1.0) for step, rest in zip(steps, rests, strict=True)]
        of_logs, of_forces = _deviation_from_a_line(steps, rates), _deviation_from_a_line(differences, rates)
        rows.append([s, of_logs, of_forces, min(rates), max(rates)])
        by_log.append((f"s {s:g}", of_logs))
        curves.append(Curve(tuple(steps), tuple(rates), f"s = {s:g}", colour, "o-"))
    columns = (
        Column("s = r_P/r_S", digits=2),
        share("Off a line in ln(F_P/F_S)", signed=False),
        share("Off a line in F_P − F_P,eq", signed=False),
        Column("Fastest down", "1/s"),
        Column("Fastest up", "1/s"),
    )
    linear = within(
        "ds/dt is linear in ln(F_P/F_S), s from 0.6 to 1.8, steps of ±0.3",
        source("shiftLaw"), by_log, None, LINE_TOLERANCE, PERCENT,
        goal="largest distance from a line ≤ 5\N{NO-BREAK SPACE}% of the span",
    )  # fmt: skip
    low = [row for row in rows if row[0] < 1.0]
    failing = reported(
        "A law linear in the force difference fails for s < 1",
        source("shiftLaw"),
        "fails",
        "; ".join(f"s {s:g}: {PERCENT.text(force)} off a line, {PERCENT.text(log)} in ln" for s, log, force, *_ in low),
    )
    title = "Linearity: largest distance from a line, over the span"
    return table("shift-linearity", title, columns, rows, "20 kN, 1000 rpm, no load."), [linear, failing], tuple(curves)


def _equilibrium_checks(gains: Gains) -> list[Check]:
    """The force ratio that holds a ratio without load, over force and speed."""
    checks = []
    for forces, what in ((FORCES[1:], "20 and 30 kN"), (FORCES, "10 to 30 kN")):
        spreads = []
        for s in gains.places:
            runs = [run for key, run in gains.runs.items() if key[0] == s and key[1] in forces]
            logs = [run.log_thrust_ratio for run in runs if run]
            complete = len(logs) == len(runs)
            spreads.append((f"s {s:g}", math.exp(max(logs) - min(logs)) - 1.0 if complete else None))
        where = source("shiftLaw")
        if forces == FORCES:
            where = Source(where.text, "extrapolation to 10 kN")
        checks.append(
            within(
                f"Without load the force ratio at rest depends on s alone, {what}, 1000 and 2000 rpm",
                where,
                spreads,
                None,
                SAME,
                PERCENT,
                goal="largest over least ≤ 5\N{NO-BREAK SPACE}% apart",
            )  # fmt: skip
        )
    return checks


def _step(bench: Bench, plan: Plan, law: ShiftLaw) -> tuple[Table, Check]:
    """The force ratio at rest about s = 1."""
    rows = []
    for s in plan.thin(STEP_PLACES, 7):
        out = bench.steady(_start(bench, s, FORCES[1], SPEEDS[0]), f"at rest, s {s:g}")
        if out:
            place = 1.0 / out["ratio.geometric"]
            rows.append([place, math.log(out["thrustRatio"]), law.equilibrium(place)])
    sides = [np.array([row for row in rows if sign * (row[0] - 1.0) > NEAR]) for sign in (-1.0, 1.0)]
    jump, theirs = (
        float(np.diff([np.polynomial.Polynomial.fit(side[:, 0], side[:, k], 1)(1.0) for side in sides])[0])
        for k in (1, 2)
    )
    check = reported(
        "The force ratio at rest has a step at s = 1",
        source("shiftLaw"),
        "a step without explanation in the source; its size is not readable",
        f"{jump:+.4f} in ln(F_P/F_S) (theory {theirs:+.4f}): the drag of the ring changes to the other pulley there".replace("-", "−"),
    )
    columns = (
        Column("s = r_P/r_S"),
        Column("ln(F_P/F_S)", digits=4, signed=True),
        Column("Theory", digits=4, signed=True),
    )
    return table(
        "shift-equilibrium", "Force ratio at rest about s = 1", columns, rows, "20 kN, 1000 rpm, no load."
    ), check


def _symmetry(bench: Bench) -> tuple[Table, list[Check]]:
    """Small steps up and down in a state that is sensitive to damping: 5000 rpm, overdrive, half load.

    An upshift accelerates the driven shaft, which requires torque. With a light shaft the load remains the same.
    """
    ratio, rpm, force = 0.5, 5000.0, 10e3
    load = -0.5 * bench.capacity(ratio, force) * ratio
    inertia = bench.given("secondary.inertia")
    where = Source(source("shiftLaw").text, "extrapolation of its linearity to load and speed")
    rows, checks = [], []
    for share_of_inertia, what in ((LIGHT, "a tenth of the inertia on the driven shaft"), (1.0, "default inertia of the driven shaft")):
        parameters = {**bench.parameters, "secondary.inertia": share_of_inertia * inertia}
        start = driven_at_speed(parameters, ratio, rad(rpm), load, force)
        runs = [bench.shift(start, math.log(factor), f"{rpm:g} rpm, F_P × {factor:g}") for factor in (1.05, 0.95)]
        up, down = (run.rate if run else math.nan for run in runs)
        rows.append([what, up, down, -up / down])
        statement = (
            f"Up- and downshift after ±5\N{NO-BREAK SPACE}% of F_P are equal at 5000 rpm, overdrive, half load; {what}"
        )
        if share_of_inertia < 1.0:
            checks.append(within(statement, where, [("up over down", -up / down)], *SYMMETRY))
        else:
            checks.append(
                reported(statement, where, "the law neglects the shaft's acceleration", PLAIN.text(-up / down))
            )
    columns = (Column("Driven shaft"), Column("Up", "1/s"), Column("Down", "1/s"), Column("Up over down", digits=2))
    note = (
        "r_S/r_P = 0.5, 10 kN, half of full slip's torque. When an upshift accelerates a heavy shaft, the torque "
        "approaches capacity, the force ratio at rest falls, and the shift becomes faster."
    )
    return table("shift-symmetry", "ds/dt after small steps at 5000 rpm", columns, rows, note), checks


def _picture(gains: Gains, lines: tuple[Curve, ...]) -> Picture:
    curves = []
    for colour, force in enumerate(FORCES):
        runs = {key[0]: run for key, run in gains.runs.items() if key[1:] == (force, SPEEDS[0]) and run}
        name = f"{force / 1e3:g} kN"
        curves.append(Curve(tuple(runs), tuple(run.gain for run in runs.values()), name, colour, "o"))
        law = tuple(gains.law[s, force, SPEEDS[0]] for s in gains.places)
        curves.append(Curve(tuple(gains.places), law, f"{name}, law", colour, "-"))
    return Picture(
        (
            Panel("Shift gain at 1000 rpm (1/s)", "s = r_P/r_S", tuple(curves), log_y=True),
            Panel("ds/dt at 20 kN, 1000 rpm (1/s)", "step of ln(F_P/F_S)", lines),
        ),
        "Left: FMU (points), and the law with the theory's g(s) (lines). Right: the FMU's rates over the step.",
    )
