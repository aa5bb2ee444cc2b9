"""Results of a study: a table with units and descriptions, in a Parquet file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from pushbelt.fmu.data import torque_capacity
from pushbelt.fmu.unit import output_names
from pushbelt.study.tasks import Row
from pushbelt.whole_file import write_whole

from .design import Design
from .point import SHORT_STEP
from .study import AXES, Study

METADATA = b"pushbelt.study"
"""Key of the study's description (JSON) in the metadata of the results."""


def extra_columns(study: Study) -> list[str]:
    """Columns of a design besides the axes and the torque, which every study has."""
    if not isinstance(study.grid, Design):
        return []
    common = {"primary.torque", *(axis.column for axis in AXES.values())}
    return [name for name in study.grid.columns if name not in common]


def schema(study: Study) -> pa.Schema:
    """Columns of the results. The metadata of each holds its unit and description."""

    def column(name: str, kind: pa.DataType, unit: str, description: str) -> pa.Field:
        return pa.field(name, kind, metadata={"unit": unit, "description": description})

    def output(name: str, kind: pa.DataType) -> pa.Field:
        variable = study.variables[name]
        return column(name, kind, variable.unit or "1", variable.description)

    return pa.schema(
        [
            column("point", pa.int64(), "1", "Index of the point in the study"),
            *(column(axis.column, pa.float64(), axis.unit, axis.description) for axis in AXES.values()),
            output("primary.torque", pa.float64()),
            *(output(name, pa.float64()) for name in extra_columns(study)),
            *(output(name, pa.float64()) for name in output_names(study.variables.values())),
            output("macroSlip", pa.bool_()),
            column("drift", pa.float64(), "1", f"Change of the thrust ratio over the step of {SHORT_STEP} s, relative"),
            column("remarks", pa.string(), "", "Warnings of the FMU"),
            column("reason", pa.string(), "", "Reason for a missing steady state; null with a steady state"),
            column("time", pa.float64(), "s", "Processor time of the point"),
        ]
    )


def table(study: Study, rows: Mapping[int, Row]) -> pa.Table:
    """A table of rows by point, with the coordinates of each point, and with metadata of the study and the number of failed points."""
    points = study.grid.points()
    columns = schema(study)
    given = [axis.column for axis in AXES.values() if axis.column in study.variables] + ["primary.torque", *extra_columns(study)]
    full = []
    for number in sorted(rows):
        point = points[number]
        values = study.start_values(point)
        carried = torque_capacity(values, values["initial.ratio"], values["secondary.clampingForce"])
        utilisation = point.get("utilisation", values["primary.torque"] / carried)
        full.append({"point": number, "utilisation": utilisation, **{name: values[name] for name in given}, **rows[number]})
    results = pa.Table.from_pylist(full, columns)
    failed = len(results) - results["reason"].null_count
    document = {**describe(study), "points": len(results), "failed": failed}
    return results.replace_schema_metadata({METADATA: json.dumps(document)})


def describe(study: Study) -> dict[str, Any]:
    description = study.description
    # The axes of a grid with their values, or the columns of a design.
    grid: dict[str, Any] = {axis.column: {"unit": axis.unit, "values": getattr(study.grid, name, ())} for name, axis in AXES.items()}
    if isinstance(study.grid, Design):
        units = {field.name: field.metadata[b"unit"].decode() for field in schema(study)}
        grid = {"design": study.grid.kind, "columns": {name: {"unit": units[name]} for name in study.grid.columns}}
    return {
        "study": study.identity,
        "fmu": {"model": description.modelName, "version": description.version, "guid": description.guid},
        "parameters": {name: {"value": value, "unit": study.variables[name].unit or "1"} for name, value in study.parameters.items()},
        "grid": grid,
    }


def write_parquet(contents: pa.Table, path: Path) -> None:
    """Writes a table completely or not at all."""
    buffer = pa.BufferOutputStream()
    pq.write_table(contents, buffer, compression="zstd")
    write_whole(path, buffer.getvalue().to_pybytes())
