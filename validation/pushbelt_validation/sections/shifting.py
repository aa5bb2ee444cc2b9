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

from pushbelt.fmu.steady import driven_at_speed
from pushbelt.report.charts import Chart, Panel, Series

from .. import shift
from ..bench import Bench, Plan, rad
from ..limit import belt_of
from ..measured import Source, opening, source
from ..outcome import PERCENT, PLAIN, Check, Column, Part, Section, Table, curve, reported, share, table, within
from ..shift import ShiftRun
from ..theory.shifting import ShiftLaw

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
SMALL, LARGE, SMALL_PLACES, SMALL_TOLERANCE = 0.02, 0.3, (0.6, 1.0, 1.6), 0.07
"""Small and large steps of F_P, relative; the places at which they are compared."""
LIGHT = 0.1
"""Factor of the driven shaft's inertia: the law has no inertia, and the rig's is not known."""
LAW = source("shiftLaw")
BEYOND = Source(LAW.text, "extrapolation of the fitted law")

Key = tuple[float, float, float]
"""s, force in N, speed in rpm."""


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

    def errors(self, *forces: float) -> list[tuple[str, float | None]]:
        """All of them at some forces."""
        return [(_name(key), self.error(key)) for key in self.runs if key[1] in forces]

    def ratios(self, of: tuple[float, float], to: tuple[float, float]) -> list[tuple[str, float | None]]:
        """Quotient of the gains at two pairs of force (N) and speed (rpm), at each place; None if one is missing."""
        pairs = [(s, self.runs[(s, *of)], self.runs[(s, *to)]) for s in self.places]
        return [(f"s {s:g}", one.gain / other.gain if one and other else None) for s, one, other in pairs]

    def over_force(self, of: float, to: float) -> list[tuple[str, float | None]]:
        """Quotient of the gains at two forces, at each place and speed."""
        return [(f"{name}, {rpm:g} rpm", value) for rpm in SPEEDS for name, value in self.ratios((of, rpm), (to, rpm))]

    def spreads(self, *forces: float) -> list[tuple[str, float | None]]:
        """Largest over least force ratio at rest minus 1, at each place."""
        found = []
        for s in self.places:
            runs = [run for key, run in self.runs.items() if key[0] == s and key[1] in forces]
            logs = [run.log_thrust_ratio for run in runs if run]
            found.append((f"s {s:g}", math.exp(max(logs) - min(logs)) - 1.0 if len(logs) == len(runs) else None))
        return found


def run(bench: Bench, plan: Plan) -> Section:
    """Runs the shifts and evaluates the checks."""
    law = ShiftLaw(belt_of(bench), tuple(plan.thin(BETWEEN, 4)))
    gains = _gains(bench, plan, law)
    tilts, tilt_check = _tilts(bench, plan)
    lines, line_checks, line_curves = _linearity(bench, plan)
    step, step_check = _step(bench, plan, law)
    return Section(
        "shift-law",
        Part.MEASUREMENTS,
        "Speed of ratio change",
        "The law fitted to a rig's shifts (the laboratory variator bench168). Its opening Δ(F) is from a later text, and g(s) is from the "
        "continuum theory. At 10 kN it is an extrapolation.",
        (tilt_check, *_gain_checks(gains), _small_steps(bench, plan), _heavy_shaft(bench, plan), *line_checks, step_check),
        (_gain_table(gains), tilts, lines, step),
        (_chart(gains, line_curves),),
        (
            "The law is evaluated over the same 60 ms as the FMU, so both include the change of g with the ratio. The law has no inertia, so "
            "the FMU's driven shaft has a tenth of the default here; its damped sheaves slow fast shifts.",
        ),
    )


