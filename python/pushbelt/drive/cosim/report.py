"""What the study found, as text and as one HTML file."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from pushbelt import page
from pushbelt.page import image
from pushbelt.style import BLUE, GREEN, ORANGE, STYLE, VIOLET, svg

from . import package
from .study import PACKAGE, SIGNALS, Coupling, orders

COLOURS = (BLUE, ORANGE, GREEN, VIOLET)


def text(result: Coupling) -> str:
    """The tables of the study."""
    steps = [f"{1e3 * step:g} ms" for step in result.plan.steps]
    lines = [f"{'root mean square, shares of the range':>44}  " + "  ".join(f"{name:>21}" for name in SIGNALS)]
    for master in result.masters:
        refinement, against = result.refinement(master), result.against_loop(master)
        rows = [
            *zip([f"{master}, {a} against {b}" for a, b in pairwise(steps)], refinement, strict=True),
            (f"{master}, order", orders(refinement)[-1]),
            *zip([f"{master} against the loop, both {step}" for step in steps], against, strict=True),
            (f"{master} against the loop, order", orders(against)[-1]),
        ]
        lines += [f"{name:>44}  " + "  ".join(f"{value:21.3g}" for value in values) for name, values in rows]
        largest = result.against_parallel(master)
        lines.append(f"{master + ' against the loop side by side':>44}  {largest:.3g} at most")
    return "\n".join(lines)


def write_html(result: Coupling, path: Path) -> None:
    """Writes `coupling.html`."""
    context = {
        "result": result,
        "package": PACKAGE,
        "wires": package.WIRES,
        "signals": SIGNALS,
        "orders": orders,
        "pictures": {"traces": image(_traces(result)), "errors": image(_errors(result))},
    }
    page.write_html("drive/cosim/coupling.html.j2", context, path)


def _traces(result: Coupling) -> str:
    """The signals by a master and by the loop at the largest step, and what lies between them."""
    step, master = result.plan.steps[0], next(iter(result.masters))
    coupled, loop = result.masters[master][step], result.loop[step]
    time = result.plan.section[0] + step * np.arange(1, len(loop) + 1)
    with plt.rc_context(STYLE):
        figure, rows = plt.subplots(2, len(SIGNALS), figsize=(11.2, 4.6), sharex=True, layout="constrained")
        for k, name in enumerate(SIGNALS):
            above, below = rows[:, k]
            above.plot(time, loop[:, k], color=ORANGE, label="loop")
            above.plot(time, coupled[:, k], color=BLUE, linewidth=0.9, label=master)
            above.set_title(name)
            below.plot(time, coupled[:, k] - loop[:, k], color=BLUE, linewidth=0.9)
            below.set(title="difference", xlabel="time (s)")
        rows[0, 0].legend(loc="best")
    return svg(figure)


def _errors(result: Coupling) -> str:
    """Differences over the communication step, with a line of slope 1."""
    steps = 1e3 * np.array(result.plan.steps)
    with plt.rc_context(STYLE):
        figure, panels = plt.subplots(1, 2, figsize=(11.2, 3.4), sharey=True, layout="constrained")
        for master, marker in zip(result.masters, "ox", strict=False):
            found = ((steps[:-1], result.refinement(master)), (steps, result.against_loop(master)))
            for axes, (where, errors) in zip(panels, found, strict=True):
                for k, name in enumerate(SIGNALS):
                    label = f"{name}, {master}"
                    axes.loglog(where, errors[:, k], marker=marker, color=COLOURS[k], markersize=4, label=label)
        for axes in panels:
            axes.loglog(steps, 1e-3 * steps, color="black", linewidth=0.8, linestyle=":", label="order 1")
            axes.set_xticks(steps, [f"{step:g}" for step in steps])
            axes.minorticks_off()
            axes.set_xlabel("communication step (ms)")
        panels[0].set_title("Master, against half its step")
        panels[1].set_title("Master against the loop, same step")
        panels[1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return svg(figure)
