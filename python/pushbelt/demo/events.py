"""Events of the manoeuvre, detected from its outputs, and checks of all results of a run."""

import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from pushbelt.fmu.data import curve_of, is_chain, manoeuvre_inputs
from pushbelt.fmu.geometry import EDGE, Array
from pushbelt.fmu.results import LoadCaseResult, Trace, intervals
from pushbelt.report.page import Check
from pushbelt.report.style import RPM

from .simulate import DemoResults

OVERLOAD = "Over-torque with macro-slip"  # Name of the event that the over-torque of the manoeuvre causes
STEP, WITHIN = 20.0, 0.03  # Least step of the primary torque, N·m, and its largest duration, s


class Event(NamedTuple):
    name: str
    occurred: bool
    evidence: str  # Description of the event by its outputs
    start: float = math.nan  # Start time, s; NaN if the event did not occur
    end: float = math.nan  # End time, s; NaN if the event did not occur or has no end


def launch(trace: Trace) -> Event:
    name = "Launch in underdrive"
    speed, ratio, time = trace["secondary.speed"], trace["ratio.geometric"], trace.time
    moving = np.flatnonzero(speed > 1.0)
    if abs(speed[0]) > 0.1 or ratio[0] <= 1.0 or not moving.size:
        return Event(name, False, f"from {RPM * speed[0]:.1f} rpm and a ratio of {ratio[0]:.2f} to at most {RPM * speed.max():.2f} rpm")
    shifted = np.flatnonzero(ratio[moving[0] :] < 0.9 * ratio[moving[0]])
    end = moving[0] + shifted[0] - 1 if shifted.size else len(time) - 1
    slip = 100 * np.abs(trace["slip"][moving[0] : end + 1]).max()
    ratios = f"ratios of {ratio[: end + 1].min():.2f} to {ratio[: end + 1].max():.2f}"
    evidence = f"secondary from 0 to {RPM * speed[end]:.0f} rpm at {ratios}; slip at most {slip:.1f} %"
    return Event(name, True, evidence, float(time[moving[0]]), float(time[end]))


def shift(trace: Trace) -> Event:
    name = "Shift to overdrive"
    ratio, time = trace["ratio.geometric"], trace.time
    through_one = np.flatnonzero((ratio[:-1] > 1.0) & (ratio[1:] <= 1.0))
    if not through_one.size:
        return Event(name, False, f"the ratio stays between {ratio.min():.2f} and {ratio.max():.2f}")
    crossing = through_one[0]
    # Medians are used, because changes of the clamping forces and macro-slip also affect the ratio.
    high, low = np.median(ratio[:crossing]), np.median(ratio[crossing:])
    start = np.flatnonzero(ratio[:crossing] > high - 0.05 * (high - low))[-1]
    end = crossing + np.flatnonzero(ratio[crossing:] < low + 0.05 * (high - low))[0]
    rate = np.gradient(ratio[start : end + 1], time[start : end + 1]).min()
    slipping = (trace["macroSlip"][start : end + 1] > 0.5).mean() * (time[end] - time[start])
    course = f"ratio from {ratio[start]:.2f} to {ratio[end]:.2f}, through 1 at {time[crossing]:.2f} s"
    evidence = f"{course}, at most {-rate:.2f} 1/s; macro-slip for {slipping:.2f} s of it"
    return Event(name, True, evidence, float(time[start]), float(time[end]))


def torque_steps(trace: Trace) -> list[Event]:
    """Steps of the primary torque that the belt carries."""
    events = []
    slipping = intervals(trace.time, trace["macroSlip"], gap=0.02)
    torque, reach = trace["primary.externalTorque"], max(1, round(WITHIN / (trace.time[1] - trace.time[0])))
    change = np.abs(torque[reach:] - torque[:-reach])
    for first, last in ((int(first), int(last)) for first, last in intervals(np.arange(len(change)), change > STEP)):
        before, after = torque[first], torque[min(last + reach, len(torque) - 1)]
        at = float(trace.time[first + int(np.argmax(np.abs(np.diff(torque[first : last + reach + 1]))))])
        if any(start - 0.1 <= at <= end + 0.1 for start, end in slipping):
            continue
        window = _within(trace, at, at + 0.3)
        belt = -trace["primary.shaftTorque"][window][-1]
        slips = 100 * trace["slip"][window]
        utilisation = trace["torqueUtilisation"][window][-1]
        evidence = f"0.3 s later the belt carries {belt:.1f} N·m; slip from {slips[0]:.2f} to {slips[-1]:.2f} %, utilisation {utilisation:.2f}"
        events.append(Event(f"Torque step {before:.0f} → {after:.0f} N·m", True, evidence, at))
    return events or [Event("Torque steps", False, f"no step of the primary torque above {STEP:g} N·m within {WITHIN:g} s")]


