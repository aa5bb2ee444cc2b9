"""Losses: comparison of the FMU with the efficiency map of a whole transmission, bounds from the literature, and drag without torque."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pushbelt.fmu.steady import driven_at_speed, driven_by_torque
from pushbelt.report.charts import Chart, Panel

from ..bench import Bench, Plan, rad
from ..measured import ESTIMATE, MapPoint, data, source, transmission_map
from ..outcome import PERCENT, POINTS, Check, Column, Part, Section, Table, Unit, curve, reported, share, table, within

SAFETIES = (1.3, 2.0)
"""Safety factors: that of a slip-controlled variator, and a larger one as without a slip controller."""
LEAST_FORCE = 4e3
"""Least secondary force, N."""
NEWTON_METRES = Unit("N·m", 2)
BAND_SPEED = 2000.0
BAND_RATIOS = (2.0, 1.0, 0.5)
BANDS = {50.0: (0.95, 0.98), 25.0: (0.92, 0.97), 10.0: (0.83, 0.94)}
"""Efficiency of a variator alone by primary torque, N·m, at safety 1.3, 2000 rpm and ratios 2 to 0.5."""
DRAG_SPEEDS = (500.0, 2000.0, 5000.0)
DRAG_FORCE = 10e3
DRAG = (0.8, 2.0)
"""Torque on P without load, N·m, from 500 to 5000 rpm at ratio 1."""
LOSSES = ("loss.sheaves", "loss.ring", "loss.layers", "loss.spin", "loss.shafts", "loss.other")
BOUND_FORCES = (10.5e3, 34.6e3)
BOUND_RATIOS = (2.36, 1.0, 0.44)
BOUND_TORQUES = (20.0, 40.0, 60.0)
MAP = source("transmissionMap")
POINT = 0.01
"""Tolerance of an efficiency with one limit, by which misses are counted: a point."""


@dataclass(frozen=True)
class Beside:
    """A measured point and the FMU's efficiencies at both safety factors."""

    measured: MapPoint
    efficiencies: tuple[float, ...]

    @property
    def name(self) -> str:
        """Ratio, speed and torque."""
        return f"ratio {self.measured.ratio:g}, {self.measured.rpm:g} rpm, {self.measured.torque:g} N·m"


def run(bench: Bench, plan: Plan) -> Section:
    """Solves the points and evaluates the checks."""
    beside = _beside(bench, plan)
    bands, band_checks = _bands(bench, plan)
    drag, drag_checks = _drag(bench, plan)
    bounds, bound_checks = _bounds(bench, plan, beside)
    return Section(
        "efficiency",
        Part.MEASUREMENTS,
        "Efficiency",
        "Comparison with a measured map of a whole transmission (variator, final drive, pump) without published clamping forces. The "
        "efficiency of the variator alone must be above each of its points, with safety factors of 1.3 (controlled) and 2 (over-clamped).",
        (*_map_checks(beside), *_trend_checks(beside), *band_checks, *drag_checks, *bound_checks),
        (bands, drag, bounds, _map_table(beside)),
        (_chart(beside),),
        ("Efficiency is that between the shafts: it includes their bearings and seals, but not pump, final drive and clutch.",),
    )


def _efficiency(bench: Bench, ratio: float, rpm: float, torque: float, force: float) -> float | None:
    """Efficiency of the shafts under a primary torque."""
    values = driven_by_torque(bench.parameters, ratio, rad(rpm), torque, force)
    out = bench.steady(values, f"ratio {ratio:g}, {rpm:g} rpm, {torque:g} N·m, {force / 1e3:.1f} kN")
    return out["efficiency"] if out else None


def _beside(bench: Bench, plan: Plan) -> list[Beside]:
    found = []
    points = transmission_map()
    ratios = dict.fromkeys(point.ratio for point in points)
    for point in (p for ratio in ratios for p in plan.thin([p for p in points if p.ratio == ratio])):
        forces = [bench.force(point.ratio, point.torque, safety, LEAST_FORCE) for safety in SAFETIES]
        efficiencies = [_efficiency(bench, point.ratio, point.rpm, point.torque, force) for force in forces]
        if None not in efficiencies:
            found.append(Beside(point, tuple(efficiencies)))  # type: ignore[arg-type]
    return found


