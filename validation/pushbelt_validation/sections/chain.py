"""A pull chain, `chain168`, against the continuum theory, which was written for a belt without gaps and without a stack.

In the comparison the flanks are stiff, and what the theory leaves out is off: joints, turning links, drag, the fall of
friction with speed. Torques are shares r of that of full slip of the secondary force, 2 mu F_S r_P/cos beta.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pushbelt.charts import Chart, Panel
from pushbelt.fmu import shift
from pushbelt.fmu.data import curve_of
from pushbelt.fmu.enumerations import RingModel
from pushbelt.fmu.geometry import Array
from pushbelt.fmu.starts import driven_at_speed, driven_by_slip, driven_by_torque
from ..theory import cmm
from ..theory.shifting import ShiftLaw

from ..bench import Bench, Plan, rad
from ..limit import EFFECTS, Deviation, belt_of, deviation
from ..measured import THEORY, opening
from ..outcome import PERCENT, Check, Column, Part, Section, Table, curve, reported, share, table, within

VARIATOR = "chain168"
PLACES = (0.6, 0.8, 1.0, 1.25, 1.6)
"""Speed ratios s."""
SHARES = (0.2, 0.5, 0.8)
BRAKING = -0.5
FORCE = 15e3
"""Secondary force, N."""
SPEED = rad(2000.0)
STIFF = {"contact.stiffness": 6e11, "ring.axialStiffness": 5e6}
"""Flanks fifty times as stiff as those of the set; the theory's are rigid."""
TOLERANCES = {RingModel.ALE: 0.025, RingModel.ALE0: 0.06}
SLIPS = (0.01, 0.015, 0.02, 0.03, 0.04)
CAPACITY_TOLERANCE, GAIN_TOLERANCE, TENSION_TOLERANCE = 0.03, 0.1, 0.03
SHIFT_PLACES = (0.8, 1.0, 1.25)
SHIFT_FORCE = 20e3
SHIFT_SPEED = rad(1000.0)

THEORY_PARAMETERS = {**EFFECTS["losses"], "belt.jointRadius": 0.0}
"""Effects that the theory neglects. The tilt is that of the set: in steady states only its shape enters."""


@dataclass(frozen=True)
class Point:
    """A steady state of the chain, and the theory there."""

    ring: RingModel
    place: float
    share: float
    stiff: bool
    found: Deviation | None
    tension: float | None = None
    """Largest difference of the tension along both arcs from the theory's, relative to the tight strand's T - sigma v²."""

    @property
    def name(self) -> str:
        """Name of the point."""
        return f"s {self.place:g}, r {self.share:g}"


def run(bench: Bench, plan: Plan) -> Section:
    """Solves the points and evaluates the checks. The section has a variator of its own."""
    with Bench(bench.archive, VARIATOR, bench.solved, bench.failures) as chain:
        points = _points(chain, plan)
        capacities = [(f"s {s:g}", _capacity(chain, s)) for s in plan.thin(PLACES, 1 if plan.short else 3)]
        gains = [(f"s {s:g}", _gain(chain, s)) for s in plan.thin(SHIFT_PLACES, 1)]
    return Section(
        "chain",
        Part.VERIFICATION,
        "Pull chain",
        "The parameter set chain168 against the continuum theory, which has neither gaps nor a stack. Joints, turning links, "
        "drag and the fall of friction with speed are off; the flanks are stiff, except where the set's are named.",
        (
            *_thrust_checks(points),
            within(
                "chain-tension", "Tension along the arcs agrees with the theory's, ALE",
                THEORY, [(p.name, p.tension) for p in points if p.tension is not None], None, TENSION_TOLERANCE, PERCENT,
            ),
            within(
                "chain-capacity", "Torque at the peak of traction, ALE, against the theory's capacity",
                THEORY, capacities, -CAPACITY_TOLERANCE, CAPACITY_TOLERANCE, PERCENT,
            ),
            within(
                "chain-gain", "Speed of ratio change without load per unit of ln F_P against the theory's",
                THEORY, gains, -GAIN_TOLERANCE, GAIN_TOLERANCE, PERCENT,
            ),
        ),
        (_table(points),),
        (_chart(points),),
    )  # fmt: skip


