"""Writes a parameter set for a belt of your own, with checks of the ratio and of the ring's stress.

Cross-section dimensions are in mm, length, center distance and radii in m; a unit may follow any of them: 0.70, 700mm, 30mm.
The other programs read the set by `--variator FILE`.
"""

import argparse
import dataclasses
import json
import math
import sys
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from pushbelt import console
from pushbelt.cli.options import add_material, add_set, add_variator, material, program, quantity
from pushbelt.errors import ArgumentError
from pushbelt.fmu.data import SAFETY_RANGE, parameter_set
from pushbelt.fmu.start_values import checked
from pushbelt.fmu.unit import belt_described
from pushbelt.points import SteadyStateError
from pushbelt.steel import Material, check_ranges
from pushbelt.variator import Variator

from .geometry import Belt, Dimensions

OUT_OF_LIMITS = 3
"""Exit code if the set is written, but the ring's stress is beyond its limits, or a load case has no steady state."""
UNITS: dict[str, Any] = {
    "MM": quantity("length", "mm", "30, 30mm or 0.03m"), "M": quantity("length", "m", "0.7 or 700mm"), "N": int,
    "G": quantity("mass", "g", "1.9 or 1.9g"), "GPA": quantity("stress", "GPa", "186 or 186GPa"),
    "DEG": quantity("angle", "deg", "11 or 11deg"), "KG/M3": float,
}  # fmt: skip
"""How the values of options are read, by their units."""
LOADS = {"torque": (-2000.0, 2000.0, " N.m"), "speed": (1.0, 2000.0, " rad/s"), "safety": (*SAFETY_RANGE, "")}
"""Range of each value of a load case."""
MARGIN = 0.02  # Distance of the outer ratios from the end stops, relative


def parser() -> argparse.ArgumentParser:
    found = program("belt", __doc__, "NAME.json", fmu="the FMU that checks the set")
    found.add_argument("--name", default="belt", help="name of the set and of its file [default: belt]")
    belt, pulleys = found.add_argument_group("the belt"), found.add_argument_group("the pulleys")
    for one in dataclasses.fields(Dimensions):
        group = pulleys if one.name in ("wedge_angle", "min_radius", "max_radius") else belt
        required, unit = one.default is dataclasses.MISSING, one.metadata["option"]
        word = f"--{one.name.replace('_', '-')}"
        group.add_argument(word, required=required, type=UNITS[unit], metavar=unit, help=one.metadata["help"])
    pulleys.add_argument("--ratio", type=float, metavar="I", help="ratio r_S/r_P that the variator must reach, above 1")
    add_variator(found, "bench168", "--base")
    add_set(found)
    case = found.add_argument_group("load case and strength of the ring")
    case.add_argument("--torque", type=float, default=100.0, metavar="NM", help="primary torque [default: 100]")
    speed = quantity("speed", "rpm", "2000 or 210rad/s")
    case.add_argument("--rpm", type=speed, default="2000", dest="speed", metavar="RPM", help="primary speed [default: 2000]")
    case.add_argument("--safety", type=float, default=1.3, help="of the clamping force [default: 1.3]")
    add_material(case)
    return found


class Stress(NamedTuple):
    """Stress of the ring in a steady state, Pa; or the reason for a missing one."""

    ratio: float
    force: float  # Secondary clamping force, N
    largest: float = math.nan
    equivalent: float = math.nan  # Largest amplitude without mean stress that does the damage of a pulley's cycle
    reason: str | None = None

    def passes(self, steel: Material) -> bool:
        """Whether the stress is within the strength and the fatigue limit with the safety factor."""
        return self.largest <= steel.strength / steel.safety and self.equivalent <= steel.allowed


