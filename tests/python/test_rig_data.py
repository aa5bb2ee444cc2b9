"""Rig data as it comes: titles, headers, cells without numbers, time series, recordings and other files."""

from __future__ import annotations

import datetime
import gzip
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rig_tables import COLUMNS, POINTS, UNITS, columns, recorded, table, titled, written

from pushbelt.calibrate import __main__
from pushbelt.tables import names, points
from pushbelt.tables.faults import TableError
from pushbelt.tables.points import Oil, Rig
from pushbelt.sweep.design import listed

POUND, FOOT = 4.4482216152605, 0.3048
ROWS = POINTS.tolist()


def values(rig: Rig) -> np.ndarray:
    return np.array([[p.ratio, p.speed * 30.0 / np.pi, p.torque, p.force / 1e3] for p in rig.points])


def is_right(rig: Rig, rel: float = 1e-9) -> None:
    assert values(rig) == pytest.approx(POINTS[:, [0, 1, 3, 5]], rel=rel)
    assert [[m.quantity for m in p.measured] for p in rig.points] == [["thrustRatio", "slip", "efficiency"]] * len(ROWS)


# Titles and units


@pytest.mark.parametrize(
    ("written", "known"),
    [
        ("input speed", "primary.speed"), ("output torque", "secondary.torque"), ("n1", None), ("primary pulley speed", "primary.speed"),
        ("driven pulley clamping force", "secondary.clampingForce"), ("Drehzahl Primär", "primary.speed"), ("Abtriebsdrehzahl", "secondary.speed"),
        ("Drehzahl der Sekundärscheibe", "secondary.speed"), ("Sekundär-Anpresskraft", "secondary.clampingForce"), ("Drehmoment", "primary.torque"),
        ("Anpresskraft", "secondary.clampingForce"), ("Primärdruck", "primary.pressure"), ("Eingangsmoment", "primary.torque"),
        ("axle torque sensor", None), ("primary", None), ("primary secondary speed", None), ("pressure", None),
    ],
)  # fmt: skip
def test_words_for_pulley_and_quantity(written: str, known: str | None) -> None:
    found = names.in_words(written)
    assert (found[0] if found else None) == known


HEADS = {
    "English": (("geometric ratio", "input speed [rpm]", "output speed [rpm]", "Torque In (Nm)", "output torque, Nm", "Sec Clamp Force (kN)", "thrust primary [kN]"), "utf-8"),
    "numbers": (("i_geo", "n1 [1/min]", "n2 [1/min]", "M1 [Nm]", "M2 [Nm]", "F2 [kN]", "F1 [kN]"), "utf-8"),
    "German": (
        ("geometrische Übersetzung", "Drehzahl Primär [1/min]", "Drehzahl Sekundär [U/min]", "Drehmoment Primär [Nm]", "Drehmoment Sekundär [Nm]",
         "Anpresskraft Sekundär [kN]", "Anpresskraft Primär [kN]"), "latin-1",
    ),
    "compounds": (
        ("i_geo", "Antriebsdrehzahl in 1/min", "Abtriebsdrehzahl in 1/min", "Antriebsmoment in Nm", "Abtriebsmoment in Nm",
         "Klemmkraft Sekundärscheibe in kN", "Klemmkraft Primärscheibe in kN"), "cp1252",
    ),
    "without pulleys": (
        ("i_geo", "Drehzahl [1/min]", "Drehzahl Abtrieb [1/min]", "Drehmoment [Nm]", "Drehmoment Abtrieb [Nm]", "Anpresskraft [kN]", "Kraft Antrieb [kN]"), "utf-16",
    ),
}  # fmt: skip


@pytest.mark.parametrize("head", HEADS)
def test_titles_of_rigs(head: str, tmp_path: Path) -> None:
    names, encoding = HEADS[head]
    is_right(points.read(written(tmp_path / "table.csv", [names, *ROWS], ";", encoding)))


def test_the_ratio_in_german_is_that_of_the_speeds(tmp_path: Path) -> None:
    c = columns()
    some = {
        "Übersetzung": c["n_P"] / c["n_S"],
        **{f"{n} [{u}]": c[n] for n, u in zip(COLUMNS, UNITS, strict=True) if n in ("n_P", "T_P", "F_S", "F_P")},
    }
    assert [p.speed_ratio for p in points.read(table(tmp_path / "table.csv", some)).points] == pytest.approx(
        c["n_P"] / c["n_S"]
    )


