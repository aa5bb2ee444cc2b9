"""The default belt beside the belt of single elements, whose results are stored (`elements/results/loads.csv`)."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

from pushbelt.fmu.enumerations import RingModel
from pushbelt.fmu.steady import driven_at_speed

from ..bench import Bench, Outputs, Plan
from ..measured import Source
from ..outcome import PERCENT, Column, Part, Section, Unit, reported, share, table, within

STORED = Path(__file__).parents[3] / "elements" / "results" / "loads.csv"
SPEED, FORCE = 209.0, 15e3
"""Primary speed, rad/s, and closing force of the secondary pulley, N, of all cases."""
RATIOS = {"low": 2.25, "medium": 1.0, "od": 0.444}
WITHOUT = {"friction.layers": 0.0, "belt.elementInertia": 0.0}
"""Losses that the single elements don't have."""
RATIO_ERROR, TRIALS = 1e-4, 6
THRUST, SLIP, ARC, LOSS = 0.02, 0.15, 0.12, 0.02
PUSHES, PUSH_OUTPUT = "pushForceMax", "pushForce.max"
RADIANS = Unit("rad", 2)
SOURCE = Source("464 push elements and a ring, each contact a contact: `cargo fmu elements`", "computed by a model without a continuum")


def run(bench: Bench, plan: Plan) -> Section:
    """Solves the cases with both rings and evaluates the checks."""
    with STORED.open(encoding="utf-8") as file:
        stored = [(str(line.pop("case")), {key: float(value) for key, value in line.items()}) for line in csv.DictReader(file)]
    stored = plan.thin(stored, 2)
    found = {ring.name: [(case, elements, _solve(bench, case, ring)) for case, elements in stored] for ring in reversed(RingModel)}
    rows = [[f"{name}, {case}", *_row(elements, out)] for name, of in found.items() for case, elements, out in of if out]
    columns = (
        Column("Case"), Column("Thrust ratio, elements"), Column("FMU"), share("Slip, elements", 3, signed=False), share("FMU", 3, signed=False),
        Column("Idle arc P, elements", "rad", 2), Column("FMU", "rad", 2), Column("S, elements", "rad", 2), Column("FMU", "rad", 2),
        Column("Push force, elements", "N", 0), Column("FMU", "N", 0), share("Loss, elements", 2, signed=False), share("FMU", 2, signed=False),
    )  # fmt: skip
    return Section(
        "elements",
        Part.ELEMENTS,
        "Single elements",
        "Nine load cases of the default belt beside a model in which each element is a body and each contact a contact. It shares parameters and the law of "
        "a flank's friction with the FMU, and neither cells, mesh nor solver. Both are without friction between layers and without elements that start to turn.",
        tuple(_checks(found)),
        (table("elements", "Cases", columns, rows, "Shares are those of the torque of full slip. 15 kN, 209 rad/s."),),
    )


def _solve(bench: Bench, case: str, ring: RingModel) -> Outputs | None:
    """The steady state of a case, whose ratio is that of the mean radii."""
    name, load = case.split("-")
    wanted = ratio = RATIOS[name]
    torque = float(load) * bench.capacity(wanted, FORCE) * wanted
    out = None
    for _ in range(TRIALS):
        values = driven_at_speed({**bench.parameters, **WITHOUT}, ratio, SPEED, -torque, FORCE, held=True)
        out = bench.steady({**values, "ring.model": ring}, f"single elements, {case}")
        excess = out["ratio.geometric"] / wanted if out else 1.0
        if abs(excess - 1.0) < RATIO_ERROR:
            break
        ratio /= excess
    return out


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

    return [
        within("elements-thrust", "Thrust ratio", SOURCE, errors("ALE", "thrustRatio", loaded=False), -THRUST, THRUST, PERCENT),
        within("elements-slip", "Slip under torque", SOURCE, errors("ALE", "slip"), -SLIP, SLIP, PERCENT),
        within("elements-arcs", "Idle arcs; at ratio 1 without torque there are none", SOURCE, arcs, -ARC, ARC, RADIANS),
        within("elements-loss", "Loss of the belt under torque", SOURCE, losses, -LOSS, LOSS, PERCENT),
        reported("elements-push", "Largest push force", SOURCE, "the same", spread("ALE", PUSH_OUTPUT, PUSHES)),
        reported("elements-guided", "Thrust ratio of ALE0", SOURCE, "the same", spread("ALE0", "thrustRatio")),
    ]
