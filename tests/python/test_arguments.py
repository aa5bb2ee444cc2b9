"""Arguments of the public interface: whatever they are, the call succeeds or raises a PushbeltError with one line, and changes nothing."""

import inspect
import re
import warnings
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from conftest import COARSE, ROOT
from sample_maps import default_maps

import pushbelt
from pushbelt.variator import Variator

NAN = float("nan")
BAD = (
    object(), None, "x", "0.01", b"x", NAN, -1.0, 10**400, True, [], [object()], [NAN], ["x", 1], [[1.0, 2.0], [3.0]], {1: 2}, {"x": 1.0},
    np.ones((2, 3)),
)  # fmt: skip
"""Wrong types, values and shapes. Some are right in some places."""


@pytest.fixture(scope="module")
def things(fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, tuple[Callable[[], Any], dict[str, Any]]]]:
    """Public functions and methods, with arguments that are right."""
    folder = tmp_path_factory.mktemp("files")
    with Variator("bench168", COARSE, fmu=fmu) as run:
        run.start()
        table, snapshot = pd.DataFrame({"primary.torque": [1.0, 2.0]}, index=[0.0, 0.01]), run.snapshot()
        maps, data = pushbelt.MapVariator(count=2), default_maps()
        grid = run.linear_grid([0.9, 1.2], [30.0], force=9e3, states="physical", sample_time=0.01)
        model = grid[0, 0]
        grid.save(folder / "models.npz")
        data.write(folder / "maps.json")
        point = {"ratio": 1.0, "torque": 20.0, "speed": 200.0, "force": 9e3, "safety": 1.3}
        bands, state = run.bands(1.0, 20.0, {}, force=9e3), run.steady(1.0, 20.0, force=9e3)
        linear = {"frequency": 50.0, "states": "modal", "sample_time": 0.01}
        over = point | {"ratio": [1.0], "torque": [20.0]}
        fields = {name: getattr(model, name) for name in ("a", "b", "c", "d", "inputs", "outputs", "states", "poles")}
        rest = {name: value for name, value in vars(model).items() if name not in fields}
        yield {
            "Variator.linearize_here": (run.linearize_here, linear),
            "Variator": (Variator, {"parameters": "bench168", "changes": {}, "fmu": fmu, "record": ["slip"]}),
            "Variator.step": (run.step, {"duration": 1e-3, "inputs": {}}), "Variator.set": (run.set, {"values": "primary.torque", "value": 2.0}),
            "Variator.get": (run.get, {"name": "slip"}), "Variator.run": (run.run, {"duration": 0.01, "inputs": {}, "step": 0.01, "outputs": ["slip"]}),
            "Bands": (pushbelt.Bands, dict(vars(bands))), "Bands.largest": (bands.largest, {"name": "slip", "count": 3}),
            "SteadyState": (pushbelt.SteadyState, dict(vars(state))), "SteadyState.gradient": (state.gradient, {"names": ["torque"], "hold": "ratio"}), "Profile": (pushbelt.Profile, dict(vars(state.profile))),
            "Variator.plot": (lambda name: run.plot(name), {"name": "slip"}), "SteadyState.plot": (lambda name: state.plot(name), {"name": "gap"}),
            "Profile.plot": (lambda name: state.profile.plot(name), {"name": "gap"}), "Maps.plot": (data.plot, {"name": "slip"}),
            "Variator.restore": (run.restore, {"snapshot": snapshot}),
            "Variator.simulate": (Variator("bench168", COARSE, fmu=fmu).simulate, {"inputs": table, "step": 0.01, "outputs": ["slip"]}),
            "Variator.linearize": (run.linearize, point | linear), "Variator.steady": (run.steady, point),
            "Variator.linear_grid": (run.linear_grid, {**over, **linear, "changes": {"belt.play": [1e-4]}, "after_each": lambda: None}),
            "Variator.least_force": (run.least_force, {"ratio": 1.0, "torque": 20.0, "safety": 1.3, "speed": 200.0, "thrust_ratio": 1.2}),
            "Variator.torque_capacity": (run.torque_capacity, {"ratio": 1.0, "force": 9e3, "thrust_ratio": 1.0}),
            "Variator.thrust_map": (run.thrust_map, over), "Variator.bands": (run.bands, point | {"deviations": {"belt.play": 1e-5, "force": 10.0}}), "Snapshot": (pushbelt.Snapshot, {"time": 0.0, "values": {}, "state": b""}),
            "Record": (pushbelt.Record, {"columns": ["slip"], "interval": 0.1}),
            "parameter_set": (pushbelt.parameter_set, {"name": "bench168"}), "parameter_deviations": (pushbelt.parameter_deviations, {"name": "bench168"}),
            "load_linear": (pushbelt.load_linear, {"path": folder / "models.npz"}),
            "LinearGrid": (pushbelt.LinearGrid, {"axes": grid.axes, "models": grid.models, "reasons": grid.reasons}),
            "LinearGrid.point": (grid.point, {"place": (0, 0)}), "LinearGrid.__getitem__": (grid.__getitem__, {"place": (0, 0)}),
            "LinearGrid.save": (grid.save, {"path": folder / "more.json"}), "LinearGrid.interpolate": (grid.interpolate, {"ratio": 1.0}),
            "LinearModel": (lambda **own: pushbelt.LinearModel(**own, **rest), fields),
            "LinearModel.of": (model.of, {"document": model.document()}), "LinearModel.sampled": (model.sampled, {"sample_time": 0.1}),
            "LinearModel.select": (model.select, {"outputs": ["slip"], "inputs": model.inputs}),
            "LinearModel.step": (model.step, {"times": [0.0, 1.0]}),
            "LinearModel.response": (model.response, {"frequencies": [1.0]}),
            "LinearModel.gain": (model.gain, {"output": "slip", "load": "primary.torque", "frequency": 1.0}),
            "MapVariator": (pushbelt.MapVariator, {"maps": None, "parameters": {}, "count": 1}),
            "MapVariator.start": (maps.start, {"ratio": 1.0, "primary_speed": [200.0, 100.0]}),
            "MapVariator.step": (maps.step, {"duration": 0.01, "primary_torque": 20.0, "secondary_torque": -20.0, "primary_force": 13e3,
                                             "secondary_force": [9e3, 9e3]}),
            "Maps": (pushbelt.Maps, dict(vars(data))), "Maps.read": (data.read, {"path": folder / "maps.json"}),
            "Maps.write": (data.write, {"path": folder / "maps.npz"}), "Maps.masked": (data.masked, {"name": "slip"}),
            "Maps.of_document": (data.of_document, {"document": data.document()}), "Variator.reset": (run.reset, {"changes": {}}),
        }  # fmt: skip


