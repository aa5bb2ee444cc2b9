"""The report: one self-contained HTML file, and its tables as CSV."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from pushbelt import tables
from pushbelt.fmu.data import load_case_speed
from pushbelt.report import page

from . import cases, figures, profiles, times
from .results import MODELS, PULLEYS, REFERENCE, PaperResults
from .statements import Statement, Verdict, signed

SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _ends(values: Iterable[float]) -> tuple[float, float]:
    values = list(values)
    return min(values), max(values)


def choices(results: PaperResults) -> list[dict[str, Any]]:
    """Figures for the choice of a model, with ALE first: ranges of its differences to the reference model and of spiral running in m,
    numbers of load cases that start steady and that slip, and mean times of whole simulations as the FMU has the model."""
    ratios = times.factors(times.stored()[0])["mean"]
    return [
        {
            "model": model,
            "thrust": _ends(map(results.thrust_difference, runs)) if model != REFERENCE else None,
            "efficiency": _ends(map(results.efficiency_difference, runs)) if model != REFERENCE else None,
            "spiral": _ends(value for run in runs for value in run.window.spiral),
            "steady": sum(run.steady for run in runs),
            "slipping": sum(run.window.slipped for run in runs),
            "time": [ratios[load, model] for load in times.LOADS],
        }
        for model in sorted(MODELS, key=lambda name: name != "ALE")
        for runs in [results.of(model)]
    ]


def write_html(results: PaperResults, statements: list[Statement], path: Path) -> None:
    """Writes the report."""
    folder = Path(__file__).parent
    page.write_html("paper.html.j2", context(results, statements), path, folder, signed=signed, brief=brief)


def brief(value: float) -> str:
    """A number with three significant digits in the shortest form."""
    if value == 0.0 or 1e-2 <= abs(value) < 1e7:
        return f"{value:.6g}".replace("-", page.MINUS)
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{mantissa}·10".replace("-", page.MINUS) + str(int(exponent)).translate(SUPERSCRIPT)


def context(results: PaperResults, statements: list[Statement]) -> dict[str, Any]:
    """Values for the template."""
    rings = results.rings
    judged = [check.passed for check in rings.checks if check.passed is not None]
    stored, measured = times.stored()
    pictures = {
        "figure6": figures.reference_oscillation(rings),
        "figure7": figures.deformable_ring(rings),
        "belt_ring": figures.belt_ring(rings),
        "meshes": figures.mesh_energy(rings),
        "convergence": figures.convergence(rings),
        "levels": figures.thrust_and_efficiency(results),
        "push_force": figures.push_force(results),
        "spiral": figures.spiral_running(results),
        "times": figures.computing_times(stored),
    }
    return {
        "version": results.fmu_version,
        "results": results,
        "effort": results.effort,
        "models": MODELS,
        "reference": REFERENCE,
        "choices": choices(results),
        "statements": statements,
        "counts": {verdict.value: sum(s.verdict is verdict for s in statements) for verdict in Verdict},
        "checks_passed": sum(judged),
        "checks_judged": len(judged),
        "rows": [(case, [results.run(case, model) for model in MODELS]) for case in results.cases],
        "speed": load_case_speed() * 30.0 / np.pi,
        "times": times,
        "measured": measured,
        "spread": times.spread(stored),
        "factors": [(title, times.factors(of)) for title, of in (("stored", stored), ("this run", results.times))],
        "seconds": times.whole(stored),
        "step": cases.STEP,
        "mesh_names": [name for name in cases.MESHES if name != "fine"],
        "residuals": {name: float(np.abs(shift.residual).max()) for name, shift in results.shifts.items()},
        "label": lambda model: figures.SHORT_NAMES.get(model, model),
        "pictures": pictures,
    }


def write_tables(results: PaperResults, statements: list[Statement], folder: Path) -> None:
    """Writes the data of figures 8 and 9, the meshes, and the statements."""
    chosen = [results.chosen(model) for model in MODELS]
    elements = [(run, *profiles.element(results.parameters, run)) for run in chosen]
    state = {"thrustRatio": "1", "efficiency.belt": "1", "ring.tensionMin": "N", "ring.tensionMax": "N"}
    tables.write(
        folder / "figure-8ab.csv",
        ["case", "model", "loadTorque [N.m]", "thrustRatio [1]", "efficiency [1]", "loss [W]", "thrustRatioDifference [1]",
         "efficiencyDifference [1]", "spiral.primary [m]", "spiral.secondary [m]", "slips", "steady", "change [1]"],
        (
            [run.case.name, run.model, run.load_torque, run.window.thrust_ratio, run.window.efficiency, run.window.loss,
             results.thrust_difference(run), results.efficiency_difference(run), *run.window.spiral, int(run.window.slipped), int(run.steady),
             run.window.change]
            for run in results.runs
        ),
    )  # fmt: skip
    rows = (
        [run.case.name, run.model, *map(float, row)]
        for run, path, force in elements
        for row in zip(path.time, path.xi, force, strict=True)
    )
    tables.write(folder / "figure-8c.csv", ["case", "model", "time [s]", "xi [m]", "pushForce [N]"], rows, digits=6)
    tables.write(
        folder / "figure-8d.csv",
        ["case", "model", "pulley", "fractionOfArc [1]", "radialDeviation [m]"],
        (
            [run.case.name, run.model, pulley, *map(float, row)]
            for run in results.runs
            for pulley in PULLEYS
            for row in zip(*profiles.arc(results.parameters, run, pulley), strict=True)
        ),
        digits=6,
    )
    meshes = [(case, mesh, values) for case, states in results.meshes.items() for mesh, values in states.items()]
    rows = ([case, mesh, *(values[name] for name in state)] for case, mesh, values in meshes)
    tables.write(folder / "meshes.csv", ["case", "mesh", *tables.titles(state, state)], rows)
    times.write(results.times, results.fmu_version, folder / "figure-9.csv")
    rows = ([s.source, s.claim, s.verdict.value, s.found, s.reason] for s in statements)
    tables.write(folder / "statements.csv", ["source", "claim", "verdict", "found", "reason"], rows)
