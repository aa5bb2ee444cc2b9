"""Comparison with the continuum theory: in its limit, at levels towards it, and at default parameters."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import product

from pushbelt.fmu.data import load_cases
from pushbelt.fmu.starts import driven_at_speed
from pushbelt.theory import cmm

from .. import against_theory
from ..against_theory import LADDER, LADDER_CASES, Deviation
from ..bench import Bench, Plan
from ..measured import THEORY
from ..outcome import (
    PERCENT,
    Check,
    Column,
    Curve,
    Panel,
    Picture,
    Section,
    Table,
    reported,
    share,
    signed,
    table,
    within,
)

TOLERANCE = 0.05
"""Tolerance of the thrust ratio in the theory's limit."""
LEAST_ERROR = 0.01
"""Error below which further reduction along the series of levels is not required."""
NO_TORQUE_TOLERANCE = 0.12
"""Tolerance of the thrust ratio without torque at default parameters."""
NO_TORQUE_RATIOS = (2.25, 1.0, 0.44)
NO_TORQUE_FORCES, NO_TORQUE_SPEED = (10e3, 20e3), 104.72
"""Force, N, and speed, rad/s, of a published state of the laboratory rig."""

VARIANTS = (({}, ""), ({"friction.ring": 0.0}, ", no ring friction"))
"""Changed parameters: the theory has no ring friction."""

COLUMNS = (
    Column("Case"),
    Column("r_S/r_P"),
    Column("Traction r", digits=3, signed=True),
    Column("Thrust ratio", digits=4),
    Column("Theory", digits=4),
    share("Difference", 2),
    share("Slip, difference"),
    share("Loss, difference"),
    share("Compression", signed=False),
    share("Strain", signed=False),
    share("v_0", signed=False),
    Column("Balance", "1e-6", 0, 1e6, signed=True),
)
NOTE = (
    "Differences: FMU minus theory. Slip and loss: the theory at the FMU's tilt. Compression: of the contact, "
    "relative to the opening; "
    "strain of the chain and v_0: relative to the sliding. Balance: net power minus losses, relative to the driving power."
)


def _row(name: str, d: Deviation) -> list[float | str]:
    return [
        name, d.ratio, d.theory.traction, d.thrust_ratio, d.theory.thrust_ratio, d.thrust_error, d.slip_error,
        d.loss_error, d.compression, d.strain, d.regularisation, d.residual,
    ]  # fmt: skip


def count(plan: Plan) -> int:
    """Approximate number of points."""
    return 12 if plan.short else 18 + 31 + 16 + 6


def run(bench: Bench, plan: Plan) -> Section:
    """Solves the points and compares them with the theory."""
    in_limit, limit_check = _limit(bench, plan)
    ladders, ladder_checks = _ladders(bench, plan)
    default, default_checks = _default(bench, plan)
    idle, idle_checks = _without_torque(bench, plan)
    return Section(
        "theory",
        "Continuum theory",
        "A continuous belt on pulleys that open under load is solved independently (python/pushbelt/theory). Each "
        "state is compared "
        "at the FMU's radii, torque and secondary force.",
        (limit_check, *ladder_checks, *default_checks, *idle_checks),
        (in_limit, ladders, default, idle, _theory_table(bench, plan)),
        (_picture(default),),
        (
            "In the theory's limit the FMU has the assumptions of the theory: no ring friction, no play, no losses of layers, "
            "turning elements and shafts, a constant "
            "friction coefficient, sheaves that tilt without clearance, and contact, chain and ring so stiff that the "
            "opening dominates.",
        ),
    )


def _name(case: tuple[float, float]) -> str:
    return f"r_S/r_P {case[0]:g}, r {signed(case[1])}"


def _limit(bench: Bench, plan: Plan) -> tuple[Table, Check]:
    cases = plan.thin(against_theory.cases(bench, plan.thin(against_theory.RATIOS, 1)), 2)
    found = {c: against_theory.compare(bench, against_theory.limit_case(bench, *c), f"limit {_name(c)}") for c in cases}
    errors = [(_name(case), d and d.thrust_error) for case, d in found.items()]
    statement = "In the theory's limit the thrust ratio agrees with the theory"
    check = within(statement, THEORY, errors, -TOLERANCE, TOLERANCE, PERCENT)
    rows = [_row("limit", d) for d in found.values() if d]
    return table("limit", "In the theory's limit", COLUMNS, rows, NOTE), check