def stresses(load: argparse.Namespace, values: Mapping[str, float], reach: float, steel: Material) -> list[Stress]:
    """Stress of the ring near both ends of the ratio's range and at ratio 1, in the load case of the options."""
    ends = reach * (1.0 - MARGIN)
    ratios = (1.0 / ends, 1.0, ends) if ends > 1.0 + MARGIN else (1.0,)
    found = []
    with Variator(dict(values), fmu=load.fmu) as variator:
        for ratio in ratios:
            force = variator.least_force(ratio, load.torque, load.safety)
            try:
                state = variator.steady(ratio, load.torque, speed=load.speed, force=force)
            except SteadyStateError as error:
                found.append(Stress(ratio, force, reason=str(error)))
                continue
            cycles = ([state[f"ring.{what}.{pulley}"] for what in ("stressAmplitude", "stressMean")] for pulley in ("primary", "secondary"))
            found.append(Stress(ratio, force, state["ring.stressMax"], max(float(steel.equivalent(*one)) for one in cycles)))
    return found


@console.program("belt", "reports")
def main(arguments: Sequence[str] | None = None) -> int:
    """Writes the set and prints its values and checks. Returns 3 if a check of the load case fails."""
    options = parser().parse_args(arguments)
    given = {one.name: getattr(options, one.name) for one in dataclasses.fields(Dimensions)}
    belt = Belt(Dimensions(**{name: value for name, value in given.items() if value is not None}))
    if options.ratio is not None and not 1.0 / belt.reach <= options.ratio <= belt.reach:
        ends = f"the stops at {1e3 * belt.dimensions.min_radius:g} and {1e3 * belt.max_radius:g} mm"
        raise ArgumentError(f"ratio {options.ratio:g} is out of reach: {ends} allow {1.0 / belt.reach:.3f} to {belt.reach:.3f}")
    variables = {variable.name: variable for variable in belt_described(options.fmu).modelVariables}
    changes = checked(variables, dict(options.set), {"parameter"})
    document = belt.document(options.name, options.variator, parameter_set(options.variator), changes)
    for name, entry in document["parameters"].items():
        entry["unit"] = variables[name].unit or "1" if name in variables else "1"
    values = checked(variables, {name: entry["value"] for name, entry in document["parameters"].items()}, {"parameter"})
    check_ranges(options, "the load case", LOADS)
    steel = material(options)
    found = stresses(options, values, belt.reach, steel)
    options.output.mkdir(parents=True, exist_ok=True)
    path = options.output / f"{options.name}.json"
    path.write_text(json.dumps(document, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    print("\n".join([*_table(belt, document), "", *_checks(belt, options, steel, found), "", str(path.resolve())]))
    return 0 if all(stress.passes(steel) for stress in found) else OUT_OF_LIMITS


def _table(belt: Belt, document: dict[str, Any]) -> list[str]:
    """Values that follow from the dimensions. Engineering values are marked by a star."""
    lines = [document["about"], ""]
    for name in belt.entries:
        entry = document["parameters"][name]
        mark = "*" if entry["origin"] == "typical" else " "
        lines.append(f"{mark} {name:31} {entry['value']:<11.5g} {entry['unit']:9} {entry.get('note', '')}".rstrip())
    others = sum(entry["origin"] == "typical" for name, entry in document["parameters"].items() if name not in belt.entries)
    return [*lines, f"* contains an engineering value; so do {others} parameters taken from the base set"]


def _checks(belt: Belt, load: argparse.Namespace, steel: Material, found: list[Stress]) -> list[str]:
    low, high = 1e-6 * steel.strength / steel.safety, 1e-6 * steel.allowed
    lines = [
        f"Ratio: {1.0 / belt.reach:.3f} to {belt.reach:.3f} between the stops",
        f"Stress of the ring at {load.torque:g} N·m and {load.speed * 30.0 / math.pi:.0f} rpm, at most {low:.0f} MPa, and as an amplitude "
        f"without mean stress at most {high:.0f} MPa:",
    ]
    for stress in found:
        at = f"  ratio {stress.ratio:.2f}, {1e-3 * stress.force:.1f} kN: "
        if stress.reason:
            lines.append(f"{at}{stress.reason}  FAILS")
        else:
            verdict = "passes" if stress.passes(steel) else "FAILS"
            lines.append(f"{at}{1e-6 * stress.largest:.0f} MPa, amplitude {1e-6 * stress.equivalent:.0f} MPa  {verdict}")
    return lines


if __name__ == "__main__":
    sys.exit(main())
