"""Writes linear models of the variator about steady working points: A, B, C, D, for controller design.

A point is a geometric ratio `initial.ratio`, a torque `primary.torque` (N·m), a speed `initial.primarySpeed` (rad/s) and a force
`secondary.clampingForce` (N), the whole one with spring and rotating oil, or `secondary.pressure` (Pa) with a cylinder. The primary force
or pressure and the secondary torque are those that hold the point. Several values define a grid: `initial.ratio=0.5,1,2`, or
`initial.ratio=0.5:2:7` for seven from 0.5 to 2. Other names are parameters of the FMU, with enumerations by name: `ring.model=ALE0`.

Writes models.npz (numpy), models.mat (MATLAB), models.json, and report.html with Bode and step plots. A point at which
the belt slips through has no model. If no point has a model, the program fails.
"""

import argparse
import math
import sys
from collections.abc import Sequence
from typing import Any

from pushbelt import console
from pushbelt.cli.options import add_variator, numbers, program
from pushbelt.errors import ArgumentError, require
from pushbelt.fmu.data import SAFETY_RANGE
from pushbelt.linear.grid import LinearGrid
from pushbelt.points import FREQUENCY, STATES
from pushbelt.variator import Variator

AXES = {
    "initial.ratio": "ratio", "primary.torque": "torque", "initial.primarySpeed": "speed", "secondary.clampingForce": "force",
}  # fmt: skip
"""Names of the FMU's variables, and of the corresponding axes of a grid."""
FORCE, PRESSURE = "secondary.clampingForce", "secondary.pressure"  # What gives the secondary force
REACTIONS = ("primary.clampingForce", "primary.pressure", "secondary.torque")  # Loads that hold a point
OUTPUTS = ("ratio.geometric", "primary.speed", "slip")  # Default outputs of the figures
FILES = ("models.npz", "models.mat", "models.json")


def asked(settings: Sequence[str], safety: float | None = None) -> tuple[dict[str, list[float]], dict[str, str], dict[str, list[str]]]:
    """Parses NAME=VALUE, NAME=VALUE,VALUE and NAME=FIRST:LAST:COUNT: values of `AXES`, parameters with one value, and with several ones."""
    found: dict[str, list[Any]] = {}
    for setting in settings:
        name, _, text = setting.partition("=")
        if not (name and text):
            raise ArgumentError(f"`{setting}` is not of the form NAME=VALUE")
        if name in found:
            raise ArgumentError(f"{name} appears twice")
        if name in REACTIONS:
            raise ArgumentError(f"{name} follows from the point: leave it out")
        found[name] = _values(name, text)
    points = {name: found.pop(name) for name in AXES if name in found}
    parameters = {name: words[0] for name, words in found.items() if len(words) == 1}
    changes = {name: words for name, words in found.items() if len(words) > 1}
    if safety is not None and not SAFETY_RANGE[0] <= safety <= SAFETY_RANGE[1]:
        raise ArgumentError(f"--safety {safety:g} is not within {SAFETY_RANGE[0]:g} to {SAFETY_RANGE[1]:g}")
    if PRESSURE in found:
        # A pressure beside a clamping force of 0 is the usual pair of the FMU.
        points = points if any(points.get(FORCE, [0.0])) else {name: values for name, values in points.items() if name != FORCE}
        parameters[FORCE] = "0"
    both = [name for name, given in (("--safety", safety is not None), (FORCE, FORCE in points), (PRESSURE, PRESSURE in found)) if given]
    if len(both) > 1:
        raise ArgumentError(f"{' and '.join(both)} both determine the clamping force: give one of them")
    return points, parameters, changes


def _values(name: str, text: str) -> list[Any]:
    """Numbers of a point, and numbers or texts of a parameter."""
    if name not in AXES and ":" not in text:
        return [word.strip() for word in text.split(",")]
    try:
        return list(numbers(text))
    except ValueError as error:
        raise ArgumentError(f"{name} = {text!r} is not a number, A,B,C or FIRST:LAST:COUNT with a count of at least 2") from error


def parser() -> argparse.ArgumentParser:
    found = program("linearize", __doc__, "the files and report.html")
    found.add_argument("settings", nargs="*", metavar="NAME=VALUE", help="points and parameters, in SI units")
    add_variator(found, None)
    text = "modes below this frequency are states [%(default)s]"
    found.add_argument("--frequency", type=float, default=FREQUENCY, metavar="HZ", help=text)
    text = "physical: speeds and the logarithm of the ratio, whose matrices can be interpolated over points [%(default)s]"
    found.add_argument("--states", choices=STATES, default="modal", help=text)
    text = "adds the discrete-time matrices Ad, Bd, Cd, Dd for this sample time"
    found.add_argument("--sample-time", type=float, metavar="S", help=text)
    text = "clamping force from the torque with this safety factor, instead of a specified force"
    found.add_argument("--safety", type=float, metavar="FACTOR", help=text)
    text = "outputs in the figures [%(default)s]"
    found.add_argument("--outputs", default=",".join(OUTPUTS), metavar="NAMES", help=text)
    found.add_argument("--time", type=float, default=2.0, metavar="S", help="length of the step plots [%(default)s]")
    return found


@console.program("linearize", "reports")
def main(arguments: Sequence[str] | None = None) -> int:
    options = parser().parse_intermixed_args(arguments)
    points, parameters, changes = asked(options.settings, options.safety)
    require("reports")  # The help needs no packages of the extras.
    from pushbelt.report.side_by_side import progress_bar

    given = {name: getattr(options, name) for name in ("safety", "frequency", "states", "sample_time")}
    with Variator(options.variator or {}, parameters, fmu=options.fmu) as variator:
        axes: dict[str, Any] = {axis: points.get(name, [variator[name]]) for name, axis in AXES.items()}
        # A single number of speed or force is not an axis. Without a force it is that of the safety factor or of the variator's inputs.
        axes |= {axis: axes[axis][0] for axis in ("speed", "force") if len(axes[axis]) == 1}
        axes |= {} if FORCE in points else {"force": None}
        size = math.prod(len(values) for values in (*axes.values(), *changes.values()) if isinstance(values, list))
        with progress_bar(size, "working points") as bar:
            grid = variator.linear_grid(**axes, changes=changes, after_each=lambda: bar.update(1), **given)
    return write(grid, options)


def write(grid: LinearGrid, options: argparse.Namespace) -> int:
    """Writes the models and prints the reasons for missing ones."""
    from . import report

    refused, found = list(grid.refused()), list(grid.points())
    for _, reason in refused:
        print(f"  {reason}", file=sys.stderr)
    if not found:
        print(f"no linear model at {'this point' if len(refused) == 1 else 'any point'}", file=sys.stderr)
        return 1
    if refused:
        print(f"no linear model at {len(refused)} of {len(refused) + len(found)} points", file=sys.stderr)
    path = report.write(grid, options.output, options.outputs.split(","), options.time)
    for name in FILES:
        grid.save(options.output / name)
    if len(found) == 1:
        model = found[0][1]
        for name in model.inputs:
            print(f"  {name} = {model.held[name]:.6g} {model.units[name]}")
        print(f"  slip = {100.0 * model.slip:.3f} %, macroSlip = {str(model.macro_slip).lower()}")
        print(f"  poles (1/s): {', '.join(report.pole(pole) for pole in model.poles)}")
    for written in (*(options.output / name for name in FILES), path):
        print(written.resolve())
    return 0


if __name__ == "__main__":
    sys.exit(main())