def test_every_public_function_is_among_them(things: dict[str, Any]) -> None:
    public = set()
    for name, thing in ((name, getattr(pushbelt, name)) for name in pushbelt.__all__):
        if inspect.isfunction(thing) and inspect.signature(thing).parameters:
            public.add(name)
        if inspect.isclass(thing) and not issubclass(thing, Exception):
            methods = ((one, inspect.unwrap(method)) for one, method in inspect.getmembers(thing, callable) if one[0] != "_")
            public |= {name, *(f"{name}.{one}" for one, method in methods if {*inspect.signature(method).parameters} - {"self", "cls"})}
    assert public <= things.keys()


def test_no_argument_ends_in_another_error(things: dict[str, Any]) -> None:
    failed = []
    for what, (call, right) in things.items():
        call(**right)
        for name, value in ((name, value) for name in right for value in BAD):
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    call(**{**right, name: value})
            except pushbelt.PushbeltError as error:
                if "\n" in str(error) or len(str(error)) > 400:
                    failed.append(f"{what}: {name} = {value!r}: {error}")
            except Exception as error:  # noqa: BLE001
                failed.append(f"{what}: {name} = {value!r}: {error!r}")
    assert not failed, "\n".join(failed)


def test_files_that_are_no_linear_models_are_named(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "models.zip", "w") as archive:
        archive.writestr("a.txt", "text")
    np.save(tmp_path / "models.npy", np.zeros(3))
    np.savez(tmp_path / "other.npz", x=np.zeros(2))
    (tmp_path / "text.npz").write_text("text", encoding="utf-8")
    (tmp_path / "torn.npz").write_bytes((tmp_path / "models.zip").read_bytes()[:40])
    names = ("models.zip", "models.npy", "other.npz", "text.npz", "torn.npz")
    for name, kind, why in (*((name, ValueError, " is not a file of linear models") for name in names), (".", OSError, ""), ("none.npz", FileNotFoundError, "")):
        with pytest.raises(pushbelt.PushbeltError, match=re.escape(str(tmp_path / name)) + why) as error:
            pushbelt.load_linear(str(tmp_path / name))
        assert isinstance(error.value, kind)
    assert pushbelt.parameter_set(ROOT / "resources" / "parameters" / "belt155.json") == pushbelt.parameter_set("belt155")
