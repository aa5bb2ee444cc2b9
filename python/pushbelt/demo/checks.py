"""Checks of the results of every run, shown in the report."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from pushbelt.fmu.data import curve_at, is_chain
from pushbelt.fmu.geometry import EDGE, Array
from pushbelt.fmu.results import LoadCaseResult, Trace
from pushbelt.report.page import Check

from .events import detect
from .simulate import DemoResults


def _cases(statement: str, values: Iterable[tuple[LoadCaseResult, float]], low: float, high: float, unit: str) -> Check:
    """Check that all cases are within limits."""
    pairs = list(values)
    numbers = [value for _, value in pairs]
    outside = [result.case.name for result, value in pairs if not low <= value <= high]
    largest = max(numbers)
    found = f"{min(numbers):.3g} to {largest:.3g}{unit}" if largest >= 1e-3 else f"below 0.001{unit}"
    return Check(statement, not outside, found + (f"; outside: {', '.join(outside)}" if outside else ""))


def power_imbalance(result: LoadCaseResult) -> float:
    """Power into both shafts minus all losses, relative to the driving power."""
    state = result.steady
    powers = [state[f"{pulley}.externalTorque"] * state[f"{pulley}.speed"] for pulley in ("primary", "secondary")]
    return (sum(powers) - state["loss.total"]) / max(powers)


def push_strand_spread(result: LoadCaseResult, parameters: Mapping[str, float]) -> float:
    """Spread of the push force in the lower strand, relative to its mean."""
    profile = result.steady.profile
    *_, start, end, _ = curve_at(parameters, result.steady).borders
    inside = (profile.position > start + EDGE) & (profile.position < end - EDGE)
    force = profile.push_force[inside]
    return float(np.ptp(force) / force.mean()) if force.size and force.mean() > 0.0 else float("inf")


def energy_bound(trace: Trace) -> Array:
    """Bound of the energy residual: 0.2 % of the energy moved and 0.1 % of the largest stored energy, J."""
    step = np.diff(trace.time, prepend=trace.time[0])
    moved = step * (np.abs(trace["primary.power"]) + np.abs(trace["secondary.power"]))
    for pulley in ("primary", "secondary"):
        position = trace[f"{pulley}.position"]
        moved = moved + np.abs(trace[f"{pulley}.clampingForce"] * np.diff(position, prepend=position[0]))
    return 2e-3 * np.cumsum(moved) + 1e-3 * np.abs(trace["stored.energy"]).max()


def _order(cases: tuple[LoadCaseResult, ...]) -> Check:
    names = ("underdrive", "medium", "overdrive")
    ratios = {(r.case.ratio_name, r.case.torque): r.steady["thrustRatio"] for r in cases}
    torques = {torque for _, torque in ratios}
    table = np.array([[ratios[name, torque] for torque in torques] for name in names])
    found = " < ".join(f"{mean:.3f}" for mean in table.mean(axis=1))
    statement = "Thrust ratio orders underdrive < medium < overdrive at every torque"
    return Check(statement, bool((np.diff(table, axis=0) > 0.0).all()), f"{found} (means over the torques)")


def _push_force_gains(cases: tuple[LoadCaseResult, ...], parameters: Mapping[str, float]) -> Check:
    profiles = [(curve_at(parameters, r.steady), r.steady.profile) for r in cases]
    gains = [curve.push_force_gains(profile.position, profile.push_force) for curve, profile in profiles]
    built_up, decayed = [primary for primary, _, _ in gains], [-secondary for _, _, secondary in gains]
    return Check(
        "Push force builds up in the primary arc and decays in the secondary arc",
        min(built_up) > 0.0 and min(decayed) > 0.0,
        f"by {min(built_up):.0f} to {max(built_up):.0f} N, by {min(decayed):.0f} to {max(decayed):.0f} N",
    )


def _manoeuvre(trace: Trace) -> list[Check]:
    residual, bound = np.abs(trace["energy.residual"]), energy_bound(trace)
    events = detect(trace)
    missing = [event.name for event in events if not event.occurred]
    found = f"at most {100 * (residual / bound).max():.0f} % of the bound, {residual.max():.3g} J"
    within = bool((residual <= bound).all())
    occurred = f"missing: {', '.join(missing)}" if missing else f"{len(events)} events"
    return [
        Check("Energy residual of the manoeuvre stays within its bound at every output point", within, found),
        Check("Every event of the manoeuvre occurs", not missing, occurred),
    ]


def evaluate(results: DemoResults) -> list[Check]:
    cases, parameters = results.cases, results.parameters
    constant, slips = "Push force is constant in the push strand within 1 %", "Slip lies between 0 and 4 %, the largest measured in underdrive"
    closed = "Losses sum to the net power of both shafts within 0.2 % of the driving power"
    persist = "Steady states persist when the simulation continues"
    of_stack = [
        _push_force_gains(cases, parameters),
        _cases(constant, [(r, 100 * push_strand_spread(r, parameters)) for r in cases], 0.0, 1.0, " % spread"),
    ]
    return [
        _order(cases),
        *([] if is_chain(parameters) else of_stack),
        _cases(slips, [(r, 100 * r.steady["slip"]) for r in cases], 0.0, 4.0, " %"),
        _cases(closed, [(r, 100 * abs(power_imbalance(r))) for r in cases], 0.0, 0.2, " %"),
        _cases(persist, [(r, 100 * abs(r.drift)) for r in cases], 0.0, 0.1, " % of the thrust ratio"),
        *_manoeuvre(results.manoeuvre.trace),
    ]
