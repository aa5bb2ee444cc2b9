"""Statements of the paper, paraphrased, and the results for them.

`paper/statements.csv` has source, claim, pinned verdict and reason of each. The numbers of a run determine its verdict: one function a
statement, by its key.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterable, Mapping
from enum import Enum
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pushbelt import tables
from pushbelt.report.page import MINUS

from . import profiles, times
from .cases import OFFSET
from .results import MODELS, OTHERS, PULLEYS, REFERENCE, PaperResults
from .rings import Rings

PINNED = Path(__file__).parents[2] / "statements.csv"
"""All statements, with the verdicts of a full run. A later one compares them."""

THIN = "\N{NARROW NO-BREAK SPACE}"
REFERENCE_DIRECTIONS = "ALE, overlay along t and n"
"""ALE with A_i = [t, n]."""
RATIOS = UNDERDRIVE, MEDIUM, OVERDRIVE = "underdrive", "medium", "overdrive"


class Verdict(Enum):
    """Verdict on a statement."""

    YES = "reproduced"
    PARTLY = "in part"
    NO = "not reproduced"
    OPEN = "not run"
    ASIDE = "elsewhere"


Finding = tuple[Verdict, str]
"""A verdict, and what was found."""


class Statement(NamedTuple):
    """A statement of the paper, with the verdict of a run and the pinned one."""

    key: str
    source: str
    claim: str
    pinned: str
    reason: str
    verdict: Verdict
    found: str


def evaluate(results: PaperResults) -> list[Statement]:
    """All statements in the paper's order."""
    with PINNED.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))[1:]
    return [Statement(*row, *globals()[f"_{row[0]}"](results)) for row in rows]


def pin(statements: Iterable[Statement]) -> None:
    """Stores the verdicts."""
    rows = ([s.key, s.source, s.claim, s.verdict.value, s.reason] for s in statements)
    tables.write(PINNED, ["key", "source", "claim", "verdict", "reason"], rows)


def compared(statements: Iterable[Statement]) -> int:
    """Prints the statements whose verdicts are not the pinned ones, and returns the exit code: 3 if there are any."""
    changed = [s for s in statements if s.verdict.value != s.pinned]
    for s in changed:
        print(f"{s.key}: {s.verdict.value}; pinned is {s.pinned}. {s.found}", file=sys.stderr)
    return 3 if changed else 0


def plain(value: float, form: str) -> str:
    """A number in a format, with a real minus."""
    return f"{value:{form}}".replace("-", MINUS)


def signed(value: float, digits: int = 1) -> str:
    """A share as per cent with its sign."""
    return f"{plain(100.0 * value, f'+.{digits}f')}{THIN}%"


def span(values: list[float], digits: int = 1) -> str:
    """Smallest and largest share as per cent."""
    return f"{signed(min(values), digits)} to {signed(max(values), digits)}"


def listed(values: Mapping[str, str]) -> str:
    """Names with their values."""
    names = {REFERENCE_DIRECTIONS: "ALE [t, n]"}
    return ", ".join(f"{names.get(n, n.replace('evenly spaced mesh', 'even mesh'))} {value}" for n, value in values.items())


def verdict(yes: bool, partly: bool = False) -> Verdict:
    """The verdict: reproduced, reproduced in part, or not reproduced."""
    return Verdict.YES if yes else Verdict.PARTLY if partly else Verdict.NO


NOT_RUN = (Verdict.OPEN, "not part of a short run")


# Rings alone (5.3)


def _reference_oscillates(results: PaperResults) -> Finding:
    theta = results.rings.motions["6", "ALE0"].theta
    low, high = theta.min(), theta.max()
    found = f"Θ from {plain(low, '+.3f')} to {plain(high, '+.3f')}"
    return verdict(abs(low + 0.4) < 0.02 and abs(high - 0.4) < 0.02), found


def _no_drift(results: PaperResults) -> Finding:
    drift = np.abs(results.rings.motions["6", "ALE0"].drift).max()
    return verdict(drift < 1e-9), f"|s| ≤ {plain(drift, '.0e')} m"


def _singular_mass(results: PaperResults) -> Finding:
    locked, free = (
        results.rings.check(f"smallest/largest eigenvalue of M, {what}", "ALE, 8 elements").value
        for what in ("node 0 locked", "nothing locked")
    )
    found = "smallest over largest eigenvalue of M, each unknown scaled to unit mass: "
    return verdict(free < 1e-3 * locked, free < locked), f"{found}{plain(free, '.0e')} free, {plain(locked, '.0e')} locked"


