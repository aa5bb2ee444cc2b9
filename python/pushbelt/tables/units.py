"""Units of table columns in their usual spellings, and their factors to SI."""

import math
import re
import unicodedata
from collections.abc import Mapping
from functools import cache, lru_cache
from typing import Any, NamedTuple


class Unit(NamedTuple):
    """A unit: the SI value is `factor` times the number, plus `offset`."""

    factor: float
    offset: float = 0.0

    def si(self, value: Any) -> Any:
        """Value in SI."""
        return self.factor * value + self.offset


RPM = math.pi / 30.0
POUND = 4.4482216152605
FOOT = 0.3048
ATMOSPHERE = 101325.0  # Pressure that is subtracted from absolute pressures, Pa
SPELLED: Mapping[str, Mapping[str, float | Unit]] = {
    "ratio": {
        "1 - none dimensionless unitless pu ratio 1/1 -/-": 1.0,
        "% percent pct prozent vh 1/100": 0.01,
        "‰ permille": 0.001,
    },
    "speed": {
        "rad/s rad.s-1 rad.s^-1 radians/s rad/sec rad/sek": 1.0,
        "rpm 1/min /min min-1 min^-1 u/min r/min rev/min revs/min revpermin rev.min-1 tr/min upm u.min-1 u.min^-1 turns/min umdr/min": RPM,
        "krpm": 1e3 * RPM,
        "hz rps rev/s r/s u/s rev.s-1": 60.0 * RPM,
        "deg/s °/s": math.pi / 180.0,
    },
    "torque": {
        "N.m newtonmeter newtonmetre newtonmeters newtonmetres j/rad": 1.0,
        "kN.m": 1e3,
        "mN.m": 1e-3,
        "daN.m": 10.0,
        "N.cm": 0.01,
        "lbf.ft lb.ft ft.lbf ft.lb ft.lbs lbs.ft lb-ft ft-lb lbf-ft ft-lbf lbs-ft ft-lbs lb_ft ft_lb poundfeet pound-feet "
        "footpounds foot-pounds": POUND * FOOT,
        "lbf.in lb.in in.lbf in.lb in-lb lb-in": POUND * FOOT / 12.0,
        "kgf.m kg.m kp.m mkp": 9.80665,
    },
    "force": {
        "N newton newtons": 1.0,
        "kN kilonewton": 1e3,
        "MN": 1e6,
        "daN": 10.0,
        "lbf lb lbs pound-force poundforce": POUND,
        "klbf kip kips": 1e3 * POUND,
        "kgf kp": 9.80665,
    },
    "pressure": {
        "Pa pascal N/m2 N/m^2": 1.0,
        "bar bars barg bar(g) bar_g bar,g": 1e5,
        "MPa N/mm2 N/mm^2": 1e6,
        "kPa": 1e3,
        "hPa mbar": 1e2,
        "bara bar(a) bar_a barabs bar,a": Unit(1e5, -ATMOSPHERE),
        "psi psig lbf/in2 lbf/in^2": 6894.757293168,
        "psia": Unit(6894.757293168, -ATMOSPHERE),
        "kgf/cm2 kgf/cm^2 kg/cm2 kg/cm^2 kp/cm2 kp/cm^2 at": 98066.5,
    },
    "time": {
        "s sec secs second seconds sek sekunden secondes hh:mm hh:mm:ss hh:mm:sssss hh:mm:ssfff yyyy-mm-ddhh:mm:ss ddmmyyyyhh:mm:ss": 1.0,
        "ms msec": 1e-3,
        "us μs": 1e-6,
        "min": 60.0,
        "h hr hours": 3600.0,
    },
    "rate": {"1/s s-1 s^-1 /s 1/sec hz": 1.0, "1/min /min min-1 min^-1": 1.0 / 60.0},
    "velocity": {"m/s m.s-1 m.s^-1 m/sec": 1.0, "km/h kmh kph km/hr kmh-1": 1.0 / 3.6, "mph mi/h": 0.44704},
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um μm": 1e-6, "km": 1e3, "mi miles": 1609.344},
    "stress": {"Pa N/m2 N/m^2": 1.0, "MPa N/mm2 N/mm^2": 1e6, "GPa": 1e9, "kPa": 1e3},
    "temperature": {"K kelvin": 1.0, "°C c degc celsius gradc grdc": Unit(1.0, 273.15)},
    "power": {"W watt": 1.0, "kW": 1e3, "ps hp": 735.49875},
    "energy": {"J joule": 1.0, "kJ": 1e3},
    "angle": {"rad": 1.0, "deg ° degree degrees": math.pi / 180.0, "mrad": 1e-3},
    "mass": {"kg": 1.0, "g": 1e-3},
    "inertia": {"kg.m2 kg.m^2": 1.0},
    "line density": {"kg/m": 1.0, "g/m": 1e-3},
    "curvature": {"1/m m-1 m^-1": 1.0, "1/mm mm-1 mm^-1": 1e3},
    "stiffness": {"N/m": 1.0, "N/mm kN/m": 1e3, "kN/mm": 1e6},
    "bending stiffness": {"N.m2 N.m^2": 1.0, "N.mm2 N.mm^2": 1e-6},
    "angular stiffness": {"N.m/rad": 1.0, "kN.m/rad N.m/mrad": 1e3},
    "angular damping": {"N.m.s/rad": 1.0},
    "damping": {"N.s/m": 1.0, "kN.s/m N.s/mm": 1e3},
    "impulse": {"N.s": 1.0, "kN.s": 1e3},
    "area": {"m2 m^2": 1.0, "cm2 cm^2": 1e-4, "mm2 mm^2": 1e-6},
    "volume": {"m3 m^3": 1.0, "cm3 cm^3": 1e-6},
    "flow": {"m3/s m^3/s": 1.0, "l/min": 1e-3 / 60.0},
    "force by squared speed": {"N.s2/rad2 N.s^2/rad^2": 1.0},
    "other": {"l/min l/h lpm cst mm2/s A mA V mV Hz kHz Wh kWh °f degf f dB °ca yyyy-mm-dd hh:mm:ss": 1.0},
}
"""Factors, and offsets, by dimension and spellings. The first unit is the FMU's. `other` has units of no column, for rows of units."""
CONFUSED: Mapping[str, str] = {
    "speed": "rpm rad/s Hz", "torque": "N.m kN.m mN.m", "force": "N kN daN MN", "pressure": "bar Pa kPa MPa",
}  # fmt: skip
"""Units that are taken for each other, the usual ones first, where these are not the first two of the dimension."""
OF_FMU: Mapping[str, str] = {
    "N/m2": "stress", **{next(iter(groups)).split()[0]: dimension for dimension, groups in SPELLED.items()},
}  # fmt: skip
"""Dimension by the unit of a variable of the FMU."""
SIGNS = str.maketrans("−–—‐⁄÷º˚", "----//°°")  # Other signs for minus, slash and degree
PREFIXED = frozenset({"mN", "MN", "mNm", "mbar", "MPa", "ms", "mm", "mm2", "mm^2"})
"""Units with the prefix milli or mega. With the prefix in the wrong case they have no certain meaning."""


