"""Thrust ratio over torque ratio: one curve per ratio, independent of force and speed."""

from __future__ import annotations

import itertools

from pushbelt.fmu.data import published_data
from pushbelt.fmu.steady import driven_by_torque
from pushbelt.report.charts import Chart, Panel

from ..bench import Bench, Plan, rad
from ..limit import EFFECTS
from ..measured import Source, source
from ..outcome import (
    NOTHING,
    PERCENT,
    Check,
    Column,
    Part,
    Section,
    Table,
    curve,
    reported,
    share,
    signed,
    table,
    within,
)
from ..tilt import RIGID

RATIOS = (2.25, 1.5, 1.0, 0.67, 0.44)
TORQUE_RATIOS = (-0.9, -0.75, -0.6, -0.45, -0.3, -0.15, 0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9)
FORCES = (10e3, 20e3)
SPEEDS = (1000.0, 3000.0)
TOLERANCE = 0.05

FAST_RATIOS = (2.25, 1.0, 0.44)
FAST_TORQUE_RATIOS = (0.0, 0.6)
FAST_SPEEDS = (2000.0, 5000.0, 7000.0)
FAST_FORCE = 15e3

Key = tuple[float, float]
"""Ratio and torque ratio."""


def run(bench: Bench, plan: Plan) -> Section:
    """Solves the points and evaluates the checks."""
    solved = _solve(bench, plan)
    fast, fast_check = _fast(bench, plan)
    found = {key: values for key, values in solved.items() if len(values) > 1}
    spread = {key: max(values.values()) / min(values.values()) - 1.0 for key, values in found.items()}
    columns = (
        Column("Ratio", digits=2), Column("Torque ratio", digits=2, signed=True), Column("Least"), Column("Greatest"),
        share("Apart", signed=False), Column("Carried", "of 4", 0),
    )  # fmt: skip
    rows = [[*key, min(v.values()), max(v.values()), spread[key], float(len(v))] for key, v in found.items()]
    note = (
        "For 10 and 20 kN, 1000 and 3000 rpm. Points in macro-slip are not counted: in underdrive the primary "
        "pulley slips first."
    )
    return Section(
        "thrust-ratio",
        Part.MEASUREMENTS,
        "Thrust ratio over torque",
        "The torque ratio is the torque divided by that of full slip under the secondary force.",
        (*_checks(spread), fast_check, _published(bench)),
        (table("thrust-ratio", "Thrust ratio over force and speed", columns, rows, note), fast),
        (_chart(found),),
    )


def _solve(bench: Bench, plan: Plan) -> dict[Key, dict[Key, float]]:
    """Thrust ratios by ratio and torque ratio, over force and speed."""
    ratios, torque_ratios = plan.thin(RATIOS, 1), plan.thin(TORQUE_RATIOS)
    found: dict[Key, dict[Key, float]] = {(i, t): {} for i in ratios for t in torque_ratios}
    branches = [t for t in torque_ratios if t >= 0.0], [t for t in reversed(torque_ratios) if t < 0.0]
    for ratio, force, rpm, branch in itertools.product(ratios, FORCES, SPEEDS, branches):
        for torque_ratio in branch:
            torque = torque_ratio * bench.capacity(ratio, force)
            values = driven_by_torque(bench.parameters, ratio, rad(rpm), torque, force)
            out = bench.steady(
                values, f"ratio {ratio:g}, torque ratio {torque_ratio:g}, {force / 1e3:g} kN, {rpm:g} rpm"
            )
            if not out or out["macroSlip"]:
                # A larger torque is not carried either.
                break
            found[ratio, torque_ratio][force, rpm] = out["thrustRatio"]
    return found


