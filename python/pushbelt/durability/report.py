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
    estimates = [clamping(result) for result in results]
    context = {"runs": list(zip(results, estimates, strict=True)), "material": results[0].material, "document": document}
    page.write_html("durability/durability.html.j2", context | {"figures": figures, "life": _life}, folder / "report.html", short=short)
    return folder / "report.html"


def summary(result: Damage) -> str:
    used = f"largest equivalent amplitude {100.0 * result.utilisation:.0f} % of the fatigue limit"
    if result.total == 0.0:
        return f"damage 0, {used}; without the limit {_life(result, result.total_without_limit)}"
    return f"damage {result.total:.3g}, life {_life(result, result.total)}, {used}"


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


def _entry(result: Damage) -> dict[str, Any]:
    """A run as JSON. A life without end is null."""
    hours, kilometres = (life if life and math.isfinite(life) else None for life in result.life(result.total))
    table, parts, classes = result.table, result.parts, result.classes()
    return {
        "name": table.name, "file": table.path.name, "sha256": table.identity,
        "geometry.beltLength": result.parameters["geometry.beltLength"],
        "duration": table.duration, "distance": table.distance, "revolutions": float(result.turns.sum()),
        "damage": result.total, "damageWithoutLimit": result.total_without_limit, "utilisation": result.utilisation,
        "lifeHours": hours, "lifeKilometres": kilometres,
        "sharesWithLimit": result.limited,
        "shares": {name: result.share(part=name) for name in parts}
        | {f"{kind}: {name}": result.share(rows) for kind, name, rows in classes},
        "clampingEstimate": [
            dict(zip(("factor", "damage", "damageWithoutLimit", "utilisation"), one, strict=True)) for one in clamping(result)
        ],
    }  # fmt: skip


def clamping(result: Damage) -> list[tuple[float, float, float, float]]:
    """Factor on the clamping forces, damage with and without fatigue limit, and utilisation. Empty without an estimate."""
    found = [(factor, result if factor == 1.0 else result.clamped(factor)) for factor in CLAMPING]
    if any(one is None for _, one in found):
        return []
    return [(factor, one.total, one.total_without_limit, one.utilisation) for factor, one in found]


def _rows(results: Sequence[Damage], names: Sequence[str]) -> Iterator[list[Any]]:
    for result in results:
        sums = [np.cumsum(sum(result.rows[limited].values())) for limited in (True, False)]
        parts = [result.equivalent.get(name, np.full(len(result.turns), np.nan)) for name in names]
        rows = np.column_stack([result.table["time"], np.cumsum(result.turns), *sums, *parts])
        yield from ([result.table.name, *row] for row in rows.tolist())