def test_a_pulley_in_the_title_counts_before_none(tmp_path: Path) -> None:
    rig = points.read(written(tmp_path / "table.csv", [[*titled(), "Drehmoment [Nm]"], *([*row, 7.0] for row in ROWS)]))
    is_right(rig)
    assert rig.sheet.ignored == ["Drehmoment [Nm]"]


def test_units_of_pounds(tmp_path: Path) -> None:
    scale = np.array([1.0, 1.0, 1.0, 1.0 / (POUND * FOOT), 1.0 / (POUND * FOOT), 1e3 / POUND, 1.0 / POUND])
    for torque, other in (("lb-ft", "ft·lbf"), ("lbf ft", "lb ft")):
        units = ["", " [rpm]", " [rpm]", f" [{torque}]", f" [{other}]", " [lbf]", " [klbf]"]
        names = [f"{name}{unit}" for name, unit in zip(COLUMNS, units, strict=True)]
        is_right(points.read(written(tmp_path / "table.csv", [names, *(POINTS * scale).tolist()], ";")))


@pytest.mark.parametrize(("unit", "pascal"), [("bar", 1e5), ("psi", 6894.757293168)])
def test_pressures_in_bar_and_psi(unit: str, pascal: float, tmp_path: Path) -> None:
    c = columns()
    some = {
        "i_geo": c["i_geo"],
        "n_P [rpm]": c["n_P"],
        "T_P [Nm]": c["T_P"],
        f"Sekundärdruck [{unit}]": 1e3 * c["F_S"] / 0.01 / pascal,
        "slip [%]": c["slip"],
    }
    found = points.read(table(tmp_path / "table.csv", some), oil=Oil({"secondary.cylinder.area": 0.01})).points
    assert [p.force for p in found] == pytest.approx(1e3 * c["F_S"])


def test_per_cent_without_a_sign(tmp_path: Path) -> None:
    c = columns()
    some = {
        "i_geo": c["i_geo"],
        "n_P [rpm]": c["n_P"],
        "T_P [Nm]": c["T_P"],
        "F_S [kN]": c["F_S"],
        "Schlupf": c["slip"],
        "Wirkungsgrad": c["eta"],
    }
    rig = points.read(table(tmp_path / "table.csv", some))
    assert [m.value for p in rig.points for m in p.measured] == pytest.approx(
        0.01 * np.column_stack([c["slip"], c["eta"]]).ravel()
    )
    assert sum("read as %" in remark for remark in rig.sheet.remarks) == 2


# Headers

DESCRIPTIONS = ["ratio", "speed", "speed", "torque", "torque", "force", "force"]
HEADERS = {
    "description, units": [COLUMNS, DESCRIPTIONS, UNITS],
    "description above": [DESCRIPTIONS, COLUMNS, UNITS],
    "units, sensors": [COLUMNS, UNITS, ["calc", *["HBM"] * 6]],
    "channels, units": [COLUMNS, ["channel", *range(1, 7)], UNITS],
    "units above": [UNITS, COLUMNS],
    "titles over two rows": [
        ["geometric", "primary", "secondary", "primary", "secondary", "secondary", "primary"],
        ["ratio", "speed", "speed", "torque", "torque", "force", "force"], UNITS,
    ],
}  # fmt: skip


@pytest.mark.parametrize("header", HEADERS)
def test_rows_of_titles(header: str, tmp_path: Path) -> None:
    is_right(points.read(written(tmp_path / "table.csv", [*HEADERS[header], *ROWS], ";")))


@pytest.mark.parametrize("units", [False, True])
def test_a_transposed_table_is_called_transposed(units: bool, tmp_path: Path) -> None:
    head = [COLUMNS, UNITS] if units else [titled()]
    rows = [list(row) for row in zip(*head, *ROWS, strict=True)]
    with pytest.raises(TableError, match="transposed"):
        points.read(written(tmp_path / "table.csv", rows))