def over_torque(trace: Trace) -> list[Event]:
    """Macro-slip under too much torque, in the interval of macro-slip with the largest external torque, and the recovery from it."""
    slipping = [one for one in intervals(trace.time, trace["macroSlip"], gap=0.02) if one[1] - one[0] >= 0.02]
    if not slipping:
        utilisation = trace["torqueUtilisation"].max()
        return [
            Event(OVERLOAD, False, f"macroSlip is never true for 20 ms; utilisation {utilisation:.2f}"),
            Event("Recovery", False, "no recovery, since there was no macro-slip"),
        ]
    start, end = max(slipping, key=lambda one: np.abs(trace["primary.externalTorque"][_within(trace, *one)]).max())
    during = _within(trace, start, end)
    torque, carried = trace["primary.externalTorque"][during].max(), np.median(-trace["primary.shaftTorque"][during])
    slip, loss = 100 * np.abs(trace["slip"][during]).max(), 1e-3 * trace["loss.total"][during].max()
    evidence = f"primary torque up to {torque:.0f} N·m, of which the belt carries {carried:.0f} N·m (median); slip up to {slip:.0f} %"
    return [Event(OVERLOAD, True, f"{evidence}, loss up to {loss:.3g} kW", start, end), _recovery(trace, end)]


def _within(trace: Trace, start: float, end: float) -> Array:
    return (trace.time >= start) & (trace.time <= end)


def _recovery(trace: Trace, overload_end: float) -> Event:
    name = "Recovery"
    slip = np.abs(trace["slip"])
    if slip[-1] > 0.03 or trace["macroSlip"][-1] > 0.5:
        return Event(name, False, f"slip is still {100 * slip[-1]:.1f} % at the end")
    late = np.flatnonzero((trace.time > overload_end) & (slip > 0.03))
    settled = float(trace.time[late[-1] + 1]) if late.size else overload_end
    evidence = f"slip below 3 % permanently {1e3 * (settled - overload_end):.0f} ms after macro-slip has ended"
    last = f"at the end slip {100 * trace['slip'][-1]:.2f} %, utilisation {trace['torqueUtilisation'][-1]:.2f}"
    return Event(name, True, f"{evidence}; {last}", overload_end, settled)


def detect(trace: Trace) -> list[Event]:
    """The events of the trace in the order of time; those of the whole manoeuvre that did not occur come last."""
    events = [launch(trace), shift(trace), *torque_steps(trace), *over_torque(trace)]
    whole = trace.time[-1] >= manoeuvre_inputs().time[-1]
    return sorted((event for event in events if event.occurred or whole), key=lambda event: (not event.occurred, event.start))


def _cases(statement: str, values: Iterable[tuple[LoadCaseResult, float]], low: float, high: float, unit: str) -> Check:
    pairs = list(values)
    outside = [result.case.name for result, value in pairs if not low <= value <= high]
    least, largest = min(value for _, value in pairs), max(value for _, value in pairs)
    found = f"{least:.3g} to {largest:.3g}{unit}" if largest >= 1e-3 else f"below 0.001{unit}"
    return Check(statement, not outside, found + (f"; outside: {', '.join(outside)}" if outside else ""))


def power_imbalance(result: LoadCaseResult) -> float:
    """Power into both shafts minus all losses, relative to the driving power."""
    state = result.steady
    powers = [state[f"{pulley}.externalTorque"] * state[f"{pulley}.speed"] for pulley in ("primary", "secondary")]
    return (sum(powers) - state["loss.total"]) / max(powers)


def push_strand_spread(result: LoadCaseResult, parameters: Mapping[str, float]) -> float:
    """Spread of the push force in the lower strand, relative to its mean."""
    profile = result.steady.profile
    *_, start, end, _ = curve_of(parameters, result.steady["reference.theta"]).borders
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
    ratios = {(r.case.ratio_name, r.case.torque): r.steady["thrustRatio"] for r in cases}
    torques = {torque for _, torque in ratios}
    table = np.array([[ratios[name, torque] for torque in torques] for name in ("underdrive", "medium", "overdrive")])
    found = " < ".join(f"{mean:.3f}" for mean in table.mean(axis=1))
    statement = "Thrust ratio orders underdrive < medium < overdrive at every torque"
    return Check(statement, bool((np.diff(table, axis=0) > 0.0).all()), f"{found} (means over the torques)")


def _push_force_gains(cases: tuple[LoadCaseResult, ...], parameters: Mapping[str, float]) -> Check:
    profiles = [(curve_of(parameters, r.steady["reference.theta"]), r.steady.profile) for r in cases]
    gains = [curve.push_force_gains(profile.position, profile.push_force) for curve, profile in profiles]
    built_up, decayed = [primary for primary, _, _ in gains], [-secondary for _, _, secondary in gains]
    found = f"by {min(built_up):.0f} to {max(built_up):.0f} N, by {min(decayed):.0f} to {max(decayed):.0f} N"
    statement = "Push force builds up in the primary arc and decays in the secondary arc"
    return Check(statement, min(*built_up, *decayed) > 0.0, found)


def _manoeuvre(trace: Trace) -> list[Check]:
    residual, bound, events = np.abs(trace["energy.residual"]), energy_bound(trace), detect(trace)
    missing = [event.name for event in events if not event.occurred]
    found = f"at most {100 * (residual / bound).max():.0f} % of the bound, {residual.max():.3g} J"
    occurred = f"missing: {', '.join(missing)}" if missing else f"{len(events)} within {trace.time[-1]:.0f} s"
    statement = "Energy residual of the manoeuvre stays within its bound at every output point"
    return [
        Check(statement, bool((residual <= bound).all()), found), Check("Every event of the manoeuvre occurs", not missing, occurred),
    ]  # fmt: skip


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
