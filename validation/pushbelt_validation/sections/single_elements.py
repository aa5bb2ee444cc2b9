"""The default belt beside the belt of single elements, and these in the theory's limit. Their results are stored in `elements/results`."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

from pushbelt.fmu.enumerations import RingModel
from pushbelt.fmu.steady import driven_at_speed

from ..bench import Bench, Outputs, Plan
from ..limit import wraps
from ..measured import THEORY, Source
from ..outcome import PERCENT, Check, Column, Part, Section, Table, Unit, reported, share, signed, table, within
from ..theory import cmm

STORED = Path(__file__).parents[3] / "elements" / "results"
SPEED, FORCE = 209.0, 15e3
"""Primary speed, rad/s, and closing force of the secondary pulley, N, of all cases."""
RATIOS = {"low": 2.25, "under": 1.5, "medium": 1.0, "over": 0.667, "od": 0.444}
WITHOUT = {"friction.layers": 0.0, "belt.elementInertia": 0.0}
"""Losses that the single elements don't have."""
RATIO_ERROR, TRIALS = 1e-4, 6
THRUST, SLIP, ARC, LOSS, GAIN, SMALL_GAIN, LIMIT = 0.02, 0.15, 0.12, 0.02, 0.1, 0.1, 0.05
SMALL, LARGE = 0.02, 0.3
"""Steps of ln F_P."""
TILT_STIFFNESS = 2e5
"""Of the sheaves of the limit's cases, N·m/rad."""
PUSHES, PUSH_OUTPUT = "pushForceMax", "pushForce.max"
RADIANS = Unit("rad", 2)
SOURCE = Source("464 push elements and a ring, each contact a contact: `cargo fmu elements`", "computed by a model without a continuum")


def run(bench: Bench, plan: Plan) -> Section:
    """Solves the cases with both rings and evaluates the checks."""
    stored = plan.thin(_stored("loads"), 2)
    found = {ring.name: [(case, elements, _solve(bench, case, ring)) for case, elements in stored] for ring in reversed(RingModel)}
    rows = [[f"{name}, {case}", *_row(elements, out)] for name, of in found.items() for case, elements, out in of if out]
    columns = (
        Column("Case"), Column("Thrust ratio, elements"), Column("FMU"), share("Slip, elements", 3, signed=False), share("FMU", 3, signed=False),
        Column("Idle arc P, elements", "rad", 2), Column("FMU", "rad", 2), Column("S, elements", "rad", 2), Column("FMU", "rad", 2),
        Column("Push force, elements", "N", 0), Column("FMU", "N", 0), share("Loss, elements", 2, signed=False), share("FMU", 2, signed=False),
    )  # fmt: skip
    idle, idle_check = _without_torque(bench, plan)
    shifts, shift_checks = _shifts(bench, plan)
    limit, limit_checks = _limit(bench)
    return Section(
        "elements",
        Part.ELEMENTS,
        "Single elements",
        "Nine load cases of the default belt beside a model in which each element is a body and each contact a contact. It shares parameters and the law of "
        "a flank's friction with the FMU, and neither cells, mesh nor solver. Both are without friction between layers and without elements that start to turn.",
        (*_checks(found), idle_check, *shift_checks, *limit_checks),
        (table("elements", "Cases", columns, rows, "Shares are those of the torque of full slip. 15 kN, 209 rad/s."), idle, shifts, limit),
    )


def _stored(name: str) -> list[tuple[str, dict[str, float]]]:
    """Cases of a file, and their values."""
    with (STORED / f"{name}.csv").open(encoding="utf-8") as file:
        return [(str(line.pop("case")), {key: float(value) for key, value in line.items()}) for line in csv.DictReader(file)]


def _solve(bench: Bench, case: str, ring: RingModel, force: float = FORCE) -> Outputs | None:
    """The steady state of a case, whose ratio is that of the mean radii."""
    name, load = case.split("-")[:2]
    wanted = ratio = RATIOS[name] if name in RATIOS else float(name)
    torque = float(load) * bench.capacity(wanted, force) * wanted
    for _ in range(TRIALS):
        values = driven_at_speed({**bench.parameters, **WITHOUT}, ratio, SPEED, -torque, force, held=True)
        out = bench.steady({**values, "ring.model": ring}, f"single elements, {case}")
        excess = out["ratio.geometric"] / wanted if out else 1.0
        if abs(excess - 1.0) < RATIO_ERROR:
            return out
        ratio /= excess
    bench.failures.append(f"single elements, {case}: the ratio {wanted:g} is not met")
    return None


