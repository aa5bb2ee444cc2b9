"""What a user of the package sees: completion, short descriptions, tables, similar names, the command line without the extras, the pages."""

import ast
import json
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from conftest import ROOT
from test_wheel import declared  # noqa: F401

import pushbelt
from pushbelt import Variator, cli, console
from pushbelt.drive import __main__ as drive
from pushbelt.drive import runs
from pushbelt.fmu.results import Trace

WITHOUT = """
import sys
from importlib.machinery import PathFinder
hidden, found = set(sys.argv.pop(1).split(",")), PathFinder.find_spec
PathFinder.find_spec = lambda name, *rest: None if name.partition(".")[0] in hidden else found(name, *rest)
import pushbelt
with pushbelt.Variator("bench168", {"ring.model": "ALE0"}, fmu=sys.argv.pop(1)) as variator:
    variator.step(1e-3)
from pushbelt import cli
for line in sys.argv[1:]:
    try:
        code = cli.main(line.split("\\n"))
    except SystemExit as end:
        code = end.code
    print("ends with", code)
"""  # A step, and command lines, in an environment in which packages are not installed


def test_every_object_describes_itself_in_one_line(belt: Variator) -> None:
    texts = [repr(belt)]
    belt.step(0.002)
    state, grid = belt.steady(1.3, 33.0), belt.linear_grid([0.9, 1.2], [30.0, 800.0], force=9e3)
    assert state.to_dataframe()["slip"].tolist() == [state["slip"]]
    assert state.profile.to_dataframe()["push_force"].max() == state.profile.push_force.max()
    texts += map(repr, (belt, state, state.profile, grid, grid[0, 0], Trace(np.array([0.0, 0.5]), {"slip": np.zeros(2)})))
    belt.close()
    texts.append(repr(belt))
    parts = (
        "not started", "at 0.002 s, 2 rows", "ratio 1.3", "72 places", "2 of 4 points have a model",
        "ratio 0.9, primary.torque 30 N.m", "0 to 0.5 s", "closed",
    )  # fmt: skip
    for text, part in zip(texts, parts, strict=True):
        assert part in text and text[0] == "<" and len(text) < 260 and "\n" not in text


def test_a_table_of_inputs_gives_a_table_of_outputs(belt: Variator) -> None:
    times = [0.0, 0.013, 0.03]
    inputs = pd.DataFrame({"primary.torque": [44.0, 52.0, 52.0], "primary.clampingForce": [12e3, 12e3, 13.5e3]}, index=times)
    found = belt.simulate(inputs, step=4e-3)
    assert found.index.name == "time" and set(times) <= set(found.index.to_numpy().round(12))
    assert np.diff(found.index).max() <= 4e-3 + 1e-12 and len(found) == 1 + 4 + 5
    assert found["primary.torque"].to_numpy() == pytest.approx(np.interp(found.index, times, inputs["primary.torque"]))
    # It continues, with time as a column and a selection of outputs.
    more = pd.DataFrame({"time": [0.03, 0.05], "secondary.torque": [-50.0, -51.0], "friction.pulley": [0.09, 0.07]})
    rest = belt.simulate(more, outputs=["slip", "macroSlip"])
    assert belt["friction.pulley"] == 0.07 and rest["slip"].iloc[-1] > 1.2 * rest["slip"].iloc[0]
    assert list(rest.columns) == ["slip", "macroSlip"] and rest.index[[0, -1]].tolist() == pytest.approx([0.03, 0.05])
    assert belt.to_dataframe().shape == (len(found) + len(rest) - 1, len(belt.outputs.dtype.names) - 1)
    with pytest.raises(pushbelt.ArgumentError):
        belt.simulate(inputs)


