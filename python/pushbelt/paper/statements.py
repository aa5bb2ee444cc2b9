"""What the paper says, in other words, one thing at a time, and what was found.

Each statement names the section, figure or equation it comes from. A verdict follows from the figures of the run, and so does
the reason: where the same words would not hold for another outcome, there are words for it too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from . import profiles
from .results import PaperResults
from .rings import Rings

OVERDRIVE, MEDIUM, UNDERDRIVE = "overdrive", "medium", "underdrive"
TURNING = "ALE, overlay along t and n"
THIN = "\N{NARROW NO-BREAK SPACE}"


class Verdict(Enum):
    """Whether a statement was reproduced."""

    YES = "reproduced"
    PARTLY = "in part"
    NO = "not reproduced"
    OPEN = "not run"


@dataclass(frozen=True)
class Statement:
    """Something the paper says."""

    source: str
    claim: str
    verdict: Verdict
    found: str
    reason: str


def signed(value: float, digits: int = 1) -> str:
    """A share as per cent with its sign."""
    return f"{100.0 * value:+.{digits}f}{THIN}%".replace("-", "\N{MINUS SIGN}")


def _span(values: Iterable[float], digits: int = 1) -> str:
    values = list(values)
    return f"{signed(min(values), digits)} to {signed(max(values), digits)}"


def _plain(value: float, form: str) -> str:
    return f"{value:{form}}".replace("-", "\N{MINUS SIGN}")


def _short(model: str) -> str:
    return {TURNING: "ALE [t, n]"}.get(model, model.replace("evenly spaced mesh", "even mesh"))


def _centre(rings: Rings, model: str) -> float:
    """How far the centre of mass of a ring of fig. 7 gets along x, m."""
    centres = [outline[:-1, 0].mean() for outline in rings.shapes["7", model].values()]
    return max(centres, key=lambda x: abs(x - centres[0])) - centres[0]


def _judge(yes: bool, partly: bool = False) -> Verdict:
    return Verdict.YES if yes else Verdict.PARTLY if partly else Verdict.NO


def rings(results: PaperResults) -> list[Statement]:
    """Statements of 5.3, on rings alone, and of 3.1."""
    found = results.rings
    motion = found.motions["6", "ALE0"]
    low, high, drift = motion.theta.min(), motion.theta.max(), np.abs(motion.drift).max()
    fig7 = {model: motion for (figure, model), motion in found.motions.items() if figure == "7"}
    ale = fig7["ALE"]
    locked, free = (
        found.check(f"smallest/largest eigenvalue of M, {what}", "ALE, 8 elements").value
        for what in ("node 0 locked", "nothing locked")
    )
    small = [f for f in found.frequencies if f.case == "circle, small" and f.elements == 40]
    large = {f.model: f for f in found.frequencies if f.case != "circle, small"}
    effort = {model: found.effort("deformable ring, 0.3 ms", model) for model in ("ALE", TURNING)}
    slower = effort[TURNING].median / effort["ALE"].median - 1.0

    def crossings(model: str) -> int:
        return int(np.count_nonzero(np.diff(np.sign(fig7[model].ovality))))

    turned = crossings("ALE") >= 2
    return [
        Statement(
            "5.3, fig. 6",
            "The reference motion alone, started in overdrive, swings about ratio 1",
            _judge(abs(low + 0.4) < 0.02 and abs(high - 0.4) < 0.02),
            f"Θ from {_plain(low, '+.3f')} to {_plain(high, '+.3f')}",
            "Bending energy is smallest where both radii are equal; nothing takes energy away.",
        ),
        Statement(
            "5.3",
            "The drift stays zero to rounding",
            _judge(drift < 1e-9),
            f"|s| ≤ {_plain(drift, '.0e')} m",
            "M_sΘ vanishes by symmetry.",
        ),
        Statement(
            "5.3",
            "Drift and ratio repeat motions of the overlay: M is singular until a node is locked",
            _judge(free < 1e-3 * locked, free < locked),
            "smallest over largest eigenvalue of M, each unknown scaled to unit mass: "
            f"{_plain(free, '.0e')} free, {_plain(locked, '.0e')} locked",
            "Eight cubic elements repeat the two motions nearly, not exactly: arcs are no cubics.",
        ),
        Statement(
            "5.3, fig. 7",
            "Released from the belt's shape, the strands bulge outwards first",
            _judge(all(motion.bulge[4] > 2e-3 for motion in fig7.values())),
            "at 0.2 ms by " + ", ".join(f"{1e3 * m.bulge[4]:.1f} mm ({_short(name)})" for name, m in fig7.items()),
            "The straight strands bend to relieve the arcs.",
        ),
        Statement(
            "5.3, fig. 7",
            "Then the node that is locked to the reference curve drags the ratio along, and the ring takes an overdrive shape that "
            "no free ring has",
            _judge(ale.theta.max() > 0.6),
            f"Θ rises from 0.4 to {ale.theta.max():.2f} at {1e3 * ale.time[int(ale.theta.argmax())]:.2f} ms; until "
            f"{1e3 * ale.time[-1]:.0f} ms the centre of mass gets off by {1e3 * abs(_centre(found, 'ALE')):.0f} mm (RCM: "
            f"{1e3 * abs(_centre(found, 'RCM')):.1f} mm)",
            "The left end has to go inwards, and only Θ can take it there. The lock bears a force, because the bending measure (23) "
            "counts from the curve and resists a change of Θ alone: no energy is lost, but momentum goes into the lock. With Θ held "
            "instead of the node the centre of mass rests to rounding (tests/ring/ale.rs). RCM and ANCF have no such lock.",
        ),
        Statement(
            "5.3, fig. 7",
            "After that it becomes an oval",
            _judge(turned),
            f"ovality of ALE changes its sign {crossings('ALE')} times in {1e3 * ale.time[-1]:.1f} ms, of RCM {crossings('RCM')}"
            + ("" if turned else f"; the run ends with Θ = {ale.theta[-1]:.2f}"),
            "Not the same oval as RCM's: the ring is far from its reference by then."
            if turned
            else "A circle's left end lies where S would have next to no radius: Θ runs towards 1, where the two-pulley curve ends.",
        ),
        Statement(
            "5.3",
            "Small deflections from the reference are right in quantity",
            _judge(all(abs(f.error) < 5e-3 for f in small)),
            "first frequency of a free band, 40 elements: "
            + ", ".join(f"{_short(f.model)} {signed(f.error, 2)}" for f in small),
            "On a circular reference curve, against the thin ring's 9.534 Hz.",
        ),
        Statement(
            "5.3, 5.4",
            "Far from the reference they are not",
            _judge(abs(large["ALE"].error) > 0.02 and abs(large["RCM"].error) < 0.01),
            "large oscillation, against 9.23 Hz: "
            + ", ".join(f"{_short(m)} {f.frequency:.2f}" for m, f in large.items())
            + " Hz",
            "The bending measure (23) is linear in the deflection.",
        ),
        Statement(
            "3.1, 5.4",
            "A_i = identity computes faster than A_i = [t, n]",
            _judge(slower > 0.05, slower > 0.0),
            f"[t, n] takes {signed(slower, 0)} of processor time, {effort[TURNING].factorizations} Jacobians against "
            f"{effort['ALE'].factorizations}",
            "Fewer derivatives with A_i = identity; nodes that turn with Θ couple to it more strongly.",
        ),
    ]


def variator(results: PaperResults) -> list[Statement]:
    """Statements of 5.4, on the variator."""
    tell: list[Callable[[PaperResults], Statement]] = [
        _speed,
        _ratio_order,
        _same_level,
        _ale_agrees,
        _ale0_overdrive,
        _ancf_low,
        _ancf_losses,
        _push_force,
        _ancf_oscillates,
        _ancf_integration,
        _spiral,
        _half_the_time,
        _ale_time,
    ]
    return [statement(results) for statement in tell]


def _missing(results: PaperResults, *models: str) -> str:
    missing = [model for model in models if model not in results.models]
    return f"this unit offers no {' and no '.join(missing)}" if missing else ""


def _needs(source: str, claim: str, missing: str) -> Statement:
    return Statement(source, claim, Verdict.OPEN, "–", missing)


def _speed(results: PaperResults) -> Statement:
    claim = "Belt speed has little influence"
    if not results.speeds:
        return _needs("5.4", claim, "left out of a short run")
    spans = {}
    for case, points in results.speeds.items():
        ratios = [point.thrust_ratio for point in points]
        spans[case] = max(ratios) / min(ratios) - 1.0
    speeds = sorted({round(point.speed * 30.0 / np.pi) for points in results.speeds.values() for point in points})
    return Statement(
        "5.4",
        claim,
        _judge(max(spans.values()) < 0.05, float(np.median(list(spans.values()))) < 0.05),
        f"thrust ratio (ALE) at {', '.join(map(str, speeds))} rpm differs by "
        + ", ".join(f"{100 * span:.1f}{THIN}% ({case})" for case, span in spans.items()),
        "Sliding scales with speed, Coulomb friction does not. Centrifugal force does: at the highest speed it takes "
        + ", ".join(f"{force:.0f} N ({case})" for case, force in _centrifugal(results).items())
        + " of the strand's force, most where the belt is fast and clamped least.",
    )


def _centrifugal(results: PaperResults) -> dict[str, float]:
    """σV² at the highest speed, N, by load case."""
    density = results.parameters["belt.massPerLength"] + results.parameters["ring.massPerLength"]
    forces = {}
    for name, points in results.speeds.items():
        run = next(run for run in results.of("ALE") if run.case.name == name)
        faster = max(point.speed for point in points) / run.window.mean("primary.speed")
        forces[name] = density * (faster * run.window.mean("belt.speed")) ** 2
    return forces


def _ratio_order(results: PaperResults) -> Statement:
    ordered = True
    means = {}
    for model in results.models:
        by_ratio: dict[str, list[float]] = {}
        for run in results.of(model):
            by_ratio.setdefault(run.case.ratio_name, []).append(run.window.thrust_ratio)
        means[model] = {name: float(np.mean(values)) for name, values in by_ratio.items()}
        levels = [means[model][name] for name in (UNDERDRIVE, MEDIUM, OVERDRIVE) if name in means[model]]
        ordered &= all(np.diff(levels) > 0.0)
    return Statement(
        "5.4, fig. 8a",
        "Thrust ratio rises from underdrive over medium to overdrive",
        _judge(ordered),
        "; ".join(
            f"{model} "
            + " < ".join(f"{means[model][n]:.2f}" for n in (UNDERDRIVE, MEDIUM, OVERDRIVE) if n in means[model])
            for model in results.models
        ),
        "The longer arc carries more of the axial force at the same belt force.",
    )


def _same_level(results: PaperResults) -> Statement:
    others = [model for model in results.models if model != results.reference]
    thrust = {m: [results.thrust_difference(c, m) for c in results.cases] for m in others}
    efficiency = {m: [results.efficiency_difference(c, m) for c in results.cases] for m in others}
    worst = max(abs(value) for values in thrust.values() for value in values)
    points = max(abs(value) for values in efficiency.values() for value in values)
    return Statement(
        "5.4, fig. 8a, 8b",
        "All models come to the same level of thrust ratio and efficiency",
        _judge(worst < 0.1 and points < 0.02, worst < 0.3 and points < 0.06),
        f"against {results.reference}, thrust ratio: "
        + ", ".join(f"{m} {_span(v)}" for m, v in thrust.items())
        + "; efficiency, points: "
        + ", ".join(
            f"{m} {_plain(100 * min(v), '+.1f')} to {_plain(100 * max(v), '+.1f')}" for m, v in efficiency.items()
        ),
        "The models share chain, contact and friction; they differ in the radius at which the ring lets elements run.",
    )


def _ale_agrees(results: PaperResults) -> Statement:
    claim = "ALE correlates well with RCM"
    if missing := _missing(results, "RCM"):
        return _needs("5.4", claim, missing)
    thrust = [results.thrust_difference(case, "ALE") for case in results.cases]
    points = [results.efficiency_difference(case, "ALE") for case in results.cases]
    return Statement(
        "5.4",
        claim,
        _judge(max(map(abs, thrust)) < 0.05 and max(map(abs, points)) < 0.01, max(map(abs, thrust)) < 0.1),
        f"thrust ratio {_span(thrust)}, efficiency {_plain(100 * min(points), '+.2f')} to "
        f"{_plain(100 * max(points), '+.2f')} points",
        "ALE's mesh is fine at the arc borders and stays there; RCM's 32 even elements travel through them, 22 mm long where the small arc is "
        "75 mm. In overdrive that costs RCM thrust; with more elements (ring.elements) it comes up to ALE, as docs/paper.md shows.",
    )


def _ale0_overdrive(results: PaperResults) -> Statement:
    claim = "ALE0's thrust ratio is far too high in overdrive"
    if missing := _missing(results, "ALE0"):
        return _needs("5.4, fig. 8a", claim, missing)
    by_ratio: dict[str, list[float]] = {}
    for case in results.cases:
        by_ratio.setdefault(case.ratio_name, []).append(results.thrust_difference(case, "ALE0"))
    if OVERDRIVE not in by_ratio:
        return _needs("5.4, fig. 8a", claim, "no overdrive case in a short run")
    overdrive = by_ratio[OVERDRIVE]
    rigid = [thrust["ALE0"] / thrust["ALE"] - 1.0 for thrust in results.rigid.values()]
    return Statement(
        "5.4, fig. 8a",
        claim,
        _judge(min(overdrive) > 0.1, min(overdrive) > 0.0),
        f"against {results.reference}: " + "; ".join(f"{name} {_span(values)}" for name, values in by_ratio.items()),
        "Without spiral running no flank is wedged in or drawn out, so friction acts along the arc only. How that moves the thrust "
        "ratio is a matter of the sheaves: with those of this variator (7e5 N·m/rad) it lowers it"
        + (f", with rigid ones ALE0 differs from ALE by {_span(rigid)} (overdrive)." if rigid else ".")
        + " The paper's sheaves are not given.",
    )


def _ancf_low(results: PaperResults) -> Statement:
    claim = "ANCF's thrust ratio is too low in medium and underdrive"
    if missing := _missing(results, "ANCF"):
        return _needs("5.4, fig. 8a", claim, missing)
    values = [results.thrust_difference(c, "ANCF") for c in results.cases if c.ratio_name in (MEDIUM, UNDERDRIVE)]
    if not values:
        return _needs("5.4, fig. 8a", claim, "no case in medium or underdrive")
    return Statement(
        "5.4, fig. 8a",
        claim,
        _judge(max(values) < -0.03, min(values) < -0.03),
        f"against {results.reference}: {_span(values)}",
        "Its membrane locks on curved elements, so the ring yields less and elements run in and out less freely.",
    )


def _ancf_losses(results: PaperResults) -> Statement:
    claim = "ANCF loses more than the others"
    if missing := _missing(results, "ANCF"):
        return _needs("5.4, fig. 8b", claim, missing)
    extra = []
    for case in results.cases:
        others = [results.run(case, m).window.loss for m in results.models if m not in ("ANCF", "ALE0")]
        extra.append(results.run(case, "ANCF").window.loss / max(others) - 1.0)
    return Statement(
        "5.4, fig. 8b",
        claim,
        _judge(min(extra) > 0.0, max(extra) > 0.0),
        f"losses against the larger of RCM's and ALE's: {_span(extra, 0)}",
        "Losses are summed from each friction law, so oscillation counts in them where it rubs.",
    )


def _push_force(results: PaperResults) -> Statement:
    shapes = {
        model: [profiles.push_force_gains(results.parameters, run) for run in results.of(model)]
        for model in results.models
    }
    holds = all(p > 0.0 > s and abs(strand) < 0.1 * p for gains in shapes.values() for p, strand, s in gains)
    return Statement(
        "5.4, fig. 8c",
        "Push force on an element builds up in the primary arc, holds in the push strand, and goes in the secondary arc",
        _judge(holds, all(p > 0.0 > s for gains in shapes.values() for p, _, s in gains)),
        "; ".join(
            f"{model} " + ", ".join(_plain(float(np.mean([g[k] for g in gains])), "+.0f") for k in range(3)) + " N"
            for model, gains in shapes.items()
        )
        + " (means over the cases)",
        "Elements can only push; what the ring does not carry, they do.",
    )


def _ancf_oscillates(results: PaperResults) -> Statement:
    claim = "ANCF is so stiff that the whole system oscillates"
    if missing := _missing(results, "ANCF", "RCM"):
        return _needs("5.4, fig. 8c", claim, missing)
    ripple = {
        model: float(np.median([profiles.strand_ripple(results.parameters, run) for run in results.of(model)]))
        for model in results.models
    }
    verdict = _judge(ripple["ANCF"] > 3.0 * ripple["RCM"], ripple["ANCF"] > 1.5 * ripple["RCM"])
    return Statement(
        "5.4, fig. 8c",
        claim,
        verdict,
        "standard deviation of the push force in the push strand (median of the cases): "
        + ", ".join(f"{model} {100 * value:.2g}{THIN}%" for model, value in ripple.items()),
        "Where an element lies across an arc border its curvature jumps, which a cubic cannot follow without stretching: every passage "
        "is a blow. RCM has one strain an element and bends freely; the meshes of ALE and ALE0 stand still."
        if verdict is not Verdict.NO
        else "Every element that passes an arc border is a blow, to RCM's ring as much as to ANCF's; the meshes of ALE and ALE0 stand "
        "still.",
    )


def _ancf_integration(results: PaperResults) -> Statement:
    claim = "Oscillations about zero spoil ANCF's efficiency values"
    if missing := _missing(results, "ANCF", "RCM"):
        return _needs("5.4", claim, missing)
    gap = {
        model: max(abs(r.window.efficiency - r.window.efficiency_from_losses) for r in results.of(model))
        for model in results.models
    }
    verdict = _judge(gap["ANCF"] > 2.0 * gap["RCM"] and gap["ANCF"] > 2e-3, gap["ANCF"] > 2e-3)
    return Statement(
        "5.4",
        claim,
        verdict,
        "efficiency from sampled powers less that from sampled losses, at most: "
        + ", ".join(f"{model} {100 * value:.2f} points" for model, value in gap.items()),
        "Each passage of an element swings powers and losses, so a mean of samples depends on where they fall."
        if verdict is not Verdict.NO
        else "Losses and powers come from one virtual-power statement at the same implicit steps: they balance, whatever oscillates.",
    )


def _spiral(results: PaperResults) -> Statement:
    claim = "ALE0 lacks spiral running, the others have it"
    spiral = {
        model: [r.window.mean(f"spiral.{p}") for r in results.of(model) for p in ("primary", "secondary")]
        for model in results.models
    }
    others = [value for model, values in spiral.items() if model != "ALE0" for value in values]
    if missing := _missing(results, "ALE0"):
        return _needs("5.4, fig. 8d", claim, missing)
    return Statement(
        "5.4, fig. 8d",
        claim,
        _judge(max(spiral["ALE0"]) < 0.1 * min(others)),
        "spread of the radius within an arc: "
        + ", ".join(f"{m} {1e3 * min(v):.2f} to {1e3 * max(v):.2f} mm" for m, v in spiral.items()),
        "Only a deflection lets an element leave the circle of the reference curve. In ALE0 the flanks' penetration changes instead.",
    )


def _half_the_time(results: PaperResults) -> Statement:
    claim = "ANCF and ALE0 need less computing time than RCM (the paper: about half)"
    if missing := _missing(results, "RCM", "ANCF", "ALE0"):
        return _needs("5.4, fig. 9", claim, missing)
    ratio = {m: float(np.median([results.time_ratio(c, m) for c in results.cases])) for m in ("ANCF", "ALE0")}
    return Statement(
        "5.4, fig. 9",
        claim,
        _judge(max(ratio.values()) < 0.65, min(ratio.values()) < 0.65),
        ", ".join(f"{m} {value:.2g} of RCM" for m, value in ratio.items()) + " (median of the cases)",
        "ALE0 stands still in its steady state and has hardly anything to compute. ANCF travels as RCM does and meets the same "
        "arc borders, but its mass matrix is constant and its elements are cheaper.",
    )


def _ale_time(results: PaperResults) -> Statement:
    claim = "ALE needs less computing time than RCM (the paper: about 80 %)"
    if missing := _missing(results, "RCM"):
        return _needs("5.4, fig. 9", claim, missing)
    ratios = [results.time_ratio(case, "ALE") for case in results.cases]
    wavy = [value for case in results.cases if (value := results.wavy_time_ratio(case, "ALE")) is not None]
    swinging = f"; with a load that swings {min(wavy):.2g} to {max(wavy):.2g}" if wavy else ""
    return Statement(
        "5.4, fig. 9",
        claim,
        _judge(max(ratios) < 0.8, min(ratios) < 0.8),
        f"{min(ratios):.2g} to {max(ratios):.2g} of RCM{swinging}",
        "The mesh stands still where the belt runs through: constant loads leave nothing that changes, so the implicit steps are "
        "as long as the communication steps and need no new Jacobian. With explicit or short steps, as the paper's, that "
        "advantage cannot show.",
    )


def evaluate(results: PaperResults) -> list[Statement]:
    """All statements in the paper's order."""
    return rings(results) + variator(results)
