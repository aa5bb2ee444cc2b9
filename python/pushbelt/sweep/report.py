"""The report of a study, one self-contained HTML file: maps of a grid; of a design rank correlations, and scatter over each varied column."""

import itertools
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pyarrow as pa
import xarray
from xarray import DataArray

from pushbelt.fmu.bands import DEVIATION
from pushbelt.fmu.geometry import Array
from pushbelt.maps.panels import QUANTITIES, Quantity, levels_of, panel, shades
from pushbelt.report.charts import Chart, Panel, Series
from pushbelt.report.page import Check, write_html
from pushbelt.report.style import BLUE, RED, RPM, in_figures
from pushbelt.study.run import Effort

from .design import Design, Points
from .results import METADATA, schema
from .study import AXES, Grid, Study

ACROSS = 4  # Largest number of maps per row
FEW = 12  # Largest number of failed points that are listed individually
SHOWN = (
    *QUANTITIES, Quantity("losses", "loss.total", unit="W"), Quantity("largest stress of the ring", "ring.stressMax", 1e-6, "MPa"),
)  # fmt: skip
LISTED = 16  # Largest number of values of a column of points that are listed
LENGTHS = {"m": (1e3, "mm"), "rad": (1e3, "mrad")}  # Scale and unit of lengths and angles
LARGE = 1e5  # Stiffnesses in N and other values above this are shown in SI units
MOST_COLUMNS = 12  # Largest number of columns with figures: those of the largest correlations


def _numbers(table: pa.Table) -> pandas.DataFrame:
    names = [field.name for field in table.schema if not pa.types.is_string(field.type)]
    return table.select(names).to_pandas().astype(float).set_index("point")


def data_set(grid: Points, table: pa.Table) -> xarray.Dataset:
    """The numbers of the results over the axes of a grid or the points of a design, NaN without a steady state, and the mask `steady`."""
    numbers = _numbers(table)
    if isinstance(grid, Grid):
        axes = {name: getattr(grid, name) for name in AXES}
        numbers = numbers.drop(columns=axes.keys() & numbers.keys())
        numbers.index = pandas.MultiIndex.from_product(axes.values(), names=axes)
    found = numbers.to_xarray()
    for name in found:
        found[name].attrs = {key.decode(): text.decode() for key, text in table.schema.field(name).metadata.items()}
    return found.assign(steady=found.thrustRatio.notnull())


def names_of(results: xarray.Dataset, points: DataArray) -> list[str]:
    """Descriptions of the points at which a mask is true."""
    if "point" in results.dims:
        return [f"point {number}" for number in points.point.values[points.values]]
    places = points.transpose(*AXES).stack(place=list(AXES))
    force = ", {force:.0f} N" if results.sizes["force"] > 1 else ""
    text = "ratio {ratio:.3g}, utilisation {utilisation:g}, μ {friction:g}, {rpm:.0f} rpm" + force
    values = (dict(zip(AXES, at, strict=True)) for at in places.place.values[places.values])
    return [text.format(**at, rpm=RPM * at["speed"]) for at in values]


def evaluate(results: xarray.Dataset) -> list[Check]:
    steady, held = results.steady, results.macroSlip == 0.0
    power = np.maximum(results["primary.power"], results["secondary.power"])
    # Powers are those of the belt, so they exclude the drag of the shafts.
    gap = results["primary.power"] + results["secondary.power"] - results["loss.total"] + results["loss.shafts"]

    def small(statement: str, values: DataArray, limit: float) -> Check:
        inside = 100.0 * abs(values).where(steady)
        return _check(results, statement, inside > limit, int(steady.sum()), f"at most {float(inside.max()):.2g} %")

    found = [
        small("Losses of the belt sum to its net power within 0.2 % of the driving power", (gap / power).where(power > 1.0, 0.0), 0.2),
        # With saturated friction a small change of load is a large change of slip, so these points are excluded.
        small("Steady states are stationary: thrust ratio constant over a step of 1 ms within 0.01 %", results.drift.where(held, 0.0), 0.01),
    ]
    return found if "point" in results.dims else [*found, *_checks_of_grid(results)]


