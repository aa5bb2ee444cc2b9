"""The report: one self-contained HTML file, and the results as JSON and CSV."""

import dataclasses
import importlib.metadata
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pushbelt import tables
from pushbelt._version import __version__
from pushbelt.fmu.geometry import Array
from pushbelt.report import page
from pushbelt.report.charts import Chart, Level, Panel, Series, stack
from pushbelt.report.style import BLUE, COLOUR_SCALE, GREEN, MUTED, ORANGE, RED

from .damage import CLAMPING, Damage

COLOURS = (BLUE, ORANGE)
MEGA = 1e-6
ESTIMATED = ("factor", "damage", "damageWithoutLimit", "utilisation")  # Names of what `clamping` estimates
MOST_POINTS = 1500  # Largest number of points of a cloud. The largest amplitudes are among them
UNITS = {
    "duration": "s", "distance": "m", "revolutions": "1", "damage": "1", "damageWithoutLimit": "1", "utilisation": "1",
    "lifeHours": "h", "lifeKilometres": "km", "lifeRepetitions": "1", "strength": "Pa", "limit": "Pa", "knee": "1", "slope": "1", "safety": "1",
    "geometry.beltLength": "m",
}  # fmt: skip


def over_time(result: Damage) -> Chart:
    """Speed of the ring, equivalent amplitude of each part, and accumulated damage."""
    time, limit = result.table["time"], result.material.allowed
    scale = (result.total if result.limited else result.total_without_limit) or 1.0
    most = max(limit, *(float(one.max()) for one in result.equivalent.values()))

    def lines(parts: Mapping[str, Array], factor: float) -> list[Series]:
        return [Series(name, time, factor * one, c) for (name, one), c in zip(parts.items(), COLOURS, strict=True)]

    level = Level(MEGA * limit, "fatigue limit with safety factor", RED)
    damage = {name: np.cumsum(one) for name, one in result.rows[result.limited].items()}
    rows = [
        ("Speed of the ring (m/s)", [Series("ring.speed", time, result.table["ring.speed"], GREEN)], {}),
        ("Largest equivalent amplitude (MPa)", lines(result.equivalent, MEGA), {"levels": [level], "y_range": (0.0, 1.1 * MEGA * most)}),
        (f"Accumulated damage, % of the run's{'' if result.limited else ', without fatigue limit'}", lines(damage, 100.0 / scale), {}),
    ]
    panels = stack(rows, "time (s)", x_range=(float(time[0]), float(time[-1])), height=190)
    return Chart(panels, "Stress and damage over time", linked=True)


