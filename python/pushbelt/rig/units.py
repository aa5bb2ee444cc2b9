"""Units of table columns in their usual spellings, and their factors to SI."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

RPM = math.pi / 30.0
ATMOSPHERE = 101325.0
"""Pressure that is subtracted from absolute pressures, Pa."""


@dataclass(frozen=True)
class Unit:
    """A unit: the SI value is `factor` times the number, plus `offset`."""

    factor: float
    offset: float = 0.0

    def si(self, value: float) -> float:
        """Value in SI."""
        return self.factor * value + self.offset


def _all(factor: float, spellings: str, offset: float = 0.0) -> dict[str, Unit]:
    return dict.fromkeys(spellings.split(), Unit(factor, offset))


POUND = 4.4482216152605
FOOT = 0.3048

# Spellings are those after `normal`: without blanks, points and multiplication signs.
SPELLINGS: Mapping[str, Mapping[str, Unit]] = {
    "ratio": {
        **_all(1.0, "1 - none dimensionless unitless pu ratio 1/1 -/-"),
        **_all(0.01, "% percent pct prozent vh 1/100"),
        **_all(0.001, "‰ permille"),
    },
    "speed": {
        **_all(1.0, "rad/s rads-1 rads^-1 radians/s rad/sec rad/sek"),
        **_all(RPM, "rpm 1/min /min min-1 min^-1 u/min r/min rev/min revs/min revpermin revmin-1 tr/min upm umin-1 umin^-1 turns/min umdr/min"),
        **_all(1e3 * RPM, "krpm"),
        **_all(60.0 * RPM, "hz rps rev/s r/s u/s revs-1"),
        **_all(math.pi / 180.0, "deg/s °/s"),
    },
    "torque": {
        **_all(1.0, "Nm newtonmeter newtonmetre newtonmeters newtonmetres j/rad"),
        **_all(1e3, "kNm"),
        **_all(1e-3, "mNm"),
        **_all(10.0, "daNm"),
        **_all(0.01, "Ncm"),
        **_all(POUND * FOOT, "lbfft lbft ftlbf ftlb ftlbs lbsft lb-ft ft-lb lbf-ft "
               "ft-lbf lbs-ft ft-lbs lb_ft ft_lb poundfeet pound-feet footpounds foot-pounds"),
        **_all(POUND * FOOT / 12.0, "lbfin lbin inlbf inlb in-lb lb-in"),
        **_all(9.80665, "kgfm kgm kpm mkp"),
    },
    "force": {
        **_all(1.0, "N newton newtons"),
        **_all(1e3, "kN kilonewton"),
        **_all(1e6, "MN"),
        **_all(10.0, "daN"),
        **_all(POUND, "lbf lb lbs pound-force poundforce"),
        **_all(1e3 * POUND, "klbf kip kips"),
        **_all(9.80665, "kgf kp"),
    },
    "pressure": {
        **_all(1.0, "Pa pascal N/m2 N/m^2"),
        **_all(1e2, "hPa mbar"),
        **_all(1e3, "kPa"),
        **_all(1e6, "MPa N/mm2 N/mm^2"),
        **_all(1e5, "bar bars barg bar(g) bar_g bar,g"),
        **_all(1e5, "bara bar(a) bar_a barabs bar,a", -ATMOSPHERE),
        **_all(6894.757293168, "psi psig lbf/in2 lbf/in^2"),
        **_all(6894.757293168, "psia", -ATMOSPHERE),
        **_all(98066.5, "kgf/cm2 kgf/cm^2 at"),
    },
    "time": {
        **_all(1.0, "s sec secs second seconds sek hh:mm hh:mm:ss hh:mm:sssss hh:mm:ssfff yyyy-mm-ddhh:mm:ss ddmmyyyyhh:mm:ss"),
        **_all(1e-3, "ms msec"), **_all(60.0, "min"), **_all(3600.0, "h hr hours"),
    },
    "rate": {**_all(1.0, "1/s s-1 s^-1 /s 1/sec hz"), **_all(1.0 / 60.0, "1/min /min min-1 min^-1")},
    "velocity": {
        **_all(1.0, "m/s ms-1 ms^-1 m/sec"),
        **_all(1.0 / 3.6, "km/h kmh kph km/hr kmh-1"),
        **_all(0.44704, "mph mi/h"),
    },
    "length": {**_all(1.0, "m"), **_all(1e-2, "cm"), **_all(1e-3, "mm"), **_all(1e-6, "um μm"), **_all(1e3, "km"), **_all(1609.344, "mi miles")},
    "stress": {**_all(1.0, "Pa N/m2 N/m^2"), **_all(1e6, "MPa N/mm2 N/mm^2"), **_all(1e9, "GPa"), **_all(1e3, "kPa")},
    "temperature": {**_all(1.0, "k kelvin"), **_all(1.0, "°c c degc celsius gradc grdc deg.c", 273.15)},
    "power": {**_all(1.0, "W watt"), **_all(1e3, "kW"), **_all(735.49875, "ps hp")},
    "energy": {**_all(1.0, "J joule"), **_all(1e3, "kJ")},
    "angle": {**_all(1.0, "rad"), **_all(1e-3, "mrad"), **_all(math.pi / 180.0, "deg ° degree degrees")},
    "mass": {**_all(1.0, "kg"), **_all(1e-3, "g")},
    "inertia": {**_all(1.0, "kgm2 kgm^2")},
    "line density": {**_all(1.0, "kg/m"), **_all(1e-3, "g/m")},
    "curvature": {**_all(1.0, "1/m m-1 m^-1"), **_all(1e3, "1/mm mm-1 mm^-1")},
    "stiffness": {**_all(1.0, "N/m"), **_all(1e3, "N/mm kN/m"), **_all(1e6, "kN/mm")},
    "bending stiffness": {**_all(1.0, "Nm2 Nm^2"), **_all(1e-6, "Nmm2 Nmm^2")},
    "angular stiffness": {**_all(1.0, "Nm/rad"), **_all(1e3, "kNm/rad Nm/mrad")},
    "angular damping": {**_all(1.0, "Nms/rad")},
    "damping": {**_all(1.0, "Ns/m"), **_all(1e3, "kNs/m Ns/mm")},
    "impulse": {**_all(1.0, "Ns"), **_all(1e3, "kNs")},
    "area": {**_all(1.0, "m2 m^2"), **_all(1e-4, "cm2 cm^2"), **_all(1e-6, "mm2 mm^2")},
    "flow": {**_all(1.0, "m3/s m^3/s"), **_all(1e-3 / 60.0, "l/min")},
    "force by squared speed": {**_all(1.0, "Ns2/rad2 Ns^2/rad^2")},
    "other": {
        **_all(1.0, "l/min l/h lpm cst mm2/s A mA V mV Hz kHz Wh kWh °f degf f dB °ca yyyy-mm-dd hh:mm:ss"),
    },
}
"""Units by dimension. `other` has units that no column here has, so that a row of units is recognised."""
PREFERRED: Mapping[str, tuple[str, ...]] = {
    "ratio": ("1", "%"),
    "speed": ("rad/s", "rpm"),
    "torque": ("N.m",),
    "force": ("N", "kN"),
    "pressure": ("Pa", "bar"),
    "time": ("s",),
    "rate": ("1/s",),
    "velocity": ("m/s", "km/h"),
    "length": ("m", "mm"),
    "stress": ("Pa", "MPa"),
    "power": ("W", "kW"),
    "energy": ("J", "kJ"),
    "angle": ("rad", "deg"),
    "mass": ("kg", "g"),
    "inertia": ("kg.m2",),
    "line density": ("kg/m", "g/m"),
    "curvature": ("1/m", "1/mm"),
    "stiffness": ("N/m", "N/mm"),
    "bending stiffness": ("N.m2",),
    "angular stiffness": ("N.m/rad",),
    "angular damping": ("N.m.s/rad",),
    "damping": ("N.s/m",),
    "impulse": ("N.s",),
    "area": ("m2", "cm2"),
    "flow": ("m3/s", "l/min"),
    "force by squared speed": ("N.s2/rad2",),
}
"""Units that messages and templates name; the first one is the SI unit as the FMU spells it."""
CONFUSED: Mapping[str, tuple[str, ...]] = {
    **PREFERRED,
    "speed": ("rpm", "rad/s", "Hz"),
    "torque": ("N.m", "kN.m", "mN.m"),
    "force": ("N", "kN", "daN", "MN"),
    "pressure": ("bar", "Pa", "kPa", "MPa"),
}
"""Units that are taken for each other, the usual ones first."""
OF_FMU: Mapping[str, str] = {
    **{units[0]: dimension for dimension, units in PREFERRED.items() if dimension != "pressure"},
    "N/m2": "stress",
}
"""Dimension by the unit of a variable of the FMU."""

SIGNS = str.maketrans({
    "\N{MINUS SIGN}": "-", "\N{EN DASH}": "-", "\N{EM DASH}": "-", "\N{HYPHEN}": "-",
    "\N{FRACTION SLASH}": "/", "\N{DIVISION SLASH}": "/", "\N{MASCULINE ORDINAL INDICATOR}": "°", "\N{RING ABOVE}": "°",
})  # fmt: skip
PREFIXED = frozenset({"mN", "MN", "mNm", "mbar", "MPa", "ms", "mm", "mm2", "mm^2"})
"""Units with the prefix milli or mega. With the prefix in the wrong case they have no certain meaning."""


@lru_cache(10_000)
def normal(text: str) -> str:
    """A unit without blanks, multiplication signs and superscripts; the case is kept."""
    text = text.strip().translate(SIGNS)
    text = re.sub(r"[⁺⁻⁰¹²³⁴-⁹]+", lambda found: "^" + found.group(), text)
    text = unicodedata.normalize("NFKC", text).translate(SIGNS).strip()
    if text[:1] in "[(<":
        bracketed = r"\s*(?:\[(.*)\]|\((?![ag]\))(.*)\)|<(.*)>)\s*"
        text = re.sub(bracketed, lambda found: next(g for g in found.groups() if g is not None), text, count=1)
    text = re.sub(r"(?<=[A-Za-z])[\s.·⋅∙•*×]+(?=[A-Za-z])", "", text)
    text = re.sub(r"\*\*", "^", text)
    text = re.sub(r"\s+", "", text)
    text = text.replace("^-1^", "^-1")
    return text.rstrip(".") if len(text) > 1 else text


@lru_cache(100_000)
def find(text: str, dimension: str) -> Unit | None:
    """The unit of a dimension with this spelling; None if there is none. The case matters only where it distinguishes units."""
    spelled, known = normal(text), SPELLINGS.get(dimension, {})
    if spelled in ("", "-"):
        return Unit(1.0) if dimension == "ratio" else None
    if spelled in known:
        return known[spelled]
    found = {name: unit for name, unit in known.items() if name.lower() == spelled.lower()}
    if any(name in PREFIXED and name[0] != spelled[0] for name in found):
        return None
    return found.popitem()[1] if len(set(found.values())) == 1 else None


@lru_cache(10_000)
def dimensions(text: str) -> frozenset[str]:
    """All dimensions that have a unit with this spelling."""
    return frozenset(dimension for dimension in SPELLINGS if find(text, dimension) is not None)


def is_unit(text: str) -> bool:
    """Whether a text is a known unit, or is written in brackets like one."""
    text = text.strip()
    return bool(dimensions(text)) or bool(re.fullmatch(r"\[[^\]]*\]|\([^)]*\)", text))


def names(dimension: str) -> str:
    """The usual units of a dimension, for messages."""
    return " or ".join(PREFERRED[dimension])
