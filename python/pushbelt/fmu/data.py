"""Data from `resources/`: published variators, parameter sets and the manoeuvre."""

import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import checks, file
from ..errors import ArgumentError, MissingFileError, UnknownNameError, similar
from .enumerations import BeltKind
from .files import RESOURCES
from .geometry import TwoPulleyCurve, primary_radius, theta_of
from .results import LoadCase, Trace
from .untrusted import InputFileError, read_parameters

SAFETY_RANGE = 1.0, 10.0  # Range of a safety factor of the clamping force
BELT_LENGTH = 0.2, 5.0  # Range of the length of a belt, m


def variators() -> dict[str, str]:
    """Names of the published parameter sets, and what they are."""
    return {path.stem: json.loads(path.read_text(encoding="utf-8"))["about"] for path in sorted((RESOURCES / "parameters").glob("*.json"))}


@checks(name=file)
def parameter_set(name: str | os.PathLike[str]) -> dict[str, float]:
    """Start values of the FMU for a variator, `bench168`, `belt155` or `chain168`, or from a file of that form, `….json`.

    A file that adds to another set names it as `base`: one of these names, or a file ….json beside it. The pins of a pull chain are at its
    centre line: `belt.pitchOffset` is 0 then, as in the FMU.

    Raises MissingFileError for another name, and InputFileError if the file is not a parameter set.
    """
    return _whole_set(name)[0]


@checks(name=file)
def parameter_deviations(name: str | os.PathLike[str]) -> dict[str, float]:
    """Standard deviations of a set's parameters, where its file has `deviation` beside `value`. Raises the errors of `parameter_set`."""
    return _whole_set(name)[1]


def known_deviations(name: str | os.PathLike[str]) -> dict[str, float]:
    """Those of `parameter_deviations`, for `--bands`. Raises ArgumentError if there are none."""
    if found := parameter_deviations(name):
        return found
    raise ArgumentError(f"--bands: no parameter of {name} has a known deviation")


def _whole_set(name: str | os.PathLike[str]) -> tuple[dict[str, float], dict[str, float]]:
    path = first = _set_file(os.fspath(name))
    values, deviations, base = read_parameters(path)
    seen = {path.resolve()}
    while base is not None:
        path = _set_file(str(path.parent / base) if base.endswith(".json") else base)
        if path.resolve() in seen:
            raise InputFileError(f"{first} adds to {base}, which adds to it")
        seen.add(path.resolve())
        below, wide, base = read_parameters(path)
        values, deviations = {**below, **values}, {**wide, **deviations}
    if is_chain(values):
        values["belt.pitchOffset"] = 0.0
        deviations.pop("belt.pitchOffset", None)
    return values, deviations


def _set_file(name: str) -> Path:
    is_file = name.endswith(".json")
    path = Path(name) if is_file else RESOURCES / "parameters" / f"{name}.json"
    if not path.is_file():
        there = variators()
        what, near = (f"no file {name}", "") if is_file else (f"no variator {name!r}", similar(name, there))
        raise MissingFileError(f"{what}; there are {', '.join(there)}, and files ….json{near}")
    return path


def needed(parameters: Mapping[str, float], name: str) -> float:
    """A value by name. Raises UnknownNameError if there is none."""
    if name not in parameters:
        raise UnknownNameError(f'the parameters lack {name}: a set that adds to another one names it, as in "base": "bench168"')
    return parameters[name]


def is_chain(parameters: Mapping[str, float]) -> bool:
    return parameters.get("belt.kind") == BeltKind.PULL_CHAIN


def published_data() -> dict[str, Any]:
    """The content of `variators.json`."""
    return json.loads((RESOURCES / "variators.json").read_text(encoding="utf-8"))


def curve_of(parameters: Mapping[str, float], theta: float) -> TwoPulleyCurve:
    return TwoPulleyCurve(needed(parameters, "geometry.centerDistance"), needed(parameters, "geometry.beltLength"), theta)


def pitch_radius(parameters: Mapping[str, float], ratio: float) -> float:
    """Pitch radius on the primary pulley, m, at a ratio of pitch radii r_S/r_P: that of the ring's centre line less the pitch offset."""
    distance, length, offset = (needed(parameters, name) for name in ("geometry.centerDistance", "geometry.beltLength", "belt.pitchOffset"))
    outer = ratio
    for _ in range(100):
        radius = primary_radius(theta_of(outer), distance, length) - offset
        before, outer = outer, (ratio * radius + offset) / (radius + offset)
        if abs(outer - before) < 1e-14 * outer:
            break
    return radius


def slip_torque(friction: float, wedge_angle: float, force: float, pitch_radius: float) -> float:
    """Torque at which a belt slips through on a pulley, 2 μ F r/cosβ, N·m; angle β in rad, axial force in N, radius in m."""
    return 2.0 * friction * force * pitch_radius / math.cos(wedge_angle)


def clamping_force(torque: float, pitch_radius: float, friction: float, wedge_angle: float, safety: float) -> float:
    """Clamping force that carries a torque with a safety factor: F_S = S_f |T_P| cosβ/(2 μ r_P), N. Torque in N·m,
    pitch radius on the primary pulley in m (positive), wedge angle β in rad, safety 1 or more."""
    return safety * abs(torque) / slip_torque(friction, wedge_angle, 1.0, pitch_radius)


def torque_capacity(parameters: Mapping[str, float], ratio: float, force: float) -> float:
    """Primary torque at which the belt slips through on S, 2 μ r_P F_S/cosβ, N·m: torque utilisation 1. The pitch
    radius r_P is that of the reference curve at a geometric ratio; F_S is the whole force on S (`closing`), N."""
    radius = pitch_radius(parameters, ratio)
    return slip_torque(needed(parameters, "friction.pulley"), needed(parameters, "geometry.wedgeAngle"), force, radius)


def load_cases(parameters: Mapping[str, float]) -> list[LoadCase]:
    """The nine load cases in their published order, with a safety factor of 1.3 and at least 6 kN of secondary clamping force."""
    described, cases = published_data()["loadCases"], []
    for name in described["order"]:
        ratio_name, torque = name.rsplit("-", 1)
        theta = described["theta"][ratio_name]
        radius = curve_of(parameters, theta).primary_radius - parameters["belt.pitchOffset"]
        needed = clamping_force(float(torque), radius, parameters["friction.pulley"], parameters["geometry.wedgeAngle"], safety=1.3)
        cases.append(LoadCase(ratio_name, theta, float(torque), max(needed, 6000.0)))
    return cases


def load_case_speed() -> float:
    """Primary speed of the load cases, rad/s."""
    return published_data()["loadCases"]["primarySpeedRpm"] * 2.0 * np.pi / 60.0


def manoeuvre_inputs() -> Trace:
    table = np.genfromtxt(RESOURCES / "manoeuvre.csv", delimiter=",", names=True, deletechars="", encoding="utf-8")
    time, *names = table.dtype.names or ()
    return Trace(table[time], {name: table[name] for name in names})
