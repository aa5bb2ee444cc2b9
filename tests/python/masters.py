"""The same run in different masters: start values, then steps of 1 ms with constant inputs, and some outputs after each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from pushbelt_cosim.masters import load_tbb
from pushbelt.fmu.unit import Archive, Instance

STEP = 1e-3
"""Communication step, s."""

Values = Mapping[str, float]
Run = Callable[[Path, Values, Callable[[float], Values], int, Sequence[str]], np.ndarray]
"""FMU, start values by name, inputs by time, number of steps, outputs: rows of outputs at 0, 1, … steps."""


def with_fmpy(
    fmu: Path, start: Values, inputs: Callable[[float], Values], steps: int, outputs: Sequence[str]
) -> np.ndarray:
    """fmpy, call by call."""
    with Archive.unpack(fmu) as archive, Instance(archive, {**start, **inputs(0.0)}) as unit:
        unit.initialise()
        reals = unit.reals(outputs)
        rows = [unit.get_reals(reals)]
        for k in range(steps):
            unit.set(inputs(k * STEP))
            unit.step_to((k + 1) * STEP)
            rows.append(unit.get_reals(reals))
    return np.array(rows)


def with_libcosim(
    fmu: Path, start: Values, inputs: Callable[[float], Values], steps: int, outputs: Sequence[str]
) -> np.ndarray:
    """libcosim of the Open Simulation Platform."""
    from libcosimpy.CosimEnums import CosimVariableType
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(step_size=round(STEP * 1e9))
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=str(fmu), instance_name="libcosim"))
    found = execution.slave_variables(slave_index=slave)
    variables = {variable.name.decode(): variable for variable in found}
    for name, value in {**start, **inputs(0.0)}.items():
        variable = variables[name]
        setter = {
            CosimVariableType.REAL.value: execution.real_initial_value,
            CosimVariableType.INTEGER.value: execution.integer_initial_value,
            CosimVariableType.BOOLEAN.value: execution.boolean_initial_value,
        }[variable.type]
        assert setter(slave, variable.reference, value), name
    override = CosimManipulator.create_override()
    observer = CosimObserver.create_last_value()
    assert execution.add_manipulator(manipulator=override)
    assert execution.add_observer(observer=observer)
    references = [variables[name].reference for name in outputs]
    rows = []
    for k in range(steps):
        values = inputs(k * STEP)
        names = list(values)
        assert override.slave_real_values(
            slave, [variables[name].reference for name in names], [values[name] for name in names]
        )
        assert execution.step()
        rows.append(observer.last_real_values(slave, references))
    # libcosim has no outputs before its first step.
    return np.array([[np.nan] * len(outputs), *rows])


def with_ecos(
    fmu: Path, start: Values, inputs: Callable[[float], Values], steps: int, outputs: Sequence[str]
) -> np.ndarray:
    """ecos."""
    load_tbb()
    from ecospy import EcosSimulation, EcosSimulationStructure

    with EcosSimulationStructure() as structure:
        structure.add_model("variator", str(fmu))
        structure.add_parameter_set(
            "start", {f"variator::{name}": value for name, value in {**start, **inputs(0.0)}.items()}
        )
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
