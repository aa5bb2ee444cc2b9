"""Laws of the friction: a linear function of a column of the table, or a value for each group of its points."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.stats import f as fisher
from scipy.stats import t as student

from pushbelt.errors import ArgumentError
from pushbelt.fmu.geometry import Array
from pushbelt.tables.columns import REQUIRED
from pushbelt.tables.points import Point, Rig
from pushbelt.tables.sheet import TableError, same

from .causes import Cause, Values
from .fit import CHANCE, CONFIDENCE, Fit
from .parameters import Parameter, additional
from .worker import Job

FRICTION, ORDER = "friction.pulley", "row order"


class Groups(NamedTuple):
    """Groups of points by the cells of a column."""

    column: str
    counts: Mapping[str, int]  # Numbers of their points; the first group has most
    causes: list[Cause]  # Differences of the friction of the others from that of the first one


def columns(rig: Rig) -> dict[str, Array]:
    """Numbers that a table has for each point, by title: conditions, times, unknown columns, and the order of the rows."""
    sheet, rows = rig.sheet, rig.rows
    found = {sheet.title(name): rig.values[name] for name in ("ratio.geometric", "ratio.speed", *REQUIRED, "time") if name in rig.values}
    found |= {title: column for title, column in sheet.others.items() if column.dtype != object}
    return {**{title: column[rows] for title, column in found.items()}, ORDER: np.arange(len(rows), dtype=float)}


def _friction_law(
    rig: Rig, title: str, some: Mapping[str, Array], parameters: Sequence[Parameter]
) -> tuple[str, Callable[[str, Array, float, str], Cause]]:
    """The column of a title, and what adds a size times weights of the points to the friction."""
    friction = next((one for one in parameters if one.name == FRICTION), None)
    own = next((name for name in some if name == rig.sheet.title(title) or same(name, title)), None)
    if friction is None:
        raise ArgumentError(f"{FRICTION} over {title} requires {FRICTION} in --fit")
    if own is None:
        raise TableError(f"there is no column {title}; there are {', '.join(some)}", rig.sheet.path)

    def law(name: str, weights: Array, scale: float, advice: str) -> Cause:
        by_line = {point.line: float(weight) for point, weight in zip(rig.points, weights, strict=True)}

        def change(values: Values, point: Point, size: float) -> Job:
            value = values[FRICTION] + size * by_line[point.line]
            return {**values, FRICTION: min(max(value, friction.low), friction.high)}, point

        return Cause(additional(name, "1", scale * friction.start), change, advice=advice)

    return own, law


def over_column(rig: Rig, title: str, parameters: Sequence[Parameter]) -> Cause:
    """A fitted friction that is a linear function of a column about its mean. Raises ArgumentError if it is not fitted, and TableError
    without such numbers."""
    own, law = _friction_law(rig, title, numbers := columns(rig), parameters)
    column = numbers[own]
    if not np.nanstd(column) > 0.0:
        raise TableError(f"{own} has no numbers that differ", rig.sheet.path)
    away, advice = np.nan_to_num(column - np.nanmean(column)), f"{FRICTION} holds at the mean of {own}, {np.nanmean(column):.5g}"
    return law(f"slope of {FRICTION} over {own}", away, 1.0 / float(np.nanstd(column)), advice)


def over_unknown_columns(rig: Rig, parameters: Sequence[Parameter]) -> list[Cause]:
    """A fitted friction over each unknown column, and over the order of the rows; none if no friction is fitted."""
    if all(one.name != FRICTION for one in parameters):
        return []
    titles = [title for title, column in columns(rig).items() if title in (*rig.sheet.others, ORDER) and np.nanstd(column) > 0.0]
    options = ["" if title == ORDER else f'--friction-over "{title}"' for title in titles]
    return [replace(over_column(rig, title, parameters), advice=option) for title, option in zip(titles, options, strict=True)]


def by_group(rig: Rig, title: str, parameters: Sequence[Parameter]) -> Groups:
    """A fitted friction of each group of points with the same cell in a column. Raises ArgumentError if the friction is not fitted, and
    TableError if there are not two groups, or one has fewer than two points."""
    some = columns(rig) | {name: column[rig.rows] for name, column in rig.sheet.others.items()}
    own, law = _friction_law(rig, title, some, parameters)
    cells = np.array(["" if cell != cell else f"{cell:.9g}" if isinstance(cell, float) else f"{cell}".strip() for cell in some[own].tolist()])
    names, counts = np.unique(cells, return_counts=True)
    few = [f"{name or 'empty'} ({count})" for name, count in zip(names, counts, strict=True) if count < 2 or not name]
    if few or len(names) < 2:
        why = f"{len(few)} groups are empty or have one point: {', '.join(few[:5])}" if few else f"all cells are {names[0]}"
        raise TableError(f"{own} does not group the points: {why}. At least two groups of at least two points are required", rig.sheet.path)
    order = np.argsort(-counts, kind="stable")
    first, *others = names[order].tolist()
    sizes = [law(f"{FRICTION} of {own} = {name} above that of {first}", cells == name, 1.0, "") for name in others]
    sizes[0] = replace(sizes[0], advice=f"{FRICTION} holds for {own} = {first}")
    return Groups(own, dict(zip(names[order].tolist(), counts[order].tolist(), strict=True)), sizes)


def compared(groups: Groups, found: Fit) -> list[str]:
    """The friction of each group with its interval, and whether they differ: an F-test of all differences."""
    names, spread = [one.parameter.name for one in found.determined], found.spread
    wanted = [FRICTION, *(cause.size.name for cause in groups.causes)]
    if missing := [name for name in wanted if name not in names]:
        return [f"the groups of {groups.column} can't be compared: the table does not determine {missing[0]}"]
    at = [names.index(name) for name in wanted]
    own = [found.determined[k] for k in at]
    halves = spread.halves[at] * [one.value if one.parameter.logarithmic else one.parameter.scale or one.parameter.start for one in own]
    squares, away = spread.correlations[np.ix_(at, at)] * np.outer(halves, halves), np.array([one.value for one in own[1:]])
    quantile, count = student.ppf(0.5 + 0.5 * CONFIDENCE, spread.freedom), len(away)
    chance = fisher.sf(quantile**2 * away @ np.linalg.solve(squares[1:, 1:], away) / count, count, spread.freedom)
    lines = []
    for k, (name, points) in enumerate(groups.counts.items()):
        sums = [0, k] if k else [0]
        value, half = sum(own[m].value for m in sums), float(np.sqrt(squares[np.ix_(sums, sums)].sum()))
        lines.append(f"{FRICTION} of {groups.column} = {name} ({points} points): {value:.5g} (95 %: {value - half:.5g} to {value + half:.5g})")
    verdict = "differ" if chance < CHANCE else "differ by no more than scatter"
    return [*lines, f"the frictions of the {count + 1} groups {verdict} (chance {chance:.1g})"]
