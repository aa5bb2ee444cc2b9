"""The docs' picture of single elements, from `elements/results`: `target/venv/bin/python fmu-build/python/pictures.py elements`."""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "elements" / "results"
sys.path.append(str(ROOT / "validation"))
from pushbelt_validation.sections.single_elements import RATIOS  # noqa: E402
from pushbelt_validation.theory.shifting import Belt  # noqa: E402

COLOURS = ("#135eb3", "#c06f14", "#0b7a48", "#8e0c1a", "#6b7785")
THEORY = Belt(math.radians(11.0), 0.09, 0.168, 0.703 - 2e-3 * math.pi)
"""The default belt."""
Line = dict[str, float]


def read(name: str) -> dict[tuple[str, str], Line]:
    """Lines of a file by case and model; single elements are the model ""."""
    return read_file(RESULTS / f"{name}.csv")


def read_file(path: Path) -> dict[tuple[str, str], Line]:
    """As `read`."""
    with path.open(encoding="utf-8") as file:
        return {(row.pop("case"), row.pop("model", "")): {key: float(value or "nan") for key, value in row.items()} for row in csv.DictReader(file)}


def along(name: str) -> list[Line]:
    """Fields along the belt."""
    with (RESULTS / f"{name}-fields.csv").open(encoding="utf-8") as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


