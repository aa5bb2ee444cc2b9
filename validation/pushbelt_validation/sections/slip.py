"""Slip: traction over slip, and the slip of best efficiency."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from pushbelt.fmu.steady import driven_by_slip, driven_by_torque
from pushbelt.report.charts import Chart, Panel

from ..bench import Bench, Plan, rad
from ..measured import Source, data, source
from ..outcome import PERCENT, Check, Column, Part, Section, Table, Unit, curve, reported, share, table, within

RATIOS = (2.0, 1.0, 0.5)
FORCES = (10e3, 20e3, 30e3)
SPEEDS = (1000.0, 2000.0, 4000.0)
SLIPS = (0.001, 0.002, 0.004, 0.007, 0.01, 0.015, 0.02, 0.03, 0.04, 0.06, 0.08, 0.1)
PEAKS_APART = 0.05
"""Tolerance of the peak traction over force and speed, for the statement that they "can be ignored"."""
AT_SLIPS = (0.02, 0.04)
"""Slips at which traction is compared for different forces and speeds."""
APART = 0.1
LARGEST_FALL = 0.15
"""Largest fall of the traction from its peak to 10 % slip that counts as slight."""

BEST_RATIOS = (2.25, 1.5, 1.0, 0.67, 0.44)
BEST_TORQUE, BEST_SPEED = 50.0, 2000.0
SAFETIES = (0.98, 1.0, 1.02, 1.04, 1.06, 1.08, 1.1, 1.12, 1.14, 1.16, 1.18, 1.2, 1.25, 1.3, 1.4, 1.5, 1.7, 2.0)
PUMP = {"area": 0.01, "displacement": 1e-5, "efficiency": 0.8}
"""A pump that feeds both cylinders: piston area, m²; oil per turn of the primary shaft, m³; efficiency of the pump."""


@dataclass(frozen=True)
class Traction:
    """Torque utilisation over slip at one ratio, force and speed."""

    ratio: float
    force: float
    rpm: float
    slips: tuple[float, ...]
    utilisations: tuple[float, ...]

    @property
    def name(self) -> str:
        """Description of the force and the speed."""
        return f"{self.force / 1e3:g} kN, {self.rpm:g} rpm"

    def at(self, slip: float) -> float:
        """Utilisation at a slip."""
        return float(np.interp(slip, self.slips, self.utilisations))

    @property
    def peak(self) -> float:
        """Largest utilisation."""
        return max(self.utilisations)

    @property
    def fall(self) -> float:
        """Relative fall of the traction from its peak to the largest slip."""
        return 1.0 - self.utilisations[-1] / self.peak

    @property
    def rise(self) -> float:
        """Slip at which 80 % of the peak are reached."""
        return float(np.interp(0.8 * self.peak, self.utilisations, self.slips))


def run(bench: Bench, plan: Plan) -> Section:
    """Solves the points and evaluates the checks."""
    curves = _curves(bench, plan)
    best, best_check = _best(bench, plan)
    return Section(
        "slip",
        Part.MEASUREMENTS,
        "Slip",
        "Traction is the torque divided by that of full slip at peak friction, with both shafts held at speeds with a slip between them. "
        "The section also has the slip at which the losses are least at a given torque.",
        (*_traction_checks(curves), *best_check),
        (_traction_table(curves), best),
        (_chart(curves),),
        (
            "The measured slips of best efficiency are those of the system: they include the pump loss, and the ratios are not published. A "
            "pump's power grows with the clamping force, which moves the optimum to less force and more slip. The table shows the FMU's "
            f"optimum without a pump and with one of {1e6 * PUMP['displacement']:g} cm³ per turn, cylinders of {1e4 * PUMP['area']:g} cm² and "
            f"an efficiency of {PUMP['efficiency']:g} (engineering values).",
        ),
    )


def _curves(bench: Bench, plan: Plan) -> list[Traction]:
    found = []
    for ratio, force, rpm in itertools.product(plan.thin(RATIOS, 2), plan.thin(FORCES, 2), plan.thin(SPEEDS, 2)):
        points = []
        for slip in plan.thin(SLIPS, 6):
            values = driven_by_slip(bench.parameters, ratio, rad(rpm), slip, force)
            out = bench.steady(values, f"ratio {ratio:g}, {force / 1e3:g} kN, {rpm:g} rpm, slip {100 * slip:g} %")
            if out:
                points.append((out["slip"], out["torqueUtilisation"]))
        if len(points) > 3:
            found.append(Traction(ratio, force, rpm, *map(tuple, zip(*points, strict=True))))  # type: ignore[arg-type]
    return found


def _traction_checks(curves: list[Traction]) -> list[Check]:
    where = source("traction")
    ratios = list(dict.fromkeys(c.ratio for c in curves))

    def spread(values: list[float]) -> float:
        return max(values) / min(values) - 1.0

    peaks, at_slips = [], []
    for ratio in ratios:
        group = [c for c in curves if c.ratio == ratio]
        peaks.append((f"ratio {ratio:g}", spread([c.peak for c in group])))
        at_slips += [(f"ratio {ratio:g} at {100 * slip:g} %", spread([c.at(slip) for c in group])) for slip in AT_SLIPS]
    names = [(f"ratio {c.ratio:g}, {c.name}", c) for c in curves]
    means = {ratio: float(np.mean([c.at(AT_SLIPS[0]) for c in curves if c.ratio == ratio])) for ratio in ratios}
    return [
        within(
            "traction-rise", "Traction rises steeply with slip", where, [(name, c.rise) for name, c in names], None, 0.025, PERCENT,
            "80\N{NO-BREAK SPACE}% of the peak within 2.5\N{NO-BREAK SPACE}% slip",
        ),
        within(
            "traction-fall", "Traction then stays flat, then falls slightly",
            where, [(name, c.fall) for name, c in names], 0.0, LARGEST_FALL, PERCENT,
            "falls from its peak to 10\N{NO-BREAK SPACE}% slip by 0 to 15\N{NO-BREAK SPACE}%",
        ),
        within(
            "traction-peak", "Clamping force and speed can be ignored: peak traction", where, peaks, None, PEAKS_APART, PERCENT,
            "largest over least ≤ 5\N{NO-BREAK SPACE}% apart",
        ),
        within(
            "traction-slips", "Clamping force and speed can be ignored: traction at 2 and 4 % slip",
            where, at_slips, None, APART, PERCENT,
            "largest over least ≤ 10\N{NO-BREAK SPACE}% apart",
        ),
        reported(
            "traction-ratio",
            "A smaller speed ratio gives a larger traction",
            Source(where.text, f"{where.certainty}; it specifies neither the ratio nor the slip"),
            "ordered by ratio",
            "at 2 % slip " + ", ".join(f"{means[ratio]:.3f} at r_S/r_P {ratio:g}" for ratio in ratios),
        ),
    ]  # fmt: skip


def _traction_table(curves: list[Traction]) -> Table:
    columns = (
        Column("Ratio", digits=1), Column("F_S", "kN", 0, 1e-3), Column("Speed", "rpm", 0), share("80 % of the peak at a slip of", 2, signed=False),
        Column("at 1 % slip"), Column("at 2 %"), Column("at 4 %"), Column("Peak"), share("Fall to 10 %", signed=False),
    )  # fmt: skip
    rows = [[c.ratio, c.force, c.rpm, c.rise, c.at(0.01), c.at(0.02), c.at(0.04), c.peak, c.fall] for c in curves]
    return table("traction", "Torque / torque of full slip", columns, rows)


def _best(bench: Bench, plan: Plan) -> tuple[Table, list[Check]]:
    """The clamping force with the least loss at a given torque."""
    rows = []
    for ratio in plan.thin(BEST_RATIOS, 2):
        points = []
        for safety in reversed(plan.thin(SAFETIES, 9)):
            force = bench.force(ratio, BEST_TORQUE, safety)
            values = driven_by_torque(bench.parameters, ratio, rad(BEST_SPEED), BEST_TORQUE, force)
            out = bench.steady(values, f"ratio {ratio:g}, safety {safety:g}")
            if not out or out["macroSlip"]:
                # A smaller force does not carry the torque either.
                break
            pump = PUMP["displacement"] * BEST_SPEED / 60.0 * max(force, force * out["thrustRatio"]) / PUMP["area"]
            points.append((out["efficiency"], out["slip"], safety, pump / PUMP["efficiency"] / out["primary.power"]))
        if points:
            alone = max(points)
            pumped = max(points, key=lambda p: p[0] - p[3])
            rows.append([ratio, *alone[:3], pumped[0] - pumped[3], *pumped[1:3]])
    measured = data()["bestSlip"]
    check = [
        reported(f"best-{key}{pump}", f"{what} of best efficiency{whose}", source("bestSlip"), unit.text(*measured[key]),
                 unit.text(*(float(row[place]) for row in rows)))
        for what, key, unit, places in (
            ("Slip", "slip", Unit("%", 2, 100.0), (2, 5)),
            ("Safety factor", "safetyFactor", Unit("", 2), (3, 6)),
            ("Efficiency at the slip", "systemEfficiency", PERCENT, (1, 4)),
        )
        for place, pump, whose in zip(places, ("", "-pump"), (", without a pump", ", with a pump"), strict=True)
    ]  # fmt: skip
    of_best = share("at a slip of", 2, signed=False), Column("and a safety of", digits=2)
    columns = (
        Column("Ratio", digits=2), share("Best efficiency", 2, signed=False), *of_best, share("With a pump", 2, signed=False), *of_best,
    )  # fmt: skip
    note = f"{BEST_TORQUE:g} N·m, {BEST_SPEED:g} rpm; the secondary force is varied."
    return table("best-slip", "Slip of best efficiency", columns, rows, note), check


def _chart(curves: list[Traction]) -> Chart:
    panels = []
    for ratio in dict.fromkeys(c.ratio for c in curves):
        group = [c for c in curves if c.ratio == ratio]
        colours = {force: k for k, force in enumerate(dict.fromkeys(c.force for c in group))}
        styles = dict(zip(dict.fromkeys(c.rpm for c in group), ("-", "--", ":"), strict=False))
        lines = [curve(c.name, [100.0 * s for s in c.slips], c.utilisations, colours[c.force], styles[c.rpm]) for c in group]
        panels.append(Panel(f"Ratio {ratio:g}: torque / torque of full slip", lines, "slip (%)", height=300))
    return Chart(panels, "Colours: clamping force; lines: speed.", columns=3, common_legend=len(panels) > 1)