def _values(ring: RingModel, stiff: bool) -> dict[str, float]:
    return {**THEORY_PARAMETERS, **(STIFF if stiff else {}), "ring.model": ring}


def _points(chain: Bench, plan: Plan) -> list[Point]:
    cases = [(s, r, True) for s in plan.thin(PLACES) for r in plan.thin((BRAKING, *SHARES), 2)]
    if not plan.short:
        cases += [(s, 0.5, False) for s in PLACES]
    return [_point(chain, ring, *case) for ring in TOLERANCES for case in cases]


def _point(chain: Bench, ring: RingModel, s: float, r: float, stiff: bool) -> Point:
    changed = _values(ring, stiff)
    torque = r * chain.capacity(1.0 / s, FORCE)
    values = driven_by_torque({**chain.parameters, **changed}, 1.0 / s, SPEED, torque, FORCE)
    out = chain.steady(values, f"chain, {ring.name}, s {s:g}, r {r:g}")
    if out is None:
        return Point(ring, s, r, stiff, None)
    try:
        found = deviation(chain, values, out)
    except ValueError as error:
        chain.failures.append(f"chain, s {s:g}, r {r:g}, theory: {error}")
        return Point(ring, s, r, stiff, None)
    tension = _tension_error(chain, found) if ring is RingModel.ALE and stiff else None
    return Point(ring, s, r, stiff, found, tension)


def _tension_error(chain: Bench, found: Deviation) -> float:
    """Largest difference of T - sigma v² on both arcs, relative to the largest."""
    profile, out = chain.states.unit.profile(), found.outputs
    curve = curve_of(chain.parameters, out["reference.theta"])
    mass = chain.given("belt.massPerLength") + chain.given("ring.massPerLength")
    tension = profile.ring_tension - mass * out["belt.speed"] ** 2
    mean = found.theory.mean_force(out["secondary.axialForce"])
    errors = []
    for pulley, arc in (("primary", found.theory.primary), ("secondary", found.theory.secondary)):
        half = 0.5 * curve.arc_length(pulley)
        place = curve.from_middle(pulley, profile.position)
        # Bending acts within some millimetres of the borders.
        inside = np.abs(place) < half - 5e-3
        # The chain runs along xi, onto an arc at -half.
        angle = (place[inside] + half) / (2.0 * half) * arc.wrap
        theory: Array = mean * np.interp(angle, arc.theta, arc.tension)
        errors.append(np.abs(tension[inside] - theory).max())
    return float(max(errors) / tension.max())


def _thrust_checks(points: list[Point]) -> list[Check]:
    def errors(ring: RingModel, stiff: bool, braking: bool) -> list[tuple[str, float | None]]:
        return [
            (p.name, p.found and p.found.thrust_error)
            for p in points
            if p.ring is ring and p.stiff is stiff and (p.share < 0.0) is braking
        ]

    checks = []
    for ring, tolerance in TOLERANCES.items():
        checks.append(
            within(
                f"chain-thrust-{ring.name}", f"Thrust ratio under driving torque, {ring.name}, stiff flanks",
                THEORY, errors(ring, True, False), -tolerance, tolerance, PERCENT,
            )
        )  # fmt: skip
        others: Mapping[str, list[tuple[str, float | None]]] = {
            "braking": errors(ring, True, True),
            "with the set's flanks at r = 0.5": errors(ring, False, False),
        }
        for what, values in others.items():
            solved = [value for _, value in values if value is not None]
            if solved:
                key, statement = f"chain-{ring.name}-{what[:7]}", f"Difference of the thrust ratio to the theory, {ring.name}, {what}"
                checks.append(reported(key, statement, THEORY, "none", PERCENT.text(*solved)))
    return checks