def draw(picture: Path) -> None:
    """Draws the panels: single elements as points, with the range of a limit cycle, `ALE` as lines, `ALE0` dotted, the theory dashed."""
    files = ("loads", "torque-free", "idle", "play", "traction", "oil", "rigid", "continuum")
    stored = {key: line for name in files for key, line in read(name).items()}
    shifts = read("shifts") | read("shifts-continuum")
    plt.rcParams.update({"font.size": 8, "axes.spines.top": False, "axes.spines.right": False, "axes.titlesize": 9, "axes.titlelocation": "left"})
    figure, places = plt.subplots(3, 4, figsize=(12.06, 9.0), layout="constrained")
    panels = iter(places.flat)

    def panel(title: str, x: str) -> Any:
        axes = next(panels)
        axes.set(title=title, xlabel=x)
        return axes

    def compare(
        axes: Any, cases: list[str], x: Callable[[str, Line], float], y: str, colour: str, label: str, scale: float = 1.0, lines: tuple[str, ...] = ("-", ":")
    ) -> None:
        for model, style in zip(("ALE", "ALE0"), lines, strict=False):
            found = [(x(case, stored[case, model]), scale * stored[case, model][y]) for case in cases if (case, model) in stored]
            axes.plot(*zip(*found, strict=True), style, color=colour, lw=1.2)
        for case in cases:
            line = stored.get((case, ""))
            if line is None:
                continue
            axes.plot(x(case, line), scale * line[y], "o", color=colour, ms=4, label=label)
            if y == "slip":
                axes.plot([x(case, line)] * 2, [scale * line["slipMin"], scale * line["slipMax"]], color=colour, lw=3, alpha=0.3)
            label = ""

    def part(case: str, place: int) -> float:
        return float(case.split("-")[place])

    axes = panel("Thrust ratio without torque", "force (kN)")
    for (name, ratio), colour in zip(RATIOS.items(), COLOURS, strict=True):
        cases = [f"{name}-0-{force}kN" for force in (5, 15, 30)]
        compare(axes, cases, lambda case, _: float(case.split("-")[2][:-2]), "thrustRatio", colour, f"r_S/r_P {ratio:g}")
        axes.axhline(math.exp(THEORY.equilibrium(1.0 / ratio)), ls="--", lw=0.8, color=colour)
    axes.set_ylim(top=2.2)
    axes = panel("Thrust ratio near ratio 1, 15 kN", "r_S/r_P")
    near = ["0.95-0", "0.98-0", "medium-0", "1.02-0", "1.05-0"]
    compare(axes, [f"{name}-15kN" for name in near], lambda _, line: line["ratio"], "thrustRatio", COLOURS[0], "a tenth of oil")
    compare(axes, [f"{name}-dry" for name in near], lambda _, line: line["ratio"], "thrustRatio", COLOURS[1], "without oil", lines=("-",))
    ratios = [0.95, 1.0, 1.05]
    axes.plot(ratios, [math.exp(THEORY.equilibrium(1.0 / ratio)) for ratio in ratios], "--", color=COLOURS[4], lw=0.8, label="theory")
    axes = panel("Idle arc of P (rad), 15 kN", "torque over that of full slip")
    for name, colour in zip(("low", "medium", "od"), COLOURS, strict=False):
        cases = [f"{name}-{share}" for share in ("0.2", "0.4", "0.6", "0.8")]
        compare(axes, cases, lambda case, _: part(case, 1), "primary.idleArc", colour, f"r_S/r_P {RATIOS[name]:g}")
    axes = panel("Slip over play (%), 12 kN, r 0.5", "play (mm), r_S/r_P 2.25")
    for oil, colour in zip(("", "-full", "-hundredth", "-dry"), COLOURS, strict=False):
        cases = [f"low-0.5-play-0.{play}mm{oil}" for play in (2, 3, 4)]
        name, aside = {"": "a tenth of oil", "-full": "full", "-hundredth": "a hundredth"}.get(oil, "without oil"), 4e-3 * COLOURS.index(colour)
        compare(axes, cases, lambda case, _, aside=aside: float(case.split("play-")[1][:3]) + aside, "slip", colour, name, 100.0, lines=("-",))
    axes = panel("Torque over that of full slip", "slip (%), r_S/r_P 2.25")
    for force, colour in zip((5, 30), COLOURS, strict=False):
        cases = [f"low-{share}-{force}kN" for share in ("0.3", "0.6", "0.7", "0.8")]
        for model, style in (("ALE", "-"), ("ALE0", ":")):
            found = [(100.0 * stored[case, model]["slip"], part(case, 1)) for case in cases if (case, model) in stored]
            axes.plot(*zip(*found, strict=True), style, color=colour, lw=1.2)
        for case in cases:
            line = stored[case, ""]
            axes.plot([100.0 * line["slipMin"], 100.0 * line["slipMax"]], [part(case, 1)] * 2, color=colour, lw=3, alpha=0.3)
            axes.plot(100.0 * line["slip"], part(case, 1), "o", color=colour, ms=4, label=f"{force} kN" if case == cases[0] else "")
    axes = panel("Shift gain without torque (1/s)", "step of ln F_P")
    steps = (-0.3, -0.1, -0.02, 0.02, 0.1, 0.3)
    for ratio, colour in zip(("1.667", "1", "0.625"), COLOURS, strict=False):
        for model, style in (("ALE", "-"), ("ALE0", ":"), ("", "o")):
            gains = [shifts[f"{ratio}-0-shift{step:+g}", model]["gain"] for step in steps]
            axes.plot(steps, gains, style, color=colour, lw=1.2, ms=4, label=f"s {1.0 / float(ratio):.1f}" if style == "o" else "")
    axes.set_ylim(bottom=0.0)
    axes = panel("Thrust ratio over oil, no torque", "share of a gap that is filled, r_S/r_P 0.444")
    fills = {"-dry": 0, "-hundredth": 1, "-15kN": 2, "-full": 3}
    compare(axes, [f"od-0{name}" for name in fills], lambda case, _: fills[case[4:]], "thrustRatio", COLOURS[0], "")
    axes.set_xticks(range(4), ["0", "0.01", "0.1", "1"])
    axes = panel("Thrust ratio, rigid sheaves", "")
    for place, case in enumerate(("low-0-rigid", "od-0-rigid", "od-0.6-rigid")):
        models = ("", "o", COLOURS[0], "elements"), ("ALE", "_", COLOURS[3], "ALE"), ("ALE x3", "_", COLOURS[2], "ALE, three times the mesh")
        for model, style, colour, label in models:
            axes.plot(place, stored[case, model]["thrustRatio"], style, color=colour, ms=5 if style == "o" else 16, mew=2, label="" if place else label)
    axes.set_xticks(range(3), ["2.25, r 0", "0.444, r 0", "0.444, r 0.6"])
    axes.set_xlim(-0.5, 2.5)
    for y, title, scale in (("pitch", "Pitch along the belt (mrad), r 0.4", 1e3), ("normalForce", "Normal force of a flank (N), r 0.4", 1.0)):
        axes = panel(title, "place over the belt's length")
        for name, colour in zip(("low", "medium", "od"), COLOURS, strict=False):
            fields = along(f"pitch-{name}")
            shares = [line["position"] / fields[-1]["position"] for line in fields]
            axes.plot(shares, [scale * line[y] for line in fields], color=colour, lw=1.2, label=f"r_S/r_P {RATIOS[name]:g}")
    tones = read_file(ROOT / "resources" / "tone.csv")
    for of, unit, title in (("axialForce", 1.0, "Axial force at order N (N), 15 kN"), ("beltTorque", 1e3, "Torque at order N (mN·m), 15 kN")):
        axes = panel(title, "speed of P (rad/s); open: thickness ± 2 %")
        for name, colour in zip(("low", "medium", "od"), COLOURS, strict=False):
            for pulley, style in (("secondary", "-"), ("primary", "--")):
                column = f"{pulley}.{of}.N"
                found = [(speed, unit * tones[f"{name}-0.4-15kN-{speed}", ""][column]) for speed in (100, 200, 400)]
                axes.plot(*zip(*found, strict=True), style, color=colour, lw=1.2, marker="o", ms=4, label=f"r_S/r_P {RATIOS[name]:g}, {pulley[0].upper()}" if unit == 1.0 else "")
                spread = [(speed, unit * tones[key, ""][column]) for speed in (100, 200, 400) if (key := f"{name}-0.4-15kN-{speed}-spread", "") in tones]
                axes.plot(*zip(*spread, strict=True), "o", color=colour, ms=4, mfc="none")
        axes.set(yscale="log", ylim=(0.02, 300.0) if unit == 1.0 else None)
    for axes in places.flat:
        if axes.get_legend_handles_labels()[1]:
            axes.legend(frameon=False, fontsize=7, loc="best")
    figure.savefig(picture, dpi=100)
    plt.close(figure)