@pytest.mark.parametrize("absent", ["n_P", "F_S", "T_P"])
def test_a_missing_column_is_one_line(absent: str, tmp_path: Path) -> None:
    c = columns()
    some = {f"{n} [{u}]": c[n] for n, u in zip(COLUMNS, UNITS, strict=True) if n != absent}
    with pytest.raises(TableError) as error:
        points.read(table(tmp_path / "table.csv", some))
    assert len(error.value.faults) == 1 and "there is no column" in str(error.value)
    empty = {name: values for name, values in some.items() if name != "T_S [Nm]"} | {
        f"{absent} [{dict(zip(COLUMNS, UNITS, strict=True))[absent]}]": [""] * len(ROWS)
    }
    with pytest.raises(TableError) as error:
        points.read(table(tmp_path / "table.csv", empty))
    assert len(error.value.faults) == 1 and absent in str(error.value)


# Cells


@pytest.mark.parametrize("cell", ["-9999", "-999", "---", "n/a", "NaN", "defect", "#NV", "1e9"])
@pytest.mark.parametrize("column", [1, 3, 6])
def test_a_cell_without_a_number_loses_its_row(cell: str, column: int, tmp_path: Path) -> None:
    rows = [list(map(str, row)) for row in ROWS]
    rows[4][column] = cell
    rig = points.read(written(tmp_path / "table.csv", [titled(), *rows], ";"))
    assert [p.line for p in rig.points] == [line for line in range(2, 14) if line != 6]
    (fault,) = rig.sheet.left_out
    assert (fault.line, fault.column) == (6, titled()[column])