def _some(rows: Array) -> Array:
    """At most `MOST_POINTS` of the rows."""
    return rows[:: -(-len(rows) // MOST_POINTS) or 1]


def haigh(result: Damage) -> Chart:
    """Amplitude over mean stress of all cycles, with the Haigh lines."""
    material, series = result.material, []
    for (name, part), colour in zip(result.parts.items(), COLOURS, strict=True):
        rows = np.flatnonzero((part.amplitude[:, 0] > 0.0) & (result.turns > 0.0))
        chosen = _some(rows[np.argsort(-result.equivalent[name][rows])])
        cycles = MEGA * part.mean[chosen, 0], MEGA * part.amplitude[chosen, 0]
        series.append(Series(name, *cycles, colour, "points", size=4, opacity=0.5))
    for text, limit, dash in (("fatigue limit with safety factor", material.allowed, ""), ("fatigue limit", material.limit, "dash")):
        line = [-200.0, 0.0, MEGA * material.strength], [MEGA * limit, MEGA * limit, 0.0]
        series.append(Series(text, *line, RED, dash=dash))
    panel = Panel("", series, "mean stress (MPa)", "amplitude (MPa)", height=320)
    return Chart([panel], "Haigh diagram: amplitude over mean stress")


def ratio_torque(result: Damage) -> Chart | None:
    """Ratio and torque of the rows, coloured by damage per revolution. None if the table lacks them."""
    torque = result.table.torque
    if torque is None or "ratio.geometric" not in result.table.columns:
        return None
    turning = result.turns > 0.0
    each = np.zeros_like(result.turns)
    each[turning] = sum(result.rows[result.limited].values())[turning] / result.turns[turning]
    share = each / (each.max() or 1.0)
    names, ends = ("none", "below 1 %", "1 to 10 %", "10 to 50 %", "above 50 %"), (-1.0, 0.0, 0.01, 0.1, 0.5, 1.0)
    series = []
    for name, low, high, colour in zip(names, ends, ends[1:], (MUTED, *COLOUR_SCALE[1:4], RED), strict=False):
        rows = _some(np.flatnonzero(turning & (share > low) & (share <= high)))
        if len(rows):
            places = result.table["ratio.geometric"][rows], torque[rows]
            series.append(Series(name, *places, colour, "points", size=5, opacity=0.7))
    panel = Panel("Damage per revolution, of the largest one", series, "ratio r_S/r_P", "primary torque (N·m)", height=340)
    return Chart([panel], "Damage over ratio and torque")


def of_clamping(found: list[tuple[float, float, float, float]]) -> Chart:
    """Damage over the factor on the clamping forces: factor, damage with and without fatigue limit, utilisation."""
    factors, with_limit, without, utilisation = np.array(found).T
    base = without[list(factors).index(1.0)] or 1.0
    rows = [
        *[("Damage", with_limit, GREEN)] * bool(with_limit.any()),
        ("Damage without fatigue limit, relative to the run", without / base, BLUE),
        ("Utilisation of the fatigue limit (%)", 100.0 * utilisation, ORANGE),
    ]
    panels = []
    for title, values, colour in rows:
        bars = Series(title.split(" ")[0].lower(), factors, values, colour, "bars", bar_width=0.05)
        panels.append(Panel(title, [bars], "factor on the clamping forces", height=220))
    return Chart(panels, "Effect of the clamping forces", columns=3)


def write(results: Sequence[Damage], folder: Path) -> Path:
    """Writes report.html, durability.json and durability.csv; returns the path of the report."""
    document = {
        "version": __version__, "rainflow": importlib.metadata.version("rainflow"), "units": UNITS,
        "material": dataclasses.asdict(results[0].material), "runs": [_entry(result) for result in results],
    }  # fmt: skip
    names = list(dict.fromkeys(name for result in results for name in result.parts))
    columns = ["time [s]", "revolutions [1]", "damage [1]", "damageWithoutLimit [1]"]
    header = ["run", *columns, *(f"equivalentAmplitude, {name} [Pa]" for name in names)]
    tables.write(folder / "durability.csv", header, _rows(results, names), digits=7)
    text = json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False)
    (folder / "durability.json").write_text(text + "\n", encoding="utf-8")
    context = {
        "runs": [(result, clamping(result)) for result in results], "material": results[0].material, "document": document,
        "life": _life, "over_time": over_time, "haigh": haigh, "ratio_torque": ratio_torque, "clamping": of_clamping,
    }  # fmt: skip
    return page.write_html("durability/durability.html.j2", context, folder / "report.html")


def summary(result: Damage) -> str:
    used = f"largest equivalent amplitude {100.0 * result.utilisation:.0f} % of the fatigue limit"
    if result.total == 0.0:
        return f"damage 0, {used}; without the limit {_life(result, result.total_without_limit)}"
    return f"damage {result.total:.3g}, life {_life(result, result.total)}, {used}"


def _life(result: Damage, damage: float) -> str:
    hours, kilometres = result.life(damage)
    if not math.isfinite(hours):
        return "unlimited"
    if result.table.collective:
        return f"{page.short(hours)} h, {page.short(1.0 / damage)} repetitions"
    return f"{page.short(hours)} h" if kilometres is None else f"{page.short(kilometres)} km"


def _entry(result: Damage) -> dict[str, Any]:
    """A run as JSON. A life without end is null."""
    hours, kilometres = (life if life and math.isfinite(life) else None for life in result.life(result.total))
    table, parts, classes = result.table, result.parts, result.classes()
    return {
        "name": table.name, "file": table.path.name, "sha256": table.identity,
        "geometry.beltLength": result.parameters["geometry.beltLength"],
        "duration": table.duration, "distance": table.distance, "revolutions": float(result.turns.sum()),
        "damage": result.total, "damageWithoutLimit": result.total_without_limit, "utilisation": result.utilisation,
        "lifeHours": hours, "lifeKilometres": kilometres, "lifeRepetitions": 1.0 / result.total if result.total else None,
        "sharesWithLimit": result.limited,
        "shares": {name: result.share(part=name) for name in parts}
        | {f"{kind}: {name}": result.share(rows) for kind, name, rows in classes},
        "clampingEstimate": [dict(zip(ESTIMATED, one, strict=True)) for one in clamping(result)],
    }  # fmt: skip


def clamping(result: Damage) -> list[tuple[float, float, float, float]]:
    """Factor on the clamping forces, damage with and without fatigue limit, and utilisation. Empty without an estimate."""
    found = [(factor, result if factor == 1.0 else result.clamped(factor)) for factor in CLAMPING]
    if any(one is None for _, one in found):
        return []
    return [(factor, one.total, one.total_without_limit, one.utilisation) for factor, one in found if one is not None]


def _rows(results: Sequence[Damage], names: Sequence[str]) -> Iterator[list[Any]]:
    for result in results:
        sums = [np.cumsum(sum(result.rows[limited].values())) for limited in (True, False)]
        parts = [result.equivalent.get(name, np.full(len(result.turns), np.nan)) for name in names]
        rows = np.column_stack([result.table["time"], np.cumsum(result.turns), *sums, *parts])
        yield from ([result.table.name, *row] for row in rows.tolist())
