"""The report of the maps: one self-contained HTML file."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pushbelt.maps.data import AXES, Maps
from pushbelt.maps.panels import QUANTITIES, TICKS, Quantity, levels_of, panel, shades
from pushbelt.report.charts import Chart, Panel, Series
from pushbelt.report.page import write_html
from pushbelt.report.style import BLUE, ORANGE, RPM
from pushbelt.study.run import Effort

from . import files

FEW = 4  # Largest number of groups of parameters that are listed for each deviation
KINDS = {0: "solved", 1: "slips through", 3: "no steady state"}
"""Points in the maps, by the numbers of the table `state`. Those beyond the capacity are behind the border."""
SHOWN = (*QUANTITIES, Quantity("torque loss at the primary shaft", "torqueLoss", unit="N·m"))


def contours(named: Sequence[tuple[str, Maps]], shown: Quantity) -> Chart:
    """A quantity of one or two variators: a row of panels for each force, a panel for each speed, variators side by side."""
    values = [shown.scale * maps.masked(shown.column) for _, maps in named]
    levels = levels_of(np.concatenate([one.ravel() for one in values]), shown.levels)
    panels = []
    first = named[0][1]
    for force, speed in itertools.product(first.axes["force"], first.axes["speed"]):
        for (name, maps), table in zip(named, values, strict=True):
            wanted = {"force": force, "speed": speed}
            # The nearest force and speed of its axes.
            place = tuple(int(np.abs(np.log(maps.axes[axis] / value)).argmin()) for axis, value in wanted.items())
            title = f"{1e-3 * maps.axes['force'][place[0]]:g} kN, {RPM * maps.axes['speed'][place[1]]:.0f} rpm"
            kinds = {kind: maps["state"][place] == number for number, kind in KINDS.items()}
            known = 100.0 * maps["capacitySlip"][place].T if shown.column == "slip" else None
            axes, border = (maps.axes["ratio"], maps.axes["utilisation"]), maps["capacity"][place].T
            panels.append(panel(f"{name}: {title}" if name else title, shown, axes, table[place], levels, kinds, border, known))
    columns = len(first.axes["speed"]) if len(named) == 1 else 2
    return Chart(panels, f"Maps of {shown.name}", columns=columns, common_legend=True, least_width=240)


def lines(maps: Maps) -> Chart:
    """Capacity over the ratio, traction over the slip and shift rates over the excess, at the middle force and speed."""
    f, s = len(maps.axes["force"]) // 2, len(maps.axes["speed"]) // 2
    ratio = maps.axes["ratio"]
    colours = shades(len(ratio))
    capacity = [
        Series(f"{'primary' if k else 'secondary'} drives", ratio, np.abs(maps["capacity"][f, s, :, k]), colour, marker="circle", size=4)
        for k, colour in enumerate((ORANGE, BLUE))
    ]  # fmt: skip
    traction, shifts = [], []
    share = maps.axes["slipShare"]
    for k, (value, colour) in enumerate(zip(ratio, colours, strict=True)):
        low, high = maps["capacitySlip"][f, s, k]
        slips = 100.0 * np.where(share < 0.0, -share * low, share * high)
        name = f"ratio {value:.3g}"
        traction.append(Series(name, slips, maps["traction"][f, s, k], colour, marker="circle", size=4))
        rates = 1e3 * maps["shiftRate"][f, s, k, -1]
        shifts.append(Series(name, maps.axes["excess"], rates, colour, marker="circle", size=4))
    drive = f"utilisation {maps.axes['shiftUtilisation'][-1]:g}"
    panels = [
        Panel("Utilisation at capacity", capacity, "ratio r_S/r_P", x_scale="log", x_ticks=TICKS, height=280),
        Panel("Torque utilisation", traction, "slip (%)", height=280),
        Panel(f"−d(ln i)/dt/ω_P (1/krad), {drive}", shifts, "ln(F_P/(κ F_S))", height=280),
    ]
    return Chart(panels, "Capacity, traction and shift rates", columns=3, common_legend=True, least_width=280)


def write(maps: Maps, folder: Path, effort: Effort, beside: Maps | None = None) -> Path:
    """Writes the report and returns its path. `beside` are the maps of another variator, side by side with these."""
    named = [("", maps)] if beside is None else [("A", maps), ("B", beside)]
    added = (Quantity(about.description, name, unit=about.unit) for name, about in maps.added.items())
    others = beside.parameters if beside else maps.parameters
    context = {
        "maps": maps, "effort": effort, "beside": beside, "files": (*files.OWN, *files.WRITERS),
        "contours": [
            *((shown.heading, contours(named, shown)) for shown in SHOWN),
            *((one.heading, contours([("", maps)], one)) for one in added),
        ],
        "lines": lines(maps),
        # Without the numbers after the first comma.
        "reasons": Counter(reason.split(",")[0] for reason in maps.reasons.values()).most_common(),
        "axes": [(name, about.unit, ", ".join(map("{:g}".format, maps.axes[name]))) for name, about in AXES.items()],
        "tables": [(name, *about[:2], ", ".join(about.axes)) for name, about in maps.quantities.items()],
        "by": [(name, *one) for name, texts in maps.by.items() for one in Counter(texts.values()).most_common(FEW)],
        "parameters": [(name, f"{value:g}") for name, value in maps.parameters.items()],
        "differing": [(name, value, others.get(name, "–")) for name, value in maps.parameters.items() if others.get(name) != value],
    }  # fmt: skip
    path = folder / "report.html"
    write_html("maps/maps.html.j2", context, path)
    return path
