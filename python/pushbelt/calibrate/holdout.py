"""Hold-out: a parameter set against a rig's table that it was not fitted to, beside the default set."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pushbelt import page, residual_figures, tables
from pushbelt.charts import Chart
from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.untrusted import described
from pushbelt.progress import progress_bar
from pushbelt.residual_figures import Residual
from pushbelt.tables import points
from pushbelt.tables.columns import MEASURED
from pushbelt.tables.points import Oil, Rig
from pushbelt.tables.sheet import Reading

from . import model
from .model import Value
from .worker import Found

DEFAULT = "bench168"


@dataclass(frozen=True)
class Score:
    """Residuals of a quantity with a parameter set, SI."""

    quantity: str
    variator: str
    count: int
    """Values at points with a steady state."""
    lost: int
    """Values at points without one."""
    rms: float
    bias: float
    """Mean of model minus measurement."""
    relative: float
    """Root mean square in standard deviations."""
    explained: float
    """1 minus the residual sum of squares over that about the measured mean; NaN for a constant quantity."""


@dataclass(frozen=True)
class HoldOut:
    """A table, and the model's values with each set."""

    rig: Rig
    version: str
    variators: tuple[str, ...]
    values: tuple[Value, ...]
    states: tuple[tuple[Found, ...], ...]
    """Results of all points for each set."""

    def scores(self) -> list[Score]:
        """By quantity and set."""
        quantities = [q for q in MEASURED if any(value.measured.quantity == q for value in self.values)]
        return [_score(self, q, k) for q in quantities for k in range(len(self.variators))]

    def residuals(self, quantity: str, k: int) -> list[tuple[Value, float]]:
        """Values of a quantity and their residuals with a set, SI."""
        pairs = [(value, value.of(self.states[k])) for value in self.values if value.measured.quantity == quantity]
        return [(value, found - value.measured.value) for value, found in pairs if found is not None]


def _score(held: HoldOut, quantity: str, k: int) -> Score:
    pairs = held.residuals(quantity, k)
    total = sum(value.measured.quantity == quantity for value in held.values)
    if not pairs:
        return Score(quantity, held.variators[k], 0, total, np.nan, np.nan, np.nan, np.nan)
    residuals = np.array([residual for _, residual in pairs])
    measured = np.array([value.measured.value for value, _ in pairs])
    deviations = np.array([value.measured.deviation for value, _ in pairs])
    spread = float(np.sum((measured - measured.mean()) ** 2))
    return Score(
        quantity, held.variators[k], len(pairs), total - len(pairs), float(np.sqrt(np.mean(residuals**2))), float(residuals.mean()),
        float(np.sqrt(np.mean((residuals / deviations) ** 2))), 1.0 - float(np.sum(residuals**2)) / spread if spread else np.nan,
    )  # fmt: skip


def hold_out(fmu: Path, table: Path, variator: str, reading: Reading | None = None, oil: Oil | None = None, workers: int = 2) -> HoldOut:
    """Solves all points of a table with a set, and with the default one if it is another.

    Raises TableError, and the errors of the parameter set.
    """
    rig = points.read(table, reading, oil)
    names = (variator,) if variator == DEFAULT else (variator, DEFAULT)
    sets = [parameter_set(name) for name in names]
    version = described(fmu).version or ""
    with progress_bar(len(sets) * len(rig.points), "steady states") as bar, model.opened(fmu, {}, rig.points, workers, bar.update) as opened:
        states = opened.states(sets)
        return HoldOut(rig, version, names, opened.values, tuple(map(tuple, states)))


# Report

SCORES = (
    "quantity", "variator", "values", "lost values", "rms [SI]", "bias [SI]", "rms/sd [1]", "explained share [1]",
)  # fmt: skip


def write(held: HoldOut, folder: Path) -> Path:
    """Writes report.html, holdout.csv, holdout.json and residuals.csv; returns the path of the report."""
    folder.mkdir(parents=True, exist_ok=True)
    scores = held.scores()
    rows = [(s.quantity, s.variator, s.count, s.lost, s.rms, s.bias, s.relative, s.explained) for s in scores]
    tables.write(folder / "holdout.csv", SCORES, rows)
    document = [{**s.__dict__, **{k: None for k, v in s.__dict__.items() if v != v}} for s in scores]
    (folder / "holdout.json").write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")
    header = ["line", "name", "time [s]", "quantity", "measured [SI]", "sd [SI]", *(f"{name} [SI]" for name in held.variators)]
    tables.write(folder / "residuals.csv", header, map(list, _residual_rows(held)))
    path = folder / "report.html"
    context = {
        "held": held,
        "scores": scores,
        "notes": points.understood(held.rig)[1:],
        "figures": [(q, MEASURED[q].meaning, figure(held, q)) for q in dict.fromkeys(s.quantity for s in scores if s.count)],
        "lost": [(held.rig.points[k], name, found.reason) for name, states in zip(held.variators, held.states, strict=True)
                 for k, found in enumerate(states) if found.reason is not None],
    }  # fmt: skip
    page.write_html("calibrate/holdout.html.j2", context, path, plain=plain)
    return path


def _residual_rows(held: HoldOut):
    for value in held.values:
        point, measured = held.rig.points[value.point], value.measured
        yield point.line, point.name, measured.time, measured.quantity, measured.value, measured.deviation, *(
            value.of(states) for states in held.states
        )


def plain(value: float) -> str:
    """A number with four significant digits."""
    return "–" if value != value else f"{value:.4g}".replace("-", page.MINUS)


def sentence(score: Score) -> str:
    """A score in one line."""
    lost = f", {score.lost} values without a steady state" if score.lost else ""
    return f"{score.quantity}, {score.variator}: {plain(score.relative)} standard deviations, bias {plain(score.bias)}{lost}"


def figure(held: HoldOut, quantity: str) -> Chart:
    """Model over measurement, and residuals over torque and ratio."""
    return residual_figures.residuals(
        quantity, {name: _residuals(held, quantity, k) for k, name in enumerate(held.variators) if held.residuals(quantity, k)}
    )


def _residuals(held: HoldOut, quantity: str, k: int) -> list[Residual]:
    found = [(held.rig.points[value.point], value.measured, residual) for value, residual in held.residuals(quantity, k)]
    return [
        Residual(point.name, point.torque, point.ratio or point.speed_ratio, measured.value, measured.value + residual, measured.deviation)
        for point, measured, residual in found
    ]
