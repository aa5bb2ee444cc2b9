"""Linear models over a grid of working points, between its points, and in files: `.npz`, `.mat` for MATLAB, `.json`.

The mode of the slip is some hundred times as fast as the others: A = A_s + λ r ℓ with its pole λ, its eigenvectors ℓ and r (ℓ r = 1), and
A_s of the slow modes (ℓ A_s = 0, A_s r = 0). ℓ x is nearly the slip, ω_P − i ω_S. The elements of λ r ℓ are much larger than the slow poles,
and change with the ratio. So λ, ℓ, r and A_s are interpolated, not their sum. B and C are divided in the same way.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..arguments import checks, mapping, number, refused
from ..arguments import path as a_path
from ..errors import ArgumentError, package
from ..fmu.results import dataframe
from ..fmu.untrusted import named
from .model import Array, LinearModel
from .physical import sorted_poles

if TYPE_CHECKING:
    import pandas

FASTER = 10.0  # Ratio of the fastest pole and the next one above which the fastest is interpolated by itself
ABOUT = "dx/dt = A x + B u, y = C x + D u: deviations from the working point in SI units; `held` contains the inputs that hold it"


def corners(axes: Mapping[str, Array], point: Mapping[str, float]) -> list[tuple[tuple[int, ...], float]]:
    """Points of the grid around a point, with their weights."""
    if unknown := [name for name in point if name not in axes]:
        raise ArgumentError(f"the grid has no axis {unknown[0]}; its axes are {', '.join(axes)}")
    found: list[tuple[tuple[int, ...], float]] = [((), 1.0)]
    point = {name: number()(name, value) for name, value in point.items()}
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


def interpolated(models: Sequence[tuple[LinearModel, float]]) -> LinearModel:
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
        held=named(attrgetter("held")), given=named(attrgetter("given")), values=named(attrgetter("values")),
        slip=float(mean(attrgetter("slip"))), macro_slip=any(one.macro_slip for one, _ in models),
        remarks=tuple(dict.fromkeys(remark for one, _ in models for remark in one.remarks)),
    )  # fmt: skip


def _parts(model: LinearModel) -> tuple[Array, ...] | None:
    """λ, ℓ with the coefficient 1 of the first state, r, ℓ B, C r, and A, B and C of the slow rest; None if no pole is much faster."""
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


@dataclass(frozen=True, repr=False)
class LinearGrid:
    """Linear models over a grid of working points. A grid without axes has a single point."""

    axes: Mapping[str, Array]
    """Values along each axis: `ratio` (1), `torque` (N·m), `speed` (rad/s), `force` (N), or names of parameters."""
    models: NDArray[np.object_]  # One `LinearModel` per point, or None
    reasons: NDArray[np.object_]  # Reason for each missing model; empty where there is a model

    def __post_init__(self) -> None:
        shape = tuple(map(np.size, mapping("axes", self.axes).values()))
        for name in ("models", "reasons"):
            if getattr(value := getattr(self, name), "shape", None) != shape:
                raise ArgumentError(refused(name, value, f"an array of the shape {shape}"))

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of points along each axis."""
        return self.models.shape

    def __getitem__(self, place: Any) -> Any:
        """The model at a point, by its index along each axis."""
        try:
            return self.models[place]
        except (IndexError, TypeError, ValueError, OverflowError) as error:
            raise ArgumentError(refused("place", place, f"a place in a grid of the shape {self.shape}")) from error

    def __iter__(self) -> Iterator[Any]:
        return iter(self.models)

    def points(self) -> Iterator[tuple[dict[str, float], LinearModel]]:
        """Points with a model: values by axis, and the model."""
        return ((self.point(place), model) for place, model in np.ndenumerate(self.models) if model is not None)

    def refused(self) -> Iterator[tuple[dict[str, float], str]]:
        """Points without a model: values by axis, and the reason."""
        return ((self.point(place), str(self.reasons[place])) for place, model in np.ndenumerate(self.models) if model is None)

    def point(self, place: tuple[int, ...]) -> dict[str, float]:
        """Values by axis at a point, by its index along each axis."""
        if not isinstance(place, tuple) or np.shape(self[place]) or len(place) != len(self.axes):
            raise ArgumentError(refused("place", place, f"a place in a grid of the shape {self.shape}"))
        return {name: float(values[k]) for (name, values), k in zip(self.axes.items(), place, strict=True)}

    def interpolate(self, **point: float) -> LinearModel:
        """The model between the points of a grid in physical coordinates: linear along each axis, along `ratio` in its logarithm.

        The slip's mode is interpolated by itself, because its large coefficients nearly cancel in the slow poles.
        A point needs a value for each axis with several values: `grid.interpolate(ratio=1.2, torque=45)`. Poles are those of the
        interpolated A.

        Raises ArgumentError for modal coordinates, for a value outside of the grid, and next to a point without a model.
        """
        around = corners(self.axes, point)
        missing = [place for place, _ in around if self.models[place] is None]
        if missing:
            raise ArgumentError(f"no linear model next to {point}: {self.reasons[missing[0]]}")
        return interpolated([(self.models[place], weight) for place, weight in around])

    def __repr__(self) -> str:
        axes = ", ".join(f"{name} {one.min():.4g} to {one.max():.4g} ({len(one)})" for name, one in self.axes.items())
        count = sum(model is not None for model in self.models.flat)
        return f"<LinearGrid: {axes or 'one point'}; {count} of {self.models.size} points have a model>"

    def to_dataframe(self) -> pandas.DataFrame:
        """A table with a row for each point: values by axis, held inputs, outputs, slip, and the reason for a missing model. Needs `pushbelt[maps]`."""
        rows = []
        for place, model in np.ndenumerate(self.models):
            found = {} if model is None else {f"held {name}": value for name, value in model.held.items()} | dict(model.values)
            rows.append({**self.point(place), **found, "reason": self.reasons[place]})
        return dataframe(rows)

    def to_control(self) -> NDArray[np.object_]:
        """One `control.StateSpace` of python-control per point, or None where there is no model."""
        return np.vectorize(lambda model: None if model is None else model.to_control(), otypes=[object])(self.models)

    @checks(path=a_path)
    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a file. The extension selects the format: `.npz`, `.mat` (needs scipy) or `.json`. `load_linear` reads `.npz`.

        Raises ArgumentError for another extension, or if no point has a model, MissingFileError or FileError if it cannot be written.
        """
        path = Path(path)
        writers: dict[str, Callable[[LinearGrid, Path], None]] = {".npz": _npz, ".mat": _mat, ".json": _json}
        if path.suffix not in writers:
            raise ArgumentError(f"{path}: the extension must be one of {', '.join(writers)}")
        kinds = {(model.coordinates, model.sample_time) for _, model in self.points()}
        if not kinds:
            raise ArgumentError(f"{path} was not written: there is no linear model at any point")
        if len(kinds) > 1:
            raise ArgumentError(f"{path} was not written: coordinates or sample times differ: {', '.join(map(str, kinds))}")
        writers[path.suffix](self, path)


@checks(path=a_path)
def load_linear(path: str | os.PathLike[str]) -> LinearGrid:
    """Reads the linear models of a `.npz` file of `LinearGrid.save` or `pushbelt linearize`.

    Raises InputFileError for any other file, MissingFileError or FileError if it cannot be read.
    """
    path = Path(path)
    with named(path, "a file of linear models"):
        with np.load(path, allow_pickle=False) as file:
            document = json.loads(str(file["document"]))
        axes = {name: np.array(values, dtype=float) for name, values in document["axes"].items()}
        shape = tuple(map(len, axes.values()))
        models, reasons = np.full(shape, None, dtype=object), np.full(shape, "", dtype=object)
        for place, one in zip(np.ndindex(shape), document["models"], strict=True):
            if "reason" in one:
                reasons[place] = one["reason"]
            else:
                models[place] = LinearModel.of(one)
        return LinearGrid(axes, models, reasons)


def _arrays(model: LinearModel) -> dict[str, Any]:
    """Matrices and values of a model by their names in the files."""
    named = {"held": model.inputs, "given": model.inputs, "values": model.outputs}
    return {
        **model._matrices(), "poles": model.poles,
        **{kind: np.array([getattr(model, kind)[name] for name in names]) for kind, names in named.items()},
        "states": np.array(model.states), "slip": np.array(model.slip), "macroSlip": np.array(float(model.macro_slip)),
    }  # fmt: skip


def _names(grid: LinearGrid) -> dict[str, Sequence[str]]:
    """Names and units that all models have."""
    first = next(model for _, model in grid.points())
    units = [first.units[name] for name in (*first.inputs, *first.outputs)]
    return {"inputs": first.inputs, "outputs": first.outputs, "units": units, "axes": list(grid.axes)}


def _npz(grid: LinearGrid, path: Path) -> None:
    """The text of the JSON file, and arrays over the grid, with the axes of the grid first. Missing values are NaN or empty."""
    rows = {place: _arrays(model) for place, model in np.ndenumerate(grid.models) if model is not None}

    def full(name: str) -> Array:
        values = [row[name] for row in rows.values()]
        shape, kind = np.max([value.shape for value in values], axis=0).astype(int), max(value.dtype for value in values)
        found = np.full((*grid.shape, *shape), "" if kind.kind == "U" else np.nan, dtype=kind)
        for place, value in zip(rows, values, strict=True):
            found[(*place, *map(slice, value.shape))] = value
        return found

    tables: dict[str, Any] = {name: full(name) for name in next(iter(rows.values()))}
    tables |= {f"axis.{name}": values for name, values in grid.axes.items()}
    tables |= {name: np.array(values, dtype=str) for name, values in _names(grid).items()}
    np.savez_compressed(path, about=ABOUT, document=json.dumps(_document(grid)), reasons=grid.reasons.astype(str), **tables)


def _mat(grid: LinearGrid, path: Path) -> None:
    """A cell array of structures, one per point: `ss(models{2,3}.A, models{2,3}.B, models{2,3}.C, models{2,3}.D)`."""
    savemat = package("scipy.io", ".mat files need scipy", "control").savemat
    cells = np.empty(grid.shape if grid.shape else (1,), dtype=object)
    for k, (place, model) in enumerate(np.ndenumerate(grid.models)):
        cells.flat[k] = {"reason": grid.reasons[place]}
        if model is not None:
            texts = {name: np.array(getattr(model, name), dtype=object) for name in ("states", "remarks")}
            sampled = {} if model.sample_time is None else {"sampleTime": model.sample_time}
            about = {"coordinates": model.coordinates, "macroSlip": model.macro_slip, "frequency": model.frequency}
            cells.flat[k] |= {**_arrays(model), **texts, **sampled, **about, "reason": ""}
    points = np.empty(len(grid.axes), dtype=object)
    points[:] = list(grid.axes.values())
    texts = {key: np.array(value, dtype=object) for key, value in _names(grid).items()}
    savemat(path, {"about": ABOUT, "models": cells, **texts, "points": points}, oned_as="column")


def _document(grid: LinearGrid) -> dict[str, Any]:
    rows = np.ndenumerate(grid.models)
    models = [grid.point(k) | ({"reason": grid.reasons[k]} if model is None else model.document()) for k, model in rows]
    return {"about": ABOUT, "axes": {name: values.tolist() for name, values in grid.axes.items()}, "models": models}


def _json(grid: LinearGrid, path: Path) -> None:
    path.write_text(json.dumps(_document(grid), indent=1), encoding="utf-8")
