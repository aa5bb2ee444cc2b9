"""Losses: comparison of the FMU with the efficiency map of a whole transmission, bounds from the literature, and drag without torque."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pushbelt.charts import Chart, Panel
from pushbelt.fmu.starts import driven_at_speed, driven_by_torque

from ..bench import Bench, Plan, rad
from ..measured import ESTIMATE, MapPoint, bound, data, source, transmission_map
from ..outcome import (
    PERCENT,
    Check,
    Column,
    Part,
    Section,
    Table,
    Unit,
    Verdict,
    curve,
    reported,
    share,
    table,
    within,
)

SAFETIES = (1.3, 2.0)
"""Safety factors: that of a slip-controlled variator, and a larger one as without a slip controller."""
LEAST_FORCE = 4e3
"""Least secondary force, N."""
POINTS = Unit("points", 1, 100.0)
NEWTON_METRES = Unit("N·m", 2)

BAND_SPEED = 2000.0
BAND_RATIOS = (2.0, 1.0, 0.5)
BANDS = {50.0: (0.95, 0.98), 25.0: (0.92, 0.97), 10.0: (0.83, 0.94)}
"""Efficiency of a variator alone by primary torque, N·m, at safety 1.3, 2000 rpm and ratios 2 to 0.5."""
DRAG_SPEEDS = (500.0, 2000.0, 5000.0)
DRAG_FORCE = 10e3
DRAG = (0.8, 2.0)
"""Torque on P without load, N·m, from 500 to 5000 rpm at ratio 1."""

BOUND_FORCES = (10.5e3, 34.6e3)
BOUND_RATIOS = (2.36, 1.0, 0.44)
BOUND_TORQUES = (20.0, 40.0, 60.0)


@dataclass(frozen=True)
class Beside:
    """A measured point and the FMU's efficiencies at both safety factors."""

    measured: MapPoint
    efficiencies: tuple[float, ...]

    @property
    def margin(self) -> float:
        """Least efficiency of the FMU minus the measured one."""
        return min(self.efficiencies) - self.measured.efficiency

    @property
    def missing_torque(self) -> float:
        """Loss of the rest of the transmission as a torque on its primary shaft, N·m, at the smaller safety factor."""
        return self.measured.torque * (self.efficiencies[0] - self.measured.efficiency)


def run(bench: Bench, plan: Plan) -> Section:
    """Solves the points and evaluates the checks."""
    beside = _beside(bench, plan)
    bands, band_checks = _bands(bench, plan)
    drag, drag_checks = _drag(bench, plan)
    bounds, bound_checks = _bounds(bench, plan, beside)
    trends = _trends(beside)
    return Section(
        "efficiency",
        Part.MEASUREMENTS,
        "Efficiency",
        "Comparison with a measured map of a whole transmission (variator, final drive, pump) without published clamping "
        "forces. The efficiency of the variator alone "
        "must be above each of its points, with safety factors of 1.3 (controlled) and 2 (over-clamped).",
        (*_map_checks(beside), *_trend_checks(trends), *band_checks, *drag_checks, *bound_checks),
        (trends, _rest_table(beside), bands, drag, bounds, _map_table(beside)),
        (_chart(beside),),
        (
            "Efficiency is that between the shafts: it includes their bearings and seals, but not pump, final drive and clutch.",
            "The loss of the rest of the transmission is the difference to the FMU at a safety factor of 1.3, "
            "fitted by "
            "c₀ + c₁ n + c₂ T over all points.",
        ),
    )


def _efficiency(bench: Bench, ratio: float, rpm: float, torque: float, force: float) -> float | None:
    """Efficiency of the shafts under a primary torque."""
    speed = rad(rpm)
    values = driven_by_torque(bench.parameters, ratio, speed, torque, force)
    out = bench.steady(values, f"ratio {ratio:g}, {rpm:g} rpm, {torque:g} N·m, {force / 1e3:.1f} kN")
    return out["efficiency"] if out else None


def _beside(bench: Bench, plan: Plan) -> list[Beside]:
    found = []
    points = transmission_map()
    ratios = dict.fromkeys(point.ratio for point in points)
    for point in (p for ratio in ratios for p in plan.thin([p for p in points if p.ratio == ratio])):
        efficiencies = [
            _efficiency(
                bench, point.ratio, point.rpm, point.torque, bench.force(point.ratio, point.torque, safety, LEAST_FORCE)
            )
            for safety in SAFETIES
        ]
        if None not in efficiencies:
            found.append(Beside(point, tuple(efficiencies)))  # type: ignore[arg-type]
    return found