def _loss(elements: dict[str, float]) -> float:
    """Share of the power of the primary pulley that is lost, without the damping of the ring's vibration, which the FMU does not need."""
    power = abs(elements["primary.beltTorque"]) * elements["primary.speed"]
    return 1.0 - elements["efficiency"] - (elements["loss.ringDamping"] + elements["loss.ringBending"]) / power


def _row(elements: dict[str, float], out: Outputs) -> list[Any]:
    pairs = [(elements[key], out[key]) for key in ("thrustRatio", "slip", "primary.idleArc", "secondary.idleArc")] + [(elements[PUSHES], out[PUSH_OUTPUT])]
    return [value for pair in pairs for value in pair] + [_loss(elements), 1.0 - out["efficiency.belt"]]


def _checks(found: dict[str, list[Any]]) -> list[Any]:
    def errors(model: str, key: str, theirs: str = "", loaded: bool = True) -> list[tuple[str, float | None]]:
        """Relative errors of an output."""
        cases = [one for one in found[model] if not loaded or not one[0].endswith("-0")]
        return [(case, out[key] / elements[theirs or key] - 1.0 if out else None) for case, elements, out in cases]

    solved = [one for one in found["ALE"] if one[0] != "medium-0"]
    arcs = [
        (f"{case}, {pulley}", out[f"{pulley}.idleArc"] - elements[f"{pulley}.idleArc"] if out else None)
        for case, elements, out in solved for pulley in ("primary", "secondary")
    ]  # fmt: skip
    losses = [
        (case, (1.0 - out["efficiency.belt"]) / _loss(elements) - 1.0 if out else None)
        for case, elements, out in solved if not case.endswith("-0")
    ]  # fmt: skip

    def spread(model: str, key: str, theirs: str = "") -> str:
        return PERCENT.text(*(value for _, value in errors(model, key, theirs, loaded=False) if value is not None))

    pitching = dict(_stored("pitch"))

    def pitched(key: str) -> str:
        """Relative errors against elements with pitch, under torque."""
        return PERCENT.text(*(out[key] / pitching[case][key] - 1.0 for case, _, out in found["ALE"] if out and not case.endswith("-0")))

    return [
        within("elements-thrust", "Thrust ratio", SOURCE, errors("ALE", "thrustRatio", loaded=False), -THRUST, THRUST, PERCENT),
        within("elements-slip", "Slip under torque", SOURCE, errors("ALE", "slip"), -SLIP, SLIP, PERCENT),
        within("elements-arcs", "Idle arcs; at ratio 1 without torque there are none", SOURCE, arcs, -ARC, ARC, RADIANS),
        within("elements-loss", "Loss of the belt under torque", SOURCE, losses, -LOSS, LOSS, PERCENT),
        reported("elements-push", "Largest push force", SOURCE, "the same", spread("ALE", PUSH_OUTPUT, PUSHES)),
        *(
            reported(f"elements-pitch-{key}", f"{name} under torque, elements that pitch by themselves", SOURCE, "typical dimensions", pitched(key))
            for key, name in (("thrustRatio", "Thrust ratio"), ("slip", "Slip"))
        ),
        reported("elements-guided", "Thrust ratio of ALE0", SOURCE, "the same", spread("ALE0", "thrustRatio")),
    ]


def _without_torque(bench: Bench, plan: Plan) -> tuple[Table, Check]:
    """The thrust ratio without torque over ratio and force."""
    rows: list[list[Any]] = []
    errors = []
    for case, elements in plan.thin(_stored("torque-free"), 2):
        out = _solve(bench, case, RingModel.ALE, elements["secondary.axialForce"])
        errors.append((case, out["thrustRatio"] / elements["thrustRatio"] - 1.0 if out else None))
        theory = _theory(bench, elements).thrust_ratio
        rows.append([case, elements["thrustRatio"], out and out["thrustRatio"], errors[-1][1], theory])
    columns = (Column("Case"), Column("Elements"), Column("FMU"), share("Difference"), Column("Theory"))
    check = within("elements-idle", "Thrust ratio without torque, 5 to 30 kN", SOURCE, errors, -THRUST, THRUST, PERCENT)
    return table("elements-idle", "Thrust ratio without torque", columns, rows, "209 rad/s."), check