def _map_checks(beside: Sequence[Beside]) -> list[Check]:
    margins = [[(b.name, b.efficiencies[k] - b.measured.efficiency) for b in beside] for k in range(len(SAFETIES))]
    statement = "The efficiency of the variator is above the transmission's at each measured point, safety {:g}"
    return [
        within(key, statement.format(safety), MAP, found, 0.0, None, POINTS, "above the measured one", POINT)
        for key, safety, found in zip(("efficiency-map", "efficiency-map-clamped"), SAFETIES, margins, strict=True)
    ]


def slopes(points: Sequence[MapPoint], efficiencies: Sequence[float]) -> tuple[float, float]:
    """Change of the efficiency per doubling of torque and of speed, by least squares."""
    matrix = np.array([[1.0, math.log2(p.torque), math.log2(p.rpm)] for p in points])
    found, *_ = np.linalg.lstsq(matrix, np.array(efficiencies), rcond=None)
    return float(found[1]), float(found[2])


def _trend_checks(beside: Sequence[Beside]) -> list[Check]:
    """Signs of the slopes of each ratio's points, measured and of the FMU at the smaller safety factor."""
    groups: dict[str, list[Beside]] = {}
    for b in beside:
        groups.setdefault(f"ratio {b.measured.ratio:g}", []).append(b)
    pairs = {
        name: (slopes([b.measured for b in of], [b.measured.efficiency for b in of]), slopes([b.measured for b in of], [b.efficiencies[0] for b in of]))
        for name, of in groups.items()
        if len(of) > 2
    }  # fmt: skip
    theirs = [measured for measured, _ in pairs.values()]
    rises = [(name, ours[0]) for name, (_, ours) in pairs.items()]
    falls = [(name, -ours[1]) for name, (_, ours) in pairs.items()]
    return [
        within(
            "efficiency-torque", "Efficiency rises with torque as measured, in each ratio, safety 1.3", MAP, rises, 0.0, None, POINTS,
            f"rises; measured by {POINTS.text(*(s[0] for s in theirs))} per doubling", POINT,
        ),
        within(
            "efficiency-speed", "Efficiency falls with speed as measured, in each ratio", MAP, falls, 0.0, None, POINTS,
            f"falls; measured by {POINTS.text(*(-s[1] for s in theirs))} per doubling", POINT,
        ),
    ]  # fmt: skip


def _map_table(beside: Sequence[Beside]) -> Table:
    columns = (
        Column("Ratio", digits=1), Column("Speed", "rpm", 0), Column("Torque", "N·m", 1), share("Measured", signed=False),
        share("FMU, safety 1.3", signed=False), share("FMU, safety 2", signed=False),
    )  # fmt: skip
    rows = [[b.measured.ratio, b.measured.rpm, b.measured.torque, b.measured.efficiency, *b.efficiencies] for b in beside]
    return table("efficiency-map", "All points", columns, rows)


def _bands(bench: Bench, plan: Plan) -> tuple[Table, list[Check]]:
    rows, checks = [], []
    for torque, (low, high) in BANDS.items():
        found = []
        for ratio in plan.thin(BAND_RATIOS):
            force = bench.force(ratio, torque, SAFETIES[0], LEAST_FORCE)
            efficiency = _efficiency(bench, ratio, BAND_SPEED, torque, force)
            rows.append([ratio, torque, force, efficiency])
            found.append((f"ratio {ratio:g}", efficiency))
        statement = f"A variator alone at {torque:g} N·m, safety 1.3, 2000 rpm, ratios 2 to 0.5"
        checks.append(within(f"efficiency-{torque:g}-Nm", statement, ESTIMATE, found, low, high, PERCENT))
    design = PERCENT.text(data()["designValues"]["efficiency"])
    checks.append(reported("efficiency-design", "Efficiency assumed in design", source("designValues"), design, "the lines above"))
    columns = (Column("Ratio", digits=1), Column("Torque", "N·m", 0), Column("F_S", "kN", 1, 1e-3), share("Efficiency", 1, signed=False))
    return table("efficiency-bands", "A variator alone at 2000 rpm, safety 1.3", columns, rows), checks


