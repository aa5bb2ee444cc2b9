"""Animation of the belt on its pulleys with a time slider: push force, or tension of a chain, in colour, gaps and spiral running magnified."""

import base64
import json
from collections.abc import Mapping

import numpy as np
from markupsafe import Markup
from scipy.integrate import cumulative_trapezoid

from ..fmu.data import curve_of, is_chain
from ..fmu.geometry import Array, TwoPulleyCurve
from ..fmu.results import BeltState, Profile, Trace
from .charts import encoded
from .page import fragment
from .style import COLOUR_SCALE

ELEMENTS_TOGETHER = 3  # Number of elements of the belt per drawn element. The pins of a chain are drawn one by one.
TURNS_A_SECOND = 0.35  # Speed of the faster pulley in the animation, turns per second
LONGEST = 60.0  # Longest duration of the animation, s
STEADY_TIME = 20.0  # Duration of the animation of a steady state, s
STEPS = 1000  # Number of steps of the slider
ROUND = (1, 2, 5, 10, 20, 50, 100, 200, 500)  # Magnifications to choose from
ELEMENT_THICKNESS = 1.5e-3
"""The FMU's default of `belt.elementThickness`, m. Parameter sets contain only values that differ."""
SPEEDS = ("primary.speed", "secondary.speed", "belt.speed")
OUTPUTS = ("reference.theta", "primary.radius", "secondary.radius")
"""Outputs of a run that its belt is drawn from, besides `SPEEDS` and the profiles."""


def belt_offset(state: BeltState, curve: TwoPulleyCurve, pitch_offset: float) -> Array:
    """Distance of the belt from its reference curve at the points of the profile, outward positive, m. On an arc the
    profile is relative to the arc's mean radius, which differs slightly from the radius of the reference curve."""
    offset = state.profile.radial_deviation
    for pulley in ("primary", "secondary"):
        on_arc = np.abs(curve.from_middle(pulley, state.profile.position)) < 0.5 * curve.arc_length(pulley)
        offset = offset + on_arc * (state[f"{pulley}.radius"] + pitch_offset - curve.radius(pulley))
    return offset


def of_run(run: Trace, profiles: Mapping[float, Profile]) -> dict[float, BeltState]:
    """The belt at the times of profiles of a run."""
    return {time: BeltState({name: float(np.interp(time, run.time, run[name])) for name in OUTPUTS}, one) for time, one in profiles.items()}


def magnification(size: float, shown: float) -> int:
    """A round magnification at which something of a size has about a size in the figure."""
    return max(step for step in ROUND if step <= max(shown / max(size, 1e-9), 1.0))


def belt_view(
    states: Mapping[float, BeltState], parameters: Mapping[str, float], label: str, group: str = "", start: float | None = None,
    run: Trace | None = None,
) -> Markup:  # fmt: skip
    """The animation of states by their times as an HTML fragment. Pulleys and belt turn by the speeds of the run, or else by those of the
    states. `label` says what is shown; the colour is added to it. With `group` it shares the cursor of charts over time."""
    time, shown = np.array(sorted(states)), [states[moment] for moment in sorted(states)]
    run = run or Trace(time, {name: np.array([state[name] for state in shown]) for name in SPEEDS})
    primary, secondary, way = (np.interp(time, run.time, cumulative_trapezoid(run[name], run.time, initial=0.0)) for name in SPEEDS)
    angles = np.stack([secondary, primary], axis=1)
    curves = [curve_of(parameters, state["reference.theta"]) for state in shown]
    radii = np.array([(curve.secondary_radius, curve.primary_radius) for curve in curves])
    gap = np.array([state.profile.gap for state in shown])
    distance, length, pitch = (parameters[name] for name in ("geometry.centerDistance", "geometry.beltLength", "belt.pitchOffset"))
    offset = np.array([belt_offset(*one, pitch) for one in zip(shown, curves, strict=True)])
    thickness, chain = parameters.get("belt.elementThickness", ELEMENT_THICKNESS), is_chain(parameters)
    together, field, text = (1, "ring_tension", "tension") if chain else (ELEMENTS_TOGETHER, "push_force", "push force")
    force = np.array([getattr(state.profile, field) for state in shown])
    label = f"{label}, coloured by {text}"
    # The largest distance from the curve is about a third of the smaller radius.
    scale = magnification(float(np.percentile(np.abs(offset), 99.0, axis=1).max()), 0.3 * float(radii.min()))
    gap_scale = magnification(float(np.percentile(gap, 99.0)), 0.75 * thickness)
    rates = np.abs(np.diff(angles, axis=0)) / np.diff(time)[:, None]
    pace = max(1.0, float(np.ptp(time)) / LONGEST)
    slow = float(f"{max(float(np.percentile(rates, 95.0)) * pace / (2.0 * np.pi * TURNS_A_SECOND), 1.0):.1g}")
    reach = float(radii.max() + scale * np.percentile(np.abs(offset), 99.9))
    data = {
        "group": group, "steady": len(time) == 2 and np.array_equal(*force), "pace": pace, "slow": slow,
        "distance": 1e3 * distance, "length": 1e3 * length, "pitchOffset": 1e3 * pitch, "reach": 1e3 * reach + 4.0,
        "chain": chain, "force": text,
        "count": round(length / (together * thickness)), "magnification": scale,
        "gapScale": gap_scale / thickness, "most": max(float(np.percentile(force, 99.8)), 1.0),
        "colours": [[int(colour[k : k + 2], 16) for k in (1, 3, 5)] for colour in COLOUR_SCALE],
        "time": encoded(time), "radii": encoded(1e3 * radii.ravel()), "angles": encoded(angles.ravel()),
        "way": encoded(1e3 * way), "push": _whole(force), "offset": _whole(1e3 * offset), "gap": _whole(gap),
    }  # fmt: skip
    value = round(STEPS * float(((time[0] if start is None else start) - time[0]) / np.ptp(time)))
    shown_there = {"steps": STEPS, "value": value, "colours": COLOUR_SCALE, "gap_scale": gap_scale, "together": together}
    return fragment("belt.html.j2", label=label, data=data, text=json.dumps(data, separators=(",", ":")), **shown_there)


def _whole(values: Array) -> dict[str, object]:
    """Values as 16-bit integers, relative to the largest magnitude."""
    unit = max(float(np.abs(values).max()), 1e-12) / 32767.0
    return {"unit": unit, "data": base64.b64encode(np.round(values / unit).astype("<i2").tobytes()).decode()}
