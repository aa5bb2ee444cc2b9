"""Writes a parameter set for a belt of your own, with checks of the ratio and of the ring's stress.

Cross-section dimensions are in mm, length, center distance and radii in m; a unit may follow any of them: 0.70, 700mm, 30mm.
The other programs read the set by `--variator FILE`.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Sequence
from typing import Any

from pushbelt import console
from pushbelt.cli.options import add_material, add_set, add_variator, material, program, quantity
from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.start_values import checked
from pushbelt.fmu.untrusted import described
from pushbelt.steel import Material

from .checks import Load, Stress, stresses
from .geometry import Belt, BeltError, Dimensions

OUT_OF_LIMITS = 3
"""Exit code if the set is written, but the ring's stress is beyond its limits, or a load case has no steady state."""


def parser() -> argparse.ArgumentParser:
    """The command line."""
    found = program("belt", __doc__, "NAME.json", fmu="the FMU that checks the set")
    mm = {"type": quantity("length", "mm", "30, 30mm or 0.03m"), "metavar": "MM"}
    m = {"type": quantity("length", "m", "0.7 or 700mm"), "metavar": "M"}
    found.add_argument("--name", default="belt", help="name of the set and of its file [default: belt]")
    belt = found.add_argument_group("the belt")
    belt.add_argument("--width", required=True, **mm, help="width of the elements, such as 24 or 30")
    belt.add_argument("--layers", type=int, required=True, metavar="N", help="layers of each of the two ring sets")
    belt.add_argument("--length", required=True, **m, help="length of the unstretched ring at its centre line")
    belt.add_argument("--center-distance", required=True, **m, help="distance of the pulley axes")
    belt.add_argument("--element-thickness", **mm, help="thickness of an element [default: 1.5]")
    belt.add_argument("--elements", type=int, metavar="N", help="number of elements [default: as many as fit]")
    belt.add_argument("--play", **mm, help="end play [default: 0.2, or what number and thickness leave]")
    belt.add_argument("--element-mass", type=float, metavar="G", help="mass of an element, g [default: from its size]")
    belt.add_argument("--element-height", **mm, help="height of an element [default: 12]")
    belt.add_argument("--layer-thickness", **mm, help="thickness of a layer [default: 0.185]")
    belt.add_argument("--layer-width", **mm, help="width of a layer [default: (width − 6)/2]")
    belt.add_argument("--pitch-offset", **mm, help="rocking edge to ring centre line [default: 0.17 and half the layers]")
    belt.add_argument("--young", type=float, metavar="GPA", help="Young's modulus of the ring, GPa [default: 186]")
    belt.add_argument("--density", type=float, metavar="KG/M3", help="density of the ring [default: 8000]")
    pulleys = found.add_argument_group("the pulleys")
    pulleys.add_argument("--wedge-angle", type=float, metavar="DEG", help="half wedge angle, degrees [default: 11]")
    pulleys.add_argument("--min-radius", **m, help="smallest pitch radius [default: 30mm]")
    pulleys.add_argument("--max-radius", **m, help="largest pitch radius [default: pulleys 4 mm apart]")
    pulleys.add_argument("--ratio", type=float, metavar="I", help="ratio r_S/r_P that the variator must reach, above 1")
    add_variator(found, "bench168", "--base")
    add_set(found)
    load = Load()
    case = found.add_argument_group("load case and strength of the ring")
    case.add_argument("--torque", type=float, default=load.torque, metavar="NM", help="primary torque [default: 100]")
    case.add_argument("--rpm", type=float, default=2000.0, help="primary speed [default: 2000]")
    case.add_argument("--safety", type=float, default=load.safety, help="of the clamping force [default: 1.3]")
    add_material(case)
    return found


def dimensions(options: argparse.Namespace) -> Dimensions:
    """Dimensions of the command line."""
    scales = {"element_mass": 1e-3, "young": 1e9, "wedge_angle": math.pi / 180.0}
    given = {name: getattr(options, name) for name in Dimensions.__dataclass_fields__}
    return Dimensions(**{name: value * scales.get(name, 1) for name, value in given.items() if value is not None})


@console.program("belt", "reports")
def main(arguments: Sequence[str] | None = None) -> int:
    """Writes the set and prints its values and checks. Returns 3 if a check of the load case fails."""
    options = parser().parse_args(arguments)
    belt = Belt(dimensions(options))
    if options.ratio is not None and not 1.0 / belt.reach <= options.ratio <= belt.reach:
        raise BeltError(
            f"ratio {options.ratio:g} is out of reach: the stops at {1e3 * belt.dimensions.min_radius:g} and {1e3 * belt.max_radius:g} mm allow "
            f"{1.0 / belt.reach:.3f} to {belt.reach:.3f}"
        )
    variables = {variable.name: variable for variable in described(options.fmu).modelVariables}
    changes = checked(variables, dict(options.set), {"parameter"})
    document = belt.document(options.name, options.variator, parameter_set(options.variator), changes)
    for name, entry in document["parameters"].items():
        entry["unit"] = variables[name].unit or "1" if name in variables else "1"
    values = checked(variables, {name: entry["value"] for name, entry in document["parameters"].items()}, {"parameter"})
    load = Load(options.torque, options.rpm * math.pi / 30.0, options.safety)
    steel = material(options)
    found = stresses(options.fmu, values, belt.reach, load, steel)
    options.output.mkdir(parents=True, exist_ok=True)
    path = options.output / f"{options.name}.json"
    path.write_text(json.dumps(document, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    print("\n".join([*_table(belt, document), "", *_checks(belt, load, steel, found), "", str(path.resolve())]))
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


def _checks(belt: Belt, load: Load, steel: Material, found: list[Stress]) -> list[str]:
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