def _map_checks(beside: Sequence[Beside]) -> list[Check]:
    checks = [
        within(
            f"efficiency-safety-{safety:g}",
            f"The efficiency of the variator at a safety factor of {safety:g} is above the transmission's at each measured point",
            source("transmissionMap"),
            [
                (f"ratio {b.measured.ratio:g}, {b.measured.rpm:g} rpm, {b.measured.torque:g} N·m",
                 b.efficiencies[k] - b.measured.efficiency)
                for b in beside
            ],
            0.0,
            None,
            POINTS,
            goal="efficiency above the measured one",
        )
        for k, safety in enumerate(SAFETIES)
    ]  # fmt: skip
    rest = [b.missing_torque for b in beside]
    constant, per_speed, per_torque = _rest(beside)
    checks.append(
        reported(
            "efficiency-rest",
            "Loss of the rest of the transmission",
            source("transmissionMap"),
            "not published",
            f"{NEWTON_METRES.text(*rest)} on the primary shaft; fitted by {constant:.2f} N·m, {1e3 * per_speed:+.2f} "
            "N·m per 1000 rpm "
            f"and {100.0 * per_torque:+.1f} % of the torque".replace("-", "−"),
        )
    )
    return checks


def _rest(beside: Sequence[Beside]) -> tuple[float, float, float]:
    """c₀ in N·m, c₁ in N·m per rpm and c₂ of the losses outside the variator, by least squares."""
    matrix = np.array([[1.0, b.measured.rpm, b.measured.torque] for b in beside])
    found, *_ = np.linalg.lstsq(matrix, np.array([b.missing_torque for b in beside]), rcond=None)
    return tuple(found.tolist())


def _slopes(points: Sequence[MapPoint], efficiencies: Sequence[float]) -> tuple[float, float]:
    """Change of the efficiency per doubling of torque and of speed, by least squares."""
    matrix = np.array([[1.0, math.log2(p.torque), math.log2(p.rpm)] for p in points])
    found, *_ = np.linalg.lstsq(matrix, np.array(efficiencies), rcond=None)
    return float(found[1]), float(found[2])


def _trends(beside: Sequence[Beside]) -> Table:
    rows = []
    for ratio in dict.fromkeys(b.measured.ratio for b in beside):
        group = [b for b in beside if b.measured.ratio == ratio]
        if len(group) < 3:
            continue
        points = [b.measured for b in group]
        measured = _slopes(points, [p.efficiency for p in points])
        controlled, clamped = (_slopes(points, [b.efficiencies[k] for b in group]) for k in range(len(SAFETIES)))
        rows.append([ratio, *(value for pair in zip(measured, controlled, clamped, strict=True) for value in pair)])
    columns = [Column("Ratio", digits=1)] + [
        Column(f"{what}, {whose}", "points", 1, 100.0, signed=True)
        for what in ("Torque × 2", "Speed × 2")
        for whose in ("measured", "FMU at 1.3", "FMU at 2")
    ]
    note = "Change of the efficiency per doubling, a plane in log₂ T and log₂ n fitted to each ratio's points."
    return table("efficiency-trends", "Trend over torque and speed", columns, rows, note)


def _trend_checks(trends: Table) -> list[Check]:
    checks = []
    for place, key, statement in (
        (1, "efficiency-torque", "Efficiency rises with torque as measured"),
        (4, "efficiency-speed", "Efficiency falls with speed as measured"),
    ):
        found = [
            (str(row[0]), float(row[place]), float(row[place + 1]))
            for row in trends.rows  # type: ignore[arg-type]
        ]
        wrong = [f"ratio {ratio}" for ratio, measured, ours in found if measured * ours < 0.0]
        checks.append(
            Check(
                key,
                f"{statement}, in each ratio",
                source("transmissionMap"),
                "the same sign per doubling",
                f"{POINTS.text(*(ours for _, _, ours in found))} (measured {POINTS.text(*(m for _, m, _ in found))})",
                Verdict.MISSED if wrong else Verdict.MET,
                f"other sign: {', '.join(wrong)}" if wrong else "",
            )
        )
    return checks


def _rest_table(beside: Sequence[Beside]) -> Table:
    rows = []
    for ratio in dict.fromkeys(b.measured.ratio for b in beside):
        group = [b for b in beside if b.measured.ratio == ratio]
        rest = [b.missing_torque for b in group]
        watts = [b.missing_torque * rad(b.measured.rpm) for b in group]
        margins = [b.margin for b in group]
        rows.append(
            [ratio, float(len(group)), min(margins), min(rest), float(np.mean(rest)), max(rest), float(np.mean(watts))]
        )
    columns = (
        Column("Ratio", digits=1),
        Column("Points", digits=0),
        Column("Least margin", "points", 1, 100.0, signed=True),
        Column("Rest, least", "N·m", 2),
        Column("mean", "N·m", 2),
        Column("most", "N·m", 2),
        Column("mean power", "W", 0),
    )
    note = "The least margin is that of both safety factors; other values are at a safety factor of 1.3."
    return table("efficiency-rest", "Loss of the rest of the transmission", columns, rows, note)


