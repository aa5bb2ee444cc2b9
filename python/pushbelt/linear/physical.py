"""A linear model in physical coordinates, x = (ω_P, ω_S, ln i).

Modal coordinates have no common scale or sign from point to point, so their matrices cannot be interpolated. The coordinates here can.
With the outputs z = C_z ξ of the n slowest modes ξ, x = C_z ξ is a similarity transform: A, B and C of the point become
C_z A C_z⁻¹, C_z B and C C_z⁻¹. Faster modes are quasi-static: they add −C A⁻¹ B to D. Coordinates that are held drop out: a speed
with a set point, and ln i with a held sheave.

Mode n is mostly one of an oscillating pair λ, the slip against the inertia of the belt. Then the similarity transform takes n + 1 modes: to
x, and to w = ż/|λ| − p B u/|λ| of the pair's share z = p ξ of x, in the direction that no slower mode has. The pair, ż = |λ| w + p B u and
ẇ = −|λ| z + 2 Re λ w + …, becomes a lag with the pole −|λ| and the same static gain. The slower poles and all static gains are exact.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..errors import PushbeltError
from .model import LOG_RATIO, Array, LinearModel

COORDINATES = {"primary.speed": "primary.torque", "secondary.speed": "secondary.torque"}
"""Speeds among the coordinates, and the input without which each is held."""
RATIO = "ratio.geometric"
FORCES = ("primary.clampingForce", "secondary.clampingForce")  # Inputs without one of which the ratio is held
WORST = 1e6  # Condition number of the transform above which it is refused
MOST_HERTZ = 1600.0  # Frequency up to which modes are searched for the coordinates, Hz


class NotPhysicalError(PushbeltError, ValueError):
    """The slow modes of a point are not determined by the physical coordinates."""


def coordinates(inputs: Sequence[str]) -> list[str]:
    """The coordinates that are not held, for the inputs of a model."""
    speeds = [speed for speed, torque in COORDINATES.items() if torque in inputs]
    return [*speeds, LOG_RATIO] if all(force in inputs for force in FORCES) else speeds


def modes_needed(model: LinearModel) -> int:
    """Number of modes that `physical` takes: the number of coordinates, plus one if that would divide an oscillating pair."""
    n = len(coordinates(model.inputs))
    return n + int(np.count_nonzero(model.poles[:n].imag)) % 2 if n <= len(model.poles) else n


def physical(model: LinearModel) -> LinearModel:
    """The model in physical coordinates. Raises NotPhysicalError if there are none, too few modes, or too large a condition number."""
    names = coordinates(model.inputs)
    if not names:
        raise NotPhysicalError("no physical coordinate is free: both speeds and the ratio are held")
    n, taken = len(names), modes_needed(model)
    if len(model.poles) < taken:
        there = f"{len(model.poles)} modes are below {model.frequency:g} Hz"
        raise NotPhysicalError(f"{there}, but {taken} are needed for {', '.join(names)}")
    # Between groups of modes A is zero.
    a, b, c, d = _quasi_static(model.a, model.b, model.c, model.d, taken)
    rows, scale = _rows(model, c, names)
    if taken > n:
        share, natural = _pair(rows / scale[:, None], a, n)
        rows = np.vstack([rows, share @ a / natural])
        scale = np.append(scale, 1.0)
    # With columns of unit length, because the length of a mode is arbitrary.
    scaled = rows / scale[:, None]
    lengths = np.linalg.norm(scaled, axis=0)
    condition = float(np.linalg.cond(scaled / np.where(lengths > 0.0, lengths, 1.0)))
    if not condition < WORST:
        raise NotPhysicalError(f"the condition number of {', '.join(names)} over the slow modes is {condition:.1e}, above {WORST:.0e}")
    back, modal = np.linalg.inv(rows), b
    a, b, c = rows @ a @ back, rows @ b, c @ back
    if taken > n:
        direct = share @ modal
        b[n] -= (a[n, n] + natural) * direct / natural
        a[n, n] = -natural
        a, b, c, d = _quasi_static(a, b, c, d, n)
    return replace(model, a=a, b=b, c=c, d=d, states=tuple(names), poles=sorted_poles(a), coordinates="physical")


def sorted_poles(a: Array) -> NDArray[np.complex128]:
    """Eigenvalues, the slowest first, and of each pair first the one with a positive imaginary part."""
    poles = np.linalg.eigvals(a).astype(complex)
    return poles[np.lexsort((-poles.imag, np.abs(poles).round(9)))]


def _quasi_static(a: Array, b: Array, c: Array, d: Array, n: int) -> tuple[Array, Array, Array, Array]:
    """The matrices without the states after the first n, whose derivatives are set to zero."""
    gone = np.linalg.solve(a[n:, n:], np.hstack([a[n:, :n], b[n:]]))
    of_states, of_inputs, coupling = gone[:, :n], gone[:, n:], a[:n, n:]
    return a[:n, :n] - coupling @ of_states, b[:n] - coupling @ of_inputs, c[:, :n] - c[:, n:] @ of_states, d - c[:, n:] @ of_inputs


def _rows(model: LinearModel, c: Array, names: Sequence[str]) -> tuple[Array, Array]:
    """Rows of C for the coordinates, and the magnitude of each coordinate: the speed, or 1 for ln i."""
    outputs, logs = [RATIO if name == LOG_RATIO else name for name in names], np.array([name == LOG_RATIO for name in names])
    rows = c[[model.outputs.index(output) for output in outputs]]
    values = np.array([model.values[output] for output in outputs])
    return rows / np.where(logs, values, 1.0)[:, None], np.where(logs, 1.0, np.maximum(np.abs(values), 1.0))


def _pair(rows: Array, a: Array, n: int) -> tuple[Array, float]:
    """Row p of the pair over n + 1 modes, its share of the coordinates in the direction that no slower mode has, and |λ|, 1/s."""
    normal = np.linalg.svd(rows[:, : n - 1].T, full_matrices=True)[2][-1] if n > 1 else np.ones(1)
    share = np.zeros_like(rows[0])
    share[n - 1 :] = (normal @ rows)[n - 1 :]
    return share, float(np.sqrt(np.linalg.det(a[n - 1 :, n - 1 :])))