def _checks_of_grid(results: xarray.Dataset) -> list[Check]:
    steady, positive = results.steady, results.utilisation >= 0.0
    driving = steady & positive

    def ascends(statement: str, values: DataArray, axis: str) -> Check:
        steps = values.diff(axis)
        return _check(results, statement, steps <= 0.0, int(steps.notnull().sum()), "steps from point to point")

    # Every point below a utilisation with a steady state has one.
    backwards = {"utilisation": slice(None, None, -1)}
    beyond = driving.isel(backwards).cumsum("utilisation").isel(backwards) > 0
    carried = results.thrustRatio.where(steady & (results.pastPeak == 0.0))
    # Below a value on either side.
    efficiency = results.efficiency.where(driving).transpose(*AXES)
    up, down = (np.fmax.accumulate(efficiency.values[..., ::way], axis=-1)[..., ::way] for way in (1, -1))
    valleys = efficiency < np.fmin(up, down)
    hole = "If a utilisation has a steady state, all smaller ones have one"
    return [
        ascends("Thrust ratio falls from overdrive to underdrive", -carried, "ratio"),
        ascends("Slip grows with torque utilisation", results.slip.where(driving), "utilisation"),
        _check(results, "Efficiency has one peak over the torque utilisation", valleys, int(driving.sum()), "points"),
        _check(results, hole, ~steady & beyond & positive, steady.size),
    ]


def _check(results: xarray.Dataset, statement: str, wrong: DataArray, asked: int, found: str = "") -> Check:
    """A check that fails if `wrong` is true at any point. The first such points are listed."""
    places = names_of(results, wrong)
    text = ", ".join(filter(None, [f"{asked - len(places)} of {asked}", found]))
    return Check(statement, not places, text + (f". Not: {'; '.join(places[:3])}" if places else ""))


def contours(results: xarray.Dataset) -> dict[str, Chart]:
    """Charts of all quantities by heading: one chart per clamping force, with one map per friction and speed."""
    end = " at {:.1f} kN" if results.sizes["force"] > 1 else ""
    deviations = (replace(one, name=f"standard deviation of {one.name}", column=one.column + DEVIATION, levels=None) for one in QUANTITIES)
    titles = {str(name): one.unit for name, one in results.items() for shown in QUANTITIES if str(name).startswith(f"d {shown.column}/")}
    slopes = (Quantity(name, name, unit=unit) for name, unit in titles.items())
    places = itertools.product(results.force.values, [*QUANTITIES, *(one for one in deviations if one.column in results), *slopes])
    return {one.heading + end.format(1e-3 * force): _contours(results.sel(force=force), one) for force, one in places}


def _contours(results: xarray.Dataset, quantity: Quantity) -> Chart:
    axes = results.ratio.values, results.utilisation.values
    levels = levels_of(quantity.scale * results[quantity.column].values, quantity.levels)
    panels = []
    for friction, speed in itertools.product(results.friction.values, results.speed.values):
        one = results.sel(friction=friction, speed=speed)
        values, slips = quantity.scale * one[quantity.column].values, one.pastPeak.values > 0.0
        there = np.isfinite(values)
        kinds = {"solved": there & ~slips, "slips through": there & slips, "no steady state": ~there}
        title = f"μ = {friction:g}, {RPM * speed:.0f} rpm"
        panels.append(panel(title, quantity, axes, values, levels, kinds, carried(axes[1], there & ~slips)))
    columns = min(len(panels), ACROSS)
    return Chart(panels, f"Maps of {quantity.name}", columns=columns, common_legend=True, least_width=240)


def carried(utilisation: Array, holds: np.ndarray) -> Array:
    """Least and greatest utilisation that is carried at each ratio: between the last point that holds and the next one.
    `holds` is over ratio × utilisation. NaN where all points hold, or none."""
    borders = np.concatenate([[np.nan], 0.5 * (utilisation[1:] + utilisation[:-1]), [np.nan]])
    ends = np.array([holds.argmax(axis=1), holds.shape[1] - holds[:, ::-1].argmax(axis=1)])
    return np.where(holds.any(axis=1), borders[ends], np.nan)


def cuts(results: xarray.Dataset) -> Chart:
    """The quantities over the utilisation at a force, a friction and a speed, one line per ratio."""
    panels = []
    for quantity in QUANTITIES:
        values = quantity.scale * results[quantity.column]
        series = [
            Series(f"ratio {ratio:.3g}", results.utilisation, values.sel(ratio=ratio), colour, marker="circle", size=4)
            for ratio, colour in zip(results.ratio.values, shades(results.sizes["ratio"]), strict=True)
        ]
        # Values past the peak would make the scale too large for the others.
        held = values.where(results.pastPeak == 0.0)
        low, high = float(held.min()), float(held.max())
        margin = 0.08 * (high - low) + 0.01
        span = (low - margin, high + margin) if np.isfinite(low) else None
        panels.append(Panel(quantity.heading, series, "torque utilisation", y_range=span, height=300))
    return Chart(panels, "Thrust ratio, efficiency and slip over torque utilisation", columns=len(panels), common_legend=True)