def _map_table(beside: Sequence[Beside]) -> Table:
    columns = (
        Column("Ratio", digits=1),
        Column("Speed", "rpm", 0),
        Column("Torque", "N·m", 1),
        share("Measured", signed=False),
        share("FMU, safety 1.3", signed=False),
        share("FMU, safety 2", signed=False),
    )
    rows = [
        [b.measured.ratio, b.measured.rpm, b.measured.torque, b.measured.efficiency, *b.efficiencies] for b in beside
    ]
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
    design = data()["designValues"]["efficiency"]
    checks.append(
        reported("efficiency-design", "Efficiency assumed in design", source("designValues"), PERCENT.text(design), "the lines above"),
    )
    columns = (
        Column("Ratio", digits=1),
        Column("Torque", "N·m", 0),
        Column("F_S", "kN", 1, 1e-3),
        share("Efficiency", 1, signed=False),
    )
    return table("efficiency-bands", "A variator alone at 2000 rpm, safety 1.3", columns, rows), checks


def _drag(bench: Bench, plan: Plan) -> tuple[Table, list[Check]]:
    """Torque on P that turns a variator without load. All input power is lost."""
    rows, torques = [], []
    for rpm in plan.thin(DRAG_SPEEDS):
        out = bench.steady(
            driven_at_speed(bench.parameters, 1.0, rad(rpm), 0.0, DRAG_FORCE, held=True), f"drag, {rpm:g} rpm"
        )
        if out:
            rows.append([rpm, *(out[name] / out["primary.speed"] for name in ("loss.total", *LOSSES))])
        torques.append((f"{rpm:g} rpm", rows[-1][1] if out else None))
    values = [row[1] for row in rows]
    rising = all(later > earlier for earlier, later in zip(values, values[1:], strict=False))
    checks = [
        within(
            "drag",
            "Torque that turns it without load, ratio 1, 10 kN, 500 to 5000 rpm",
            ESTIMATE,
            torques,
            *DRAG,
            NEWTON_METRES,
        ),
        Check(
            "drag-rises",
            "The torque without load grows with speed",
            ESTIMATE,
            "oil and bearings",
            NEWTON_METRES.text(*values),
            Verdict.MET if rising else Verdict.MISSED,
            "" if rising else "it doesn't",
        ),
    ]
    columns = [Column("Speed", "rpm", 0), Column("Torque on P", "N·m", 2)]
    columns += [Column(name.removeprefix("loss."), "N·m", 2) for name in LOSSES]
    return table("drag", "Drag without load, ratio 1, 10 kN", columns, rows), checks


LOSSES = ("loss.sheaves", "loss.ring", "loss.layers", "loss.spin", "loss.shafts", "loss.other")


def _bounds(bench: Bench, plan: Plan, beside: Sequence[Beside]) -> tuple[Table, list[Check]]:
    """Statements of experimental studies about a variator at fixed force."""
    rows: list[list[float]] = []
    for force in plan.thin(BOUND_FORCES, 1):
        for torque in BOUND_TORQUES:
            found = [_efficiency(bench, ratio, 2000.0, torque, force) for ratio in BOUND_RATIOS]
            if None not in found:
                rows.append([force, torque, *found])  # type: ignore[list-item]
    lower = [
        (f"{force / 1e3:g} kN, {torque:g} N·m", overdrive - max(under, one))
        for force, torque, under, one, overdrive in rows
    ]
    rising = [
        (f"{now[0] / 1e3:g} kN, {now[1]:g} N·m", after[k] - now[k])
        for now, after in zip(rows, rows[1:], strict=False)
        if now[0] == after[0]
        for k in (2, 3, 4)
    ]
    peak = max([value for row in rows for value in row[2:]] + [value for b in beside for value in b.efficiencies])
    checks = [
        within(
            "efficiency-overdrive", "Efficiency is lower in overdrive than at ratios 1 and 2.36", bound(0), lower, None, 0.0, POINTS, "lower"
        ),
        within(
            "efficiency-load", "Efficiency is lower at low load", bound(0), rising, 0.0, None, POINTS, "rises from 20 to 40 and 60 N·m"
        ),
        within(
            "efficiency-peak",
            "A peak above 97 % is possible with a small pump",
            bound(1),
            [("peak of all points here", peak)],
            0.97,
            None,
            PERCENT,
        ),
    ]
    columns = (
        Column("F_S", "kN", 1, 1e-3),
        Column("Torque", "N·m", 0),
        *(share(f"ratio {ratio:g}", signed=False) for ratio in BOUND_RATIOS),
    )
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