def test_equal_reasons_are_one_line_of_the_check(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [[*row[:3], "n/a" if k % 3 == 0 else row[3], *row[4:]] for k, row in enumerate(ROWS)]
    assert __main__.main([str(written(tmp_path / "table.csv", [titled(), *rows])), "--check"]) == 0
    assert "left out: 4 lines, 2, 5, 8, 11: column T_P [Nm]: 'n/a' is no value" in capsys.readouterr().out


def test_a_formula_that_was_never_calculated_says_so(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(titled())
    for row in ROWS:
        sheet.append([*row[:6], "=1.2*F2"])
    book.save(tmp_path / "rig.xlsx")
    with pytest.raises(TableError, match=r"F_P \[kN\]: a formula that was never calculated"):
        points.read(tmp_path / "rig.xlsx")
    for line, row in enumerate(ROWS[:-2], 2):
        sheet.cell(line, 7).value = row[6]
    book.save(tmp_path / "rig.xlsx")
    rig = points.read(tmp_path / "rig.xlsx")
    assert len(rig.points) == 10 and [fault.line for fault in rig.sheet.left_out] == [12, 13]


# Time series

HEAD = ["t [s]", *titled()]


def shown(row: np.ndarray) -> list[str]:
    return [f"{value:.6g}" for value in row]


def is_series(rig: Rig, count: int = 12, rel: float = 0.01) -> None:
    assert values(rig) == pytest.approx(POINTS[:count, [0, 1, 3, 5]], rel=rel)
    assert all(
        p.measured[0].value == pytest.approx(point[6] / point[5], rel=rel)
        for p, point in zip(rig.points, POINTS, strict=False)
    )


@pytest.mark.parametrize(
    ("step", "length", "ramp", "noise"),
    [
        (0.01, 2.0, 0.0, 0.005),
        (0.01, 1.0, 0.3, 0.01),
        (0.1, 5.0, 1.0, 0.005),
        (1.0, 15.0, 0.0, 0.005),
        (0.01, 2.0, 2.0, 0.002),
        (0.02, 2.0, 0.0, 0.0),
    ],
)
def test_plateaus_of_a_time_series_are_the_points(
    step: float, length: float, ramp: float, noise: float, tmp_path: Path
) -> None:
    rig = points.read(written(tmp_path / "series.csv", [HEAD, *map(shown, recorded(step, length, ramp, noise))]))
    is_series(rig, rel=0.02)


def test_a_plateau_has_its_scatter_and_count(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = recorded(points=7)
    path = written(tmp_path / "series.csv", [HEAD, *map(shown, data)])
    rig = points.read(path)
    is_series(rig, 7)
    (remark,) = [remark for remark in rig.sheet.remarks if remark.startswith("plateau 3:")]
    inside = data[425:576]
    assert "lines 427 to 577, 151 samples" in remark
    assert f"T_P [Nm] {inside[:, 4].mean():.4g}" in remark and f"± {inside[:, 4].std(ddof=1):.2g}" in remark
    # The standard error is small beside the assumed deviation of a thrust ratio, 1 %.
    ratio = rig.points[2].measured[0]
    shares = [inside[:, k].std(ddof=1) / inside[:, k].mean() / np.sqrt(151) for k in (6, 7)]
    assert ratio.deviation == pytest.approx(ratio.value * np.hypot(0.01, np.hypot(*shares)), rel=1e-3)
    assert __main__.main([str(path), "--check"]) == 0
    said = capsys.readouterr().out
    assert "7 plateaus" in said and "7 points: a fit of 3 parameters takes about" in said


def clock(time: float) -> datetime.datetime:
    return datetime.datetime(2026, 11, 27, 23, 59, 55) + datetime.timedelta(seconds=time)


TIMES = {
    "Zeit [ms]": lambda t: f"{1e3 * t:g}",
    "timestamp": lambda t: f"{1.7e9 + t:.3f}",
    "Time stamp": lambda t: f"{1.7e12 + 1e3 * t:.0f}",
    "Datum": lambda t: clock(t).strftime("%d.%m.%Y %H:%M:%S.%f"),
    "time": lambda t: clock(t).isoformat(),
    "Date": lambda t: clock(t).strftime("%m/%d/%Y %I:%M:%S.%f %p"),
    "Uhrzeit": lambda t: clock(t).strftime("%H:%M:%S.%f"),
    "Time [hh:mm:ss]": lambda t: clock(t).strftime("%H:%M:%S.%f"),
}


@pytest.mark.parametrize("title", TIMES)
def test_times_as_dates_and_clocks(title: str, tmp_path: Path) -> None:
    data = recorded(points=5)
    rows = [[TIMES[title](row[0]), *shown(row[1:])] for row in data]
    is_series(points.read(written(tmp_path / "series.csv", [[title, *titled()], *rows])), 5)


def test_a_date_beside_a_clock(tmp_path: Path) -> None:
    rows = [["27.11.2026", clock(row[0] - 20).strftime("%H:%M:%S.%f"), *shown(row[1:])] for row in recorded(points=5)]
    is_series(points.read(written(tmp_path / "series.csv", [["Datum", "Uhrzeit", *titled()], *rows], ";")), 5)


def test_samples_without_times(tmp_path: Path) -> None:
    is_series(points.read(written(tmp_path / "series.csv", [titled(), *map(shown, recorded(points=5)[:, 1:])])), 5)


def test_channels_with_times_of_their_own(tmp_path: Path) -> None:
    data = recorded(points=6)
    groups = [(data[::every, [0]], data[::every, 1 + k]) for k, every in enumerate((1, 2, 5, 1, 2, 5, 1))]
    longest = len(data)

    def cell(column: np.ndarray, row: int) -> str:
        return f"{column[row]:.5f}" if row < len(column) else ""

    titles = [title for name in titled() for title in ("t [s]", name)]
    rows = [[cell(column, row) for times, values in groups for column in (times[:, 0], values)] for row in range(longest)]
    apart = points.read(written(tmp_path / "apart.csv", [titles, *rows]))
    together = points.read(written(tmp_path / "together.csv", [["t [s]", *titled()], *data.tolist()]))
    assert len(apart.points) == len(together.points) == 6
    assert values(apart) == pytest.approx(values(together), rel=4e-3)


def test_channels_with_their_own_rasters(tmp_path: Path) -> None:
    rows = [[cell if line % every == 0 else "" for cell, every in zip(shown(row), (1, 3, 3, 1, 2, 10, 5, 1), strict=True)]
            for line, row in enumerate(recorded())]  # fmt: skip
    rig = points.read(
        written(tmp_path / "series.csv", [[HEAD[0], *HEAD[2:], HEAD[1]], *([r[0], *r[2:], r[1]] for r in rows)])
    )
    is_series(rig)


def test_a_pause_of_the_recording_and_unequal_times_cost_no_memory(tmp_path: Path) -> None:
    """The channels' times differ by less than a microsecond, and the recorder pauses for a year."""
    data = recorded(points=5)
    data[500:, 0] += 3e7
    rows = []
    for row in data:
        rows += [
            [f"{row[0]:.3f}", *shown(row[1:5]), "", "", ""],
            [f"{row[0] + 5e-7:.7f}", "", "", "", "", *shown(row[5:])],
        ]
    rig = points.read(written(tmp_path / "series.csv", [HEAD, *rows]))
    assert len(rig.points) == 5
    is_series(rig, 5)


def test_spikes_and_lost_samples_do_not_split_a_plateau(tmp_path: Path) -> None:
    rows = list(map(shown, recorded(points=5)))
    for line, cell in ((60, "-9999"), (61, "n/a"), (470, "99.9"), (700, "99.9")):
        rows[line][6] = cell
    rig = points.read(written(tmp_path / "series.csv", [HEAD, *rows]))
    is_series(rig, 5)
    assert [fault.line for fault in rig.sheet.left_out] == [62, 63]


def test_a_ramp_has_no_plateau(tmp_path: Path) -> None:
    data = np.tile(recorded(points=1)[0], (4800, 1))
    data[:, 0], data[:, 4] = 0.01 * np.arange(4800), np.linspace(0.0, 60.0, 4800)
    with pytest.raises(TableError, match="without a plateau"):
        points.read(written(tmp_path / "series.csv", [HEAD, *map(shown, data)]))


@pytest.mark.parametrize("title", ["Datum", "time"])
def test_words_for_the_time_lose_no_row(title: str, tmp_path: Path) -> None:
    is_right(points.read(written(tmp_path / "table.csv", [[title, *titled()], *(["Monday", *row] for row in ROWS)])))


def test_points_with_their_times_are_no_time_series(tmp_path: Path) -> None:
    rows = [[600 * k, *row] for k, row in enumerate(ROWS * 2)]
    assert len(points.read(written(tmp_path / "table.csv", [HEAD, *rows])).points) == 24


# Files


def test_a_compressed_file(tmp_path: Path) -> None:
    path = tmp_path / "table.csv.gz"
    path.write_bytes(gzip.compress(written(tmp_path / "table.csv", [titled(), *ROWS]).read_bytes()))
    is_right(points.read(path))
    path.write_bytes(path.read_bytes()[:-12])
    with pytest.raises(TableError, match="gzip"):
        points.read(path)


def test_parquet(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    data = recorded(points=5)
    frame = pandas.DataFrame(data[:, 1:], columns=titled(), index=pandas.to_datetime(1.7e9 + data[:, 0], unit="s"))
    frame.loc[frame.index[1::2], "F_S [kN]"] = np.nan
    frame.to_parquet(tmp_path / "series.parquet")
    is_series(points.read(tmp_path / "series.parquet"), 5)


def test_mf4_with_channels_at_their_own_times(tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf")
    data = recorded(points=5)
    path = tmp_path / "series.mf4"
    with asammdf.MDF() as file:
        for k, (name, unit) in enumerate(zip([*COLUMNS, "noise"], [*UNITS, "dB"], strict=True)):
            every = (1, 2, 2, 5, 5, 10, 10, 1)[k]
            file.append(asammdf.Signal(data[::every, min(k + 1, 7)], data[::every, 0], name=name, unit=unit))
        file.save(path)
    rig = points.read(path)
    is_series(rig, 5)
    assert rig.sheet.source == "MDF"
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(TableError, match="MDF"):
        points.read(path)


def test_a_list_of_points_of_a_sweep_is_read_in_the_same_way(description: Any, tmp_path: Path) -> None:
    variables = {variable.name: variable for variable in description.modelVariables}
    c = columns()
    some = {
        "Drehzahl Primär [1/min]": c["n_P"],
        "geometrische Übersetzung": c["i_geo"],
        "Anpresskraft [lbf]": 1e3 * c["F_S"] / POUND,
    }
    path = tmp_path / "points.csv.gz"
    path.write_bytes(gzip.compress(table(tmp_path / "points.csv", some).read_bytes()))
    design, _ = listed(path, variables)
    assert design.columns == ("initial.primarySpeed", "initial.ratio", "secondary.clampingForce")
    assert np.array(design.rows) == pytest.approx(
        np.column_stack([c["n_P"] * np.pi / 30.0, c["i_geo"], 1e3 * c["F_S"]])
    )
