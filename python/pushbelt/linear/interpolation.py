"""Interpolation of linear models in physical coordinates.

The mode of the slip is some hundred times as fast as the others: A = A_s + λ r ℓ with its pole λ, its eigenvectors ℓ and r (ℓ r = 1), and
A_s of the slow modes (ℓ A_s = 0, A_s r = 0). ℓ x is nearly the slip, ω_P − i ω_S. The elements of λ r ℓ are much larger than the slow poles,
and change with the ratio. So λ, ℓ, r and A_s are interpolated, not their sum. B and C are divided in the same way.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from operator import attrgetter
from typing import Any

import numpy as np

from ..errors import ArgumentError
from .model import Array, LinearModel
from .physical import sorted_poles

FASTER = 10.0  # Ratio of the fastest pole and the next one above which the fastest is interpolated by itself

Weighted = Sequence[tuple[LinearModel, float]]


def corners(axes: Mapping[str, Array], point: Mapping[str, float]) -> list[tuple[tuple[int, ...], float]]:
    """Points of the grid around a point, with their weights."""
    if unknown := [name for name in point if name not in axes]:
        raise ArgumentError(f"the grid has no axis {unknown[0]}; its axes are {', '.join(axes)}")
    found: list[tuple[tuple[int, ...], float]] = [((), 1.0)]
    for name, values in axes.items():
        if name not in point and len(values) > 1:
            raise ArgumentError(f"a value of {name} is missing: the grid has {len(values)} values of it")
        along = _along(name, values, point.get(name, values[0]))
        found = [((*place, k), weight * share) for place, weight in found for k, share in along]
    return found


def _along(name: str, values: Array, value: float) -> list[tuple[int, float]]:
    """Neighbours of a value along an axis, with their weights."""
    order = np.argsort(values)
    low, high = values[order[[0, -1]]]
    tolerance = 1e-9 * max(abs(low), abs(high))
    if not low - tolerance <= value <= high + tolerance:
        raise ArgumentError(f"{name} = {value:g} is outside of the grid, {low:g} to {high:g}")
    at, along = (np.log(value), np.log(values)) if name == "ratio" else (value, values)
    place = float(np.interp(at, along[order], np.arange(len(values))))
    weights = {int(place): 1.0 - place % 1.0, int(np.ceil(place)): place % 1.0 or 1.0}
    return [(int(order[k]), weight) for k, weight in weights.items() if weight > 0.0]


def interpolated(models: Weighted) -> LinearModel:
    """The mean of models with weights. Raises ArgumentError if their states or inputs differ, or have no common meaning."""
    first = models[0][0]
    if first.coordinates != "physical":
        raise ArgumentError("modal coordinates differ from point to point, so they have no mean: make the grid with states='physical'")
    kind = attrgetter("inputs", "outputs", "states", "sample_time")
    if any(kind(one) != kind(first) for one, _ in models):
        raise ArgumentError("the models have different inputs, states or sample times and cannot be interpolated")

    def mean(of: Callable[[LinearModel], Any]) -> Any:
        return sum(weight * np.asarray(of(one)) for one, weight in models)

    def named(of: Callable[[LinearModel], Mapping[str, float]]) -> dict[str, float]:
        names = tuple(of(first))
        return dict(zip(names, mean(lambda one: [of(one)[name] for name in names]).tolist(), strict=True))

    a, b, c = (mean(attrgetter(name)) for name in "abc")
    parts = [_parts(one) for one, _ in models]
    if None not in parts:
        weights = [weight for _, weight in models]
        a, b, c = _matrices(*(np.tensordot(weights, np.array(each), 1) for each in zip(*parts, strict=True)))
    return replace(
        first, a=a, b=b, c=c, d=mean(attrgetter("d")), poles=sorted_poles(a),
        **{name: named(attrgetter(name)) for name in ("held", "given", "values")},
        slip=float(mean(attrgetter("slip"))),
        macro_slip=any(one.macro_slip for one, _ in models),
        remarks=tuple(dict.fromkeys(remark for one, _ in models for remark in one.remarks)),
    )  # fmt: skip


def _parts(model: LinearModel) -> tuple[Array, ...] | None:
    """λ, ℓ with the coefficient 1 of the first state, r, ℓ B, C r, and A, B and C of the slow rest; None if no pole is much faster than
    the others."""
    poles = model.poles
    if len(poles) < 2 or poles[-1].imag != 0.0 or abs(poles[-1]) < FASTER * abs(poles[-2]):
        return None
    values, vectors = np.linalg.eig(model.a)
    fast = int(np.argmax(np.abs(values)))
    left, right = np.linalg.inv(vectors)[fast].real, vectors[:, fast].real
    if left[0] == 0.0:
        return None
    right, left = right * left[0], left / left[0]
    slow = np.eye(len(left)) - np.outer(right, left)
    rest = slow @ model.a @ slow, slow @ model.b, model.c @ slow
    return np.array(values[fast].real), left, right, left @ model.b, model.c @ right, *rest


def _matrices(pole: Array, left: Array, right: Array, inputs: Array, outputs: Array, *rest: Array) -> tuple[Array, Array, Array]:
    """A, B and C. The slow rest is projected, so that the fast mode is exactly an eigenvector of A."""
    a, b, c = rest
    right = right / (left @ right)
    slow = np.eye(len(right)) - np.outer(right, left)
    return slow @ a @ slow + pole * np.outer(right, left), slow @ b + np.outer(right, inputs), c @ slow + np.outer(outputs, left)
