"""A wedge angle of 9° instead of 11°, in overdrive.

The torque of full slip, 2 μ F R/cos β, hardly knows the angle at equal force. The ring's tension does: it is about
2 tan β F/α. So the gain in capacity is read at equal largest ring tension, each angle at the same safety factor.
"""

from __future__ import annotations

import math

from scipy.optimize import brentq

from pushbelt.fmu.starts import driven_by_torque

from ..bench import Bench, Outputs, Plan
from ..measured import data, source
from ..outcome import PERCENT, Column, Section, Unit, share, table, within

RATIO = 0.45
SPEED = 2000.0 * math.pi / 30.0
FORCE = 10e3
"""Secondary force at the old angle, N."""
SAFETY = 1.3
GAIN_TOLERANCE = 0.05
EFFICIENCY = (0.0, 0.01)
"""Gain of the unit's efficiency, measured 0.005."""
POINTS = Unit("points", 2, 100.0)


def count(_plan: Plan) -> int:
    """Points, about."""
    return 12


def run(bench: Bench, _plan: Plan) -> Section:
    """Solves and judges."""
    measured = data()["wedgeAngle"]
    old, new = (math.radians(measured[key]) for key in ("fromDeg", "toDeg"))

    def at(angle: float, force: float, torque: float | None = None) -> Outputs | None:
        changed = {"geometry.wedgeAngle": angle}
        torque = bench.capacity(RATIO, force, changed) / SAFETY if torque is None else torque
        values = driven_by_torque({**bench.parameters, **changed}, RATIO, SPEED, torque, force)
        return bench.steady(values, f"wedge angle {math.degrees(angle):g}°, {force / 1e3:.1f} kN")

    reference = at(old, FORCE)
    torque = bench.capacity(RATIO, FORCE, {"geometry.wedgeAngle": old}) / SAFETY
    same_torque = at(new, FORCE * math.cos(new) / math.cos(old), torque)
    rows, gains, efficiencies = [], [], []
    if reference and same_torque:

        def excess(force: float) -> float:
            out = at(new, force)
            return out["ring.tensionMax"] - reference["ring.tensionMax"] if out else math.nan

        force = float(brentq(excess, FORCE, 1.6 * FORCE, xtol=5.0))
        same_tension = at(new, force)
        if same_tension:
            capacities = [
                bench.capacity(RATIO, *pair)
                for pair in ((FORCE, {"geometry.wedgeAngle": old}), (force, {"geometry.wedgeAngle": new}))
            ]
            gains.append(("gain", capacities[1] / capacities[0] - 1.0))
            efficiencies.append(("gain", same_torque["efficiency"] - reference["efficiency"]))
            for name, out in (
                ("11°", reference),
                ("9°, the same torque", same_torque),
                ("9°, the same ring tension", same_tension),
            ):
                rows.append(
                    [
                        name,
                        out["secondary.axialForce"],
                        -out["primary.shaftTorque"],
                        out["ring.tensionMax"],
                        out["efficiency"],
                        out["slip"],
                    ]
                )
    checks = (
        within(
            "Torque capacity from 11° to 9° at equal ring tension",
            source("wedgeAngle"), gains,
            measured["torqueCapacityGain"] - GAIN_TOLERANCE, measured["torqueCapacityGain"] + GAIN_TOLERANCE, PERCENT,
            f"+{PERCENT.text(measured['torqueCapacityGain'])} measured; ±5 points",
        ),
        within(
            "Efficiency from 11° to 9° at equal torque, overdrive",
            source("wedgeAngle"), efficiencies, *EFFICIENCY, POINTS,
            f"+{POINTS.text(measured['unitEfficiencyGainOverdrive'])} of the unit measured; 0 to 1 point",
        ),
    )  # fmt: skip
    columns = (
        Column("Wedge angle"),
        Column("F_S", "kN", 2, 1e-3),
        Column("Torque", "N·m", 1),
        Column("Largest ring tension", "N", 0),
        share("Efficiency", 2, signed=False),
        share("Slip", 2, signed=False),
    )
    note = f"Ratio {RATIO:g}, 2000 rpm, safety {SAFETY:g}."
    return Section(
        "wedge-angle",
        "Wedge angle",
        "A published change of the half wedge angle. Everything else is that of bench168; the measured unit was "
        "another one.",
        checks,
        (table("wedge-angle", "9° against 11° in overdrive", columns, rows, note),),
    )
