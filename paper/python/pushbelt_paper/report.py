"""The report: one self-contained HTML file, and its tables as CSV."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pushbelt import page, tables
from pushbelt.fmu.data import load_case_speed
from pushbelt.fmu.results import LoadCase

from . import cases, figures, profiles, statements
from .results import CHOSEN_CASE, MODELS, REFERENCE, CaseRun, PaperResults
from .rings import RingCheck
from .statement import Verdict, signed

ABOUT = {
    "ALE": (
        "Deflections over a moving reference curve; the mesh is fixed and material flows through it",
        "Default: spiral running, steady states, linear models, drivetrain simulation",
    ),
    "ALE0": (
        "The reference curve alone, with free centres of the arcs: drift and ratio, and a tension that friction transports",
        "Controller design and drive cycles with many runs",
    ),
    "ANCF": (
        "Absolute nodal coordinates on a mesh that travels with the ring",
        "Independent comparison: large deflections without a reference curve",
    ),
    "RCM": (
        "Co-rotational elements in redundant coordinates on a mesh that travels with the ring",
        "Reference for checks of ALE: large deflections, no membrane locking",
    ),
}
"""Description and purpose of each model."""


SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Choice:
    """A line of the table of ring models."""

    model: str
    what: str
    use: str
    thrust: tuple[float, float] | None
    """Smallest and largest difference of the thrust ratio to the reference model's, relative."""
    efficiency: tuple[float, float] | None
    """Smallest and largest difference of the efficiency to the reference model's, absolute."""
    spiral: tuple[float, float]
    """Smallest and largest spiral running, m."""
    steady: int
    """Number of load cases with a steady state of this model, or of the model from which it starts."""
    slipping: int
    """Number of load cases with macro-slip."""
    time: tuple[float, float, float]
    """Smallest, median and largest computing time relative to the reference model's."""
    wavy: float | None
    """Median of the same quotient with an oscillating load."""


def _ends(values: list[float]) -> tuple[float, float]:
    return min(values), max(values)


def choices(results: PaperResults) -> list[Choice]:
    """Table for the choice of a model, with ALE first."""
    lines = []
    for model in sorted(MODELS, key=lambda name: name != "ALE"):
        runs = results.of(model)
        what, use = ABOUT[model]
        other = model != REFERENCE
        times = [results.time_ratio(case, model) for case in results.cases]
        wavy = [value for case in results.cases if (value := results.wavy_time_ratio(case, model)) is not None]
        lines.append(
            Choice(
                model,
                what,
                use,
                _ends([results.thrust_difference(case, model) for case in results.cases]) if other else None,
                _ends([results.efficiency_difference(case, model) for case in results.cases]) if other else None,
                _ends([run.window.mean(f"spiral.{p}") for run in runs for p in ("primary", "secondary")]),
                sum(run.steady for run in runs),
                sum(run.slipped for run in runs),
                (min(times), float(np.median(times)), max(times)),
                float(np.median(wavy)) if wavy else None,
            )
        )
    return lines


def chosen_runs(results: PaperResults) -> Callable[[str], CaseRun]:
    """Runs of the case whose fields along the belt are shown, by model."""
    case = next((case for case in results.cases if case.name == CHOSEN_CASE), results.cases[0])
    return lambda model: results.run(case, model)


def case_rows(results: PaperResults) -> list[tuple[LoadCase, list[CaseRun]]]:
    """All runs, grouped by load case."""
    return [(case, [results.run(case, model) for model in MODELS]) for case in results.cases]


def checks_by_number(results: PaperResults) -> list[tuple[str, list[RingCheck]]]:
    """The checks of rings alone by group."""
    names = {
        "1": "Derivatives: P (12), −∂V/∂q (18), inertia (13), (14)",
        "2": "Reference motion alone (fig. 6)",
        "3": "Deformable ring (fig. 7)",
        "4": "Running ring on a circle",
        "5": "Free ring",
        "6": "Orders of convergence",
    }
    return [
        (name, [check for check in results.rings.checks if check.number == number]) for number, name in names.items()
    ]


def write_html(results: PaperResults, path: Path) -> None:
    """Writes the report."""
    page.write_html("paper.html.j2", context(results), path, Path(__file__).parent, signed=signed, brief=brief)


def brief(value: float) -> str:
    """A number with three significant digits in the shortest form."""
    if value == 0.0 or 1e-2 <= abs(value) < 1e7:
        return f"{value:.6g}".replace("-", page.MINUS)
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{mantissa}·10".replace("-", page.MINUS) + str(int(exponent)).translate(SUPERSCRIPT)