def _start(bench: Bench, s: float, force: float, rpm: float, inertia: float = LIGHT) -> dict[str, float]:
    parameters = {**bench.parameters, "secondary.inertia": inertia * bench.given("secondary.inertia")}
    return driven_at_speed(parameters, 1.0 / s, rad(rpm), 0.0, force)


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
    low, middle, high = FORCES
    doubling = [
        (f"{name}, {force / 1e3:g} kN", value)
        for force in (middle, high)
        for name, value in gains.ratios((force, SPEEDS[1]), (force, SPEEDS[0]))
    ]

    def beyond(key: str, statement: str, goal: str, unit, values: list[tuple[str, float | None]]) -> Check:
        return reported(key, statement, BEYOND, goal, unit.text(*(value for _, value in values if value is not None)))

    same = "largest over least ≤ 5\N{NO-BREAK SPACE}% apart"
    return [
        within(
            "shift-gain", "Speed of ratio change per unit of ln F_P agrees with the law, 20 and 30 kN",
            LAW, gains.errors(middle, high), -GAIN_TOLERANCE, GAIN_TOLERANCE, PERCENT,
        ),
        beyond("shift-gain-10", "The same at 10 kN", "the law", PERCENT, gains.errors(low)),
        within(
            "shift-force", "From 20 to 30 kN it changes by a factor of 1.20",
            LAW, gains.over_force(high, middle), 1.2 - RATIO_TOLERANCE, 1.2 + RATIO_TOLERANCE,
        ),
        beyond("shift-force-10", "From 20 to 10 kN it changes by a factor of 0.80", "the law", PLAIN, gains.over_force(low, middle)),
        within("shift-speed", "From 1000 to 2000 rpm it doubles", LAW, doubling, 2.0 - DOUBLING_TOLERANCE, 2.0 + DOUBLING_TOLERANCE),
        within(
            "shift-rest", "Without load the force ratio at rest depends on s alone, 20 and 30 kN, 1000 and 2000 rpm",
            LAW, gains.spreads(middle, high), None, SAME, PERCENT, same,
        ),
        beyond("shift-rest-10", "The same from 10 to 30 kN", same, PERCENT, gains.spreads(*FORCES)),
    ]  # fmt: skip


def _small_steps(bench: Bench, plan: Plan) -> Check:
    """The mean gain of small steps up and down against that of large ones."""
    found: list[tuple[str, float | None]] = []
    for s in plan.thin(SMALL_PLACES, 1):
        start = _start(bench, s, FORCES[1], SPEEDS[0])
        small, large = (
            [bench.shift(start, sign * math.log1p(step), f"s {s:g}, step {sign * step:+g}") for sign in (-1.0, 1.0)] for step in (SMALL, LARGE)
        )
        there = all(small) and all(large)
        found.append((f"s {s:g}", sum(run.gain for run in small) / sum(run.gain for run in large) - 1.0 if there else None))  # type: ignore[union-attr]
    statement = f"Steps of {100 * SMALL:g} % have the gain of steps of {100 * LARGE:g} %, 20 kN, 1000 rpm"
    return within("shift-small", statement, LAW, found, -SMALL_TOLERANCE, SMALL_TOLERANCE, PERCENT)


def _heavy_shaft(bench: Bench, plan: Plan) -> Check:
    """The same with the default inertia of the driven shaft, whose acceleration grows with the square of the speed and loads the belt."""
    found = []
    for s in plan.thin(PLACES, 1):
        runs = [bench.shift(_start(bench, s, FORCES[1], rpm, 1.0), what=f"heavy shaft, s {s:g}") for rpm in SPEEDS]
        found += [runs[1].gain / runs[0].gain] if all(runs) else []
    goal = "2 in a law without inertia; the rig's inertia is not known"
    return reported("shift-speed-inertia", "The same at 20 kN with the default inertia of the driven shaft", LAW, goal, PLAIN.text(*found))


