"""Standard deviations of the outputs of a steady state by those of parameters and conditions."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from .results import Bands
from .steady import StartValues, SteadyStates
from .unit import UnitError

SAMPLES = 60  # Number of samples, with which a standard deviation is known to 9 %
LINEAR_UTILISATION, LINEAR = 0.6, 0.5
"""Torque utilisation, and curvature as a share of an output's deviation, beyond which samples are drawn."""
DEVIATION = ".sd"  # Suffix of a column of standard deviations
NAMED = ("thrustRatio", "slip", "loss.total")  # Outputs whose curvature counts


def increased(variables: Mapping[str, Any], values: Mapping[str, float], changes: Mapping[str, float]) -> dict[str, float]:
    """Values of variables with changes, within their ranges."""
    limits = {name: (variables[name].min, variables[name].max) for name in changes}
    ends = {name: (-np.inf if low is None else float(low), np.inf if high is None else float(high)) for name, (low, high) in limits.items()}
    return {name: min(max(values[name] + more, ends[name][0]), ends[name][1]) for name, more in changes.items()}


def samples(deviations: Mapping[str, float], count: int) -> list[dict[str, float]]:
    """Changes drawn from independent normal distributions, the same in each call."""
    draws = np.random.default_rng(0).standard_normal((count, len(deviations))) * list(deviations.values())
    return [dict(zip(deviations, draw, strict=True)) for draw in draws.tolist()]


def bands(
    states: SteadyStates, outputs: Mapping[str, float], near: bytes, start_values: Callable[[Mapping[str, float]], StartValues],
    deviations: Mapping[str, float],
) -> Bands:  # fmt: skip
    """Standard deviations of the outputs of a stored steady state by `deviations`, from which `start_values` adds some. An output that
    depends on each x, in standard deviations, as a x + b x² has the deviation √Σ(a² + 2 b²). Where b contributes much, or near the
    capacity, that of samples of independent normal distributions replaces it."""
    middle, lost = np.array(list(outputs.values())), np.nan

    def at(changes: Mapping[str, float]) -> np.ndarray:
        try:
            return np.array(list(states.at(start_values(changes), near).outputs().values()))
        except UnitError:
            return np.full(len(middle), np.nan)

    pairs = [[at({name: sign * deviation}) for sign in (1.0, -1.0)] for name, deviation in deviations.items()]
    above, below = np.reshape(pairs, (-1, 2, len(middle))).transpose(1, 0, 2) - middle
    found = np.isfinite(above) & np.isfinite(below)
    # Without a steady state on one side the other one is the chord.
    chords = np.nan_to_num(np.where(found, 0.5 * (above - below), np.where(np.isfinite(above), above, -below)))
    curvatures = np.where(found, 0.5 * (above + below), 0.0)
    linear, curved = np.linalg.norm(chords, axis=0), 2.0**0.5 * np.linalg.norm(curvatures, axis=0)
    spread, named = np.hypot(linear, curved), [list(outputs).index(name) for name in NAMED]
    if not found.all() or outputs["torqueUtilisation"] > LINEAR_UTILISATION or (curved > LINEAR * linear)[named].any():
        drawn = np.array([at(changes) for changes in samples(deviations, SAMPLES)])
        kept = np.isfinite(drawn).all(axis=1)
        spread, lost = np.std(drawn[kept], axis=0, ddof=1), 1.0 - float(kept.mean())
    return Bands(outputs, dict(deviations), dict(zip(outputs, chords.T, strict=True)), dict(zip(outputs, spread.tolist(), strict=True)), lost)
