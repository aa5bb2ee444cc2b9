"""The report: one self-contained HTML file, and the results as JSON and CSV."""

from __future__ import annotations

import dataclasses
import importlib.metadata
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pushbelt import tables
from pushbelt._version import __version__
from pushbelt.report import page

from . import figures
from .damage import CLAMPING, Damage

UNITS = {
    "duration": "s", "distance": "m", "revolutions": "1", "damage": "1", "damageWithoutLimit": "1", "utilisation": "1",
    "lifeHours": "h", "lifeKilometres": "km", "strength": "Pa", "limit": "Pa", "knee": "1", "slope": "1", "safety": "1",
    "geometry.beltLength": "m",
}  # fmt: skip


def write(results: Sequence[Damage], folder: Path) -> Path:
    """Writes report.html, durability.json and durability.csv; returns the path of the report."""
    document = {
        "version": __version__,
        "rainflow": importlib.metadata.version("rainflow"),
        "units": UNITS,
        "material": dataclasses.asdict(results[0].material),
        "runs": [_entry(result) for result in results],
    }
    text = json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False)
    (folder / "durability.json").write_text(text + "\n", encoding="utf-8")
    names = list(dict.fromkeys(name for result in results for name in result.parts))
    columns = ["time [s]", "revolutions [1]", "damage [1]", "damageWithoutLimit [1]"]
    header = ["run", *columns, *(f"equivalentAmplitude, {name} [Pa]" for name in names)]
    tables.write(folder / "durability.csv", header, _rows(results, names), digits=7)
    path = folder / "report.html"
    context = {
        "runs": [_shown(key, result) for key, result in enumerate(results, start=1)],
        "material": results[0].material,
        "document": document,
    }
    page.write_html("durability/durability.html.j2", context, path, short=short)
    return path


def summary(result: Damage) -> str:
    """One line about a run."""
    life = _life(result, result.total)
    used = f"largest equivalent amplitude {100.0 * result.utilisation:.0f} % of the fatigue limit"
    if result.total == 0.0:
        return f"damage 0, {used}; without the limit {_life(result, result.total_without_limit)}"
    return f"damage {result.total:.3g}, life {life}, {used}"


def short(value: float) -> str:
    """A number with three significant digits."""
    if not math.isfinite(value):
        return "∞"
    if 1e3 <= abs(value) < 1e7:
        return page.number(float(f"{value:.3g}"))
    return f"{value:.3g}".replace("e+0", "e").replace("e+", "e").replace("-", page.MINUS)


def _life(result: Damage, damage: float) -> str:
    hours, kilometres = result.life(damage)
    if not math.isfinite(hours):
        return "unlimited"
    return f"{short(hours)} h" if kilometres is None else f"{short(kilometres)} km"


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def _entry(result: Damage) -> dict[str, Any]:
    """A run as JSON. A life without end is null."""
    hours, kilometres = result.life(result.total)
    every = np.ones(len(result.turns), dtype=bool)
    return {
        "name": result.table.name,
        "file": result.table.path.name,
        "sha256": result.table.identity,
        "geometry.beltLength": result.parameters["geometry.beltLength"],
        "duration": result.table.duration,
        "distance": result.table.distance,
        "revolutions": float(result.turns.sum()),
        "damage": result.total,
        "damageWithoutLimit": result.total_without_limit,
        "utilisation": result.utilisation,
        "lifeHours": _finite(hours),
        "lifeKilometres": _finite(kilometres),
        "sharesWithLimit": result.limited,
        "shares": {
            **{name: result.share(every, name) for name in result.parts},
            **{f"{one.kind}: {one.name}": result.share(one.rows) for one in result.classes()},
        },
        "clampingEstimate": [
            {"factor": factor, "damage": damage, "damageWithoutLimit": without, "utilisation": used}
            for factor, damage, without, used in clamping(result)
        ],
    }


def clamping(result: Damage) -> list[tuple[float, float, float, float]]:
    """Factor on the clamping forces, damage with and without fatigue limit, and utilisation. Empty without an estimate."""
    found = [(factor, result if factor == 1.0 else result.clamped(factor)) for factor in CLAMPING]
    if any(one is None for _, one in found):
        return []
    return [(factor, one.total, one.total_without_limit, one.utilisation) for factor, one in found]


def _rows(results: Sequence[Damage], names: Sequence[str]) -> Iterator[list[Any]]:
    for result in results:
        with_limit, without = (np.cumsum(sum(result.rows(limited).values())) for limited in (True, False))
        empty = np.full(len(with_limit), np.nan)
        parts = [result.equivalent.get(name, empty) for name in names]
        rows = np.column_stack([result.table["time"], np.cumsum(result.turns), with_limit, without, *parts])
        for row in rows.tolist():
            yield [result.table.name, *row]


def _shown(key: int, result: Damage) -> dict[str, Any]:
    """Values of a run for the template."""
    every, estimate = np.ones(len(result.turns), dtype=bool), clamping(result)
    turns = result.turns.sum() or 1.0
    classes = [
        (one.kind, one.name, float(result.turns[one.rows].sum() / turns), result.share(one.rows))
        + tuple(result.share(one.rows, name) for name in result.parts)
        for one in result.classes()
    ]
    by = {kind: [one for one in result.classes() if one.kind == kind] for kind in ("ratio", "torque")}
    return {
        "key": f"run-{key}",
        "result": result,
        "life": _life(result, result.total),
        "life_without": _life(result, result.total_without_limit),
        "parts": [(name, result.share(every, name)) for name in result.parts],
        "classes": classes,
        "grid": [
            (torque.name, [result.share(torque.rows & ratio.rows) for ratio in by["ratio"]]) for torque in by["torque"]
        ],
        "ratios": [one.name for one in by["ratio"]],
        "estimate": estimate,
        "over_time": figures.over_time(result),
        "haigh": figures.haigh(result),
        "map": figures.ratio_torque(result),
        "clamping": figures.clamping(estimate) if estimate else None,
    }
