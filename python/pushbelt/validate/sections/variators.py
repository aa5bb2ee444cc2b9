"""Comparison of two variators, which separates effects of the law from those of the geometry."""

from __future__ import annotations

import math

from pushbelt.fmu.starts import driven_by_torque

from .. import against_theory
from ..bench import Bench, Plan
from ..measured import THEORY
from ..outcome import PERCENT, Column, Section, reported, share, table

NAMES = ("bench168", "belt155")
RATIOS = (2.25, 1.0, 0.44)
TORQUE_RATIOS = (0.3, 0.75)
FORCE = 15e3
SPEED = 2000.0 * math.pi / 30.0


def count(plan: Plan) -> int:
    """Approximate number of points."""
    return 2 if plan.short else 12


def run(bench: Bench, plan: Plan) -> Section:
    """Solves both at the same ratio, force and share of their torque of full slip."""
    rows, errors = [], []
    for name in NAMES:
        with Bench(bench.archive, name, bench.solved, bench.failures) as own:
            for ratio in plan.thin(RATIOS, 1):
                for share_of_slip in plan.thin(TORQUE_RATIOS, 1):
                    torque = share_of_slip * own.capacity(ratio, FORCE)
                    values = driven_by_torque(own.parameters, ratio, SPEED, torque, FORCE)
                    found = against_theory.compare(own, values, f"{name}, ratio {ratio:g}, {share_of_slip:g}")
                    if found:
                        out = found.outputs
                        theory = found.theory.thrust_ratio
                        rows.append(
                            [
                                name,
                                ratio,
                                share_of_slip,
                                torque,
                                found.thrust_ratio,
                                theory,
                                found.thrust_error,
                                out["slip"],
                                out["efficiency"],
                            ]
                        )
                        errors.append(found.thrust_error)
    check = reported(
        "Thrust ratio of both variators, and theory for each",
        THEORY,
        "the theory's at the same traction",
        PERCENT.text(*errors),
    )
    columns = (
        Column("Variator"),
        Column("Ratio", digits=2),
        Column("Torque ratio", digits=2),
        Column("Torque", "N·m", 1),
        Column("Thrust ratio"),
        Column("Theory"),
        share("Difference"),
        share("Slip", 2, signed=False),
        share("Efficiency", 1, signed=False),
    )
    note = "15 kN on the secondary pulley, 2000 rpm; torque as a share of full slip's."
    return Section(
        "variators",
        "Two variators",
        "bench168 (168 mm, μ 0.09) and belt155 (155 mm, μ 0.11) at the same ratio, force and torque ratio.",
        (check,),
        (table("variators", "bench168 and belt155", columns, rows, note),),
    )
