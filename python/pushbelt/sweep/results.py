"""Results of a study: a table with units and descriptions, in a Parquet file."""

import json
import math
from collections.abc import Mapping
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from pushbelt.fmu.bands import DEVIATION
from pushbelt.fmu.unit import TRUTHS, output_names
from pushbelt.study.tasks import Row
from pushbelt.whole_file import write_whole

from .point import BANDS, SHORT_STEP, capacity, slope
from .study import AXES, Study

METADATA = b"pushbelt.study"  # Key of the study's description (JSON) in the metadata of the results


def schema(study: Study) -> pa.Schema:
    """Columns of the results. The metadata of each holds its unit and description."""
    number, variables = pa.float64(), study.variables
    axes = [axis.column for axis in AXES.values()]
    # Columns of a design are among the parameters and inputs.
    units = {name: one.unit or "1" for name, one in variables.items()}
    own = {name: units[name] for name in output_names(variables.values())}
    outputs = dict.fromkeys(("primary.torque", *study.grid.columns, *own))
    banded = BANDS if study.deviations else ()
    columns = [
        ("point", pa.int64(), "1", "Index of the point in the study"),
        *((axis.column, number, axis.unit, axis.description) for axis in AXES.values()),
        *((name, number, units[name], variables[name].description) for name in outputs if name not in axes),
        *((name, pa.bool_(), "1", variables[name].description) for name in TRUTHS),
        *((name + DEVIATION, number, units[name], f"Standard deviation of {name}") for name in banded),
        *((f"{name} by", pa.string(), "", f"Parameters that make most of the deviation of {name}") for name in banded),
        *((slope(output, over), number, unit, text) for output, over, unit, text in study.asked.columns(own, variables)),
        ("drift", number, "1", f"Change of the thrust ratio over the step of {SHORT_STEP} s, relative"),
        ("remarks", pa.string(), "", "Warnings of the FMU"),
        ("reason", pa.string(), "", "Reason for a missing steady state; null with a steady state"),
        ("time", number, "s", "Processor time of the point"),
    ]
    return pa.schema([pa.field(name, kind, metadata={"unit": unit, "description": text}) for name, kind, unit, text in columns])


def table(study: Study, rows: Mapping[int, Row]) -> pa.Table:
    """A table of rows by point, with the coordinates of each point, and with metadata of the study and the number of failed points."""
    points = study.grid.points()
    columns = schema(study)
    full = []
    for number in sorted(rows):
        values = study.start_values(points[number])
        carried = capacity(values)
        utilisation = points[number].get("utilisation", values["primary.torque"] / carried if carried else math.nan)
        given = {name: values[name] for name in columns.names if name in values}
        full.append({"point": number, "utilisation": utilisation, **given, **rows[number]})
    results = pa.Table.from_pylist(full, columns)
    about = study.description
    document = {
        "study": study.identity,
        "fmu": {"model": about.modelName, "version": about.version, "guid": about.guid},
        **study.document(), "points": len(results), "failed": len(results) - results["reason"].null_count,
    }  # fmt: skip
    return results.replace_schema_metadata({METADATA: json.dumps(document)})


def write_parquet(contents: pa.Table, path: Path) -> None:
    """Writes a table completely or not at all."""
    buffer = pa.BufferOutputStream()
    pq.write_table(contents, buffer, compression="zstd")
    write_whole(path, buffer.getvalue().to_pybytes())