def _capacity(chain: Bench, s: float) -> float | None:
    """The largest torque over slip against the largest of the theory."""
    torques = []
    for slip in SLIPS:
        values = {**chain.parameters, **_values(RingModel.ALE, True)}
        out = chain.steady(driven_by_slip(values, 1.0 / s, SPEED, slip, FORCE), f"chain, s {s:g}, slip {slip:g}")
        if out:
            torques.append((-out["primary.shaftTorque"] / out["primary.radius"], out))
    if not torques:
        return None
    pull, out = max(torques, key=lambda pair: pair[0])
    distance = chain.given("geometry.centerDistance")
    lean = math.asin((out["primary.radius"] - out["secondary.radius"]) / distance)
    wraps = math.pi + 2.0 * lean, math.pi - 2.0 * lean
    beta, mu = chain.given("geometry.wedgeAngle"), chain.given("friction.pulley")
    limit = cmm.capacity(*wraps, beta, mu) * (1.0 - 1e-5)
    theory = cmm.variator(*wraps, beta, mu, limit)
    return pull / (theory.torque_number * out["secondary.axialForce"]) - 1.0


def _gain(chain: Bench, s: float) -> float | None:
    values = {**chain.parameters, **_values(RingModel.ALE, True)}
    found = chain.shift(driven_at_speed(values, 1.0 / s, SHIFT_SPEED, 0.0, SHIFT_FORCE), what=f"chain, shift at s {s:g}")
    if found is None:
        return None
    law = ShiftLaw(belt_of(chain), tuple(s * factor for factor in (0.8, 0.95, 1.15, 1.4)))
    path = law.run(s, shift.LOG_STEP, SHIFT_SPEED, opening(SHIFT_FORCE), shift.times())
    return found.gain / (shift.mean_rate(shift.times(), path) / shift.LOG_STEP) - 1.0


def _table(points: list[Point]) -> Table:
    columns = (
        Column("Ring"),
        Column("s = r_P/r_S", digits=2),
        Column("r", digits=1, signed=True),
        Column("Flanks"),
        Column("Thrust ratio"),
        Column("Theory"),
        share("Difference"),
        share("Slip", 2),
        share("Theory's slip", 2),
        share("Tension off by"),
    )
    rows = [
        [
            p.ring.name,
            p.place,
            p.share,
            "stiff" if p.stiff else "of the set",
            p.found.thrust_ratio,
            p.found.theory.thrust_ratio,
            p.found.thrust_error,
            p.found.outputs["slip"],
            p.found.theory_slip,
            p.tension,
        ]
        for p in points
        if p.found
    ]
    return table("chain", "Chain and continuum theory", columns, rows, f"2000 rpm, {FORCE / 1e3:g} kN on S.")


def _chart(points: list[Point]) -> Chart:
    curves = []
    for colour, r in enumerate((BRAKING, *SHARES)):
        of = [p for p in points if p.share == r and p.stiff and p.found]
        rows = {ring: [(p.place, p.found) for p in of if p.ring is ring and p.found] for ring in TOLERANCES}
        lines = (
            ("theory", [(s, f.theory.thrust_ratio) for s, f in rows[RingModel.ALE]], "-"),
            ("ALE", [(s, f.thrust_ratio) for s, f in rows[RingModel.ALE]], "o"),
            ("ALE0", [(s, f.thrust_ratio) for s, f in rows[RingModel.ALE0]], "x"),
        )
        curves += [curve(f"r {r:g}, {label}", *zip(*line, strict=True), colour, style) for label, line, style in lines if line]
    return Chart([Panel("Thrust ratio of a chain", curves, "s = r_P/r_S", height=300)], "Stiff flanks, 15 kN, 2000 rpm.")
