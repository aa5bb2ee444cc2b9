"""`pushbelt.Variator` over time: tables of inputs, recording, earlier states, variables, threads and processes."""

import multiprocessing
import os
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from conftest import COARSE

import pushbelt
from pushbelt.recording import Record, Recording
from pushbelt.variator import Snapshot, Variator

TORQUE, FORCE = "primary.torque", "primary.clampingForce"
TORQUES = (20.0, 35.0, 50.0, 65.0)


def test_a_ramp_is_a_ramp_between_communication_points(fmu: Path) -> None:
    ramp = pd.DataFrame({TORQUE: [20.0, 80.0]}, index=[0.0, 0.5])
    with Variator("bench168", COARSE, fmu=fmu) as one, Variator("bench168", COARSE, fmu=fmu) as other:
        exact, coarse = one.simulate(ramp, step=1e-3)["slip"], other.simulate(ramp, step=20e-3)["slip"]
    assert np.abs(coarse - exact[coarse.index]).max() < 1e-3 * np.ptp(exact)
    assert len(coarse) == 26 and coarse.index[-1] == 0.5


def test_two_rows_of_the_same_time_are_a_step(fmu: Path, belt: Variator) -> None:
    times = [0.0, 0.02, 0.02, 0.04]
    found = belt.simulate(pd.DataFrame({TORQUE: [40.0, 40.0, 60.0, 60.0]}, index=times), step=5e-3)
    assert found[TORQUE].tolist() == [40.0] * 5 + [60.0] * 4
    with Variator("bench168", {**COARSE, TORQUE: 40.0}, fmu=fmu) as other:
        for k in range(8):
            state = other.step(5e-3, {TORQUE: 40.0 if k < 4 else 60.0})
    assert found["slip"].iloc[-1] == pytest.approx(state["slip"], rel=1e-9)
    # After a jump it can rise, and the last row can be a jump.
    rest = belt.simulate(pd.DataFrame({TORQUE: [60.0, 50.0, 70.0, 10.0]}, index=[0.04, 0.04, 0.06, 0.06]))
    assert rest[TORQUE].tolist() == [60.0, 60.0, 70.0] and belt[TORQUE] == 10.0
    for times in ([0.06, 0.06, 0.06, 0.08], [0.06] * 4):
        with pytest.raises(pushbelt.ArgumentError):
            belt.simulate(pd.DataFrame({TORQUE: [1.0, 2.0, 3.0, 4.0]}, index=times))
    # A tunable parameter has in each step the value of the middle.
    with Variator("bench168", COARSE, fmu=fmu) as other:
        other.restore(belt.snapshot())
        tuned = belt.simulate(pd.DataFrame({"friction.pulley": [0.09, 0.07]}, index=[0.06, 0.07]), step=5e-3)
        found = [other.step(5e-3, {"friction.pulley": middle})["slip"] for middle in (0.085, 0.075)]
    assert found == pytest.approx(tuned["slip"].tolist()[1:], rel=1e-9)


def test_a_constant_table_takes_no_more_work_than_steps(fmu: Path, belt: Variator) -> None:
    """The end of a step and the begin of the next have the same bits: otherwise each step would begin with a ramp."""
    belt.simulate(pd.DataFrame({TORQUE: [43.1, 43.1, 43.1], FORCE: [12345.6] * 3}, index=[0.0, 0.0333, 0.1]))
    with Variator("bench168", {**COARSE, TORQUE: 43.1, FORCE: 12345.6}, fmu=fmu) as other:
        for at in np.diff(belt.outputs["time"]):
            other.step(at)
        assert belt["solver.steps"] == other["solver.steps"]


def test_a_long_recording_fits_in_a_hundred_megabytes(belt: Variator) -> None:
    """Ten minutes in milliseconds. Whenever the memory is full, every other row goes."""
    belt.start()
    rows = 600_000
    names = ("time", *belt.outputs.dtype.names[1:])
    recording, row = Recording(names, Record()), np.zeros(len(names))
    tracemalloc.start()
    for k in range(rows + 1):
        row[0] = k * 1e-3
        recording.add(row)
    table = recording.table()
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 100e6
    assert table["time"][[0, -1]].tolist() == [0.0, rows * 1e-3]
    steps = np.diff(table["time"])
    assert np.ptp(steps[:-1]) < 1e-9 and steps[0] == pytest.approx(0.016)


def test_a_recording_has_its_columns_and_interval(fmu: Path) -> None:
    record = pushbelt.Record(columns=["time", "slip", TORQUE, "slip"], interval=4e-3)
    with Variator("bench168", COARSE, fmu=fmu, record=record) as belt:
        for _ in range(10):
            state = belt.step(1e-3)
        assert "ratio.geometric" in state
        assert belt.outputs.dtype.names == ("time", "slip", TORQUE)
        # The latest row is always there.
        assert belt.outputs["time"] == pytest.approx([0.0, 4e-3, 8e-3, 10e-3])
        belt.step(2e-3)
        assert belt.outputs["time"] == pytest.approx([0.0, 4e-3, 8e-3, 12e-3])
        state = belt.snapshot()
        run = belt.simulate(pd.DataFrame({TORQUE: [50.0, 50.0]}, index=[0.012, 0.02]), step=1e-3)
        assert list(run) == ["slip", TORQUE] and run.index.to_numpy() == pytest.approx([0.012, 0.016, 0.02])
        belt.restore(state)
        belt.step(1e-3)
        assert belt.outputs["time"] == pytest.approx([0.0, 4e-3, 8e-3, 12e-3, 13e-3])