def _bulges(results: PaperResults) -> Finding:
    bulge = {model: motion.bulge[4] for (figure, model), motion in results.rings.motions.items() if figure == "7"}
    found = listed({model: f"{1e3 * value:.1f}" for model, value in bulge.items()})
    return verdict(min(bulge.values()) > 2e-3), f"at 0.2 ms, in mm: {found}"


def _centre(rings: Rings, model: str) -> float:
    """Largest displacement of the centre of mass of a ring of fig. 7 along x, mm."""
    centres = [outline[:-1, 0].mean() for outline in rings.shapes["7", model].values()]
    return 1e3 * max(abs(x - centres[0]) for x in centres)


def _artefact(results: PaperResults) -> Finding:
    ale = results.rings.motions["7", "ALE"]
    moved, free = (_centre(results.rings, model) for model in ("ALE", "RCM"))
    return verdict(ale.theta.max() > 0.6), (
        f"Θ rises from 0.4 to {ale.theta.max():.2f} at {1e3 * ale.time[ale.theta.argmax()]:.2f} ms; until {1e3 * ale.time[-1]:.0f} ms the "
        f"centre of mass moves by {moved:.0f} mm (RCM: {free:.1f} mm)"
    )


def _oval(results: PaperResults) -> Finding:
    ale, rcm = (results.rings.motions["7", model] for model in ("ALE", "RCM"))
    turns, turns_of_rcm = (int(np.count_nonzero(np.diff(np.sign(motion.ovality)))) for motion in (ale, rcm))
    found = f"ovality of ALE changes its sign {turns} times in {1e3 * ale.time[-1]:.1f} ms, of RCM {turns_of_rcm}"
    return verdict(turns >= 2), f"{found}; the run ends with Θ = {ale.theta[-1]:.2f}"


def _small_deflections(results: PaperResults) -> Finding:
    error = {f.model: f.error for f in results.rings.frequencies if f.case == "circle, small" and f.elements == 40}
    found = listed({model: signed(value, 2) for model, value in error.items()})
    return verdict(max(map(abs, error.values())) < 5e-3), f"first frequency of a free band, 40 elements: {found}"


def _large_deflections(results: PaperResults) -> Finding:
    large = {f.model: f for f in results.rings.frequencies if f.case != "circle, small"}
    found = listed({model: f"{f.frequency:.2f}" for model, f in large.items()})
    outcome = verdict(abs(large["ALE"].error) > 0.02 and abs(large["RCM"].error) < 0.01)
    return outcome, f"large oscillation, against 9.23 Hz: {found}"


def _identity_is_faster(results: PaperResults) -> Finding:
    """By counts, since a verdict may not depend on a clock."""
    fixed, turning = (results.rings.effort("deformable ring, 0.3 ms", model) for model in ("ALE", REFERENCE_DIRECTIONS))
    more = turning.factorizations / fixed.factorizations
    return verdict(more > 1.05, more > 1.0), (
        f"[t, n] takes {signed(turning.cpu / fixed.cpu - 1.0, 0)} of processor time, {turning.factorizations:.0f} Jacobians against "
        f"{fixed.factorizations:.0f}"
    )


# Variator (5.4)


def _speed(results: PaperResults) -> Finding:
    if not results.speeds:
        return NOT_RUN
    spans = {case: max(of.values()) / min(of.values()) - 1.0 for case, of in results.speeds.items()}
    speeds = sorted({round(speed * 30.0 / np.pi) for of in results.speeds.values() for speed in of})
    # σV² at the highest speed.
    density = results.parameters["belt.massPerLength"] + results.parameters["ring.massPerLength"]
    windows = {run.case.name: run.window for run in results.of("ALE")}
    faster = {name: max(of) / windows[name].mean("primary.speed") for name, of in results.speeds.items()}
    forces = {name: density * (share * windows[name].mean("belt.speed")) ** 2 for name, share in faster.items()}
    return verdict(max(spans.values()) < 0.05, float(np.median(list(spans.values()))) < 0.05), (
        f"thrust ratio (ALE) at {', '.join(map(str, speeds))} rpm differs by "
        + ", ".join(f"{100 * span:.1f}{THIN}% ({case})" for case, span in spans.items())
        + "; centrifugal force at the highest speed: "
        + ", ".join(f"{force:.0f} N ({case})" for case, force in forces.items())
    )


