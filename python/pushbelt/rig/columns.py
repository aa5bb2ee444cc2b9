"""Columns that a rig's table may have, and the template of a table."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from . import units
from .measured import SAMPLED
from .titles import Column


@dataclass(frozen=True)
class Quantity(Column):
    """A column that is measured and compared with the model."""

    absolute: float = 0.0
    """Default standard deviation, SI: the root of the sum of squares of this value …"""
    relative: float = 0.0
    """… and this share of the measured value."""

    def assumed(self, value: float) -> float:
        """Default standard deviation, SI."""
        return math.hypot(self.absolute, self.relative * value)


def _spelled(quantity: str, *words: str) -> dict[str, tuple[str, ...]]:
    """Common names of a quantity of both pulleys."""
    ends = {"primary": ("P", "1", "pri", "prim", "primary", "in", "an", "DR"), "secondary": ("S", "2", "sec", "sek", "secondary", "out", "ab", "DN")}
    short = {"primary": ("P", "1"), "secondary": ("S", "2")}
    return {
        pulley: (
            *(f"{letter}{end}" for letter in quantity.split() for end in ends[pulley]),
            *(f"{word} {end}" for word in words for end in short[pulley]),
        )
        for pulley in ends
    }


_SPEEDS = _spelled("n w omega N", "speed", "rpm", "Drehzahl")
_TORQUES = _spelled("T M Trq", "torque", "moment", "Drehmoment")
_FORCES = _spelled("F Fax Fcl", "clamping force", "force", "axial force", "clampForce", "Anpresskraft", "Axialkraft")
_PRESSURES = _spelled("p", "pressure", "oil pressure", "Druck")

NAME, SERIES, TIME = "name", "series", "time"
CONDITIONS: Mapping[str, Column] = {
    "ratio.geometric": Column(
        "ratio", 0.1, 10.0, "r_S/r_P, above 1 is underdrive",
        ("geometric ratio", "i_geo", "i_geom", "r_S/r_P", "r2/r1", "pulley ratio", "geometrische Übersetzung", "Radienverhältnis"),
    ),
    "ratio.speed": Column(
        "ratio", 0.1, 10.0, "primary speed/secondary speed, in place of ratio.geometric", 
        ("i", "speed ratio", "i_speed", "n_P/n_S", "n1/n2", "n_in/n_out", "n_an/n_ab", "ratio", "gear ratio", "transmission ratio", "CVT ratio",
         "variator ratio", "Übersetzung", "Uebersetzung", "Übersetzungsverhältnis", "Drehzahlverhältnis"),
    ),
    "primary.speed": Column("speed", 1.0, 2000.0, "speed of the primary pulley", _SPEEDS["primary"]),
    "secondary.speed": Column(
        "speed", 1.0, 2000.0, "speed of the secondary pulley; gives the speed ratio, and with ratio.geometric the slip", _SPEEDS["secondary"]
    ),
    "primary.torque": Column("torque", -5000.0, 5000.0, "torque on the primary shaft, negative in overrun", _TORQUES["primary"]),
    "secondary.torque": Column(
        "torque", -5000.0, 5000.0, "torque on the secondary shaft, of any sign; gives the efficiency", _TORQUES["secondary"]
    ),
    "secondary.clampingForce": Column("force", 100.0, 5e5, "clamping force of the secondary pulley", _FORCES["secondary"]),
    "primary.clampingForce": Column(
        "force",
        100.0,
        5e5,
        "clamping force of the primary pulley; needed for a shift, else it gives the thrust ratio",
        _FORCES["primary"],
    ),
    "secondary.pressure": Column(
        "pressure", 0.0, 2e7, "oil pressure in place of the secondary force; needs secondary.cylinder.area", _PRESSURES["secondary"]
    ),
    "primary.pressure": Column("pressure", 0.0, 2e7, "oil pressure in place of the primary force; needs primary.cylinder.area", _PRESSURES["primary"]),
}
HIGHEST = 1.0
"""Largest efficiency. In overrun the output over the input of the driving direction may be given, which is above 1."""
QUANTITIES: Mapping[str, Quantity] = {
    "thrustRatio": Quantity(
        "ratio", 0.05, 20.0, "primary force/secondary force that holds the ratio",
        ("thrust ratio", "F_P/F_S", "F1/F2", "zeta", "KpKs", "Kp/Ks", "force ratio", "clamping force ratio", "Kraftverhältnis"), None, 0.0, 0.01
    ),
    "slip": Quantity(
        "ratio", -0.5, 0.5, "1 - secondary speed/primary speed * ratio.geometric",
        ("belt slip", "slip ratio", "nu", "Schlupf", "Riemenschlupf"), None, 5e-4, 0.05
    ),
    "efficiency": Quantity("ratio", 0.01, 1e3, "driven power/driving power, at most 1", ("eta", "eff", "Wirkungsgrad"), None, 3e-3, 0.0),
    "di/dt": Quantity("rate", -100.0, 100.0, "shift rate, i = ratio.geometric", ("didt",), None, 0.01, 0.05),
    "ds/dt": Quantity("rate", -100.0, 100.0, "shift rate, s = 1/ratio.geometric", ("dsdt",), None, 0.01, 0.05),
}
MEASURED: Mapping[str, Quantity] = {
    **QUANTITIES,
    SAMPLED: Quantity("ratio", 0.1, 10.0, "ratio r_S/r_P during recorded shifts", (), None, 2e-3, 0.01),
}
"""All quantities that are compared with the model, in the order of the report."""
OTHERS: Mapping[str, Column] = {
    NAME: Column("text", 0.0, 0.0, "a name for the report", ("label", "point name", "operating point", "Bezeichnung")),
    SERIES: Column("text", 0.0, 0.0, "name of a recorded shift; with time, each of its rows is a sample", ("shift", "run", "series no")),
    TIME: Column(
        "time", -1e12, 1e19, "time of a sample: of a recorded shift, or of a time series whose plateaus are the points",
        ("t", "timestamp", "time stamp", "Zeit", "Uhrzeit", "Zeitstempel", "date", "date time", "Datum", "Datum Uhrzeit"), "s",
    ),
}
COLUMNS: Mapping[str, Column] = {**CONDITIONS, **QUANTITIES, **OTHERS}
REQUIRED = ("primary.speed", "primary.torque", "secondary.clampingForce")
CHANNELS = tuple(CONDITIONS)
"""Columns whose changes end a plateau of a time series."""
POWER = "power ratio"
"""Driven power/driving power by the direction of the primary torque, also above 1."""
PARTS = {
    "thrustRatio": ("primary.clampingForce", "secondary.clampingForce"),
    "slip": ("ratio.geometric", "primary.speed", "secondary.speed"),
    "efficiency": ("primary.speed", "secondary.speed", "primary.torque", "secondary.torque"),
}
"""Columns from which a quantity is computed, as products and quotients."""
RECORDED = ("primary.speed", "primary.torque", "primary.clampingForce", "secondary.clampingForce", SAMPLED)
"""Columns of recorded shifts besides series and time."""


EXAMPLES = (
    ("underdrive", 2, 1500, 60, 14, "", 1.05, 0.8, "", "", ""),
    ("ratio 1", 1, 2000, 50, 9, "", 1.37, "", 0.05, 97.1, ""),
    ("overdrive", 0.5, 2000, 40, 10, 18.1, "", 0.3, 0.05, "", ""),
    ("upshift", 1, 1000, 0, 20, 26, "", "", "", "", 0.45),
)
"""Template of a table."""


def template() -> str:
    """Text of the template: every column with its meaning, and example lines."""
    header = (
        "name,ratio.geometric,primary.speed [rpm],primary.torque [N.m],secondary.clampingForce [kN],"
        "primary.clampingForce [kN],thrustRatio,slip [%],slip.sd [%],efficiency [%],ds/dt [1/s]"
    )
    return "\n".join(
        (
            "# Table for `cargo fmu calibrate`: one steady point per line. Replace the lines below the header.",
            "# Empty cells are allowed. Unused columns can be removed, and their order is free.",
            *_described("Conditions", CONDITIONS),
            *_described("Measured quantities, any of", QUANTITIES),
            f"# {' ' * 4}….sd: standard deviation of a measured column; the default is an assumed one",
            "# Recorded shifts are another table: series; time [s]; " + "; ".join(RECORDED),
            header,
            *(",".join(map(str, line)) for line in EXAMPLES),
            "",
        )
    )


def _described(title: str, columns: Mapping[str, Column]) -> Iterable[str]:
    yield f"# {title}:"
    for name, column in columns.items():
        yield f"# {' ' * 4}{name} [{units.names(column.dimension)}]: {column.meaning}".replace(",", ";")