def _drag(bench: Bench, plan: Plan) -> tuple[Table, list[Check]]:
    """Torque on P that turns a variator without load. All input power is lost."""
    rows: list[list[float | None]] = []
    for rpm in plan.thin(DRAG_SPEEDS):
        out = bench.steady(driven_at_speed(bench.parameters, 1.0, rad(rpm), 0.0, DRAG_FORCE, held=True), f"drag, {rpm:g} rpm")
        rows.append([rpm, *(out and out[name] / out["primary.speed"] for name in ("loss.total", *LOSSES))])
    torques = [(f"{row[0]:g} rpm", row[1]) for row in rows]
    steps = [(f"to {b[0]:g} rpm", b[1] - a[1] if a[1] and b[1] else None) for a, b in zip(rows, rows[1:], strict=False)]
    checks = [
        within("drag", "Torque that turns it without load, ratio 1, 10 kN, 500 to 5000 rpm", ESTIMATE, torques, *DRAG, NEWTON_METRES),
        within("drag-rises", "The torque without load grows with speed, by oil and bearings", ESTIMATE, steps, 0.0, None, NEWTON_METRES, "grows", 0.1),
    ]
    columns = [Column("Speed", "rpm", 0), Column("Torque on P", "N·m", 2), *(Column(name.removeprefix("loss."), "N·m", 2) for name in LOSSES)]
    return table("drag", "Drag without load, ratio 1, 10 kN", columns, rows), checks


def _bounds(bench: Bench, plan: Plan, beside: Sequence[Beside]) -> tuple[Table, list[Check]]:
    """Statements of experimental studies about a variator at fixed force."""
    rows: list[list[float]] = []
    for force in plan.thin(BOUND_FORCES, 1):
        for torque in BOUND_TORQUES:
            found = [_efficiency(bench, ratio, 2000.0, torque, force) for ratio in BOUND_RATIOS]
            if None not in found:
                rows.append([force, torque, *found])  # type: ignore[list-item]
    lower = [(f"{force / 1e3:g} kN, {torque:g} N·m", over - max(under, one)) for force, torque, under, one, over in rows]
    rising = [
        (f"{now[0] / 1e3:g} kN, {now[1]:g} N·m", after[k] - now[k])
        for now, after in zip(rows, rows[1:], strict=False)
        if now[0] == after[0]
        for k in (2, 3, 4)
    ]
    peak = max([value for row in rows for value in row[2:]] + [value for b in beside for value in b.efficiencies])
    checks = [
        within("efficiency-overdrive", "Efficiency is lower in overdrive than at ratios 1 and 2.36", source(0), lower, None, 0.0, POINTS, "lower", POINT),
        within("efficiency-load", "Efficiency is lower at low load", source(0), rising, 0.0, None, POINTS, "rises from 20 to 40 and 60 N·m", POINT),
        within("efficiency-peak", "A peak above 97 % is possible with a small pump", source(1), [("all points", peak)], 0.97, None, PERCENT),
    ]
    columns = (Column("F_S", "kN", 1, 1e-3), Column("Torque", "N·m", 0), *(share(f"ratio {ratio:g}", signed=False) for ratio in BOUND_RATIOS))
    return table("efficiency-bounds", "Efficiency at fixed force, 2000 rpm", columns, rows), checks


def _chart(beside: Sequence[Beside]) -> Chart:
    """Efficiency in per cent over torque, one panel per ratio."""
    panels: list[Panel] = []
    for ratio in dict.fromkeys(b.measured.ratio for b in beside):
        group = sorted((b for b in beside if b.measured.ratio == ratio), key=lambda b: b.measured.torque)
        series = [("transmission, measured", 1, "o", [b.measured.efficiency for b in group])]
        for k, (safety, style) in enumerate(zip(SAFETIES, (".", "x"), strict=True)):
            series.append((f"FMU, safety {safety:g}", 0, style, [b.efficiencies[k] for b in group]))
        torques = [b.measured.torque for b in group]
        curves = [curve(name, torques, [100.0 * v for v in values], colour, style) for name, colour, style, values in series]
        panels.append(Panel(f"Ratio {ratio:g}: efficiency (%)", curves, "primary torque (N·m)", height=300))
    return Chart(panels, "Points at one torque differ in speed, 1500 to 5000 rpm.", columns=3, common_legend=len(panels) > 1)
