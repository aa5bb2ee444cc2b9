"""A run in ecos: start values, then steps of 1 ms with constant inputs, and some outputs after each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from pushbelt_cosim.masters import load_tbb

STEP = 1e-3  # Communication step, s
Values = Mapping[str, float]


def with_ecos(fmu: Path, start: Values, inputs: Callable[[float], Values], steps: int, outputs: Sequence[str]) -> np.ndarray:
    """Start values by name, inputs by time; rows of outputs at 0, 1, … steps."""
    load_tbb()
    from ecospy import EcosSimulation, EcosSimulationStructure

    with EcosSimulationStructure() as structure:
        structure.add_model("variator", str(fmu))
        structure.add_parameter_set("start", {f"variator::{name}": value for name, value in {**start, **inputs(0.0)}.items()})
        with EcosSimulation(structure=structure, step_size=STEP) as simulation:
            assert simulation.init(parameter_set="start")
            rows = [[simulation.get_real(f"variator::{name}") for name in outputs]]
            for k in range(steps):
                for name, value in inputs(k * STEP).items():
                    simulation.set_real(f"variator::{name}", value)
                simulation.step(1)
                rows.append([simulation.get_real(f"variator::{name}") for name in outputs])
            simulation.terminate()
    return np.array(rows)