def _fast(bench: Bench, plan: Plan) -> tuple[Table, Check]:
    """Thrust ratios up to high speeds, where centrifugal tension stretches the ring and opens gaps."""
    rows: list[list[float | None]] = []
    for ratio, torque_ratio in itertools.product(plan.thin(FAST_RATIOS, 1), FAST_TORQUE_RATIOS):
        torque = torque_ratio * bench.capacity(ratio, FAST_FORCE)
        found: list[float | None] = []
        for rpm in FAST_SPEEDS:
            values = driven_by_torque(bench.parameters, ratio, rad(rpm), torque, FAST_FORCE)
            out = bench.steady(values, f"ratio {ratio:g}, torque ratio {torque_ratio:g}, {rpm:g} rpm")
            found.append(out["thrustRatio"] if out else None)
        change = found[-1] / found[0] - 1.0 if found[0] and found[-1] else None
        rows.append([ratio, torque_ratio, *found, change])
    changes = [row[-1] for row in rows if row[-1] is not None]
    check = reported(
        "thrust-speed",
        "Thrust ratio at 7000 rpm against 2000 rpm, 15 kN, torque ratios 0 and 0.6",
        source("thrustRatioInvariance"),
        "almost independent of speed; the speeds of the measurement are not known",
        PERCENT.text(*changes),
    )
    speeds = (Column(f"at {rpm:g} rpm") for rpm in FAST_SPEEDS)
    columns = (Column("Ratio", digits=2), Column("Torque ratio", digits=1), *speeds, share("From least to greatest speed"))
    note = f"{FAST_FORCE / 1e3:g} kN on the secondary pulley."
    return table("thrust-ratio-speed", "Thrust ratio over speed", columns, rows, note), check


ASSUMPTIONS = {
    **EFFECTS["ring friction"], **EFFECTS["play"], **EFFECTS["losses"], "belt.pitchOffset": 0.0,
    "primary.tiltStiffness": RIGID, "secondary.tiltStiffness": RIGID, "mesh.primaryArc": 24, "mesh.secondaryArc": 24, "mesh.strand": 12,
}  # fmt: skip
"""Of the theory of the published case: rigid sheaves, no ring friction, no play, the pitch line on the ring. The pressure then rises abruptly."""


def _published(bench: Bench) -> Check:
    """The published state of `belt155`, whose theory has no friction along the flank."""
    case = next(one["referenceCase"] for one in published_data()["variators"] if one["id"] == "belt155")
    with Bench(bench.archive, "belt155", bench.solved, bench.failures, ASSUMPTIONS) as own:
        values = driven_by_torque(
            own.parameters, case["geometricRatio"], case["primarySpeed"], case["primaryTorque"], case["secondaryClampingForce"]
        )
        out = own.steady(values, "published case of belt155")
    return reported(
        "published-case", "Thrust ratio of the published state of belt155, under the assumptions of its theory",
        Source("CVT_VelocityInit code, 2012-2015", "a closed form without friction along the flank, with idle and active arcs on rigid sheaves"),
        f"{case['thrustRatio']:.3f}", f"{out['thrustRatio']:.3f}" if out else NOTHING,
    )  # fmt: skip


def _checks(spread: dict[Key, float]) -> tuple[Check, ...]:
    names = [(f"ratio {ratio:g}, torque ratio {signed(torque)}", value) for (ratio, torque), value in spread.items()]
    return (
        within(
            "thrust-curve", "The thrust ratio depends on ratio and torque ratio alone, not on force or speed",
            source("thrustRatioInvariance"), names, None, TOLERANCE, PERCENT,
            "largest over least ≤ 5\N{NO-BREAK SPACE}% apart",
        ),
    )  # fmt: skip


def _chart(found: dict[Key, dict[Key, float]]) -> Chart:
    curves = []
    for colour, ratio in enumerate(dict.fromkeys(ratio for ratio, _ in found)):
        for force, rpm in itertools.product(FORCES, SPEEDS):
            points = [(t, values[force, rpm]) for (i, t), values in found.items() if i == ratio and (force, rpm) in values]
            curves.append(curve(f"ratio {ratio:g}", *zip(*points, strict=True), colour, "-" if rpm == SPEEDS[0] else "--"))
    label = "Four lines per ratio: 10 and 20 kN, 1000 rpm (solid) and 3000 rpm (dashed)."
    return Chart([Panel("Thrust ratio F_P/F_S", curves, "torque / torque of full slip under the secondary force", height=300)], label)
