"""Standard deviations of the outputs of a steady state by those of parameters and conditions."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from .results import Bands
from .steady import StartValues, SteadyStates
from .unit import UnitError

SAMPLES = 60
"""Number of samples, with which a standard deviation is known to 9 %."""
LINEAR_UTILISATION, LINEAR = 0.6, 0.5
"""Torque utilisation, and curvature as a share of an output's deviation, beyond which samples are drawn."""
NAMED = ("thrustRatio", "slip", "loss.total")
"""Outputs whose curvature counts."""


def bands(states: SteadyStates, start_values: Callable[[Mapping[str, float]], StartValues], deviations: Mapping[str, float]) -> Bands:
    """Outputs at `start_values({})`, and their standard deviations by `deviations`, from which `start_values` adds some.

    An output that depends on each x, in standard deviations, as a x + b x² has the deviation √Σ(a² + 2 b²). Where b contributes much, or near
    the capacity, samples of independent normal distributions replace it. Raises UnitError without a steady state at one deviation.
    """
    unit = states.at(start_values({}))
    outputs, near = unit.outputs(), unit.state()
    middle, lost = np.array(list(outputs.values())), np.nan

    def at(changes: Mapping[str, float]) -> np.ndarray:
        return np.array(list(states.at(start_values(changes), near).outputs().values()))

    pairs = np.array([[at({name: sign * deviation}) for sign in (1.0, -1.0)] for name, deviation in deviations.items()])
    pairs = pairs.reshape(-1, 2, len(middle))
    chords, curvatures = 0.5 * (pairs[:, 0] - pairs[:, 1]), 0.5 * (pairs[:, 0] + pairs[:, 1]) - middle
    linear, curved = np.linalg.norm(chords, axis=0), 2.0**0.5 * np.linalg.norm(curvatures, axis=0)
    spread = np.hypot(linear, curved)
    named = [list(outputs).index(name) for name in NAMED]
    if outputs["torqueUtilisation"] > LINEAR_UTILISATION or (curved > LINEAR * linear)[named].any():
        random, found = np.random.default_rng(0), []
        for _ in range(SAMPLES):
            try:
                found.append(at({name: deviation * random.standard_normal() for name, deviation in deviations.items()}))
            except UnitError:
                continue
        lost = 1.0 - len(found) / SAMPLES
        spread = np.std(found, axis=0, ddof=1) if len(found) > 1 else np.full(len(middle), np.nan)
    return Bands(outputs, dict(deviations), dict(zip(outputs, chords.T, strict=True)), dict(zip(outputs, spread.tolist(), strict=True)), lost)
