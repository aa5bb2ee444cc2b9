"""Sensitivity of results to single parameters about the default parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from pushbelt.fmu.starts import driven_at_speed, driven_by_torque

from ..bench import Bench, Plan
from ..measured import OWN
from ..outcome import PERCENT, Check, Column, Curve, Panel, Picture, Section, share, table, within

TORQUE, SPEED, SAFETY, LEAST_FORCE = 50.0, 2000.0 * math.pi / 30.0, 1.3, 6e3
STATES = {"underdrive": 7.0 / 3.0, "medium": 1.0, "overdrive": 3.0 / 7.0}
SHIFT_FORCE, SHIFT_SPEED = 20e3, 1000.0 * math.pi / 30.0
BOTH = ("primary", "secondary")

QUANTITIES = (
    "thrust, underdrive", "medium", "overdrive", "slip, underdrive", "medium", "overdrive",
    "loss, underdrive", "medium", "overdrive", "shift gain",
)  # fmt: skip


@dataclass(frozen=True)
class Change:
    """A change of parameters."""

    name: str
    values: Mapping[str, float]


def changes(bench: Bench) -> list[Change]:
    """Changes in pairs: decrease and increase."""

    def pair(label: str, *names: str, factors: tuple[float, float] = (0.5, 2.0)) -> list[Change]:
        return [
            Change(f"{label} × {factor:g}", {name: factor * bench.given(name) for name in names}) for factor in factors
        ]

    def step(label: str, name: str, by: float) -> list[Change]:
        return [
            Change(f"{label} {text} {by:g}", {name: bench.given(name) + sign * by})
            for text, sign in (("−", -1.0), ("+", 1.0))
        ]

    def on(name: str) -> tuple[str, ...]:
        return tuple(f"{pulley}.{name}" for pulley in BOTH)

    meshes = ("mesh.primaryArc", "mesh.secondaryArc", "mesh.strand")
    off = (0.0, 2.0)
    return [
        *step("friction of the sheaves μ", "friction.pulley", 0.01),
        *pair("friction of the ring", "friction.ring", factors=off),
        *pair("friction between layers", "friction.layers", factors=off),
        *pair("inertia of the elements' turning", "belt.elementInertia", factors=off),
        *pair("fall of the friction", "friction.fall", factors=off),
        *pair("speed of that fall", "friction.fallSpeed"),
        *pair("friction velocity v_0", "friction.velocity"),
        *pair("friction velocity of the ring", "friction.ringVelocity"),
        *pair("play", "belt.play", factors=off),
        *pair("roughness of the elements", "belt.roughness"),
        *pair("thickness of the oil between the elements", "belt.filmThickness"),
        *pair("its damping", "belt.filmDamping", factors=off),
        *pair("its suction", "belt.suction"),
        *pair("oil squeezed out of closing gaps", "belt.squeezeDamping", factors=off),
        *pair("push stiffness", "belt.pushStiffness"),
        *pair("contact stiffness", "contact.stiffness"),
        *pair("roughness of the flanks", "contact.roughness"),
        *pair("tilt stiffness", *on("tiltStiffness")),
        *pair("tilt clearance", *on("tiltClearance")),
        *pair("drag of the seals", *on("drag.constant"), factors=off),
        *pair("drag of the oil", *on("drag.viscous"), factors=off),
        *pair("friction of the bearings", *on("bearing.friction"), factors=off),
        *pair("sheave damping", *on("sheaveDamping")),
        *[
            Change(f"mesh × {factor:g}", {name: round(factor * bench.given(name)) for name in meshes})
            for factor in (0.5, 2.0)
        ],
    ]


def count(plan: Plan) -> int:
    """Approximate number of points."""
    return 20 if plan.short else 4 * 43


def run(bench: Bench, plan: Plan) -> Section:
    """Solves the points and evaluates the checks."""
    base = _quantities(bench, {}, "nothing changed")
    chosen = changes(bench)
    if plan.short:
        chosen = [
            c for c in chosen if c.name.startswith(("roughness of the elements", "contact stiffness", "mesh × 2"))
        ]
    found = {change.name: _quantities(bench, change.values, change.name) for change in chosen}
    relative = {
        name: [a / b - 1.0 if a is not None and b else None for a, b in zip(values, base, strict=True)]
        for name, values in found.items()
    }
    columns = (Column("Changed"), *(share(name) for name in QUANTITIES))
    shown = (
        Column("Nothing changed"),
        *(Column(name, digits=4) for name in QUANTITIES[:3]),
        *(share(name, 2, signed=False) for name in QUANTITIES[3:6]),
        *(Column(name, "W", 0) for name in QUANTITIES[6:9]),
        Column(QUANTITIES[9], "1/s"),
    )
    note = (
        "Relative changes. 50 N·m, 2000 rpm, safety 1.3 of the unchanged variator, at least 6 kN; r_S/r_P 7/3, 1, "
        "3/7. Shift gain: ratio 1, "
        "20 kN, 1000 rpm. A dash: the belt does not carry the torque."
    )
    return Section(
        "sensitivity",
        "Sensitivity to parameters",
        "One parameter at a time, about the default parameters. Where an uncertain parameter has a large effect, "
        "calibrate it.",
        _checks(relative),
        (
            table("base", "The states that are changed", shown, [["", *base]]),
            table(
                "sensitivity", "Relative changes", columns, [[name, *values] for name, values in relative.items()], note
            ),
        ),
        (_tornado(relative),),
    )


def _quantities(bench: Bench, changed: Mapping[str, float], what: str) -> list[float | None]:
    """Thrust ratios, slips and losses of the three states, and the shift gain."""
    parameters = {**bench.parameters, **changed}
    states = []
    for name, ratio in STATES.items():
        force = bench.force(ratio, TORQUE, SAFETY, LEAST_FORCE)
        values = driven_by_torque(parameters, ratio, SPEED, TORQUE, force)
        out = bench.steady(values, f"{name}, {what}")
        states.append(out if out and not out["macroSlip"] else None)
    start = driven_at_speed(parameters, 1.0, SHIFT_SPEED, 0.0, SHIFT_FORCE)
    shifted = bench.shift(start, what=f"shift, {what}")
    return [
        *(out and out[name] for name in ("thrustRatio", "slip", "loss.total") for out in states),
        shifted and shifted.gain,
    ]


def _checks(relative: Mapping[str, list[float | None]]) -> tuple[Check, ...]:
    def of(start: str, places: range | tuple[int, ...]) -> list[tuple[str, float | None]]:
        return [
            (
                f"{name}, {QUANTITIES[k].removeprefix('thrust, ')}",
                abs(value) if (value := values[k]) is not None else None,
            )
            for name, values in relative.items()
            if name.startswith(start)
            for k in places
        ]

    checks = [
        within(
            "Roughness of the elements × ½ … × 2: slip in underdrive",
            OWN,
            of("roughness of the elements", (3,)),
            None,
            0.1,
            PERCENT,
        ),
        within(
            "Contact stiffness × ½ … × 2: thrust ratios", OWN, of("contact stiffness", range(3)), None, 0.015, PERCENT
        ),
    ]
    finer = of("mesh × 2", range(3))
    if finer:
        checks.append(within("Twice the mesh: thrust ratios", OWN, finer, None, 0.005, PERCENT))
    return tuple(checks)


def _tornado(relative: Mapping[str, list[float | None]]) -> Picture:
    """Per cent by parameter: points left and right of 0."""
    panels = []
    for title, places in (
        ("Thrust ratio (%)", range(3)),
        ("Slip (%)", range(3, 6)),
        ("Losses (%)", range(6, 9)),
        ("Shift gain (%)", (9,)),
    ):
        names = list(relative)
        rows = tuple(float(-k) for k in range(len(names)))
        curves = tuple(
            Curve(
                tuple(100.0 * value if (value := relative[name][k]) is not None else math.nan for name in names),
                rows,
                QUANTITIES[k].split(", ")[-1],
                colour,
                "o",
            )
            for colour, k in enumerate(places)
        )
        panels.append(Panel(title, "change", curves, names=tuple(names)))
    return Picture(
        tuple(panels),
        "Each point is one change of one parameter, as in the table. Changes of slip beyond one half are not shown.",
    )
