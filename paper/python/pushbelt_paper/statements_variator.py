"""Statements of 5.4, on the variator."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from . import profiles
from .results import MODELS, OTHERS, REFERENCE, PaperResults
from .statement import THIN, Statement, Verdict, not_run, plain, span, verdict

OVERDRIVE, MEDIUM, UNDERDRIVE = "overdrive", "medium", "underdrive"


def _speed(results: PaperResults) -> Statement:
    claim = "Belt speed has little influence"
    if not results.speeds:
        return not_run("5.4", claim, "not part of a short run")
    spans = {}
    for case, points in results.speeds.items():
        ratios = [point.thrust_ratio for point in points]
        spans[case] = max(ratios) / min(ratios) - 1.0
    speeds = sorted({round(point.speed * 30.0 / np.pi) for points in results.speeds.values() for point in points})
    return Statement(
        "5.4",
        claim,
        verdict(max(spans.values()) < 0.05, float(np.median(list(spans.values()))) < 0.05),
        f"thrust ratio (ALE) at {', '.join(map(str, speeds))} rpm differs by "
        + ", ".join(f"{100 * span:.1f}{THIN}% ({case})" for case, span in spans.items()),
        "Sliding is proportional to speed, but Coulomb friction does not depend on it. Centrifugal force does: at the highest speed it is "
        + ", ".join(f"{force:.0f} N ({case})" for case, force in _centrifugal(results).items())
        + " of the strand's force, with the largest share at high belt speed and low clamping force.",
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
    for model in MODELS:
        by_ratio: dict[str, list[float]] = {}
        for run in results.of(model):
            by_ratio.setdefault(run.case.ratio_name, []).append(run.window.thrust_ratio)
        means[model] = {name: float(np.mean(values)) for name, values in by_ratio.items()}
        levels = [means[model][name] for name in (UNDERDRIVE, MEDIUM, OVERDRIVE) if name in means[model]]
        ordered &= all(np.diff(levels) > 0.0)
    return Statement(
        "5.4, fig. 8a",
        "Thrust ratio rises from underdrive over medium to overdrive",
        verdict(ordered),
        "; ".join(
            f"{model} "
            + " < ".join(f"{means[model][n]:.2f}" for n in (UNDERDRIVE, MEDIUM, OVERDRIVE) if n in means[model])
            for model in MODELS
        ),
        "The longer arc carries more of the axial force at the same belt force.",
    )


def _same_level(results: PaperResults) -> Statement:
    others = OTHERS
    thrust = {m: [results.thrust_difference(c, m) for c in results.cases] for m in others}
    efficiency = {m: [results.efficiency_difference(c, m) for c in results.cases] for m in others}
    worst = max(abs(value) for values in thrust.values() for value in values)
    points = max(abs(value) for values in efficiency.values() for value in values)
    return Statement(
        "5.4, fig. 8a, 8b",
        "All models give similar levels of thrust ratio and efficiency",
        verdict(worst < 0.1 and points < 0.02, worst < 0.3 and points < 0.06),
        f"against {REFERENCE}, thrust ratio: "
        + ", ".join(f"{m} {span(v)}" for m, v in thrust.items())
        + "; efficiency, points: "
        + ", ".join(
            f"{m} {plain(100 * min(v), '+.1f')} to {plain(100 * max(v), '+.1f')}" for m, v in efficiency.items()
        ),
        "The models have the same chain, contact and friction. They differ in the running radius of the elements that the ring permits.",
    )


def _ale_agrees(results: PaperResults) -> Statement:
    claim = "ALE correlates well with RCM"
    thrust = [results.thrust_difference(case, "ALE") for case in results.cases]
    points = [results.efficiency_difference(case, "ALE") for case in results.cases]
    return Statement(
        "5.4",
        claim,
        verdict(max(map(abs, thrust)) < 0.05 and max(map(abs, points)) < 0.01, max(map(abs, thrust)) < 0.1),
        f"thrust ratio {span(thrust)}, efficiency {plain(100 * min(points), '+.2f')} to "
        f"{plain(100 * max(points), '+.2f')} points",
        "ALE's mesh is fine at the arc borders and fixed; RCM's 32 even elements travel through them and are 22 mm long where the small arc is "
        "75 mm. The models therefore differ most in overdrive.",
    )


def _on_sheaves(results: PaperResults, sheaves: str, model: str) -> list[float]:
    """Thrust ratios of a model against ALE, in the steady states of overdrive."""
    states = [of[sheaves] for of in results.sheaves.values()]
    return [of[model]["thrustRatio"] / of["ALE"]["thrustRatio"] - 1.0 for of in states]


def _ale0_overdrive(results: PaperResults) -> Statement:
    claim = "ALE0's thrust ratio is too high in overdrive"
    if not results.sheaves:
        return not_run("5.4, fig. 8a", claim, "a short run has no overdrive case")
    found = {
        (model, sheaves): _on_sheaves(results, sheaves, model)
        for model in ("ALE0Centred", "ALE0")
        for sheaves in ("elastic", "rigid")
    }
    paper, rigid = found["ALE0Centred", "elastic"], found["ALE0Centred", "rigid"]
    return Statement(
        "5.4, fig. 8a",
        claim,
        verdict(min(paper) > 0.0 and max(paper) > 0.05, max(paper) > 0.0),
        f"arcs about the axes, as in the paper, against ALE: {span(paper)}, with rigid sheaves {span(rigid)}; the FMU's ALE0, whose arcs have free "
        f"centres: {span(found['ALE0', 'elastic'])}, with rigid sheaves {span(found['ALE0', 'rigid'])}",
        "Elements on circles about the axes do not move radially, so all friction acts along the arc. With free centres, tilted sheaves cause spiral "
        "running. The paper does not specify its sheaves.",
    )


def _ancf_low(results: PaperResults) -> Statement:
    claim = "ANCF's thrust ratio is too low in medium and underdrive"
    values = [results.thrust_difference(c, "ANCF") for c in results.cases if c.ratio_name in (MEDIUM, UNDERDRIVE)]
    if not values:
        return not_run("5.4, fig. 8a", claim, "the run has no case in medium or underdrive")
    return Statement(
        "5.4, fig. 8a",
        claim,
        verdict(max(values) < -0.03, min(values) < -0.03),
        f"against {REFERENCE}: {span(values)}",
        "Its curved elements show membrane locking, so the ring is stiffer and radial motion of elements is smaller.",
    )


def _ancf_losses(results: PaperResults) -> Statement:
    claim = "ANCF loses more than the others"
    extra = []
    for case in results.cases:
        others = [results.run(case, m).window.loss for m in MODELS if m not in ("ANCF", "ALE0")]
        extra.append(results.run(case, "ANCF").window.loss / max(others) - 1.0)
    return Statement(
        "5.4, fig. 8b",
        claim,
        verdict(min(extra) > 0.0, max(extra) > 0.0),
        f"losses against the larger of RCM's and ALE's: {span(extra, 0)}",
        "Losses are the sum over all friction laws, so oscillation increases them wherever surfaces slide.",
    )


def _push_force(results: PaperResults) -> Statement:
    shapes = {
        model: [profiles.push_force_gains(results.parameters, run) for run in results.of(model)] for model in MODELS
    }
    holds = all(p > 0.0 > s and abs(strand) < 0.1 * p for gains in shapes.values() for p, strand, s in gains)
    return Statement(
        "5.4, fig. 8c",
        "Push force on an element builds up in the primary arc, is constant in the push strand, and decays in the secondary arc",
        verdict(holds, all(p > 0.0 > s for gains in shapes.values() for p, _, s in gains)),
        "; ".join(
            f"{model} " + ", ".join(plain(float(np.mean([g[k] for g in gains])), "+.0f") for k in range(3)) + " N"
            for model, gains in shapes.items()
        )
        + " (means over the cases)",
        "Elements transmit only pressure, and carry the part of the load that the ring does not.",
    )


def _ancf_oscillates(results: PaperResults) -> Statement:
    claim = "ANCF is so stiff that the whole system oscillates"
    ripple = {
        model: float(np.median([profiles.strand_ripple(results.parameters, run) for run in results.of(model)]))
        for model in MODELS
    }
    outcome = verdict(ripple["ANCF"] > 3.0 * ripple["RCM"], ripple["ANCF"] > 1.5 * ripple["RCM"])
    return Statement(
        "5.4, fig. 8c",
        claim,
        outcome,
        "standard deviation of the push force in the push strand (median of the cases): "
        + ", ".join(f"{model} {100 * value:.2g}{THIN}%" for model, value in ripple.items()),
        "In an element across an arc border the curvature jumps, which a cubic cannot represent without stretching: every passage "
        "is an impact. RCM has one strain per element and bends freely; the meshes of ALE and ALE0 are fixed."
        if outcome is not Verdict.NO
        else "The passage of an element at an arc border is an impact, for RCM as well as ANCF; the meshes of ALE and ALE0 are "
        "fixed.",
    )


def _ancf_integration(results: PaperResults) -> Statement:
    claim = "Oscillations about zero impair ANCF's efficiency values"
    gap = {
        model: max(abs(r.window.efficiency - r.window.efficiency_from_losses) for r in results.of(model))
        for model in MODELS
    }
    outcome = verdict(gap["ANCF"] > 2.0 * gap["RCM"] and gap["ANCF"] > 2e-3, gap["ANCF"] > 2e-3)
    return Statement(
        "5.4",
        claim,
        outcome,
        "efficiency from sampled powers minus that from sampled losses, at most: "
        + ", ".join(f"{model} {100 * value:.2f} points" for model, value in gap.items()),
        "Each passage of an element makes powers and losses oscillate, so a mean of samples depends on their times."
        if outcome is not Verdict.NO
        else "Losses and powers follow from the same virtual-power statement at the same implicit steps, so they balance with any oscillation.",
    )


def _spiral(results: PaperResults) -> Statement:
    claim = "ALE0 has no spiral running; the other models have it"
    spiral = {
        model: [r.window.mean(f"spiral.{p}") for r in results.of(model) for p in ("primary", "secondary")]
        for model in MODELS
    }
    centred = [of["elastic"]["ALE0Centred"] for of in results.sheaves.values()]
    if not centred:
        return not_run("5.4, fig. 8d", claim, "a short run has no steady states of ALE0 about the axes")
    none = max(state[f"spiral.{p}"] for state in centred for p in ("primary", "secondary"))
    others = [value for model, values in spiral.items() if model != "ALE0" for value in values]
    return Statement(
        "5.4, fig. 8d",
        claim,
        verdict(none < 0.1 * min(others)),
        f"spread of the radius within an arc: ALE0 about the axes, as in the paper, {1e3 * none:.3f} mm; "
        + ", ".join(f"{m} {1e3 * min(v):.2f} to {1e3 * max(v):.2f} mm" for m, v in spiral.items()),
        "The arcs of the FMU's ALE0 have free centres, which allows spiral running without deflection.",
    )


def _half_the_time(results: PaperResults) -> Statement:
    claim = "ANCF and ALE0 need less computing time than RCM (the paper: about half)"
    ratio = {m: float(np.median([results.time_ratio(c, m) for c in results.cases])) for m in ("ANCF", "ALE0")}
    return Statement(
        "5.4, fig. 9",
        claim,
        verdict(max(ratio.values()) < 0.65, min(ratio.values()) < 0.65),
        ", ".join(f"{m} {value:.2g} of RCM" for m, value in ratio.items()) + " (median of the cases)",
        "ALE0 is at rest in its steady state and needs little computation. The mesh of ANCF travels like that of RCM and passes the same "
        "arc borders, but its mass matrix is constant and its elements are cheaper.",
    )


def _ale_time(results: PaperResults) -> Statement:
    claim = "ALE needs less computing time than RCM (the paper: about 80 %)"
    ratios = [results.time_ratio(case, "ALE") for case in results.cases]
    wavy = [value for case in results.cases if (value := results.wavy_time_ratio(case, "ALE")) is not None]
    swinging = f"; with an oscillating load {min(wavy):.2g} to {max(wavy):.2g}" if wavy else ""
    return Statement(
        "5.4, fig. 9",
        claim,
        verdict(max(ratios) < 0.8, min(ratios) < 0.8),
        f"{min(ratios):.2g} to {max(ratios):.2g} of RCM{swinging}",
        "The belt runs through a fixed mesh. Under constant loads the unknowns are constant, so the implicit steps are "
        "as long as the communication steps and need no new Jacobian. Explicit or short steps, as in the paper, do not have "
        "this advantage.",
    )


STATEMENTS: tuple[Callable[[PaperResults], Statement], ...] = (
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
)
"""All functions of statements on the variator, in the paper's order."""


def variator(results: PaperResults) -> list[Statement]:
    """All statements on the variator."""
    return [statement(results) for statement in STATEMENTS]