def test_a_reset_is_a_new_variator(belt: Variator) -> None:
    belt.set({"initial.ratio": 1.2})
    first = [belt.step(2e-3, {TORQUE: 60.0}) for _ in range(3)]
    belt.reset()
    assert belt.time == 0.0 and len(belt.outputs) == 0 and belt["initial.ratio"] == 1.0 and belt[TORQUE] == 50.0
    belt.reset({"initial.ratio": 1.2})
    assert [belt.step(2e-3, {TORQUE: 60.0}) for _ in range(3)] == first
    with pytest.raises(pushbelt.StartValueError):
        belt.reset({"initial.ratio": -1.0})
    assert belt.step(2e-3)["time"] == pytest.approx(8e-3)
    for _ in range(2):
        belt.reset({TORQUE: 400.0, "secondary.torque": -400.0})
        with pytest.warns(pushbelt.VariatorWarning, match="no steady state"):
            belt.start()


def test_a_restored_state_continues_bit_for_bit(fmu: Path, belt: Variator) -> None:
    belt.step(5e-3, {TORQUE: 60.0})
    state = belt.snapshot()
    assert "0.005 s" in repr(state)
    first = [belt.step(1e-3, {FORCE: 12e3}) for _ in range(3)]
    belt.restore(state)
    assert belt.time == 5e-3 and belt[TORQUE] == 60.0 and belt[FORCE] != 12e3
    assert belt.outputs["time"].tolist() == [0.0, 5e-3]
    assert [belt.step(1e-3, {FORCE: 12e3}) for _ in range(3)] == first
    with Variator("bench168", COARSE, fmu=fmu) as other:
        other.restore(state)
        assert [other.step(1e-3, {FORCE: 12e3}) for _ in range(3)] == first
        assert len(other.outputs) == 4
        with pytest.raises(pushbelt.UnitError):
            other.restore(Snapshot(state.time, state.values, state.state[:-8]))
        assert other.step(1e-3)["time"] > first[-1]["time"]


def test_variables_are_a_typed_table(belt: Variator) -> None:
    inertia, ring, steady, slip = (belt.variables[name] for name in ("secondary.inertia", "ring.model", "initial.steady", "slip"))
    assert (inertia.causality, inertia.variability, inertia.unit, inertia.type) == ("parameter", "fixed", "kg.m2", "Real")
    assert all(isinstance(one, float) for one in (inertia.start, inertia.min, inertia.max))
    assert ring.items == {"ALE0": 1, "ALE": 2} and ring.start == 2 and inertia.items == {}
    assert steady.start is True and belt.variables["initial.equilibrium"].start is False and slip.start is None and slip.unit == "1"
    assert len(belt.variables) == len(list(belt.variables)) and "slips" not in belt.variables
    assert belt.variables.to_dataframe().loc["secondary.inertia", "start"] == inertia.start
    for one, part in ((inertia, "kg.m2"), (ring, "start ALE, one of ALE0, ALE"), (steady, "start True"), (slip, "output")):
        assert all(text in repr(one) for text in (one.name, one.description, part)) and "\n" not in repr(one)
    assert "8 inputs" in repr(belt.variables)


def test_other_units_are_named(fmu3: Path, map_fmu: Path) -> None:
    with pytest.raises(pushbelt.InputFileError, match="FMI 3.0"):
        Variator({}, fmu=fmu3)
    with pytest.raises(pushbelt.ArgumentError, match="MapVariator"):
        Variator({}, fmu=map_fmu)


def steps(fmu: Path, torque: float, state: Snapshot | None = None) -> tuple[list[float], float]:
    with Variator("bench168", COARSE, fmu=fmu) as variator:
        if state is not None:
            variator.restore(state)
        return [variator.step(2e-3, {TORQUE: torque})["slip"] for _ in range(5)], variator.steady(1.2, torque)["thrustRatio"]


def test_threads_have_variators_of_their_own(fmu: Path) -> None:
    here, expected = os.getcwd(), [steps(fmu, torque) for torque in TORQUES]
    with ThreadPoolExecutor(len(TORQUES)) as pool:
        assert list(pool.map(partial(steps, fmu), TORQUES)) == expected
    assert os.getcwd() == here


def test_spawned_processes_continue_a_state(fmu: Path, belt: Variator) -> None:
    belt.step(2e-3, {TORQUE: 40.0})
    jobs = [(fmu, torque, belt.snapshot()) for torque in (30.0, 60.0)]
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        assert pool.starmap(steps, jobs) == [steps(*job) for job in jobs]