def _ladders(bench: Bench, plan: Plan) -> tuple[Table, list[Check]]:
    rows: list[list[float | str]] = []
    last, halved = [], []
    for case in plan.thin(LADDER_CASES, 1):
        levels = []
        for level in plan.thin(LADDER, 2):
            name = f"level {LADDER.index(level) + 1}"
            values = against_theory.limit_case(bench, *case, level)
            levels.append(against_theory.compare(bench, values, f"{name}, {_name(case)}"))
            rows += [_row(name, levels[-1])] if levels[-1] else []
        first, end = levels[0], levels[-1]
        last.append((_name(case), end and end.thrust_error))
        allowed = max(0.5 * abs(first.thrust_error), LEAST_ERROR) if first else None
        halved.append((_name(case), abs(end.thrust_error) / allowed if end and allowed else None))
    steps = "With increasing stiffness and mesh refinement the thrust ratio"
    goal = "half of the first level's error, or 1\N{NO-BREAK SPACE}%: the last over that ≤ 1"
    checks = [
        within(f"{steps} ends at the theory's", THEORY, last, -TOLERANCE, TOLERANCE, PERCENT),
        within(f"{steps} comes nearer to the theory's", THEORY, halved, None, 1.0, goal=goal),
    ]
    return table("ladder", "Approach to the limit: stiffness and mesh grow together", COLUMNS, rows, NOTE), checks


def _default(bench: Bench, plan: Plan) -> tuple[Table, list[Check]]:
    rows, checks = [], []
    for changed, what in VARIANTS:
        errors = []
        for case in plan.thin(load_cases(bench.parameters), 2):
            name = f"{case.name}{what}"
            found = against_theory.compare(bench, against_theory.load_case(case, changed), name)
            if found:
                rows.append(_row(name, found))
                errors.append(found.thrust_error)
        checks.append(_range(f"Nine load cases at default parameters{what}", errors))
    return table("load-cases", "Nine load cases at default parameters", COLUMNS, rows, NOTE), checks


def _range(statement: str, errors: Iterable[float]) -> Check:
    errors = list(errors)
    found = PERCENT.text(*errors) + " of the thrust ratio"
    return reported(statement, THEORY, "the theory's thrust ratio at the same traction", found)


def _without_torque(bench: Bench, plan: Plan) -> tuple[Table, list[Check]]:
    """Without torque the ring's friction and the play determine which part of an arc is loaded by push forces."""
    belt, rows, checks = against_theory.belt_of(bench), [], []
    for (changed, variant), force in product(VARIANTS, NO_TORQUE_FORCES):
        what = f", {force / 1e3:g} kN{variant}"
        errors = []
        for ratio in plan.thin(NO_TORQUE_RATIOS):
            values = driven_at_speed({**bench.parameters, **changed}, ratio, NO_TORQUE_SPEED, 0.0, force)
            out = bench.steady(values, f"no torque, ratio {ratio:g}{what}")
            error = None
            if out:
                theory = math.exp(belt.equilibrium(1.0 / out["ratio.geometric"]))
                error = out["thrustRatio"] / theory - 1.0
                rows.append([f"{ratio:g}{what}", out["thrustRatio"], theory, error])
            errors.append((f"r_S/r_P {ratio:g}", error))
        statement = f"Without torque the thrust ratio agrees with the theory{what}"
        checks.append(within(statement, THEORY, errors, -NO_TORQUE_TOLERANCE, NO_TORQUE_TOLERANCE, PERCENT))
    columns = (Column("r_S/r_P"), Column("Thrust ratio", digits=4), Column("Theory", digits=4), share("Difference"))
    note = "1000 rpm, no load on the secondary shaft; the force is the secondary pulley's."
    return table("no-torque", "Thrust ratio without torque", columns, rows, note), checks


def _theory_table(bench: Bench, plan: Plan) -> Table:
    """Results of the theory alone, for comparison with other models."""
    belt = against_theory.belt_of(bench)
    tractions = plan.thin((-0.5, -0.4, -0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3, 0.4, 0.5))
    rows = []
    for ratio in plan.thin((0.45, 0.6, 0.8, 1.0, 1.25, 1.6, 2.2), 1):
        wrap_p, wrap_s, _, _ = cmm.wrap_angles(
            ratio, bench.given("geometry.centerDistance"), bench.given("geometry.beltLength")
        )
        limits = [cmm.capacity(wrap_p, wrap_s, belt.beta, belt.mu, driving) for driving in (True, False)]
        rows.append(
            [
                ratio,
                *limits,
                *(
                    cmm.variator(wrap_p, wrap_s, belt.beta, belt.mu, r).thrust_ratio
                    if abs(r) < limits[r < 0.0]
                    else None
                    for r in tractions
                ),
            ]
        )
    columns = [
        Column("r_S/r_P", digits=2),
        Column("Capacity, drive"),
        Column("Capacity, brake"),
        *(Column(f"r = {signed(r)}") for r in tractions),
    ]
    return table("theory", "The theory alone: thrust ratio over ratio and traction", columns, rows)


def _picture(default: Table) -> Picture:
    names = [row[0] for row in default.rows]
    places = tuple(float(k) for k in range(len(names)))
    ours, theirs = (tuple(float(row[k]) for row in default.rows) for k in (3, 4))  # type: ignore[arg-type]
    panel = Panel(
        "Thrust ratio",
        "",
        (Curve(places, ours, "FMU", 0, "o"), Curve(places, theirs, "theory", 1, "_")),
        places=tuple(str(name) for name in names),
    )
    return Picture(
        (panel,), "Thrust ratio of the load cases at default parameters, and of the theory at the same traction."
    )
