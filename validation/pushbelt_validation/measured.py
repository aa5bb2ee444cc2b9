"""Measurements of pushbelts from `measured.json`, and sources of the goals."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from .outcome import Source

FILE = Path(__file__).with_name("measured.json")


@lru_cache(maxsize=1)
def data() -> dict[str, Any]:
    """Content of the file."""
    return json.loads(FILE.read_text(encoding="utf-8"))


def source(key: str | int) -> Source:
    """Source and certainty of an entry by its name, or of one of the bounds by its number."""
    entry = data()["bounds"][key] if isinstance(key, int) else data()[key]
    return Source(entry["source"], entry["certainty"])


def cause(key: str) -> tuple[str, str]:
    """Cause of a missed goal as far as known, and what decides it on a rig."""
    entry = data()["causes"].get(key, {})
    return entry.get("cause", "not known"), entry.get("decides", "not known")


THEORY = Source(
    "Carbone, Mangialardi, Mantriota, J. Mech. Des. 127 (2005) 103-113, solved independently",
    "theory of a continuous belt; computed",
)
"""The continuum theory."""
ESTIMATE = Source("engineering value", "estimate, no measurement of a variator alone is public")
"""Not published."""
OWN = Source("requirement of this model", "follows from what its parameters mean")
"""Effect of an uncertain parameter."""


def opening(force: float) -> float:
    """Deformation Δ of the laboratory rig's sheaves, rad, at a clamping force in N: fitted at 20 and 30 kN."""
    return (1.0 + 0.02 * (force / 1e3 - 20.0)) * 1e-3


@dataclass(frozen=True)
class MapPoint:
    """A measured point of a whole transmission."""

    ratio: float
    """Geometric ratio r_S/r_P."""
    rpm: float
    """Primary speed."""
    torque: float
    """Primary torque, N·m."""
    efficiency: float


def transmission_map() -> list[MapPoint]:
    """All points of the measured transmission."""
    by_ratio = data()["transmissionMap"]["byRatio"]
    return [MapPoint(float(ratio), *map(float, point)) for ratio, points in by_ratio.items() for point in points]
