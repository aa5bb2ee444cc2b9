"""The examples around `pushbelt.Variator`: the notebook, and the car."""

from __future__ import annotations

from pathlib import Path

import nbformat
import numpy as np
import pytest
from conftest import ROOT, module_of

CAR = module_of(ROOT / "examples" / "drivetrain" / "car.py")


def test_the_notebook_runs_from_start_to_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MPLBACKEND")
    monkeypatch.syspath_prepend(ROOT / "examples")
    import notebook

    def printed(outputs: list[nbformat.NotebookNode]) -> str:
        return "".join(output.text for output in outputs if output.output_type == "stream" and output.name == "stdout")

    kept, book = nbformat.read(notebook.PATH, as_version=4), notebook.run(tmp_path)
    stored, outputs = ([output for cell in one.cells if cell.cell_type == "code" for output in cell.outputs] for one in (kept, book))
    said = printed(outputs)
    assert said == printed(stored), "run examples/notebook.py"
    assert str(ROOT) not in notebook.PATH.read_text(encoding="utf-8")
    before, after = said.split("\nratio ")[1].splitlines()[0].split(" -> ")
    assert float(before) == pytest.approx(1.5, abs=1e-3)
    assert float(after) < 1.2
    assert 1.0 < float(said.split("45 N·m: ")[1]) < 1.4
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 2
    assert not [output.text for output in outputs if output.output_type == "stream" and output.name == "stderr"]


@pytest.fixture(autouse=True)
def outside(fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to run an example in, with the FMU under test and a separate cache."""
    for name, value in {"PUSHBELT_FMU": fmu, "PYTHONPATH": ROOT / "python", "XDG_CACHE_HOME": tmp_path, "MPLBACKEND": "Agg"}.items():
        monkeypatch.setenv(name, str(value))
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
def test_the_car_launches_shifts_and_stops(outside: Path) -> None:
    run = CAR.main()
    time, torque, ratio = run["time"], run["primary.torque"], run["ratio.geometric"]
    speed = 3.6 * CAR.LEVER * run["secondary.speed"]
    assert abs(speed[0]) < 1e-3 and 45.0 < speed.max() < 60.0
    assert np.abs(speed[time > 21.5]).max() < 0.01
    # Driving, overrun after the tip-out, driving again after the tip-in, overrun while braking.
    at = lambda moment: float(np.interp(moment, time, torque))  # noqa: E731
    assert [np.sign(at(moment)) for moment in (5.0, 10.5, 13.5, 17.0)] == [1.0, -1.0, 1.0, -1.0]
    assert ratio[time < 4.0] == pytest.approx(2.2, rel=0.03)
    assert ratio.min() < 0.55 and ratio[-1] > 2.1
    # The clutch does not chatter and the belt does not slip through.
    assert np.abs(np.diff(torque)).max() < 10.0
    assert not run["macroSlip"].any()
    assert (outside / "car.png").stat().st_size > 10_000


@pytest.mark.slow
def test_a_clutch_with_too_steep_a_law_chatters() -> None:
    """The instability that the rule for external inertias prevents. Until the clutch locks both runs are smooth."""
    run = CAR.main(naive=True, end=3.0)
    changes = np.abs(np.diff(run["primary.torque"]))
    assert changes[run["time"][1:] < 2.0].max() < 10.0
    assert changes.max() > 200.0
