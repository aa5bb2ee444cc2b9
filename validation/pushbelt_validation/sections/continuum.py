"""The belt in the limit of the continuum theory: everything stiff, no play, no oil, no friction of the ring."""

from __future__ import annotations

import math

from pushbelt.fmu.steady import driven_at_speed

from .. import limit
from ..bench import Bench, Plan, rad
from ..limit import OFF, QUICK, WITH_CLEARANCE, Deviation, belt_of
from ..measured import THEORY
from ..outcome import PERCENT, PLAIN, Check, Column, Part, Section, Table, share, signed, table, within

TOLERANCE = 0.05
"""Tolerance of the thrust ratio, and of the tilt without clearance."""
SLIP_TOLERANCE = 0.1
"""Tolerance of slip and friction power, which are proportional to the opening."""
IDLE_TOLERANCE, SLOPE_TOLERANCE, GAIN_TOLERANCE = 0.025, 0.03, 0.03
IDLE_RATIOS, IDLE_FORCES, IDLE_SPEED = (2.25, 1.0, 0.444), (5e3, 15e3, 30e3), rad(2000.0)
SLOPE_PLACES, SLOPE_FORCE = (0.95, 1.05), 15e3
SHIFT_PLACES, SHIFT_FORCE, SHIFT_SPEED, SHIFT_STEP = (0.6, 1.0, 1.8), 20e3, rad(1000.0), 0.05
"""A small step, after which the opening hardly changes."""
LOADED_PLACES, LOADS, LOADED_STEP, LOADED_TOLERANCE = (0.6, 1.0, 1.6), (0.4, 0.7), 0.02, 0.1
"""Shifts under torque: speed ratios, shares of the torque of full slip, steps of ln F_P. At 0.7 an upshift by 0.05 gains a sixth more than
a downshift, since its torque comes nearer to capacity."""

COLUMNS = (
    Column("Case"), Column("r_S/r_P"), Column("Traction r", digits=3, signed=True), Column("Thrust ratio", digits=4), Column("Theory", digits=4),
    share("Difference", 2), share("Slip, difference"), share("Loss, difference"), share("Compression", signed=False),
    share("Strain", signed=False), share("v_0", signed=False), Column("Balance", "1e-6", 0, 1e6, signed=True),
)  # fmt: skip
NOTE = (
    "Differences: FMU minus theory. Slip and loss: the theory at the FMU's tilt. Compression: of the contact, relative to the opening; "
    "strain of the chain and v_0: relative to the sliding. Balance: net power minus losses, relative to the driving power."
)


def _row(name: str, d: Deviation) -> list[float | str]:
    return [
        name, d.ratio, d.theory.traction, d.thrust_ratio, d.theory.thrust_ratio, d.thrust_error, d.slip_error,
        d.loss_error, d.compression, d.strain, d.regularisation, d.residual,
    ]  # fmt: skip


def run(bench: Bench, plan: Plan) -> Section:
    """Solves the points and compares them with the theory."""
    in_limit, limit_checks = _limit(bench, plan)
    idle, idle_check = _without_torque(bench, plan)
    shifts, shift_check = _shifts(bench, plan)
    loaded = loaded_gains(bench, plan, {**OFF, **QUICK}, "limit")
    statement = "The same under 0.4 and 0.7 of the torque of full slip, steps up and down"
    loaded_check = within("limit-gain-loaded", statement, THEORY, loaded, -LOADED_TOLERANCE, LOADED_TOLERANCE, PERCENT)
    return Section(
        "theory",
        Part.VERIFICATION,
        "Continuum theory",
        "A continuous belt on pulleys that open under load, solved independently. The FMU has the assumptions of the theory: no ring "
        "friction, no play, no oil, no losses but those of the flanks, constant friction, and contact, stack and ring so stiff that the "
        "opening dominates. The theory is solved at the FMU's radii, torque and secondary force.",
        (*limit_checks, idle_check, _slope(bench), shift_check, loaded_check),
        (in_limit, idle, shifts),
    )


def _name(case: tuple[float, float]) -> str:
    return f"r_S/r_P {case[0]:g}, r {signed(case[1])}"


def _limit(bench: Bench, plan: Plan) -> tuple[Table, list[Check]]:
    cases = plan.thin(limit.cases(bench, plan.thin(limit.RATIOS, 1)), 2)
    found = {c: limit.compare(bench, limit.limit_case(bench, *c), f"limit {_name(c)}") for c in cases}

    def check(key: str, statement: str, quantity: str, tolerance: float) -> Check:
        errors = [(_name(case), d and getattr(d, quantity)) for case, d in found.items()]
        return within(key, statement, THEORY, errors, -tolerance, tolerance, PERCENT)

    checks = [
        check("limit-thrust", "Thrust ratio under torque", "thrust_error", TOLERANCE),
        check("limit-slip", "Slip under torque", "slip_error", SLIP_TOLERANCE),
        check("limit-loss", "Friction power on the sheaves under torque", "loss_error", SLIP_TOLERANCE),
        check("limit-tilt", "Tilt of the sheaves under torque", "tilt_error", TOLERANCE),
    ]
    return table("limit", "In the theory's limit", COLUMNS, [_row("limit", d) for d in found.values() if d], NOTE), checks


