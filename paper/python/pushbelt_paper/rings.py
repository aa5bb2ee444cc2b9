"""Rings alone: runs the program `paper_rings` and reads its CSV files."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pandas as pd

from pushbelt.errors import PushbeltError
from pushbelt.fmu.geometry import Array
from pushbelt.tables import split

Motion = SimpleNamespace
"""A ring over time, arrays by the names of the columns; `total` is the sum of the energies."""


class RingsError(PushbeltError, RuntimeError):
    """The program failed."""


@dataclass(frozen=True)
class Rings:
    """All results on rings alone. Rows have the columns as attributes."""

    checks: list[Any]
    """`passed` is None if the value is only reported."""
    frequencies: list[Any]
    orders: list[Any]
    motions: dict[tuple[str, str], Motion]
    """By figure and model."""
    shapes: dict[tuple[str, str], dict[float, Array]]
    """Outlines by figure and model, then by time; shape (n, 2), m."""
    work: pd.DataFrame
    """Computing effort by case and model: processor time in s, median of the repetitions, and counts."""

    def check(self, statement: str, model: str) -> Any:
        """The check whose statement begins with the given text."""
        return next(c for c in self.checks if c.statement.startswith(statement) and c.model == model)

    def effort(self, case: str, model: str) -> Any:
        """The effort of a model in an experiment."""
        return self.work.loc[case, model]


def run(program: Path, output: Path, short: bool, progress: Callable[[float], None]) -> Rings:
    """Runs the program. `progress` is called with the share of each job."""
    command = [str(program), "--output", str(output), *(["--short"] if short else [])]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8") as child:
        assert child.stdout is not None and child.stderr is not None
        for line in child.stdout:
            progress(1.0 / int(line.split()[0].partition("/")[2]))
        errors = child.stderr.read()
    if child.returncode != 0:
        raise RingsError(f"{program.name} failed: {errors.strip()}")
    return read(output)


def table(path: Path, **options: Any) -> pd.DataFrame:
    """A CSV file by the names of the columns without their units."""
    return pd.read_csv(path, **options).rename(columns=lambda title: split(title)[0])


def _rows(frame: pd.DataFrame) -> list[Any]:
    """Rows by the names of the columns, with None for empty cells."""
    return [SimpleNamespace(**row) for row in frame.astype(object).where(frame.notna(), None).to_dict("records")]


def read(folder: Path) -> Rings:
    """Reads the program's files."""
    checks, frequencies, orders, motions, shapes, work = (
        table(folder / f"{name}.csv", dtype={"check": str, "figure": str}) for name in ("checks", "frequencies", "orders", "motions", "shapes", "work")
    )
    checks["passed"] = checks["passed"].map({"yes": True, "no": False, "reported": None})
    frequencies["error"] = frequencies["frequency"] / frequencies["reference"] - 1.0
    motions["total"] = motions["kinetic"] + motions["membrane"] + motions["bending"]
    outlines: dict[tuple[str, str], dict[float, Array]] = {}
    for (figure, model, time), points in shapes.groupby(["figure", "model", "time"], sort=False):
        outlines.setdefault((figure, model), {})[time] = points[["x", "y"]].to_numpy()
    return Rings(
        _rows(checks),
        _rows(frequencies.astype({"elements": int})),
        _rows(orders),
        {
            (figure, model): Motion(**{name: of[name].to_numpy() for name in motions.columns[2:]})
            for (figure, model), of in motions.groupby(["figure", "model"], sort=False)
        },
        outlines,
        work.groupby(["case", "model"], sort=False).median(numeric_only=True),
    )