def _shifts(bench: Bench, plan: Plan) -> tuple[Table, list[Check]]:
    """Speed of ratio change per unit of ln F_P after small and large steps, without torque."""
    stored = {(line["ratio"], line["step"]): line["gain"] for case, line in _stored("shifts") if case.split("-shift")[0].endswith("-0")}
    rows: list[list[Any]] = []
    errors, falls = [], []
    for ratio in plan.thin(sorted({ratio for ratio, _ in stored}, reverse=True), 1):
        start = driven_at_speed({**bench.parameters, **WITHOUT}, ratio, SPEED, 0.0, FORCE)
        found: dict[float, tuple[float, float]] = {}
        for step in (step for place, step in stored if place == ratio):
            name = f"s {1.0 / ratio:.2g}, step {signed(step)}"
            run = bench.shift(start, step, f"single elements, {name}")
            errors.append((name, run.gain / stored[ratio, step] - 1.0 if run else None))
            rows += [[1.0 / ratio, step, stored[ratio, step], run.gain, errors[-1][1]]] if run else []
            found |= {step: (stored[ratio, step], run.gain)} if run else {}
        steps = [sign * size for size in (SMALL, LARGE) for sign in (1.0, -1.0)]
        if all(step in found for step in steps):
            theirs, ours = ((sum(found[step][k] for step in steps[:2]) / sum(found[step][k] for step in steps[2:]) - 1.0) for k in (0, 1))
            falls.append((f"s {1.0 / ratio:.2g}", ours - theirs))
    columns = (
        Column("s = r_P/r_S", digits=2), Column("Step of ln F_P", digits=2, signed=True), Column("Elements", "1/s"), Column("FMU", "1/s"), share("Difference"),
    )  # fmt: skip
    note = "ds/dt per unit of ln F_P, 60 to 120 ms after the step. 15 kN, 209 rad/s."
    return table("elements-shifts", "Shift gains without torque", columns, rows, note), [
        within("elements-gain", "Shift gain without torque, steps of ±0.02 to ±0.3", SOURCE, errors, -GAIN, GAIN, PERCENT),
        within("elements-small", "Gain of steps of ±0.02 over that of ±0.3: FMU less elements", SOURCE, falls, -SMALL_GAIN, SMALL_GAIN, PERCENT),
    ]  # fmt: skip


def _theory(bench: Bench, elements: dict[str, float]) -> cmm.Variator:
    """The theory at the radii, force and torque of single elements."""
    radii = elements["primary.radius"], elements["secondary.radius"]
    pull = 0.5 * (elements["secondary.beltTorque"] / radii[1] - elements["primary.beltTorque"] / radii[0])
    beta, mu = bench.given("geometry.wedgeAngle"), bench.given("friction.pulley")
    arcs = wraps(*radii, bench.given("geometry.centerDistance"))
    return cmm.variator_at_torque(*arcs, beta, mu, radii[0], pull * radii[0], elements["secondary.axialForce"])


def _limit(bench: Bench) -> tuple[Table, list[Check]]:
    """Single elements in the theory's limit beside the theory, whose sheaves tilt by moment over stiffness."""
    rows: list[list[Any]] = []
    for case, elements in _stored("limit"):
        theory = _theory(bench, elements)
        mean, tan_beta = theory.mean_force(elements["secondary.axialForce"]), math.tan(bench.given("geometry.wedgeAngle"))
        arcs = (theory.primary, elements["primary.radius"]), (theory.secondary, elements["secondary.radius"])
        primary, secondary = (arc.thrust * mean * arc.moment * radius / TILT_STIFFNESS / tan_beta * arc.mean_sliding for arc, radius in arcs)
        pairs = (elements["thrustRatio"], theory.thrust_ratio), (elements["slip"], secondary - primary)
        rows.append([case, *(value for pair in pairs for value in (*pair, pair[0] / pair[1] - 1.0))])
    columns = (
        Column("Case"), Column("Thrust ratio, elements"), Column("Theory"), share("Thrust ratio, difference"),
        share("Slip, elements", 3, signed=False), share("Slip, theory", 3, signed=False), share("Slip, difference"),
    )  # fmt: skip
    checks = [
        within(f"elements-limit-{key}", f"Single elements in the theory's limit: {name}", THEORY, [(row[0], row[at]) for row in rows], -LIMIT, LIMIT, PERCENT)
        for key, name, at in (("thrust", "thrust ratio", 3), ("slip", "slip", 6))
    ]
    return table("elements-limit", "Single elements in the theory's limit", columns, rows, "15 kN, 209 rad/s; tilt stiffness 2e5 N·m/rad."), checks