def _without_torque(bench: Bench, plan: Plan) -> tuple[Table, Check]:
    belt, rows, errors = belt_of(bench), [], []
    for ratio in IDLE_RATIOS:
        for force in plan.thin(IDLE_FORCES, 1):
            name = f"r_S/r_P {ratio:g}, {force / 1e3:g} kN"
            values = driven_at_speed({**bench.parameters, **WITH_CLEARANCE}, ratio, IDLE_SPEED, 0.0, force, held=True)
            out = bench.steady(values, f"limit without torque, {name}")
            error = None
            if out:
                theory = math.exp(belt.equilibrium(1.0 / out["ratio.geometric"]))
                error = out["thrustRatio"] / theory - 1.0
                rows.append([ratio, force, out["thrustRatio"], theory, error])
            errors.append((name, error))
    statement = "Thrust ratio without torque, at any force"
    check = within("limit-idle", statement, THEORY, errors, -IDLE_TOLERANCE, IDLE_TOLERANCE, PERCENT)
    columns = (
        Column("r_S/r_P"), Column("F_S", "kN", 0, 1e-3), Column("Thrust ratio", digits=4), Column("Theory", digits=4), share("Difference", 2),
    )  # fmt: skip
    return table("limit-idle", "Thrust ratio without torque in the limit", columns, rows, "2000 rpm."), check


def slope(bench: Bench, changed: dict[str, float], what: str) -> float | None:
    """d ln(F_P/F_S)/d ln s near s = 1 without torque."""
    found = []
    for place in SLOPE_PLACES:
        values = driven_at_speed({**bench.parameters, **changed}, 1.0 / place, IDLE_SPEED, 0.0, SLOPE_FORCE, held=True)
        out = bench.steady(values, f"slope, {what}, s {place:g}")
        if out is None:
            return None
        found.append((math.log(out["thrustRatio"]), -math.log(out["ratio.geometric"])))
    (low, s_low), (high, s_high) = found
    return (high - low) / (s_high - s_low)


def slope_of_theory(bench: Bench) -> float:
    """The same of the theory."""
    low, high = (belt_of(bench).equilibrium(place) for place in SLOPE_PLACES)
    return (high - low) / math.log(SLOPE_PLACES[1] / SLOPE_PLACES[0])


def _slope(bench: Bench) -> Check:
    expected = slope_of_theory(bench)
    found = [("s 0.95 to 1.05", slope(bench, WITH_CLEARANCE, "limit"))]
    statement = "Slope of the thrust ratio without torque over the ratio near 1, d ln(F_P/F_S)/d ln s"
    goal = f"{expected:.3f} ± {SLOPE_TOLERANCE:g}"
    return within("limit-slope", statement, THEORY, found, expected - SLOPE_TOLERANCE, expected + SLOPE_TOLERANCE, PLAIN, goal)


def shift_gain(
    bench: Bench, s: float, changed: dict[str, float], what: str, load: float = 0.0, step: float = SHIFT_STEP
) -> tuple[float, float] | None:
    """ds/dt per unit of ln F_P after a small step under a share of the torque of full slip, 1/s: of the FMU, and of the theory at the
    FMU's tilt."""
    torque = load * bench.capacity(1.0 / s, SHIFT_FORCE, changed)
    start = driven_at_speed({**bench.parameters, **changed}, 1.0 / s, SHIFT_SPEED, -torque / s, SHIFT_FORCE)
    found = bench.shift(start, step, f"{what}, shift at s {s:g}, r {load:g}")
    if not found:
        return None
    primary, secondary = found.tilts
    beta, mu = bench.given("geometry.wedgeAngle"), bench.given("friction.pulley")
    # a Delta = psi/tan beta.
    amplitude = primary / math.tan(beta)
    return found.gain, SHIFT_SPEED * amplitude * belt_of(bench).gain(s, primary / secondary, 2.0 * mu * load / math.cos(beta))


def loaded_gains(bench: Bench, plan: Plan, changed: dict[str, float], what: str) -> list[tuple[str, float | None]]:
    """Relative differences of the gain under torque, the mean up and down, to the theory's."""
    rows: list[tuple[str, float | None]] = []
    for s in plan.thin(LOADED_PLACES, 1):
        for load in plan.thin(LOADS, 1):
            both = [shift_gain(bench, s, changed, what, load, step) for step in (LOADED_STEP, -LOADED_STEP)]
            shares = [gains[0] / gains[1] for gains in both if gains]
            rows.append((f"s {s:g}, r {load:g}", 0.5 * sum(shares) - 1.0 if len(shares) == len(both) else None))
    return rows


def _shifts(bench: Bench, plan: Plan) -> tuple[Table, Check]:
    rows, errors = [], []
    for s in plan.thin(SHIFT_PLACES, 1):
        gains = shift_gain(bench, s, {**WITH_CLEARANCE, **QUICK}, "limit")
        rows += [[s, *gains, gains[0] / gains[1] - 1.0]] if gains else []
        errors.append((f"s {s:g}", rows[-1][-1] if gains else None))
    statement = "Speed of ratio change without load per unit of ln F_P, with a light driven shaft and hardly damped sheaves"
    check = within("limit-gain", statement, THEORY, errors, -GAIN_TOLERANCE, GAIN_TOLERANCE, PERCENT)
    columns = (Column("s = r_P/r_S", digits=1), Column("FMU", "1/s"), Column("Theory", "1/s"), share("Difference"))
    note = f"{SHIFT_FORCE / 1e3:g} kN, 1000 rpm, step of ln F_P by {SHIFT_STEP:g}; the theory at the tilt of both pulleys before it."
    return table("limit-shifts", "Speed of ratio change in the limit", columns, rows, note), check
