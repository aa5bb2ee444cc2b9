"""Writes linear models of the variator about steady working points: A, B, C, D, for controller design.

A point is a geometric ratio `initial.ratio`, a torque `primary.torque` (N·m), a speed `initial.primarySpeed` (rad/s) and a force
`secondary.clampingForce` (N). The primary force and the secondary torque are those that hold the point. Several values define a grid:
`initial.ratio=0.5,1,2`, or `initial.ratio=0.5:2:7` for seven from 0.5 to 2. Other names are parameters of the FMU, with enumerations
by name: `ring.model=ALE0`.

Writes models.npz (numpy), models.mat (MATLAB), models.json, and report.html with Bode and step plots. A point at which
the belt slips through, or which requires other loads than the specified ones, has no model. If no point has a model, the program fails.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence

from pushbelt import console, provenance
from pushbelt.cli.options import add_variator, program
from pushbelt.linear.grid import LinearGrid
from pushbelt.linear.points import FREQUENCY, STATES
from pushbelt.variator import Variator

from . import points

OUTPUTS = ("ratio.geometric", "primary.speed", "slip")  # Default outputs of the figures
FILES = ("models.npz", "models.mat", "models.json")


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
    provenance.begin("linearize", arguments)
    asked = points.read(options.settings, options.safety)
    # Imported here, so that the help needs no packages of the extras.
    from pushbelt.report.side_by_side import progress_bar

    given = {name: getattr(options, name) for name in ("frequency", "states", "sample_time")}
    with Variator(options.variator or {}, asked.parameters, fmu=options.fmu) as variator:
        axes = asked.axes(variator)
        size = math.prod(len(values) for values in (*axes.values(), *asked.changes.values()) if isinstance(values, list))
        with progress_bar(size, "working points") as bar:
            each = {"changes": asked.changes, "after_each": lambda: bar.update(1)}
            grid = variator.linear_grid(**axes, safety=asked.safety or 1.0, **each, **given)
    return write(points.without_other_loads(grid, asked.loads), options)


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
    options.output.mkdir(parents=True, exist_ok=True)
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
