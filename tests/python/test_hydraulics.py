"""The example of a hydraulic circuit around the FMU."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, module_of

from pushbelt.fmu.data import parameter_set

PULLEYS = ("primary", "secondary")


def test_a_circuit_shifts_by_its_valves(fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stable in steps of 1 ms, and the energies of oil, sheaves and belt are balanced."""
    monkeypatch.setenv("PUSHBELT_FMU", str(fmu))
    example, picture = module_of(ROOT / "examples" / "hydraulics.py"), tmp_path / "hydraulics.png"
    trace, pressures, energies = example.main(str(picture))
    assert picture.stat().st_size > 10_000
    at = {time: trace["ratio.geometric"][round(time / example.STEP)] for time in (0.3, 0.8, 1.3, 1.9)}
    assert at[0.8] < at[0.3] - 0.1 and at[1.9] > at[1.3] + 0.05
    held = pressures[round(2.3 / example.STEP) :, 1]
    assert np.abs(np.diff(held, 2)).max() < 1e-4 * held.mean(), "no ripple"
    spent = ("relief", "valves", *PULLEYS, "stored")
    assert energies["pump"] == pytest.approx(sum(energies[name] for name in spent), abs=1e-6)
    for pulley in PULLEYS:
        assert energies[f"{pulley} sheave"] == pytest.approx(energies[pulley], rel=5e-3)
    assert abs(energies["belt"]) < 1e-3 * example.STEP * trace["primary.power"].sum()


def test_the_example_cylinders_follow_from_their_radii() -> None:
    """As docs/hydraulics.md derives it; the secondary one has a compensation chamber."""

    def centrifugal(inner: float, outer: float, fill: float) -> float:
        square = outer**2 - inner**2
        return np.pi * 850.0 * square * (0.25 * (outer**2 + inner**2) - 0.5 * fill**2)

    values = parameter_set(str(ROOT / "resources" / "bench168-cylinders.json"))
    for pulley, outer in (("primary", 71.3e-3), ("secondary", 61.8e-3)):
        assert values[f"{pulley}.cylinder.area"] == pytest.approx(np.pi * (outer**2 - 25e-3**2), rel=4e-3)
    assert values["primary.cylinder.centrifugal"] == pytest.approx(centrifugal(25e-3, 71.3e-3, 12e-3), rel=4e-3)
    secondary = centrifugal(25e-3, 61.8e-3, 12e-3) - centrifugal(20e-3, 62.5e-3, 0.0)
    assert values["secondary.cylinder.centrifugal"] == pytest.approx(secondary, rel=0.02)
