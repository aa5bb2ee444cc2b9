"""Calls that a user tries before reading the documentation, right and wrong ones, in `guesses.txt`; programs as functions."""

import inspect
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from conftest import COARSE, MESH

import pushbelt
from pushbelt import Variator

mpl.use("Agg")
GUESSES = Path(__file__).with_name("guesses.txt").read_text(encoding="utf-8").splitlines()
MODULES = {one.__name__: one for one in (inspect, pushbelt, pytest)} | {"np": np, "pd": pd, "Variator": Variator}


@pytest.fixture(scope="module")
def results(coarse: Variator) -> dict[str, Any]:
    point = {"ratio": 1.0, "torque": 30.0, "force": 9e3}
    maps = coarse.thrust_map([0.9, 1.0], [20.0, 30.0], force=9e3)
    of_maps = pushbelt.MapVariator(count=2)
    of_maps.start(1.0, [200.0, 100.0])
    grid = coarse.linear_grid([0.7, 1.5], [30.0, 700.0], force=11e3, states="physical")
    found = {"state": coarse.steady(**point), "bands": coarse.bands(**point), "model": coarse.linearize(**point)}
    return {**found, "maps": maps, "of_maps": of_maps, "grid": grid}


@pytest.mark.parametrize("guess", GUESSES)
def test_a_guess_is_right(guess: str, belt: Variator, results: dict[str, Any], tmp_path: Path) -> None:
    exec(guess, {"v": belt, "folder": tmp_path, **MODULES, **results})
    if guess.startswith("with pytest.raises") and "v.start" not in guess:
        assert len(belt.outputs) == 0, "what is refused changes nothing"


def test_a_study_is_a_call(fmu: Path, tmp_path: Path) -> None:
    """With a list, a mapping and a range; the report names the command."""
    given = {"ring": "ALE0", "set": MESH, "workers": 1, "fmu": fmu, "output": tmp_path}
    table = pushbelt.sweep(vary={"belt.play": (1e-4, 4e-4), "friction.pulley": [0.08, 0.09]}, samples=2, **given)
    assert len(table) == 4 and table["slip"].notna().all() and table.attrs["units"]["belt.play"] == "m"
    assert "--vary=belt.play=0.0001:0.0004" in (tmp_path / "report.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_maps_a_fit_and_a_drive_are_calls(fmu: Path, drive_folder: Path, tmp_path: Path) -> None:
    maps = pushbelt.maps(force=[6e3, 15e3], speed=200.0, ratios=2, utilisation=(0.0, 0.4), ring="ALE0", set=COARSE, fmu=fmu, output=tmp_path / "maps")
    assert maps.to_xarray()["thrustRatio"].units == "1" and maps.plot("slip").axs.shape == (2, 1)
    pushbelt.calibrate(template=tmp_path / "points.csv")
    points = pd.read_csv(tmp_path / "points.csv", comment="#")
    fit = pushbelt.calibrate(points, fit={"friction.pulley": 0.085}, prior={"friction.pulley": (0.09, 0.02)}, fmu=fmu, output=tmp_path / "fit")
    assert fit.parameters["friction.pulley"] == pytest.approx(0.09, rel=0.01)
    drive = pushbelt.drive(cycle="nedc", short=True, until=2.0, ring="ALE0", fmu=fmu, output=drive_folder)
    assert drive.runs[0].to_dataframe().index[-1] == pytest.approx(11.99) and drive.runs[0].plot("slip").size == 1
