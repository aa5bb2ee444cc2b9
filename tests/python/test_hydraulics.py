"""Pressure in, flow out: in all FMUs, and the example of a circuit around one."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import fmpy
import numpy as np
import pytest
from conftest import ROOT, module_of

from pushbelt.fmu.data import parameter_set

AREA = 1.0 / 128.0
"""An area with which forces from pressures have no rounding error, m²."""
PULLEYS = ("primary", "secondary")
OUTPUTS = [
    "ratio.geometric", "loss.total", "loss.seals",
    *(f"{pulley}.{name}" for pulley in PULLEYS for name in ("clampingForceTotal", "cylinder.flow", "sheaveVelocity")),
]  # fmt: skip
START = {
    "primary.cylinder.area": AREA, "secondary.cylinder.area": AREA, "primary.torque": 40.0, "secondary.torque": -38.0,
}  # fmt: skip


def simulated(path: Path, per_force: float, name: str) -> dict[str, np.ndarray]:
    """A run whose forces, or pressures, jump and ramp."""
    times = np.array([0.0, 0.01, 0.01, 0.03, 0.05])
    forces = np.array([[13000.0, 10000.0], [13000.0, 10000.0], [13512.0, 10000.0], [13512.0, 9744.0], [13000.0, 9744.0]])
    columns = [f"{pulley}.{name}" for pulley in PULLEYS]
    rows = [(time, *(per_force * row)) for time, row in zip(times, forces, strict=True)]
    table = np.array(rows, dtype=[("time", float), *((column, float) for column in columns)])
    start = {f"{pulley}.clampingForce": 0.0 for pulley in PULLEYS} | START | dict(zip(columns, per_force * forces[0], strict=True))
    run = fmpy.simulate_fmu(str(path), stop_time=0.05, output_interval=1e-3, start_values=start, input=table, output=OUTPUTS)
    return {output: np.asarray(run[output]) for output in OUTPUTS}


@pytest.mark.parametrize("which", ["fmu", "fmu3", "map_fmu", "map_fmu3"])
def test_pressures_and_forces_give_the_same_bits(which: str, request: pytest.FixtureRequest) -> None:
    path = request.getfixturevalue(which)
    by_force, by_pressure = simulated(path, 1.0, "clampingForce"), simulated(path, 1.0 / AREA, "pressure")
    for output in OUTPUTS:
        assert np.array_equal(by_force[output], by_pressure[output]), output
    for pulley in PULLEYS:
        assert np.array_equal(by_pressure[f"{pulley}.cylinder.flow"], AREA * by_pressure[f"{pulley}.sheaveVelocity"])
    assert by_pressure["primary.cylinder.flow"].max() > 0.0


@pytest.fixture(scope="module")
def example() -> ModuleType:
    """`examples/hydraulics.py` as a module."""
    return module_of(ROOT / "examples" / "hydraulics.py")


def test_a_circuit_shifts_by_its_valves(fmu: Path, example: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stable in steps of 1 ms, and the energies of oil, sheaves and belt are balanced."""
    monkeypatch.setenv("PUSHBELT_FMU", str(fmu))
    picture = tmp_path / "hydraulics.png"
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
