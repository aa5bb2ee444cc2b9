"""A wedge angle of 9° instead of 11°, in overdrive.

At equal force the torque of full slip, 2 μ F R/cos β, hardly depends on the angle. The ring's tension does: without torque
it is about 2 tan β F/α. The gain in capacity is therefore evaluated at equal ring tension, with the same safety factor at each angle.
Under torque a part of the tension is due to the torque, independent of the angle. The source does not state which condition it means.
"""

from __future__ import annotations

import math

from scipy.optimize import brentq

from pushbelt.fmu.steady import driven_by_torque

from ..bench import Bench, Outputs, Plan, rad
from ..measured import data, source
from ..outcome import NOTHING, PERCENT, POINTS, Check, Column, Part, Section, reported, share, table, within

RATIO = 0.45
SPEED = rad(2000.0)
FORCE = 10e3
"""Secondary force at the larger angle, N."""
SAFETY = 1.3
GAIN_TOLERANCE = 0.05
EFFICIENCY = (0.0, 0.01)
"""Gain of the unit's efficiency, measured 0.005."""
LOADS = {"without torque": 0.0, "under torque": 1.0 / SAFETY}
"""Loads at which ring tensions are compared: torque divided by that of full slip."""
TENSION = "ring.tensionMax"


def _state(bench: Bench, angle: float, force: float, torque: float) -> Outputs | None:
    """A steady state at a half wedge angle in rad, under a secondary force in N and a primary torque in N·m."""
    parameters = {**bench.parameters, "geometry.wedgeAngle": angle}
    values = driven_by_torque(parameters, RATIO, SPEED, torque, force)
    return bench.steady(values, f"wedge angle {math.degrees(angle):g}°, {force / 1e3:.1f} kN, {torque:.0f} N·m")


def _capacity(bench: Bench, angle: float, force: float) -> float:
    return bench.capacity(RATIO, force, {"geometry.wedgeAngle": angle})


def _force_of_equal_tension(bench: Bench, old: float, new: float, load: float) -> float | None:
    """Secondary force at which the ring tension at the smaller angle equals that at the larger one, N."""
    reference = _state(bench, old, FORCE, load * _capacity(bench, old, FORCE))

    def excess(force: float) -> float:
        out = _state(bench, new, force, load * _capacity(bench, new, force))
        return out[TENSION] - reference[TENSION] if out and reference else math.nan

    try:
        return float(brentq(excess, FORCE, 1.6 * FORCE, xtol=5.0))
    except ValueError:
        return None


def run(bench: Bench, _plan: Plan) -> Section:
    """Solves the points and evaluates the checks."""
    measured = data()["wedgeAngle"]
    old, new = (math.radians(measured[key]) for key in ("fromDeg", "toDeg"))
    before = _capacity(bench, old, FORCE)
    torque = before / SAFETY
    states = {
        "11°": _state(bench, old, FORCE, torque),
        "9°, same torque": _state(bench, new, FORCE * before / _capacity(bench, new, FORCE), torque),
    }
    efficiencies = [out and out["efficiency"] for out in states.values()]
    gains: dict[str, float | None] = {}
    for name, load in LOADS.items():
        force = _force_of_equal_tension(bench, old, new, load)
        gains[name] = _capacity(bench, new, force) / before - 1.0 if force else None
        if force:
            loaded = _state(bench, new, force, _capacity(bench, new, force) / SAFETY)
            states[f"9°, the ring tension of 11° {name}"] = loaded
    rows = [
        [name, out["secondary.axialForce"], -out["primary.shaftTorque"], out[TENSION], out["efficiency"], out["slip"]]
        for name, out in states.items()
        if out
    ]
    columns = (
        Column("Wedge angle"), Column("F_S", "kN", 2, 1e-3), Column("Torque", "N·m", 1), Column("Largest ring tension", "N", 0),
        share("Efficiency", 2, signed=False), share("Slip", 2, signed=False),
    )  # fmt: skip
    note = f"Ratio {RATIO:g}, 2000 rpm, torque at a safety of {SAFETY:g}."
    return Section(
        "wedge-angle",
        Part.MEASUREMENTS,
        "Wedge angle",
        "A published change of the half wedge angle. All other parameters are those of bench168; the measured unit was a different one.",
        _checks(gains, None if None in efficiencies else efficiencies[1] - efficiencies[0]),  # type: ignore[operator]
        (table("wedge-angle", "9° against 11° in overdrive", columns, rows, note),),
    )


def _checks(gains: dict[str, float | None], efficiency: float | None) -> tuple[Check, ...]:
    measured, where = data()["wedgeAngle"], source("wedgeAngle")
    gain = measured["torqueCapacityGain"]
    idle, loaded = gains.values()
    statement = "Torque capacity from 11° to 9° at equal ring tension"
    return (
        within(
            "wedge-capacity", f"{statement} without torque", where, [("gain", idle)], gain - GAIN_TOLERANCE, gain + GAIN_TOLERANCE, PERCENT,
            f"+{PERCENT.text(gain)} measured; ±5 points",
        ),
        reported(
            "wedge-capacity-loaded", f"{statement} under torque", where,
            "the source does not state the load at which tensions are equal; the continuum theory has +7 to +12 % under torque",
            PERCENT.text(loaded) if loaded else NOTHING,
        ),
        within(
            "wedge-efficiency", "Efficiency from 11° to 9° at equal torque, overdrive", where, [("gain", efficiency)], *EFFICIENCY, POINTS,
            f"+{POINTS.text(measured['unitEfficiencyGainOverdrive'])} of the unit measured; 0 to 1 point",
        ),
    )  # fmt: skip