def context(results: PaperResults) -> dict[str, Any]:
    """Values for the template."""
    found = statements.evaluate(results)
    run_of = chosen_runs(results)
    judged = [check for check in results.rings.checks if check.passed is not None]
    rings = results.rings
    outlines, over_time = figures.deformable_ring(rings)
    belt_outlines, belt_over_time = figures.belt_ring(rings)
    pictures = {
        "figure6": figures.reference_oscillation(rings),
        "figure7": outlines,
        "figure7_over_time": over_time,
        "belt_ring": belt_outlines,
        "belt_ring_over_time": belt_over_time,
        "meshes": figures.mesh_energy(rings),
        "convergence": figures.convergence(rings),
        "levels": figures.thrust_and_efficiency(results),
        "push_force": figures.push_force(results, run_of),
        "spiral": figures.spiral_running(results, run_of),
        "times": figures.computing_times(results),
    }
    return {
        "version": results.fmu_version,
        "results": results,
        "effort": results.effort,
        "models": MODELS,
        "reference": REFERENCE,
        "choices": choices(results),
        "statements": found,
        "counts": {verdict.value: sum(s.verdict is verdict for s in found) for verdict in Verdict},
        "checks": checks_by_number(results),
        "checks_passed": sum(bool(check.passed) for check in judged),
        "checks_judged": len(judged),
        "rows": case_rows(results),
        "speed": load_case_speed() * 30.0 / np.pi,
        "wave": (cases.WAVE_FREQUENCY, cases.WAVE_DEPTH),
        "step": cases.STEP,
        "mesh_names": [name for name in cases.MESHES if name != "fine"],
        "residuals": {name: float(np.abs(shift.residual).max()) for name, shift in results.shifts.items()},
        "label": figures.label,
        "pictures": pictures,
    }


def write_tables(results: PaperResults, folder: Path) -> None:
    """Writes the data of figures 8 and 9, the meshes, and the statements."""
    for write in (_write_cases, _write_elements, _write_arcs, _write_meshes, _write_times, _write_statements):
        write(results, folder)


def _write_cases(results: PaperResults, folder: Path) -> None:
    tables.write(
        folder / "figure-8ab.csv",
        ["case", "model", "loadTorque [N.m]", "thrustRatio [1]", "efficiency [1]", "loss [W]", "thrustRatioDifference [1]",
         "efficiencyDifference [1]", "spiral.primary [m]", "spiral.secondary [m]", "slips", "steady", "change [1]"],
        (
            [
                run.case.name,
                run.model,
                run.load_torque,
                run.window.thrust_ratio,
                run.window.efficiency,
                run.window.loss,
                results.thrust_difference(run.case, run.model),
                results.efficiency_difference(run.case, run.model),
                run.window.mean("spiral.primary"),
                run.window.mean("spiral.secondary"),
                int(run.slipped),
                int(run.steady),
                run.window.change,
            ]
            for run in results.runs
        ),
    )  # fmt: skip


def _write_elements(results: PaperResults, folder: Path) -> None:
    run_of = chosen_runs(results)
    elements = [(run, *profiles.element(results.parameters, run)) for run in map(run_of, MODELS)]
    tables.write(
        folder / "figure-8c.csv",
        ["case", "model", "time [s]", "xi [m]", "pushForce [N]"],
        (
            [run.case.name, run.model, *map(float, row)]
            for run, path, force in elements
            for row in zip(path.time, path.xi, force, strict=True)
        ),
        digits=6,
    )


def _write_arcs(results: PaperResults, folder: Path) -> None:
    tables.write(
        folder / "figure-8d.csv",
        ["case", "model", "pulley", "fractionOfArc [1]", "radialDeviation [m]"],
        (
            [run.case.name, run.model, pulley, *map(float, row)]
            for run in results.runs
            for pulley in ("primary", "secondary")
            for row in zip(*profiles.arc(results.parameters, run, pulley), strict=True)
        ),
        digits=6,
    )


def _write_meshes(results: PaperResults, folder: Path) -> None:
    columns = {"thrustRatio": "1", "efficiency.belt": "1", "ring.tensionMin": "N", "ring.tensionMax": "N"}
    tables.write(
        folder / "meshes.csv",
        ["case", "mesh", *tables.titles(columns, columns)],
        (
            [case, mesh, *(state[name] for name in columns)]
            for case, states in results.meshes.items()
            for mesh, state in states.items()
        ),
    )


def _write_times(results: PaperResults, folder: Path) -> None:
    tables.write(
        folder / "figure-9.csv",
        ["case", "model", "load", "repetition", "simulated [s]", "stepping [s]", "starting [s]"],
        (
            [run.case.name, run.model, load, number, times.simulated, *pair]
            for run in results.runs
            for load, times in (("constant", run.times), ("swinging", run.wavy_times))
            if times is not None
            for number, pair in enumerate(zip(times.stepping, times.starting, strict=True), start=1)
        ),
        digits=6,
    )


def _write_statements(results: PaperResults, folder: Path) -> None:
    tables.write(
        folder / "statements.csv",
        ["source", "claim", "verdict", "found", "reason"],
        ([s.source, s.claim, s.verdict.value, s.found, s.reason] for s in statements.evaluate(results)),
    )