@cache
def spellings() -> Mapping[str, Mapping[str, Unit]]:
    """Units by dimension and spelling."""
    return {
        dimension: {normal(word): one if isinstance(one, Unit) else Unit(one) for words, one in groups.items() for word in words.split()}
        for dimension, groups in SPELLED.items()
    }


@lru_cache(10_000)
def normal(text: str) -> str:
    """A unit without blanks, multiplication signs and superscripts; the case is kept."""
    text = text.strip().translate(SIGNS)
    text = re.sub(r"[⁺⁻⁰¹²³⁴-⁹]+", lambda found: "^" + found.group(), text)
    text = unicodedata.normalize("NFKC", text).translate(SIGNS).strip()
    if text[:1] in "[(<":
        bracketed = r"\s*(?:\[(.*)\]|\((?![ag]\))(.*)\)|<(.*)>)\s*"
        text = re.sub(bracketed, lambda found: next(g for g in found.groups() if g is not None), text, count=1)
    text = re.sub(r"(?<=[A-Za-z])[\s.·⋅∙•・*×]+(?=[A-Za-z])", "", text)
    text = re.sub(r"\s+", "", text.replace("**", "^")).replace("^-1^", "^-1")
    return text.rstrip(".") if len(text) > 1 else text


@lru_cache(100_000)
def find(text: str, dimension: str) -> Unit | None:
    """The unit of a dimension with this spelling; None if there is none. The case matters only where it distinguishes units."""
    spelled, known = normal(text), spellings().get(dimension, {})
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
    return frozenset(dimension for dimension in SPELLED if find(text, dimension) is not None)


def usual(dimension: str) -> list[str]:
    """The usual units of a dimension, for messages; the first one is SI."""
    return [words.split()[0] for words in SPELLED[dimension]][:2]


def confused(dimension: str) -> list[str]:
    return CONFUSED[dimension].split() if dimension in CONFUSED else usual(dimension)
