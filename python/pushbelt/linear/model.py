"""The linear model of the variator about a steady working point.

ẋ = A x + B u, y = C x + D u: deviations from the point, SI units. The states x are coordinates of the slow modes and have no unit,
or physical coordinates (`physical`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arguments import checks, names, number, optional, refused, text
from ..errors import ArgumentError, PushbeltError, package
from ..fmu.results import dataframe, in_notebook, item

if TYPE_CHECKING:
    import control

Array = NDArray[np.float64]
LOG_RATIO = "ln(ratio.geometric)"  # Name of the state ln i


class LinearPointError(PushbeltError, RuntimeError):
    """There is no linear model at a working point, or the point differs from the requested one."""


@dataclass(frozen=True, repr=False)
class LinearModel:
    """A linear model about a working point."""

    a: Array  # (states, states), 1/s
    b: Array  # (states, inputs)
    c: Array  # (outputs, states)
    d: Array
    """Shape (outputs, inputs): direct feedthrough, including the quasi-static response of modes that are not in A."""
    inputs: tuple[str, ...]
    """Inputs, by names of FMU variables: clamping forces (N), torques (N·m), or set points of speeds (rad/s)."""
    outputs: tuple[str, ...]  # Outputs, by names of FMU variables
    states: tuple[str, ...]
    """Names of the states; `mode1` is the slowest. An oscillatory mode has two states, such as `mode2.re` and `mode2.im`."""
    poles: NDArray[np.complex128]  # Eigenvalues of A in the order of the states, 1/s
    held: Mapping[str, float]  # Values of the inputs that hold the point
    values: Mapping[str, float]  # Outputs at the point
    units: Mapping[str, str]  # Units of inputs and outputs, and of ln i
    frequency: float  # Frequency, Hz, below which modes are states
    slip: float
    macro_slip: bool  # Whether the belt slips through at the point
    given: Mapping[str, float]  # Values of the inputs that were set at the instance
    remarks: tuple[str, ...]  # Differences of the point from the specified one
    coordinates: str = "modal"
    """`modal`, or `physical`: the states are speeds (rad/s) and the logarithm of the ratio, as deviations from the point."""
    sample_time: float | None = None  # Sample time of `ad`, `bd`, `cd`, `dd`, s

    def __post_init__(self) -> None:
        n, k, m = (len(names(name, getattr(self, name))) for name in ("states", "inputs", "outputs"))
        for name, shape in {"a": (n, n), "b": (n, k), "c": (m, n), "d": (m, k), "poles": (n,)}.items():
            if getattr(value := getattr(self, name), "shape", None) != shape:
                raise ArgumentError(refused(name, value, f"an array of the shape {shape}"))

    def __repr__(self) -> str:
        at = f"ratio {self.values['ratio.geometric']:.4g}, " if "ratio.geometric" in self.values else ""
        held = ", ".join(f"{name} {value:.4g} {self.units[name]}" for name, value in self.held.items())
        size = f"{len(self.states)} {self.coordinates} states, {len(self.inputs)} inputs, {len(self.outputs)} outputs"
        return f"<LinearModel: {at}{held}; {size}>"

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> LinearModel:
        """Creates a model from the object that the FMU's `pushbeltLinearize` returns. Raises ArgumentError for another one."""
        try:
            states, loads, readings = document["states"], document["inputs"], document["outputs"]
            n, k, m = len(states), len(loads), len(readings)
            shapes = {"A": (n, n), "B": (n, k), "C": (m, n), "D": (m, k)}
            poles = np.array(document["poles"], dtype=float).reshape(-1, 2)
            return cls(
                **{name.lower(): np.array(document[name], dtype=float).reshape(shape) for name, shape in shapes.items()},
                inputs=tuple(one["name"] for one in loads),
                outputs=tuple(one["name"] for one in readings),
                states=tuple(states), poles=poles[:, 0] + 1j * poles[:, 1],
                held={one["name"]: one["held"] for one in loads}, given={one["name"]: one["given"] for one in loads},
                values={one["name"]: one["value"] for one in readings},
                units={one["name"]: one["unit"] for one in (*loads, *readings)} | {LOG_RATIO: "1"},
                frequency=document["frequency"]["value"], slip=document["slip"], macro_slip=bool(document["macroSlip"]),
                remarks=tuple(document["remarks"]),
                coordinates=document.get("coordinates", "modal"), sample_time=document.get("sampleTime"),
            )  # fmt: skip
        except (LookupError, TypeError, ValueError, AttributeError) as error:
            raise ArgumentError(f"document is no linear model: {error!r}") from error

    def document(self) -> dict[str, Any]:
        """The object from which `of` creates a model."""
        return {
            "coordinates": self.coordinates, "sampleTime": self.sample_time, "frequency": {"unit": "Hz", "value": self.frequency},
            "inputs": [{"name": name, "unit": self.units[name], "given": self.given[name], "held": self.held[name]} for name in self.inputs],
            "outputs": [{"name": name, "unit": self.units[name], "value": self.values[name]} for name in self.outputs],
            "states": list(self.states), "poles": np.column_stack([self.poles.real, self.poles.imag]).tolist(),
            "slip": self.slip, "macroSlip": self.macro_slip, "remarks": list(self.remarks),
            **{name: matrix.tolist() for name, matrix in self._matrices().items()},
        }  # fmt: skip

    def _matrices(self) -> dict[str, Array]:
        """The matrices by their names in files; with a sample time also those in discrete time."""
        found = {name: getattr(self, name.lower()) for name in "ABCD"}
        return found if self.sample_time is None else found | dict(zip(("Ad", "Bd", "Cd", "Dd"), self.discrete(), strict=True))

    @checks(sample_time=number("s", above=0.0))
    def sampled(self, sample_time: float) -> LinearModel:
        """The model with the discrete-time matrices `ad`, `bd`, `cd`, `dd` for a sample time, s."""
        return replace(self, sample_time=sample_time)

    def discrete(self) -> tuple[Array, Array, Array, Array]:
        """A, B, C and D in discrete time, x[k+1] = A_d x[k] + B_d u[k], y[k] = C_d x[k] + D_d u[k], for inputs that are constant over
        each sample time.

        Needs scipy, `pushbelt[control]`. Raises ArgumentError without a sample time.
        """
        if self.sample_time is None:
            raise ArgumentError("the model has no sample time: use sample_time= or sampled()")
        return *self._held(np.array(self.sample_time)), self.c, self.d

    def _held(self, times: Array) -> tuple[Array, Array]:
        """exp(A t) and its integral times B: the states after times (s) under constant inputs. Also for poles at zero and double poles."""
        expm = package("scipy.linalg", "responses in time need scipy", "control").expm
        n, k = self.b.shape
        whole = np.zeros((n + k, n + k))
        whole[:n, :n], whole[:n, n:] = self.a, self.b
        grown = expm(times[..., None, None] * whole)
        return grown[..., :n, :n], grown[..., :n, n:]

    A, B, C, D = (property(attrgetter(name), doc=f"The matrix `{name}`.") for name in "abcd")
    ad, bd, cd, dd = (property(lambda self, k=k: self.discrete()[k], doc=f"{name} in discrete time.") for k, name in enumerate("ABCD"))  # type: ignore[misc]

    @checks(outputs=optional(names), inputs=optional(names))
    def select(self, outputs: Iterable[str] | None = None, inputs: Iterable[str] | None = None) -> LinearModel:
        """The model with a selection of outputs and inputs, in the given order. Raises UnknownNameError for an unknown name."""
        outputs, inputs = (own if some is None else tuple(some) for some, own in ((outputs, self.outputs), (inputs, self.inputs)))
        rows, columns = _places(outputs, self.outputs, "output"), _places(inputs, self.inputs, "input")
        d = self.d[np.ix_(rows, columns)]
        return replace(self, b=self.b[:, columns], c=self.c[rows], d=d, inputs=inputs, outputs=outputs)

    @checks(frequencies=number("rad/s", several=True))
    def response(self, frequencies: ArrayLike) -> NDArray[np.complex128]:
        """Frequency response at angular frequencies (rad/s), of the shape (frequencies, outputs, inputs).

        A model with a sample time has that of its discrete-time matrices, for inputs that are constant over each sample time. At a pole
        it is not a number.
        """
        at = 1j * np.atleast_1d(frequencies)
        a, b, c, d = (self.a, self.b, self.c, self.d) if self.sample_time is None else self.discrete()
        if self.sample_time is not None:
            at = np.exp(self.sample_time * at)
        return np.array([c @ _solved(one * np.eye(len(a)) - a, b) + d for one in at]).reshape(-1, *d.shape)

    @checks(output=text, load=text, frequency=number("rad/s"))
    def gain(self, output: str, load: str, frequency: float) -> complex:
        """One entry of the frequency response, at an angular frequency (rad/s)."""
        return complex(self.select([output], [load]).response(frequency)[0, 0, 0])

    @checks(times=number("s", least=0.0, several=True))
    def step(self, times: ArrayLike) -> Array:
        """Deviation of the outputs at times (s) after a unit step of each input, of the shape (times, outputs, inputs).

        With a sample time it is the same at its multiples, where the inputs change. Needs scipy, `pushbelt[control]`.
        """
        return self.c @ self._held(np.atleast_1d(times))[1] + self.d

    def to_control(self) -> control.StateSpace:
        """The model as a `StateSpace` of python-control, `variator`, with the names of inputs, outputs and states and `_` for their dots. Needs
        `pushbelt[control]`.

        With a sample time it is the system in discrete time.
        """
        ss = package("control", "to_control needs python-control", "control").ss
        # In python-control a dot in a name separates the system from its signal.
        plain = {key: [name.replace(".", "_") for name in getattr(self, key)] for key in ("inputs", "outputs", "states")}
        matrices = (self.a, self.b, self.c, self.d) if self.sample_time is None else (*self.discrete(), self.sample_time)
        return ss(*matrices, name="variator", **plain)

    def _repr_html_(self) -> str | None:
        rows, columns = (*self.states, *self.outputs), (*self.states, *self.inputs)
        return in_notebook(self, lambda: dataframe(np.block([[self.a, self.b], [self.c, self.d]])).set_axis(rows).set_axis(columns, axis="columns"))


def _solved(matrix: NDArray[np.complex128], right: Array) -> NDArray[Any]:
    try:
        return np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        return np.full(right.shape, np.nan, dtype=complex)


def _places(wanted: Iterable[str], there: tuple[str, ...], what: str) -> list[int]:
    places = {name: place for place, name in enumerate(there)}
    return [item(places, name, "linear model", what) for name in wanted]