def _ratio_order(results: PaperResults) -> Finding:
    means: dict[str, list[float]] = {}
    for model in MODELS:
        of = {name: [r.window.thrust_ratio for r in results.of(model) if r.case.ratio_name == name] for name in RATIOS}
        means[model] = [float(np.mean(values)) for values in of.values() if values]
    found = "; ".join(f"{model} " + " < ".join(f"{level:.2f}" for level in levels) for model, levels in means.items())
    return verdict(all(np.all(np.diff(levels) > 0.0) for levels in means.values())), found


def _same_level(results: PaperResults) -> Finding:
    thrust = results.by_model(results.thrust_difference, OTHERS)
    efficiency = results.by_model(results.efficiency_difference, OTHERS)
    worst, off = (max(abs(value) for values in of.values() for value in values) for of in (thrust, efficiency))
    return verdict(worst < 0.1 and off < 0.02, worst < 0.3 and off < 0.06), (
        f"against {REFERENCE}, thrust ratio: {listed({m: span(v) for m, v in thrust.items()})}; efficiency, in points: "
        + listed({m: span(v) for m, v in efficiency.items()})
    )


def _ale_agrees(results: PaperResults) -> Finding:
    thrust = results.by_model(results.thrust_difference)["ALE"]
    efficiency = results.by_model(results.efficiency_difference)["ALE"]
    worst = max(map(abs, thrust))
    outcome = verdict(worst < 0.05 and max(map(abs, efficiency)) < 0.01, worst < 0.1)
    return outcome, f"thrust ratio {span(thrust)}, efficiency {span(efficiency, 2)} (points)"


def _ale0_in_overdrive(results: PaperResults) -> Finding:
    if not results.sheaves:
        return NOT_RUN

    def against_ale(model: str, sheaves: str) -> list[float]:
        states = [of[sheaves] for of in results.sheaves.values()]
        return [of[model]["thrustRatio"] / of["ALE"]["thrustRatio"] - 1.0 for of in states]

    paper, rigid, free, free_rigid = (
        against_ale(model, sheaves) for model in ("ALE0Centred", "ALE0") for sheaves in ("elastic", "rigid")
    )
    return verdict(min(paper) > 0.0 and max(paper) > 0.05, max(paper) > 0.0), (
        f"arcs about the axes, as in the paper, against ALE: {span(paper)}, with rigid sheaves {span(rigid)}; the FMU's ALE0, whose arcs "
        f"have free centres: {span(free)}, with rigid sheaves {span(free_rigid)}"
    )


def _ancf_is_low(results: PaperResults) -> Finding:
    runs = [run for run in results.of("ANCF") if run.case.ratio_name in (MEDIUM, UNDERDRIVE)]
    values = [results.thrust_difference(run) for run in runs]
    return verdict(max(values) < -0.03, min(values) < -0.03), f"against {REFERENCE}: {span(values)}"


def _ancf_loses(results: PaperResults) -> Finding:
    of_case = [{m: results.run(case, m).window.loss for m in MODELS} for case in results.cases]
    extra = [loss["ANCF"] / max(loss["RCM"], loss["ALE"]) - 1.0 for loss in of_case]
    return verdict(min(extra) > 0.0, max(extra) > 0.0), f"losses against the larger of RCM's and ALE's: {span(extra, 0)}"


def _push_force(results: PaperResults) -> Finding:
    shapes = {m: np.array([profiles.push_force_gains(results.parameters, r) for r in results.of(m)]) for m in MODELS}
    primary, strand, secondary = np.concatenate(list(shapes.values())).T
    builds_up = bool(np.all(primary > 0.0) and np.all(secondary < 0.0))
    found = "; ".join(f"{m} {', '.join(plain(gain, '+.0f') for gain in of.mean(axis=0))} N" for m, of in shapes.items())
    return verdict(builds_up and bool(np.all(np.abs(strand) < 0.1 * primary)), builds_up), f"{found} (means over the cases)"


def _ancf_oscillates(results: PaperResults) -> Finding:
    strand = results.by_model(lambda run: profiles.strand_ripple(results.parameters, run))
    ripple = {model: float(np.median(values)) for model, values in strand.items()}
    found = listed({model: f"{100 * value:.2g}{THIN}%" for model, value in ripple.items()})
    outcome = verdict(ripple["ANCF"] > 3.0 * ripple["RCM"], ripple["ANCF"] > 1.5 * ripple["RCM"])
    return outcome, f"standard deviation of the push force in the push strand (median of the cases): {found}"