def write(study: Study, table: pa.Table, folder: Path, effort: Effort) -> Path:
    """Writes the report and returns its path."""
    results, numbers, names = data_set(study.grid, table), _numbers(table), list(study.grid.columns)
    reasons = Counter(filter(None, table["reason"].to_pylist()))
    about = {field.name: {key.decode(): text.decode() for key, text in field.metadata.items()} for field in schema(study)}
    ranges = {quantity: quantity.scale * numbers[quantity.column].dropna() for quantity in SHOWN}
    context = {
        "design": None, "cut": None,
        "version": study.description.version or "", "identity": study.identity, "points": len(table), "effort": effort,
        "reasons": reasons.most_common(), "failed_count": reasons.total(), "metadata_key": METADATA.decode(),
        "columns": [(name, one["unit"], one["description"]) for name, one in about.items()],
        "parameters": [(name, _shown(study.variables[name], value), study.variables[name].unit or "1") for name, value in study.parameters.items()],
        "quantities": [(quantity, (values.min(), values.max())) for quantity, values in ranges.items()],
        "slipping": int((numbers.pastPeak == 1.0).sum()), "checks": evaluate(results) if results.steady.any() else [],
        "failed": [(int(one.name), *map("{:g}".format, one)) for _, one in numbers[numbers.thrustRatio.isna()][names].head(FEW).iterrows()],
        "columns_of_points": [(name, about[name]["unit"], _values(numbers[name])) for name in names],
    }  # fmt: skip
    own = _of_design(study.grid, numbers, about) if isinstance(study.grid, Design) else _of_grid(results)
    return write_html("sweep/sweep.html.j2", context | own, folder / "report.html")


def _values(column: pandas.Series) -> str:
    """All values of a column of points, or the least and the greatest."""
    found = sorted(column.unique())
    return ", ".join(f"{value:g}" for value in found) if len(found) <= LISTED else f"{found[0]:.5g} – {found[-1]:.5g}"


def _shown(variable: Any, value: float) -> str:
    """Value of a parameter, or the name of an enumeration's value."""
    if variable.type == "Enumeration":
        return next(item.name for item in variable.declaredType.items if int(item.value) == value)
    return f"{value:g}"


def _of_grid(results: xarray.Dataset) -> dict[str, Any]:
    middle = results.isel(force=results.sizes["force"] // 2).sel(friction=0.09, speed=209.44, method="nearest")
    about = {name: float(middle[name]) for name in ("friction", "force")}
    return {"cut": {"picture": cuts(middle), "rpm": RPM * float(middle.speed), **about}, "charts": contours(results).items()}


def _of_design(design: Design, numbers: pandas.DataFrame, about: Mapping[str, Mapping[str, str]]) -> dict[str, Any]:
    names, columns = list(design.columns), [quantity.column for quantity in SHOWN]
    # By rank: 1 where a quantity rises with a column at all points, NaN where either is constant.
    correlations = numbers[[*names, *columns]].corr("spearman", min_periods=3).loc[names, columns]
    strongest = correlations.abs().max(axis=1).fillna(0.0).sort_values(ascending=False, kind="stable").index
    return {
        "design": design, "correlations": [(name, correlations.loc[name].tolist()) for name in strongest],
        "charts": [(name, _scatter(numbers, name, about[name]["unit"])) for name in strongest[:MOST_COLUMNS]],
    }  # fmt: skip


def _scatter(numbers: pandas.DataFrame, name: str, unit: str) -> Chart:
    """The quantities over a column. Points past the peak of traction have another colour."""
    x = numbers[name]
    scale, unit = LENGTHS.get(unit, in_figures(unit)) if x.abs().max() < LARGE or unit == "Pa" else (1.0, unit)
    slipping = numbers.pastPeak == 1.0
    label = name if unit in ("", "1") else f"{name} ({unit})"
    panels = []
    for quantity in QUANTITIES:
        y = quantity.scale * numbers[quantity.column]
        kinds = (("steady", y.notna() & ~slipping, BLUE), ("slips through", y.notna() & slipping, RED))
        series = [
            Series(kind, scale * x[where], y[where], colour, "points", marker="circle", size=5, opacity=0.7)
            for kind, where, colour in kinds
            if where.any()
        ]
        panels.append(Panel(quantity.heading, series, label, height=260))
    return Chart(panels, f"Thrust ratio, efficiency and slip over {name}", columns=len(panels), common_legend=True)
