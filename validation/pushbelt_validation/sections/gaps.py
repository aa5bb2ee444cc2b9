"""End play: where the gaps between elements close on the primary pulley, and the slip that play costs."""

from __future__ import annotations

import math

from pushbelt.fmu.steady import driven_by_torque

from ..bench import Bench, Outputs, Plan, rad
from ..measured import data, source
from ..outcome import NOTHING, POINTS, Check, Column, Part, Section, Table, Unit, reported, share, table, within

SPEED = rad(2000.0)
ARC_RATIO, ARC_FORCE = 1.0, 15e3
WRAP = math.pi
"""Wrap of both pulleys at ratio 1."""
LOADS = (0.4, 0.6, 0.8)
"""Torques as shares of that of full slip."""
SLIP_RATIO, SLIP_FORCE, SLIP_LOAD = 2.25, 12e3, 0.5
PLAYS = (0.2e-3, 0.4e-3)
OF_WRAP = Unit("of the wrap", 2)
ARC = Column("Idle arc", "°", 0, 180.0 / math.pi)


def run(bench: Bench, _plan: Plan) -> Section:
    """Solves the points and evaluates the checks."""
    arcs, arc_checks = _arcs(bench)
    slips, slip_check = _slips(bench)
    return Section(
        "gaps",
        Part.MEASUREMENTS,
        "Play and gaps",
        "The elements leave gaps where nothing presses them together. On a driving pulley they ride without slip along the idle arc. "
        "Then the gaps are closed and the push force builds up along the active arc.",
        (*arc_checks, slip_check),
        (arcs, slips),
    )


def _solve(bench: Bench, ratio: float, force: float, load: float, play: float | None = None) -> Outputs | None:
    """The steady state at a share of the torque of full slip."""
    parameters = bench.parameters if play is None else {**bench.parameters, "belt.play": play}
    values = driven_by_torque(parameters, ratio, SPEED, load * bench.capacity(ratio, force), force)
    what = f"ratio {ratio:g}, {force / 1e3:g} kN, torque ratio {load:g}"
    return bench.steady(values, what if play is None else f"{what}, play {1e3 * play:g} mm")


def _arcs(bench: Bench) -> tuple[Table, list[Check]]:
    """The idle arc of the primary pulley over torque."""
    solved = [(load, _solve(bench, ARC_RATIO, ARC_FORCE, load)) for load in LOADS]
    found = [(load, out["primary.idleArc"] / WRAP if out else math.nan) for load, out in solved]
    shown = [f"{OF_WRAP.show(value)} at {load:g}" for load, value in found if not math.isnan(value)]
    where = source("idleArc")
    steps = [
        (f"torque ratio {before:g} to {after:g}", there - here)
        for (before, here), (after, there) in zip(found, found[1:], strict=False)
    ]
    checks = [
        reported(
            "idle-arc", "Idle arc as a share of the wrap of the primary pulley, over the torque ratio; ratio 1, 15 kN",
            where, "half of the wrap at half the torque of full slip", ", ".join(shown) or NOTHING,
        ),
        within(
            "idle-arc-shrinks", "The idle arc of the primary pulley shrinks towards the entry as the torque grows",
            where, steps, None, 0.0, OF_WRAP, "does not grow", tolerance=0.1,
        ),
    ]  # fmt: skip
    columns = (
        Column("Torque ratio", digits=1), ARC, share("Idle arc / wrap", 0, signed=False), share("Slip", 2, signed=False), Column("Thrust ratio"),
    )  # fmt: skip
    rows = [
        [load, out["primary.idleArc"], value, out["slip"], out["thrustRatio"]]
        for (load, out), (_, value) in zip(solved, found, strict=True)
        if out
    ]
    note = f"Ratio {ARC_RATIO:g}, {ARC_FORCE / 1e3:g} kN on the secondary pulley, 2000 rpm."
    return table("idle-arc", "Idle arc of the primary pulley", columns, rows, note), checks


def _slips(bench: Bench) -> tuple[Table, Check]:
    """The slip that more play adds in underdrive."""
    solved = [(play, _solve(bench, SLIP_RATIO, SLIP_FORCE, SLIP_LOAD, play)) for play in PLAYS]
    less, more = (out["slip"] if out else math.nan for _, out in solved)
    low, high = data()["playSlip"]["slipGain"]
    check = reported(
        "play-slip",
        f"Slip that play of {1e3 * PLAYS[1]:g} instead of {1e3 * PLAYS[0]:g} mm adds, ratio {SLIP_RATIO:g}, "
        f"{SLIP_FORCE / 1e3:g} kN, half of the torque of full slip",
        source("playSlip"), f"{POINTS.text(low, high)} by a law that has all play on the arc",
        NOTHING if math.isnan(more - less) else POINTS.text(more - less),
    )  # fmt: skip
    columns = (Column("Play", "mm", 1, 1e3), share("Slip", 2, signed=False), ARC, Column("Thrust ratio"))
    rows = [[play, out["slip"], out["primary.idleArc"], out["thrustRatio"]] for play, out in solved if out]
    note = f"Ratio {SLIP_RATIO:g}, {SLIP_FORCE / 1e3:g} kN, torque ratio {SLIP_LOAD:g}, 2000 rpm."
    return table("play-slip", "Slip over play", columns, rows, note), check
