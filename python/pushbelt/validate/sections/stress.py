"""Stress in the layers of the ring at full load."""

from __future__ import annotations

import math

from pushbelt.fmu.starts import driven_by_torque

from ..bench import Bench, Outputs, Plan
from ..measured import data, source
from ..outcome import Check, Column, Section, Unit, reported, table

RATIOS = (2.25, 1.0, 0.44)
TORQUE, FORCE = 150.0, 30e3
"""Full load of bench168: primary torque, N·m, and secondary force, N."""
SPEED = 2000.0 * math.pi / 30.0
MEGAPASCAL = Unit("MPa", 0, 1e-6)

COLUMNS = (
    "ring.stressMax",
    "ring.stressAmplitude.primary",
    "ring.stressMean.primary",
    "ring.stressAmplitude.secondary",
    "ring.stressMean.secondary",
)


def count(plan: Plan) -> int:
    """Approximate number of points."""
    return len(plan.thin(RATIOS))


def run(bench: Bench, plan: Plan) -> Section:
    """Solves the points and evaluates the check."""
    solved = []
    for ratio in plan.thin(RATIOS):
        values = driven_by_torque(bench.parameters, ratio, SPEED, TORQUE, FORCE)
        out = bench.steady(values, f"ratio {ratio:g}, {TORQUE:g} N·m, {FORCE / 1e3:g} kN")
        if out:
            solved.append((ratio, out))
    columns = (
        Column("Ratio", digits=2),
        Column("Largest", "MPa", 0, 1e-6),
        Column("Amplitude on P", "MPa", 0, 1e-6),
        Column("Mean on P", "MPa", 0, 1e-6),
        Column("Amplitude on S", "MPa", 0, 1e-6),
        Column("Mean on S", "MPa", 0, 1e-6),
    )
    rows = [[ratio, *(out[name] for name in COLUMNS)] for ratio, out in solved]
    note = f"{TORQUE:g} N·m, {FORCE / 1e3:g} kN on the secondary pulley, 2000 rpm."
    return Section(
        "stress",
        "Stress of the ring",
        "Tension and bending in the layer and at the face with the largest stress over a revolution. The residual curvature of the layers "
        "reduces the bending stress of their inner or outer faces.",
        (_check(solved),),
        (table("stress", "Stress at full load", columns, rows, note),),
    )


def _check(solved: list[tuple[float, Outputs]]) -> Check:
    estimate = data()["ringStress"]
    return reported(
        "Largest stress of the ring at full load, ratios 2.25 to 0.44",
        source("ringStress"),
        f"up to {MEGAPASCAL.text(estimate['sum'])}: tension up to {MEGAPASCAL.text(estimate['tension'])}, "
        f"bending {MEGAPASCAL.text(*estimate['bending'])}",
        MEGAPASCAL.text(*(out["ring.stressMax"] for _, out in solved)),
    )
