"""Hold-out: a parameter set against a rig's table that it was not fitted to, beside the default set."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from pushbelt import tables
from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.untrusted import described
from pushbelt.report import page
from pushbelt.tables import points
from pushbelt.tables.columns import MEASURED
from pushbelt.tables.points import Rig

from . import figures, model
from .model import Score, of, plain, quantities, score

DEFAULT = "bench168"
short = partial(plain, digits=4, none="–")
SCORES = ("quantity", "variator", "values", "lost values", "rms [SI]", "bias [SI]", "rms/sd [1]", "explained share [1]")


class HoldOut(NamedTuple):
    """A table, and the model's values with each set."""

    rig: Rig
    version: str
    sets: Mapping[str, pd.DataFrame]
    scores: list[Score]  # By quantity and set


def hold_out(fmu: Path, rig: Rig, variator: str, workers: int = 2) -> HoldOut:
    """Solves all points of a table with a set, and with the default one if it is another. Raises the errors of the parameter set."""
    sets = {name: parameter_set(name) for name in dict.fromkeys((variator, DEFAULT))}
    with model.opened(fmu, {}, rig.points, workers, len(sets) * len(rig.points)) as opened:
        rows = dict(zip(sets, map(opened.rows, opened.states(list(sets.values()))), strict=True))
    measured = quantities(rows[variator])
    scores = [score(own, quantity, name) for quantity in measured for name, own in rows.items()]
    return HoldOut(rig, described(fmu).version or "", rows, scores)


def write(held: HoldOut, folder: Path) -> Path:
    """Writes report.html, holdout.csv, holdout.json and residuals.csv; returns the path of the report."""
    folder.mkdir(parents=True, exist_ok=True)
    first = next(iter(held.sets.values()))
    tables.write(folder / "holdout.csv", SCORES, held.scores)
    document = [{name: None if value != value else value for name, value in one._asdict().items()} for one in held.scores]
    (folder / "holdout.json").write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")
    header = ["line", "name", "time [s]", "quantity", "measured [SI]", "sd [SI]", *(f"{name} [SI]" for name in held.sets)]
    columns = [first[name] for name in ("line", "name", "time", "quantity", "measured", "sd")]
    tables.write_frame(folder / "residuals.csv", header, pd.concat([*columns, *(rows["found"] for rows in held.sets.values())], axis=1))
    context = {
        "held": held,
        "variators": list(held.sets),
        "notes": points.understood(held.rig)[1:],
        "figures": [
            (q, MEASURED[q].meaning, figures.chart(q, {name: own for name, rows in held.sets.items() if len(own := of(rows, q))}))
            for q in dict.fromkeys(one.quantity for one in held.scores if one.count)
        ],
        "lost": [
            (name, row)
            for name, rows in held.sets.items()
            for row in rows[rows["reason"].notna()].drop_duplicates("line").itertuples()
        ],
    }
    page.write_html("calibrate/holdout.html.j2", context, folder / "report.html", plain=short)
    return folder / "report.html"


def sentence(score: Score) -> str:
    """A score in one line."""
    lost = f", {score.lost} values without a steady state" if score.lost else ""
    return f"{score.quantity}, {score.variator}: {short(score.relative)} standard deviations, bias {short(score.bias)}{lost}"
