"""Differences of two parameter sets, as `calibrate` writes them."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from scipy.stats import norm

from pushbelt.errors import ArgumentError
from pushbelt.fmu.untrusted import InputFileError, read_json, read_parameters

CONFIDENCE = 0.95


class Difference(NamedTuple):
    name: str
    unit: str
    a: float
    b: float
    size: float  # B minus A
    deviation: float | None  # Joint standard deviation; None unless both sets have one
    relative: float | None  # Difference over the joint deviation


def differences(a: Path, b: Path) -> list[Difference]:
    """The parameters that both sets have. Raises InputFileError for a file that is no parameter set, ArgumentError without a common one."""
    one, other = _read(a), _read(b)
    rows = []
    for name in (name for name in one if name in other):
        (first, sd, unit), (second, its_sd, _) = one[name], other[name]
        joint = None if sd is None or its_sd is None else (sd**2 + its_sd**2) ** 0.5
        rows.append(Difference(name, unit, first, second, second - first, joint, joint and (second - first) / joint))
    if not rows:
        raise ArgumentError(f"{a} and {b} have no parameter in common")
    return rows


def _read(path: Path) -> dict[str, tuple[float, float | None, str]]:
    """Value, standard deviation and unit of each number."""
    values, deviations, _ = read_parameters(path)
    entries = read_json(path)["parameters"]
    for name, entry in entries.items():
        if "interval95" in entry:
            try:
                low, high = map(float, entry["interval95"])
            except (TypeError, ValueError):
                low = high = 0.0
            if not low < high:
                raise InputFileError(f"{path}: the interval95 {entry['interval95']!r} of {name} is not two ascending numbers")
            deviations[name] = (high - low) / (2.0 * float(norm.ppf(0.5 + 0.5 * CONFIDENCE)))
    return {n: (float(one), deviations.get(n), entries[n].get("unit", "")) for n, one in values.items() if type(one) in (int, float)}


def verdict(rows: Sequence[Difference]) -> str:
    """Whether the sets agree: no difference exceeds the quantile of the largest of so many normal ones (Bonferroni)."""
    tested = {row.name: abs(row.relative) for row in rows if row.relative is not None}
    others = [row.size != 0.0 for row in rows if row.relative is None]
    said = [f"{sum(others)} of {len(others)} values without two intervals differ"] * bool(others)
    if tested:
        limit = float(norm.ppf(1.0 - 0.5 * (1.0 - CONFIDENCE) / len(tested)))
        beyond = ", ".join(name for name, size in tested.items() if size > limit)
        worst = max(tested, key=lambda name: tested[name])
        text = f"the sets differ in {beyond}" if beyond else "the sets agree within their intervals"
        text += f": the largest of {len(tested)} differences is {tested[worst]:.3g} joint standard deviations, in {worst}"
        said.insert(0, f"{text}, and up to {limit:.3g} may be chance ({100.0 * CONFIDENCE:.0f} %)")
    return "; ".join(said)
