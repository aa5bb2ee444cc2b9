"""Calls that a user of fmpy, pandas, xarray or python-control tries before reading the documentation."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import pushbelt
from pushbelt import Variator

mpl = pytest.importorskip("matplotlib")
mpl.use("Agg")
GUESSES = """
v.set("primary.torque", 60.0); assert v["primary.torque"] == 60.0
v["initial.ratio"] = 1.2; assert v.start()["ratio.geometric"] == pytest.approx(1.2, abs=1e-6)
v.step(0.001); v["primary.torque"] = 60.0; assert v.inputs["primary.torque"] == 60.0
assert 0.0 < v["slip"] < 0.1 and v["slip"] == v.outputs["slip"][-1]
assert v.get("slip") == v["slip"]
assert v.profile().push_force.max() > 0.0
assert {"primary.torque", "secondary.clampingForce"} <= set(v.inputs)
v.inputs["primary.torque"] = 60.0; assert v["primary.torque"] == 60.0
v.inputs.update({"primary.torque": 60.0}); assert v["primary.torque"] == 60.0
run = v.run(0.02); assert run.index[-1] == 0.02 and run["slip"].iloc[-1] == v["slip"]
run = v.run(0.02, {"primary.torque": 60.0}); assert v.time == 0.02 and v["primary.torque"] == 60.0
run = v.run(0.02, inputs={"primary.torque": 60.0}, step=0.005, outputs=["slip"]); assert run.shape == (5, 1)
v.step(0.001); v.run(duration=0.01); assert len(v.run(0.01)) == 2
assert (v.run(0.02).columns == v.simulate(pd.DataFrame({"time": [0.02, 0.03], "primary.torque": [50.0, 60.0]})).columns).all()
assert v.run(0.01)[["slip", "ratio.geometric"]].plot(subplots=True).size == 2
v.run(0.01); assert v.plot("slip").size == 1
assert "primary.torque" in v._repr_html_(); v.start(); assert "slip" in v._repr_html_() and "<table" in v._repr_html_()
assert v.variables["slip"].unit == "1" and "unit" in v.variables.to_dataframe()
assert "bench168" in pushbelt.variators() and "TU Eindhoven" in pushbelt.variators()["bench168"]
assert all(Variator(name)["belt.play"] > 0.0 for name in pushbelt.variators())
assert isinstance(state, pushbelt.SteadyState) and isinstance(state.profile, pushbelt.Profile) and isinstance(bands, pushbelt.Bands)
assert isinstance(model, pushbelt.LinearModel) and isinstance(v.linear_grid(ratio=1.0, torque=30.0, force=9e3), pushbelt.LinearGrid)
assert state.plot().size == 6 and state.profile.plot("push_force")[0].get_xlabel() == "position"
assert "<table" in state._repr_html_() and "efficiency" in state._repr_html_()
assert bands["slip"] > 0.0 and "<table" in bands._repr_html_()
assert maps.sizes == {"ratio": 2, "torque": 2} and maps.sel(ratio=1.0, torque=30.0)["slip"] > 0.0
assert v.thrust_map(1.0, [20.0, 30.0], force=9e3)["slip"].shape == (1, 2)
assert maps.attrs["variator"] == "bench168" and maps.attrs["version"] == pushbelt.__version__
assert maps["primary.speed"].units == "rad/s" and maps.torque.units == "N.m" and maps["speed"] == 200.0
assert maps["thrustRatio"].plot() is not None
maps.to_netcdf(folder / "maps.nc"); assert (folder / "maps.nc").stat().st_size > 0
assert v.linear_grid(ratio=[0.9, 1.2], torque=[30.0], force=9e3).shape == (2, 1)
assert model.A.shape == (len(model.states),) * 2 and model.C.shape == (len(model.outputs), len(model.states))
assert np.array_equal(model.B, model.b) and np.array_equal(model.D, model.d)
assert model.to_control().name == "variator" and "ratio_geometric" in model.to_control().output_labels
assert model.to_control()["ratio_geometric", "primary_torque"].nstates == len(model.A)
assert "mode1" in model._repr_html_()
with pytest.raises(pushbelt.ArgumentError, match="ratios.*similar names: ratio"): v.thrust_map(ratios=[1.0], torque=[30.0])
with pytest.raises(pushbelt.ArgumentError, match="similar names: torque"): v.steady(1.0, torqe=30.0)
assert all(map(callable, (pushbelt.calibrate, pushbelt.drive, pushbelt.sweep, pushbelt.maps)))
with pytest.raises(pushbelt.UnknownNameError, match="similar names: ratio"): pushbelt.sweep(ratois=[1.0])
with pytest.raises(pushbelt.ArgumentError, match="ring"): pushbelt.sweep(ring="RCM")
"""


@pytest.fixture(scope="module")
def results(coarse: Variator) -> dict[str, Any]:
    point = {"ratio": 1.0, "torque": 30.0, "force": 9e3}
    maps = coarse.thrust_map([0.9, 1.0], [20.0, 30.0], force=9e3)
    return {"state": coarse.steady(**point), "bands": coarse.bands(**point), "model": coarse.linearize(**point), "maps": maps}


@pytest.mark.parametrize("guess", GUESSES.strip().splitlines())
def test_a_guess_is_right(guess: str, belt: Variator, results: dict[str, Any], tmp_path: Path) -> None:
    exec(guess, {"v": belt, "folder": tmp_path, "np": np, "pd": pd, "pytest": pytest, "pushbelt": pushbelt, "Variator": Variator, **results})
