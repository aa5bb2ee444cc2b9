"""Rings alone: runs the program `paper_rings` and reads its CSV files."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np

from pushbelt.errors import PushbeltError
from pushbelt.fmu.geometry import Array
from pushbelt.tables import by_name

Row = dict[str, str]


class RingsError(PushbeltError, RuntimeError):
    """The program failed."""


@dataclass(frozen=True)
class RingCheck:
    """A check of a ring alone."""

    number: str
    """Group: 1 derivatives, 2 reference motion, 3 deformable ring, 4 running ring, 5 free ring, 6 orders."""
    statement: str
    model: str
    value: float
    reference: float | None
    low: float | None
    high: float | None
    passed: bool | None
    """Verdict; None if the value is only reported."""


@dataclass(frozen=True)
class Motion:
    """A ring over time."""

    time: Array
    theta: Array
    drift: Array
    kinetic: Array
    membrane: Array
    bending: Array
    bulge: Array
    """Outward deflection of the strands' midpoints from their chords, m."""
    ovality: Array
    """Mean square extent along x minus that along y, m²."""

    @property
    def total(self) -> Array:
        """T + V, J."""
        return self.kinetic + self.membrane + self.bending


@dataclass(frozen=True)
class Work:
    """Computing effort of one experiment with one model."""

    case: str
    model: str
    elements: int
    cpu: tuple[float, ...]
    """Processor times of the repetitions, s."""
    steps: int
    factorizations: int
    residuals: int

    @property
    def median(self) -> float:
        """Median processor time, s."""
        return median(self.cpu)


@dataclass(frozen=True)
class Frequency:
    """Frequency of a free ring, Hz."""

    case: str
    model: str
    elements: int
    frequency: float
    reference: float

    @property
    def error(self) -> float:
        """Error relative to the reference."""
        return self.frequency / self.reference - 1.0


@dataclass(frozen=True)
class Order:
    """Result at one of a series of resolutions."""

    model: str
    quantity: str
    expected: float
    resolution: float
    error: float
    order: float | None
    """Order observed between the previous resolution and this one."""


@dataclass(frozen=True)
class Rings:
    """All results on rings alone."""

    checks: tuple[RingCheck, ...]
    frequencies: tuple[Frequency, ...]
    orders: tuple[Order, ...]
    motions: dict[tuple[str, str], Motion]
    """Motions by figure and model."""
    shapes: dict[tuple[str, str], dict[float, Array]]
    """Outlines by figure and model, then by time; shape (n, 2), m."""
    work: tuple[Work, ...]

    def check(self, statement: str, model: str) -> RingCheck:
        """The check whose statement begins with the given text."""
        return next(c for c in self.checks if c.statement.startswith(statement) and c.model == model)

    def effort(self, case: str, model: str) -> Work:
        """The effort of a model in an experiment."""
        return next(w for w in self.work if w.case == case and w.model == model)


def run(program: Path, output: Path, short: bool, progress: Callable[[float, str], None]) -> Rings:
    """Runs the program. `progress` is called with the finished share and the name of each job."""
    command = [str(program), "--output", str(output), *(["--short"] if short else [])]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8"
    ) as child:
        assert child.stdout is not None and child.stderr is not None
        for line in child.stdout:
            count, _, name = line.strip().partition(" ")
            done, _, total = count.partition("/")
            progress(int(done) / int(total), name)
        errors = child.stderr.read()
    if child.returncode != 0:
        raise RingsError(f"{program.name} failed: {errors.strip()}")
    return read(output)


def _optional(text: str) -> float | None:
    return float(text) if text else None


def _columns(rows: list[Row], names: tuple[str, ...]) -> dict[str, Array]:
    return {name: np.array([float(row[name]) for row in rows]) for name in names}


def _grouped(rows: list[Row], *names: str) -> dict[tuple[str, ...], list[Row]]:
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(tuple(row[name] for name in names), []).append(row)
    return groups


def read(folder: Path) -> Rings:
    """Reads the program's files."""
    judged = {"yes": True, "no": False, "reported": None}
    checks = tuple(
        RingCheck(
            row["check"],
            row["statement"],
            row["model"],
            float(row["value"]),
            *(_optional(row[name]) for name in ("reference", "low", "high")),
            judged[row["passed"]],
        )
        for row in by_name(folder / "checks.csv")
    )
    frequencies = tuple(
        Frequency(
            row["case"], row["model"], round(float(row["elements"])), float(row["frequency"]), float(row["reference"])
        )
        for row in by_name(folder / "frequencies.csv")
    )
    orders = tuple(
        Order(
            row["model"],
            row["quantity"],
            float(row["expected"]),
            float(row["resolution"]),
            float(row["error"]),
            _optional(row["order"]),
        )
        for row in by_name(folder / "orders.csv")
    )
    fields = ("time", "theta", "drift", "kinetic", "membrane", "bending", "bulge", "ovality")
    motions = {
        (figure, model): Motion(**_columns(rows, fields))
        for (figure, model), rows in _grouped(by_name(folder / "motions.csv"), "figure", "model").items()
    }
    shapes: dict[tuple[str, str], dict[float, Array]] = {}
    for (figure, model, time), rows in _grouped(by_name(folder / "shapes.csv"), "figure", "model", "time").items():
        points = _columns(rows, ("x", "y"))
        shapes.setdefault((figure, model), {})[float(time)] = np.column_stack([points["x"], points["y"]])
    work = tuple(
        Work(
            case,
            model,
            round(float(rows[0]["elements"])),
            tuple(float(row["cpu"]) for row in rows),
            *(round(float(rows[0][name])) for name in ("steps", "factorizations", "residuals")),
        )
        for (case, model), rows in _grouped(by_name(folder / "work.csv"), "case", "model").items()
    )
    return Rings(checks, frequencies, orders, motions, shapes, work)
