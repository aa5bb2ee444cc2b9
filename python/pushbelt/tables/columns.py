"""Columns that a rig's table may have, and the template of a table."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ..fmu.files import RESOURCES
from . import units
from .names import Column

NAME, SERIES, STEP, TIME = "name", "series", "step", "time"
SHIFTS = ("di/dt", "ds/dt")  # Quantities of a point whose ratio changes
SAMPLED = "ratio.geometric"  # Quantity of a recorded shift
ENDS = {"primary": "P 1 pri prim primary in an DR", "secondary": "S 2 sec sek secondary out ab DN"}
"""What follows a letter such as n in the name of a quantity of a pulley; the first two also follow a word."""
HIGHEST = 1.0
"""Largest efficiency. In overrun the output over the input of the driving direction may be given, which is above 1."""
REQUIRED = ("primary.speed", "primary.torque", "secondary.clampingForce")
POWER = "power ratio"  # Driven power/driving power by the direction of the primary torque, also above 1
PARTS = {
    "thrustRatio": ("primary.clampingForce", "secondary.clampingForce"),
    "slip": ("ratio.geometric", "ratio.speed"),
    "efficiency": ("primary.torque", "secondary.torque", "ratio.speed"),
    "ratio.speed": ("primary.speed", "secondary.speed"),
}
"""Columns from which a quantity is computed, as products and quotients."""
SURE = 3.0  # Standard deviations by which an efficiency may be above `HIGHEST`
RECORDED = ("primary.speed", "primary.torque", "primary.clampingForce", "secondary.clampingForce", SAMPLED)
"""Columns of recorded shifts besides series and time."""
EXAMPLES = RESOURCES / "calibrate-template.csv"
"""Header and lines of the template, with results of the model. Written by `fmu-build/python/page_programs.py`."""


@dataclass(frozen=True)
class Quantity(Column):
    """A column that is measured and compared with the model."""

    absolute: float = 0.0  # Default standard deviation, SI: the root of the sum of squares of this value …
    relative: float = 0.0  # … and this share of the measured value

    def assumed(self, value: float) -> float:
        """Default standard deviation, SI."""
        return math.hypot(self.absolute, self.relative * value)


def _of_both(dimension: str, low: float, high: float, name: str, letters: str, words: str, meanings: Mapping[str, str]) -> dict[str, Column]:
    """A quantity of both pulleys, with its common names."""
    found = {}
    for pulley, meaning in meanings.items():
        ends = ENDS[pulley].split()
        symbols = [f"{letter}{end}" for letter in letters.split() for end in ends]
        symbols += [f"{end} {letter}" for letter in letters.split() for end in ends if len(end) > 2]
        spelled = [f"{word} {end}" for word in words.split(", ") for end in ends[:2]]
        found[f"{pulley}.{name}"] = Column(dimension, low, high, meaning, (*symbols, *spelled))
    return found


CONDITIONS: Mapping[str, Column] = {
    "ratio.geometric": Column(
        "ratio", 0.1, 10.0, "r_S/r_P, above 1 is underdrive",
        ("geometric ratio", "i_geo", "i_geom", "r_S/r_P", "r2/r1", "pulley ratio", "geometrische Übersetzung", "Radienverhältnis",
         "rapport géométrique"),
    ),
    "ratio.speed": Column(
        "ratio", 0.1, 10.0, "primary speed/secondary speed, in place of ratio.geometric",
        ("i", "speed ratio", "i_speed", "n_P/n_S", "n1/n2", "n_in/n_out", "n_an/n_ab", "ratio", "gear ratio", "transmission ratio", "CVT ratio",
         "variator ratio", "Übersetzung", "Uebersetzung", "Übersetzungsverhältnis", "Drehzahlverhältnis", "rapport",
         "rapport de transmission", "rapport des vitesses"),
    ),
    **_of_both("speed", 1.0, 2000.0, "speed", "n w omega N", "speed, rpm, Drehzahl", {
        "primary": "speed of the primary pulley",
        "secondary": "speed of the secondary pulley; gives the speed ratio, and with ratio.geometric the slip",
    }),
    **_of_both("torque", -5000.0, 5000.0, "torque", "T M Trq", "torque, moment, Drehmoment", {
        "primary": "torque on the primary shaft, negative in overrun",
        "secondary": "torque on the secondary shaft, of any sign; gives the efficiency",
    }),
    **_of_both(
        "force", 100.0, 5e5, "clampingForce", "F Fax Fcl", "clamping force, force, axial force, clampForce, Anpresskraft, Axialkraft", {
            "secondary": "clamping force of the secondary pulley",
            "primary": "clamping force of the primary pulley; needed for a shift, else it gives the thrust ratio",
        },
    ),
    **_of_both("pressure", 0.0, 2e7, "pressure", "p", "pressure, oil pressure, Druck", {
        "secondary": "oil pressure in place of the secondary force; needs secondary.cylinder.area",
        "primary": "oil pressure in place of the primary force; needs primary.cylinder.area",
    }),
}  # fmt: skip
QUANTITIES: Mapping[str, Quantity] = {
    "thrustRatio": Quantity(
        "ratio", 0.05, 20.0, "primary force/secondary force that holds the ratio",
        ("thrust ratio", "F_P/F_S", "F1/F2", "zeta", "KpKs", "Kp/Ks", "force ratio", "clamping force ratio", "Kraftverhältnis"),
        relative=0.01,
    ),
    "slip": Quantity(
        "ratio", -0.5, 0.5, "1 - secondary speed/primary speed * ratio.geometric",
        ("belt slip", "slip ratio", "nu", "Schlupf", "Riemenschlupf", "glissement"), absolute=5e-4, relative=0.05,
    ),
    "efficiency": Quantity(
        "ratio", 0.01, 10.0, "driven power/driving power, at most 1", ("eta", "eff", "Wirkungsgrad", "rendement"), absolute=3e-3
    ),
    "di/dt": Quantity("rate", -100.0, 100.0, "shift rate, i = ratio.geometric", ("didt",), absolute=0.01, relative=0.05),
    "ds/dt": Quantity("rate", -100.0, 100.0, "shift rate, s = 1/ratio.geometric", ("dsdt",), absolute=0.01, relative=0.05),
}  # fmt: skip
MEASURED: Mapping[str, Quantity] = {
    **QUANTITIES,
    SAMPLED: Quantity("ratio", 0.1, 10.0, "ratio r_S/r_P during recorded shifts", absolute=2e-3, relative=0.01),
}
"""All quantities that are compared with the model, in the order of the report."""
COLUMNS: Mapping[str, Column] = {
    **CONDITIONS,
    **QUANTITIES,
    NAME: Column("text", 0.0, 0.0, "a name for the report", ("label", "point name", "operating point", "Bezeichnung")),
    SERIES: Column("text", 0.0, 0.0, "name of a recorded shift; with time, each of its rows is a sample", ("shift", "run", "series no")),
    STEP: Column(
        "text", 0.0, 0.0, "number of a step of the program, whose rows are averaged",
        ("step no", "step number", "step id", "Stufe", "Laststufe", "Schritt", "Prüfschritt", "étape", "palier", "stage"),
    ),
    TIME: Column(
        "time", -1e12, 1e19, "time of a sample: of a recorded shift, or of a time series whose plateaus are the points",
        ("t", "timestamp", "time stamp", "Zeit", "Uhrzeit", "Zeitstempel", "date", "date time", "Datum", "Datum Uhrzeit",
         "t_rel", "t_abs", "elapsed time",
         "relative time", "X_Value", "master", "Sekunden", "seconds", "Messzeit", "Laufzeit", "temps"), "s",
    ),
}  # fmt: skip


def template() -> str:
    """Text of the template: every column with its meaning, and example lines."""
    lines = [
        "# Table for `cargo fmu calibrate`: one steady point per line. Replace the lines below the header.",
        "# Empty cells are allowed. Unused columns can be removed, and their order is free.",
    ]
    for title, columns in (("Conditions", CONDITIONS), ("Measured quantities, any of", QUANTITIES)):
        lines.append(f"# {title}:")
        for name, one in columns.items():
            lines.append(f"#     {name} [{' or '.join(units.usual(one.dimension))}]: {one.meaning}".replace(",", ";"))
    lines.append("#     ….sd: standard deviation of a measured column; the default is an assumed one")
    lines.append("# Recorded shifts are another table: series; time [s]; " + "; ".join(RECORDED))
    return "\n".join([*lines, EXAMPLES.read_text(encoding="utf-8")])