def _ancf_efficiency(results: PaperResults) -> Finding:
    off = results.by_model(lambda run: abs(run.window.efficiency - run.window.efficiency_from_losses))
    gap = {model: max(values) for model, values in off.items()}
    found = listed({model: f"{100 * value:.2f} points" for model, value in gap.items()})
    outcome = verdict(gap["ANCF"] > 2.0 * gap["RCM"] and gap["ANCF"] > 2e-3, gap["ANCF"] > 2e-3)
    return outcome, f"efficiency from sampled powers minus that from sampled losses, at most: {found}"


def _spiral(results: PaperResults) -> Finding:
    if not results.sheaves:
        return NOT_RUN
    spiral = results.by_model(lambda run: run.window.spiral)
    states = [of["elastic"]["ALE0Centred"] for of in results.sheaves.values()]
    none = max(state[f"spiral.{pulley}"] for state in states for pulley in PULLEYS)
    others = [value for model, values in spiral.items() if model != "ALE0" for value in values]
    return verdict(none < 0.1 * min(others)), (
        f"spread of the radius within an arc: ALE0 about the axes, as in the paper, {1e3 * none:.3f} mm; "
        + listed({m: f"{1e3 * min(v):.2f} to {1e3 * max(v):.2f} mm" for m, v in spiral.items()})
    )


def _time(variants: Iterable[str], share: float) -> Finding:
    """Fig. 9. The verdict is that of the stored times."""
    factors = times.factors(times.stored()[0])
    found = {(variant, load): factors.loc[load, variant] for variant in variants for load in times.LOADS}
    means = [of["mean"] for of in found.values()]
    at = [abs(mean / share - 1.0) < 0.25 for mean in means]
    return verdict(all(at), any(at) or min(means) < share), "; ".join(
        f"{variant}, {load} load: {of['mean']:.2g} of RCM ({of['min']:.2g} to {of['max']:.2g}), from {of['steps']:.2g} × steps, "
        f"{of['residuals a step']:.2g} × residuals a step, {of['time a residual']:.2g} × time a residual"
        for (variant, load), of in found.items()
    )


def _half_the_time(_: PaperResults) -> Finding:
    return _time(("ANCF", f"ALE0{times.FORWARD}"), 0.5)


def _ale_time(_: PaperResults) -> Finding:
    ale = f"ALE{times.FORWARD}"
    outcome, found = _time([ale], 0.8)
    return outcome, f"{found}; {_time([ale + times.SHORT_STEPS], 0.8)[1]}"


# Elsewhere in the paper


def _rotating_directions(results: PaperResults) -> Finding:
    fixed, turning = (results.shifts[name].jacobians for name in ("aligned", "directions"))
    ride = [results.rings.effort("manoeuvre, 10 s", model) for model in ("ALE", REFERENCE_DIRECTIONS)]
    more = [turning / fixed, ride[1].factorizations / ride[0].factorizations]
    return verdict(min(more) > 1.2, max(more) > 1.05), (
        f"Jacobians with [t, n] and with the identity: {turning} and {fixed} in a shift, {ride[1].factorizations:.0f} and "
        f"{ride[0].factorizations:.0f} in the manoeuvre of 10 s, which takes {signed(ride[1].cpu / ride[0].cpu - 1.0, 0)} of processor time"
    )


def _space(results: PaperResults) -> Finding:
    state = results.misaligned
    return verdict(state["belt.lateralMax"] > 0.1 * OFFSET and state["belt.skew"] != 0.0), (
        f"pulleys {1e3 * OFFSET:g} mm out of line: the ring deflects sideways by {1e3 * state['belt.lateralMax']:.2f} mm, the strands are "
        f"inclined by {1e3 * state['belt.skew']:.2f} mrad, efficiency of the belt {100 * state['efficiency.belt']:.2f} %"
    )


def _other_belts(_: PaperResults) -> Finding:
    return Verdict.ASIDE, "paper/examples/idler.rs"


def _separated_integration(_: PaperResults) -> Finding:
    return Verdict.ASIDE, "docs/notebook/experiments.md"


_reduced_overlay = _separated_integration