def test_variables_are_listed(fmu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def listed(*words: str) -> str:
        assert cli.main(["variables", *words, "--fmu", str(fmu)]) == 0
        return capsys.readouterr().out

    said = listed("inertia", "--kind", "parameter")
    assert "secondary.inertia\n    parameter, start " in said and " kg.m2, range 0" in said
    assert "start ALE, one of ALE0, ALE\n" in listed("ring.model")
    said = listed("--kind", "output")
    assert said.startswith("thrustRatio\n    output, ") and "profile.pushForce[1]" not in said and "primary.torque\n" not in said


def test_pages_are_shown(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["docs"]) == cli.main(["docs", "limits"]) == 0
    said = capsys.readouterr().out
    assert "linear, " in said and "\n# " in said
    assert cli.main(["docs", "variabels"]) == 1
    assert "variables" in capsys.readouterr().err


def test_steps_and_help_need_no_extra_and_a_program_names_its_own(declared: dict[str, set[str]], fmu: Path, tmp_path: Path) -> None:  # noqa: F811
    """Without the packages of all extras, help also without an FMU."""
    hidden = ",".join({name.lower().replace("-", "_") for name in declared["all"] - declared["base"]} | {"wltp"})
    programs = [*cli.PROGRAMS, "fmu", "variables", "docs", "cache"]
    command = [sys.executable, "-c", WITHOUT, hidden, fmu, *(f"{program}\n--help" for program in programs), f"demo\n--fmu\n{fmu}"]
    environment = {"PYTHONPATH": str(ROOT / "python"), "PUSHBELT_FMU": str(tmp_path / "none.fmu"), "PATH": "/usr/bin:/bin"}
    run = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=tmp_path)
    assert run.returncode == 0 and "pip install 'pushbelt[reports]'" in run.stderr, run.stderr
    shown, codes = (re.findall(line, run.stdout, re.MULTILINE) for line in (r"^usage: pushbelt (\w+) ", r"^ends with (.*)$"))
    assert shown == programs and codes == ["0"] * len(programs) + ["1"] and "Traceback" not in run.stderr


def test_only_an_error_of_the_package_has_no_traceback(fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    own = tmp_path / "own.json"
    own.write_text(json.dumps({"base": "bench168", "parameters": {"belt.colour": {"value": 1.0}}}), encoding="utf-8")
    assert cli.main(["demo", "--variator", str(own), "--fmu", str(fmu), "--output", str(tmp_path)]) == 1
    assert "belt.colour" in capsys.readouterr().err
    monkeypatch.setattr("pushbelt.demo.__main__.main", console.program("demo", "reports")(lambda _: int("an error within the program")))
    with pytest.raises(ValueError, match="invalid literal"):
        cli.main(["demo", "--fmu", str(fmu)])


def test_without_the_wltc_the_nedc_is_driven(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], fmu: Path, tmp_path: Path) -> None:
    plans = []
    monkeypatch.setattr("pushbelt.drive.runs.run_all", lambda fmu, plan, output: plans.append(plan) or SimpleNamespace(runs=[]))
    monkeypatch.setattr("pushbelt.drive.report.write_html", lambda _, path: path)
    monkeypatch.setitem(sys.modules, "wltp.cycles", None)
    words = ["--fmu", str(fmu), "--output", str(tmp_path), "--short"]
    assert drive.main(words) == 0
    assert "the NEDC is driven, not the WLTC" in capsys.readouterr().err
    assert plans[0] == runs.SHORT["nedc"]
    assert drive.main([*words, "--cycle", "wltc"]) == 0
    assert not capsys.readouterr().err


def test_the_notebook_runs_on_the_line_that_it_names(declared: dict[str, set[str]]) -> None:  # noqa: F811
    book = json.loads((ROOT / "examples" / "notebook.ipynb").read_text(encoding="utf-8"))
    text = "".join("".join(cell["source"]) for cell in book["cells"] if cell["cell_type"] == "markdown")
    (extra,) = re.findall(r'pip install "pushbelt-[\d.]+-py3-none-any.whl\[(\w+)\]" jupyterlab', text)
    code = "\n".join("".join(cell["source"]) for cell in book["cells"] if cell["cell_type"] == "code")
    used = {node.names[0].name.partition(".")[0] for node in ast.walk(ast.parse(code)) if isinstance(node, ast.Import)}
    assert used - {"pushbelt"} <= declared[extra]
    assert "thrust_map" not in code or "xarray" in declared[extra]