def _gain_table(gains: Gains) -> Table:
    columns = (
        Column("s = r_P/r_S", digits=2), Column("F_S", "kN", 0, 1e-3), Column("Speed", "rpm", 0), Column("FMU", "1/s"), Column("Law", "1/s"),
        share("Difference"), Column("ln(F_P/F_S) at rest", digits=4, signed=True),
    )  # fmt: skip
    rows = [
        [*key, found.gain, gains.law[key], gains.error(key), found.log_thrust_ratio] for key, found in gains.runs.items() if found
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
    statement = "Tilt of the sheaves at ratio 1 is 1.02 Δ(F), 5 to 30 kN"
    check = within("shift-tilt", statement, LAW, errors, -TILT_TOLERANCE, TILT_TOLERANCE, PERCENT)
    columns = (
        Column("F_S", "kN", 0, 1e-3), Column("Tilt", "mrad", 3, 1e3), Column("1.02 Δ(F)", "mrad", 3, 1e3), share("Difference"),
    )  # fmt: skip
    note = "Without load, 1000 rpm; mean of both pulleys. The law was fitted at 20 and 30 kN."
    return table("tilt", "Tilt of the sheaves", columns, rows, note), check


def deviation_from_a_line(x: list[float], y: list[float]) -> float:
    """Largest distance from the best line, relative to the range of y."""
    line = np.polynomial.Polynomial.fit(x, y, 1)
    return float(np.abs(np.array(y) - line(np.array(x))).max() / np.ptp(y))


def _linearity(bench: Bench, plan: Plan) -> tuple[Table, list[Check], list[Series]]:
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
        of_logs, of_forces = deviation_from_a_line(steps, rates), deviation_from_a_line(differences, rates)
        rows.append([s, of_logs, of_forces, min(rates), max(rates)])
        by_log.append((f"s {s:g}", of_logs))
        curves.append(curve(f"s = {s:g}", steps, rates, colour, "o-"))
    columns = (
        Column("s = r_P/r_S", digits=2), share("Off a line in ln(F_P/F_S)", signed=False), share("Off a line in F_P − F_P,eq", signed=False),
        Column("Fastest down", "1/s"), Column("Fastest up", "1/s"),
    )  # fmt: skip
    linear = within(
        "shift-linear", "ds/dt is linear in ln(F_P/F_S), s from 0.6 to 1.8, steps of ±0.3",
        LAW, by_log, None, LINE_TOLERANCE, PERCENT,
        goal="largest distance from a line ≤ 5\N{NO-BREAK SPACE}% of the span",
    )  # fmt: skip
    low = [
        f"s {s:g}: {PERCENT.text(force)} off a line, {PERCENT.text(log)} in ln" for s, log, force, *_ in rows if s < 1.0
    ]
    failing = reported("shift-difference", "A law linear in the force difference fails for s < 1", LAW, "fails", "; ".join(low))
    title = "Linearity: largest distance from a line, over the span"
    return table("shift-linearity", title, columns, rows, "20 kN, 1000 rpm, no load."), [linear, failing], curves


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
        float(np.diff([np.polynomial.Polynomial.fit(side[:, 0], side[:, k], 1)(1.0) for side in sides])[0]) for k in (1, 2)
    )
    check = reported(
        "shift-step", "The force ratio at rest has a step at s = 1", LAW,
        "a step without explanation in the source; its size is not readable",
        f"{jump:+.4f} in ln(F_P/F_S) (theory {theirs:+.4f}): the drag of the ring changes to the other pulley there".replace("-", "−"),
    )  # fmt: skip
    columns = (Column("s = r_P/r_S"), Column("ln(F_P/F_S)", digits=4, signed=True), Column("Theory", digits=4, signed=True))
    return table("shift-equilibrium", "Force ratio at rest about s = 1", columns, rows, "20 kN, 1000 rpm, no load."), check


def _chart(gains: Gains, lines: list[Series]) -> Chart:
    curves = []
    for colour, force in enumerate(FORCES):
        runs = {key[0]: run for key, run in gains.runs.items() if key[1:] == (force, SPEEDS[0]) and run}
        name = f"{force / 1e3:g} kN"
        curves.append(curve(name, tuple(runs), [run.gain for run in runs.values()], colour, "o"))
        curves.append(curve(f"{name}, law", gains.places, [gains.law[s, force, SPEEDS[0]] for s in gains.places], colour))
    return Chart(
        [
            Panel("Shift gain at 1000 rpm (1/s)", curves, "s = r_P/r_S", scale="log", height=300),
            Panel("ds/dt at 20 kN, 1000 rpm (1/s)", lines, "step of ln(F_P/F_S)", height=300),
        ],
        "Left: FMU (points), and the law with the theory's g(s) (lines). Right: the FMU's rates over the step.",
        columns=2,
    )
