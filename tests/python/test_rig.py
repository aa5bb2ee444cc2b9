"""Tables of rigs: one table in many notations gives the same points; faults are named with line and column, all at once."""

from __future__ import annotations

import itertools
import math
import random
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pushbelt.calibrate import __main__
from pushbelt.tables import files, numerals, points, units
from pushbelt.tables.faults import TableError
from pushbelt.tables.points import Oil, Rig
from pushbelt.tables.sheet import Reading

QUANTITIES = (
    "ratio.geometric", "primary.speed", "primary.torque", "secondary.clampingForce", "primary.clampingForce", "slip", "efficiency",
)  # fmt: skip
ROWS = (
    (1.85, 1210.5, 71.25, 17.5, 18.34, 0.71, 96.1),
    (1.85, 1210.5, -22.4, 9.25, 6.105, -0.32, 95.25),
    (1.15, 2104.0, 44.0, 10.0, 12.77, 0.354, 96.82),
    (0.74, 2651.25, 38.6, 9.5, 13.61, 0.218, 95.07),
    (0.52, 3005.0, 31.05, 8.75, 12.96, 0.172, 92.4),
)
"""Ratio, rpm, N·m, kN, kN, %, %."""
UNITS = {
    "usual": ("", "rpm", "N.m", "kN", "kN", "%", "%"),
    "signs": ("-", "1/min", "Nm", "kN", "kN", "%", "%"),
    "typographic": ("1", "min⁻¹", "N·m", "KN", "kn", "pct", "percent"),
    "german": ("[-]", "U/min", "N m", "kN", "kN", "Prozent", "%"),
    "english": ("–", "RPM", "N*m", "kN", "kN", "%", "%"),
    "revolutions": ("", "rev/min", "Nm", "kN", "kN", "%", "%"),
}
TITLES = {
    "own": QUANTITIES,
    "capital": tuple(name.upper() for name in QUANTITIES),
    "words": ("Geometric Ratio", "primary speed", "Primary Torque", "secondary clamping force", "Primary_Clamping_Force", "Slip", "ETA"),
    "letters": ("i_geo", "n_P", "T_P", "F_S", "F_P", "slip", "eta"),
    "numbers": ("i_geo", "n1", "T1", "F2", "F1", "slip", "η"),
}
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "cp1252")


def numeral(value: float, decimal: str, thousands: str) -> str:
    whole, _, part = f"{abs(value):.3f}".rstrip("0").rstrip(".").partition(".")
    groups = [whole[max(k - 3, 0) : k] for k in range(len(whole), 0, -3)][::-1]
    return ("-" if value < 0.0 else "") + thousands.join(groups) + (decimal + part if part else "")


def rows_of(decimal: str = ".", thousands: str = "") -> list[list[str]]:
    return [[numeral(value, decimal, thousands) for value in row] for row in ROWS]


def titled(titles: Sequence[str], spelled: Sequence[str], style: str) -> list[list[str]]:
    """The header: units in brackets, in parentheses, after a word, or in a row of their own."""
    if style == "row":
        return [list(titles), [unit or "-" for unit in spelled]]
    if style == "bracketed row":
        return [list(titles), [f"[{unit.strip('[]') or '-'}]" for unit in spelled]]
    joined = {"brackets": "{} [{}]", "parentheses": "{} ({})", "slash": "{} / {}", "in": "{} in {}", "tight": "{}[{}]"}[style]
    found = []
    for title, unit in zip(titles, spelled, strict=True):
        plain = unit.strip("[]")
        found.append(joined.format(title, plain) if plain not in ("", "-", "–", "1") or style == "brackets" and plain else title)
    return [found]


def joined(rows: Sequence[Sequence[str]], separator: str, newline: str = "\n", quotes: bool = False) -> str:
    def cell(value: str) -> str:
        return f'"{value}"' if quotes or (separator.strip() and separator in value) else value

    return newline.join(separator.join(map(cell, row)) for row in rows) + newline


def written(tmp_path: Path, content: str | bytes, encoding: str = "utf-8", name: str = "table.csv") -> Path:
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode(encoding))
    return path


def values_of(rig: Rig) -> np.ndarray:
    return np.array(
        [[p.ratio, p.speed, p.torque, p.force, *(m.value for m in p.measured)] for p in rig.points], dtype=float
    )


def expected() -> np.ndarray:
    return np.array([[r[0], r[1] * math.pi / 30.0, r[2], 1e3 * r[3], r[4] / r[3], r[5] / 100.0, r[6] / 100.0] for r in ROWS])


def is_right(rig: Rig) -> None:
    assert [[m.quantity for m in p.measured] for p in rig.points] == [["thrustRatio", "slip", "efficiency"]] * len(ROWS)
    assert values_of(rig) == pytest.approx(expected(), rel=1e-12)


def combinations() -> list[tuple[Any, ...]]:
    """All pairs of a notation's parts that can be written, in a seeded choice of the full product."""
    numbers = [(".", ""), (",", ""), (".", ","), (",", "."), (".", " "), (",", "\N{NO-BREAK SPACE}"), (".", "'"), (",", "\N{NARROW NO-BREAK SPACE}")]
    parts = (
        ENCODINGS, (";", "\t", ",", "|"), numbers, TITLES, UNITS,
        ("brackets", "parentheses", "slash", "in", "tight", "row", "bracketed row"), ("\n", "\r\n", "\r"), (False, True),
    )  # fmt: skip
    chosen = random.Random(52).sample(list(itertools.product(*map(tuple, parts))), 160)

    def possible(one: tuple[Any, ...]) -> bool:
        encoding, _, (_, thousands), titles, spelled, *_ = one
        characters = "".join((*TITLES[titles], *UNITS[spelled], thousands))
        return encoding != "cp1252" or not any(sign in characters for sign in "η⁻\N{NARROW NO-BREAK SPACE}")

    return [one for one in chosen if possible(one)]


def test_one_table_in_every_notation_gives_the_same_points(tmp_path: Path) -> None:
    """Encodings, separators, decimal and thousands signs, names, units and their place, ends of lines, quotes."""
    tried = combinations()
    assert len(tried) > 120
    for values in zip(*tried, strict=True):
        assert len(set(map(str, values))) > 1
    for one in tried:
        encoding, separator, (decimal, thousands), titles, spelled, style, newline, quotes = one
        header = titled(TITLES[titles], UNITS[spelled], style)
        content = joined([*header, *rows_of(decimal, thousands)], separator, newline, quotes)
        try:
            is_right(points.read(written(tmp_path, content, encoding)))
        except (TableError, AssertionError) as error:
            pytest.fail(f"{one}\n{content}\n{error}")


HEADER = ["ratio.geometric", "primary.speed [rpm]", "primary.torque [N.m]", "secondary.clampingForce [kN]", "primary.clampingForce [kN]"]
HEADER += ["slip [%]", "efficiency [%]"]

VARIANTS = {
    "sep": "sep=;\n" + joined([HEADER, *rows_of()], ";"),
    "quoted sep": '"sep=;"\n' + joined([HEADER, *rows_of(",")], ";"),
    "sep that no row has twice": "sep=|\r\n" + joined([HEADER, *rows_of(",")], "|", "\r\n"),
    "index": joined([["", *HEADER], *([str(k), *row] for k, row in enumerate(rows_of()))], ","),
    "numbered": joined([["Nr.", *HEADER], *([str(k), *row] for k, row in enumerate(rows_of()))], ";"),
    "hash": joined([["#", *HEADER], *([str(k), *row] for k, row in enumerate(rows_of()))], ","),
    "unnamed": joined([["Unnamed: 0", *HEADER], *([str(k), *row] for k, row in enumerate(rows_of()))], ","),
    "oil temperature": joined([[*HEADER, "T_oil [°C]"], *([*row, "81,5"] for row in rows_of(","))], ";"),
    "a temperature that is named like a torque": joined([[*HEADER, "T_P [°C]"], *([*row, "81.5"] for row in rows_of())], ","),
    "date and time": joined([["Date", "Clock", *HEADER], *(["27.11.2026", "10:05:11", *row] for row in rows_of(","))], ";"),
    "empty lines": joined([HEADER], ",") + "\n\n" + joined(rows_of(), ",\n,,,,,\n".replace("\n,,,,,\n", "")) + "\n",
    "separators at the ends": "".join(line + ";;\n" for line in joined([HEADER, *rows_of(",")], ";").splitlines()),
    "blanks": joined([HEADER, *rows_of()], "   "),
    "padded": joined([[f" {title} " for title in HEADER], *([f"  {cell} " for cell in row] for row in rows_of())], ";"),
    "remarks": "# rig 3\n#; made by hand\n" + joined([HEADER, *rows_of()], ",").replace("\n", "\n# between\n", 2),
    "header in a remark": "# rig 3\n# " + joined([HEADER, *rows_of()], ","),
    "preamble": "Rig;3\nOperator;N. N.\n\n" + joined([HEADER, *rows_of(",")], ";"),
    "title over two lines": joined([['"primary.speed\n[rpm]"' if "speed" in t else t for t in HEADER], *rows_of()], ","),
    "per cent in the cells": joined([[t.replace(" [%]", "") for t in HEADER], *([*r[:5], r[5] + "%", r[6] + " %"] for r in rows_of())], ","),
    "typographic minus": joined([HEADER, *rows_of()], ",").replace("-", "\N{MINUS SIGN}"),
    "exponents": joined([HEADER, *([f"{float(cell):.6E}" for cell in row] for row in rows_of())], ","),
    "exponents with commas": joined([HEADER, *([f"{float(cell):.6e}".replace(".", ",") for cell in row] for row in rows_of())], "\t"),
    "other order": joined([[*HEADER[::-1]], *(row[::-1] for row in rows_of())], ","),
    "a column without values": joined([[*HEADER, "ds/dt [1/s]"], *([*row, "NaN"] for row in rows_of())], ","),
    "empty column": joined([[*HEADER, "thrustRatio"], *([*row, ""] for row in rows_of())], ","),
    "units after underscores": joined([["i_geo", "n_P_rpm", "T_P_Nm", "F_S_kN", "F_P_kN", "slip_%", "eta_%"], *rows_of()], ","),
    "newtons": joined(
        [[t.replace("kN", "N") for t in HEADER], *([*r[:3], f"{1e3 * float(r[3]):.0f}", f"{1e3 * float(r[4]):.0f}", *r[5:]] for r in rows_of())], ";"
    ),
    "shares": joined([[t.replace(" [%]", "") for t in HEADER], *([*r[:5], *(f"{float(c) / 100:.6f}" for c in r[5:])] for r in rows_of())], ","),
    "rad/s": joined([[t.replace("rpm", "rad/s") for t in HEADER], *([r[0], repr(float(r[1]) * math.pi / 30), *r[2:]] for r in rows_of())], ","),
    "numbers of a spreadsheet with a unit in a row above an empty one": joined(
        [["i_geo", "n_P", "T_P", "F_S", "F_P", "slip", "eta"], ["", "rpm", "Nm", "kN", "kN", "%", "%"], [""] * 7, *rows_of(",")], ";"
    ),
    "rows with error values": joined([HEADER, rows_of()[0], ["#DIV/0!", *rows_of()[0][1:]], *rows_of()[1:]], ","),
    "rows without a needed value": joined([HEADER, *rows_of(","), ["1,5", "", *rows_of(",")[0][2:]]], ";"),
    "rows with NaN": joined([HEADER, *rows_of(), ["1.5", *rows_of()[0][1:5], "nan", "96"]], ","),
}  # fmt: skip


@pytest.mark.parametrize("variant", VARIANTS)
def test_habits_of_rigs_and_spreadsheets(variant: str, tmp_path: Path) -> None:
    rig = points.read(written(tmp_path, VARIANTS[variant]))
    is_right(rig)
    assert bool(rig.sheet.left_out) == variant.startswith("rows")


def test_rows_that_are_left_out_are_named(tmp_path: Path) -> None:
    rows = rows_of()
    rows[1][2], rows[3][5], rows[4][0] = "", "#N/A", "-nan"
    rig = points.read(written(tmp_path, joined([HEADER, *rows], ",")))
    assert [point.line for point in rig.points] == [2, 4]
    assert sorted(str(fault) for fault in rig.sheet.left_out) == [
        "line 3, column primary.torque [N.m]: the cell is empty",
        "line 5, column slip [%]: '#N/A' is no value",
        "line 6, column ratio.geometric: '-nan' is no value",
    ]


def test_spreadsheets_are_read(tmp_path: Path) -> None:
    """Numbers, per cent formats, error values, a second sheet, text with decimal commas."""
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["Rig 3", "made by hand"])
    sheet = book.create_sheet("Points")
    sheet.append(["Rig 3"])
    sheet.append([])
    sheet.append(["Nr.", "i_geo", "n_P", "T_P", "F_S", "F_P", "slip", "eta", "T_oil"])
    sheet.append(["", "-", "1/min", "Nm", "kN", "kN", "%", "%", "°C"])
    for k, row in enumerate(ROWS):
        sheet.append([k, *row[:5], row[5] / 100.0, row[6], "80,5"])
        sheet.cell(sheet.max_row, 7).number_format = "0.00%"
    sheet.append([9, "#DIV/0!", *ROWS[0][1:], ""])
    sheet.cell(sheet.max_row, 2).data_type = "e"
    path = tmp_path / "rig.xlsx"
    book.save(path)
    rig = points.read(path)
    is_right(rig)
    assert rig.sheet.source == "sheet Points"
    assert [point.line for point in rig.points] == [5, 6, 7, 8, 9]
    assert [fault.line for fault in rig.sheet.left_out] == [10]
    with pytest.raises(TableError, match="no sheet Data; there are Sheet, Points"):
        points.read(path, Reading(sheet="Data"))


# Decimal signs


@pytest.mark.parametrize("cells", [["1,234", "5"], ["2.125", "1.500"], ["1,234", "12,500", "-3"]])
def test_numbers_with_two_readings_ask_for_the_decimal_sign(cells: list[str]) -> None:
    with pytest.raises(numerals.NumeralError, match="specify --decimal point or --decimal comma"):
        numerals.settle(cells, ";")


@pytest.mark.parametrize(
    ("cells", "separator", "decimal"),
    [
        (["1,234", "5,25"], ";", "comma"),
        (["1,234", "5.25"], ";", "point"),
        (["1.234", "0.617"], ";", "point"),
        (["1.234,5"], "\t", "comma"),
        (["1,234.5"], "\t", "point"),
        (["1.500", "2.125"], ",", "point"),
        (["12", "-3"], ";", "point"),
        (["1.234.567", "1.000"], ";", "comma"),
        (["nan", "", "1,5"], ";", "comma"),
    ],
)
def test_the_whole_file_settles_the_decimal_sign(cells: list[str], separator: str, decimal: str) -> None:
    assert numerals.settle(cells, separator) == decimal


def test_the_user_settles_the_decimal_sign(tmp_path: Path) -> None:
    content = "i_geo;n_P [rpm];T_P [Nm];F_S [kN];thrustRatio\n1,250;1,500;40;10;1,125\n"
    path = written(tmp_path, content)
    with pytest.raises(TableError, match="--decimal"):
        points.read(path)
    with pytest.raises(TableError, match=r"line 2, column n_P \[rpm\]: 1,500 is not within"):
        points.read(path, Reading(decimal="comma"))
    (point,) = points.read(written(tmp_path, content.replace("1,500", "1500")), Reading(decimal="comma")).points
    assert (point.ratio, point.measured[0].value) == (1.25, 1.125)


def test_a_number_with_the_other_sign_is_a_fault(tmp_path: Path) -> None:
    rows = rows_of()
    rows[2][2] = "44,05"
    with pytest.raises(TableError, match=r"line 4, column primary.torque \[N.m\]: '44,05' is not a number with a decimal point"):
        points.read(written(tmp_path, joined([HEADER, *rows], ";")))


# Units and names


@pytest.mark.parametrize("dimension", ["ratio", "speed", "torque", "force", "pressure", "time", "rate", "velocity", "length", "area"])
def test_units_in_other_cases_have_the_same_factor_or_none(dimension: str) -> None:
    """A prefix in the wrong case never changes the factor silently."""
    for spelling, unit in units.spellings()[dimension].items():
        assert units.find(spelling, dimension) == unit
        for other in (spelling.lower(), spelling.upper(), spelling.capitalize()):
            assert units.find(other, dimension) in (unit, None) or other in units.spellings()[dimension]
    for unit in units.usual(dimension):
        assert units.find(unit, dimension) is not None


@pytest.mark.parametrize(
    ("spelling", "dimension", "si"),
    [
        ("Nm", "torque", 1.0), ("N·m", "torque", 1.0), ("N⋅m", "torque", 1.0), ("N m", "torque", 1.0), ("kNm", "torque", 1e3),
        ("min⁻¹", "speed", math.pi / 30), ("min^-1", "speed", math.pi / 30), ("1/min", "speed", math.pi / 30), ("s^-1", "rate", 1.0),
        ("rad s⁻¹", "speed", 1.0), ("KN", "force", 1e3), ("bar", "pressure", 1e5), ("MPa", "pressure", 1e6), ("N/mm²", "pressure", 1e6),
        ("[kN]", "force", 1e3), ("(kN)", "force", 1e3), ("cm²", "area", 1e-4), ("l/min", "flow", 1.0 / 6e4), ("lb-ft", "torque", 1.3558179483314),
    ],
)  # fmt: skip
def test_spellings_of_units(spelling: str, dimension: str, si: float) -> None:
    assert units.find(spelling, dimension).si(1.0) == pytest.approx(si, rel=1e-12)


@pytest.mark.parametrize(("spelling", "dimension"), [("mPA", "pressure"), ("1/s", "speed"), ("kNm", "force"), ("", "force")])
def test_units_without_a_certain_meaning_are_refused(spelling: str, dimension: str) -> None:
    assert units.find(spelling, dimension) is None


def test_all_faults_of_a_file_are_in_one_answer_at_once(tmp_path: Path) -> None:
    content = (
        "ratio.geometric;n_P [rpm];primary.torque [kN];F_S [kN];thrustRato;slip [%];colour\n"
        "2,1;1500;60;14;1,1;0,5;red\n2,1;15x0;60;14;1,1;80;red\n0,01;1500;60;14;1,1;0,5;red;7\n"
    )
    path = written(tmp_path, content)
    begin = time.process_time()
    with pytest.raises(TableError) as error:
        points.read(path)
    assert time.process_time() - begin < 0.5
    said = str(error.value)
    for part in (
        "line 1, column primary.torque [kN]: the unit of primary.torque is N.m or kN.m, not kN",
        "line 1, column thrustRato: there is no such column; thrustRatio is meant?",
        "line 3, column n_P [rpm]: '15x0' is not a number",
        "line 3, column slip [%]: 80 is not within -50 to 50 %",
        "line 4: 8 cells, but the header has 7",
        "line 4, column ratio.geometric: 0,01 is not within 0.1 to 10",
    ):
        assert part in said
    assert "colour" not in said and said.startswith(f"{path}: 6 faults\n")


@pytest.mark.parametrize("title", ["primery.torque [Nm]", "primary.torqe [Nm]", "secondary.clampForces [kN]", "ratio.geometrc", "efficency"])
def test_a_title_close_to_a_known_name_is_a_fault(title: str, tmp_path: Path) -> None:
    path = written(tmp_path, joined([[*HEADER, title], *([*row, "1"] for row in rows_of())], ","))
    with pytest.raises(TableError, match="is meant"):
        points.read(path)


@pytest.mark.parametrize("title", ["T_oil", "humidity [%]", "belt noise [dB]", "p_line [bar]", "u", "axle torque sensor"])
def test_other_unknown_titles_are_named_and_ignored(title: str, tmp_path: Path) -> None:
    rig = points.read(written(tmp_path, joined([[*HEADER, title], *([*row, "x"] for row in rows_of())], ",")))
    is_right(rig)
    assert rig.sheet.ignored == [title]


def test_names_by_the_user(tmp_path: Path) -> None:
    titles = ["k", "Drehzahl", "Moment vorn", "Kraft hinten", "Kraft vorn", "slip [%]", "efficiency [%]"]
    path = written(tmp_path, joined([titles, *rows_of(",")], ";"))
    renamed = {
        "k": "ratio.geometric", "Drehzahl": "primary.speed [rpm]", "T_P [Nm]": "Moment vorn", "Kraft hinten": "F_S [kN]", "Kraft vorn": "F_P [kN]",
    }  # fmt: skip
    is_right(points.read(path, Reading(renamed=renamed)))
    with pytest.raises(TableError, match="there is no column Drehmoment in the file"):
        points.read(path, Reading(renamed=renamed | {"Drehmoment": "primary.torque"}))
    with pytest.raises(TableError, match="neither k nor gear is a known name"):
        points.read(path, Reading(renamed={"k": "gear"}))


def test_a_column_with_the_inverse_or_the_other_sign_is_turned(tmp_path: Path) -> None:
    rows = [[repr(1.0 / row[0]), repr(row[1]), repr(-row[2]), *map(repr, row[3:])] for row in ROWS]
    path = written(tmp_path, joined([["x", *HEADER[1:]], *rows], ","))
    is_right(points.read(path, Reading(renamed={"x": "1/ratio.geometric", "primary.torque": "-primary.torque"})))


def test_i_is_the_speed_ratio_unless_the_user_says_otherwise(tmp_path: Path) -> None:
    path = written(tmp_path, joined([["i", *HEADER[1:]], *rows_of()], ","))
    assert all(point.ratio is None and point.speed_ratio for point in points.read(path).points)
    is_right(points.read(path, Reading(renamed={"i": "ratio.geometric"})))


# Quantities that follow from others


def test_slip_needs_a_geometric_ratio(tmp_path: Path) -> None:
    rows = [["1.02", "2000", "1950", "10", "40"], ["1.5", "1500", "980", "10", "40"]]
    titles = ["ratio.geometric", "n_P [rpm]", "n_S [rpm]", "F_S [kN]", "T_P [Nm]"]
    found = points.read(written(tmp_path, joined([titles, *rows], ","))).points
    assert [[m.quantity for m in p.measured] for p in found] == [["slip"]] * 2
    assert [p.measured[0].value for p in found] == pytest.approx([1 - 1.02 * 1950 / 2000, 1 - 1.5 * 980 / 1500])
    without = joined([[*titles[1:], "thrustRatio"], *([*row[1:], "1.2"] for row in rows)], ",")
    rig = points.read(written(tmp_path, without))
    assert [[m.quantity for m in p.measured] for p in rig.points] == [["thrustRatio"]] * 2
    assert [p.speed_ratio for p in rig.points] == pytest.approx([2000 / 1950, 1500 / 980])


def test_efficiency_takes_the_torque_of_any_sign_and_overrun_inverts_it(tmp_path: Path) -> None:
    titles = ["n_P [rpm]", "n_S [rpm]", "T_P [Nm]", "T_S [Nm]", "F_S [kN]"]
    rows = [[2000, 1000, 50, -96, 10], [2000, 1000, 50, 96, 10], [2000, 1000, -48, 100, 10], [2000, 1000, 0, 3, 10]]
    rig = points.read(written(tmp_path, joined([titles, *([str(c) for c in row] for row in rows)], ",")))
    assert [p.measured[0].value for p in rig.points] == pytest.approx([0.96, 0.96, 0.96])


def test_an_efficiency_above_one_is_inverted_in_overrun_only(tmp_path: Path) -> None:
    titles = ["i_geo", "n_P [rpm]", "T_P [Nm]", "F_S [kN]", "eta [%]"]
    rig = points.read(written(tmp_path, joined([titles, ["1", "2000", "-40", "10", "104"]], ",")))
    assert rig.points[0].measured[0].value == pytest.approx(1.0 / 1.04)
    with pytest.raises(TableError, match=r"line 2, column eta \[%\]: 104 is not within 1 to 100"):
        points.read(written(tmp_path, joined([titles, ["1", "2000", "40", "10", "104"]], ",")))


def test_pressures_give_forces(tmp_path: Path) -> None:
    titles = ["i_geo", "n_P [rpm]", "T_P [Nm]", "p_S [bar]", "p_P [bar]", "slip [%]"]
    path = written(tmp_path, joined([titles, ["2", "3000", "40", "10", "12", "0.5"]], ","))
    with pytest.raises(TableError, match=r"column p_S \[bar\]: .*secondary\.cylinder\.area"):
        points.read(path)
    areas = {"primary.cylinder.area": 0.02, "secondary.cylinder.area": 0.01}
    rig = points.read(path, oil=Oil(areas))
    (point,) = rig.points
    assert point.force == pytest.approx(1e4)
    assert point.measured[0].value == pytest.approx(2.4)
    assert any(remark.startswith("warning: secondary.clampingForce is without the centrifugal force") for remark in rig.remarks)
    oil = Oil({**areas, "primary.cylinder.centrifugal": 0.01, "secondary.cylinder.centrifugal": 0.02, "secondary.cylinder.springForce": 300.0})
    rig = points.read(path, oil=oil)
    speed = 3000 * math.pi / 30
    assert rig.points[0].force == pytest.approx(1e4 + 300.0 + 0.02 * (speed / 2) ** 2)
    assert rig.points[0].measured[0].value == pytest.approx((2.4e4 + 0.01 * speed**2) / rig.points[0].force)
    assert not any("warning" in remark for remark in rig.remarks)


def test_a_ratio_that_contradicts_the_speeds_is_a_fault(tmp_path: Path) -> None:
    titles = ["i_geo", "n_P [rpm]", "n_S [rpm]", "T_P [Nm]", "F_S [kN]"]
    rows = [["0.5", "2000", "990", "40", "10"], ["1.6", "1500", "2380", "40", "10"]]
    path = written(tmp_path, joined([titles, *rows], ","))
    with pytest.raises(TableError, match="it is the inverse of ratio.geometric.*--map \"i_geo=1/ratio.geometric\""):
        points.read(path)
    found = points.read(path, Reading(renamed={"i_geo": "1/ratio.geometric"})).points
    assert [p.ratio for p in found] == pytest.approx([2.0, 1 / 1.6])
    rows[1][0] = "4"
    rows[0][0] = "2"
    with pytest.raises(TableError, match="line 3, column i_geo: 4, but the speeds give 0.6303"):
        points.read(written(tmp_path, joined([titles, *rows], ",")))


# Recorded shifts


def test_series_of_samples_are_recorded_shifts(tmp_path: Path) -> None:
    titles = ["series", "time [ms]", "n_P [rpm]", "T_P [Nm]", "F_P [kN]", "F_S [kN]", "ratio.geometric"]
    rows = [
        [name, str(time), "1500", "20", "12", "10", f"{ratio:g}"]
        for name, start in (("up", 1.5), ("down", 0.8))
        for time, ratio in ((10, start), (60, start + 0.05), (110, start + 0.09))
    ]
    rig = points.read(written(tmp_path, joined([titles, *rows], ",")))
    assert rig.recorded
    up, down = rig.points
    assert [m.value for m in down.measured] == pytest.approx([0.85, 0.89])
    assert [m.time for m in up.measured] == pytest.approx([0.05, 0.1])
    assert up.samples[0][:3] == pytest.approx((0.0, 50 * math.pi, 20.0))
    rows[1][1] = "10"
    with pytest.raises(TableError, match=r"line 3, column time \[ms\]: 0.01 s is not after 0.01 s"):
        points.read(written(tmp_path, joined([titles, *rows], ",")))
    with pytest.raises(TableError, match="there is no column primary.clampingForce"):
        points.read(written(tmp_path, joined([[t for t in titles if t != "F_P [kN]"], *([*r[:4], *r[5:]] for r in rows)], ",")))


# Files


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "the table is empty"),
        (b"\xff\xfe", "the table is empty"),
        (b"\xd0\xcf\x11\xe0rest", "old Excel file"),
        (b"PK\x03\x04rest", "not a readable .xlsx file"),
        (bytes(range(256)) * 8, "bytes that no text has"),
        (b"ratio.geometric,slip\n", "there is no column primary.speed"),
    ],
)
def test_files_that_are_no_tables_say_so(content: bytes, why: str, tmp_path: Path) -> None:
    with pytest.raises(TableError, match=why) as error:
        points.read(written(tmp_path, content))
    assert "\n" not in str(error.value)


def test_remarks_and_error_values_both_start_with_a_hash() -> None:
    assert files.is_remark("# remark") and files.is_remark('"# remark"')
    assert not any(map(files.is_remark, ("#DIV/0!;2", "#N/A", "#NV;1", "2;#")))


def test_check_prints_what_is_understood_and_needs_no_fmu(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = rows_of(",")
    rows[0][5] = "#DIV/0!"
    path = written(tmp_path, joined([[*HEADER, "T_oil [°C]"], *([*row, "80"] for row in rows)], ";"), "cp1252")
    assert __main__.main([str(path), "--check"]) == 0
    said = capsys.readouterr().out
    for part in (
        "CP1252, semicolon between columns, decimal comma",
        "primary.speed [rpm]: primary.speed [rpm], 4 values, 126.76 to 314.68 rad/s",
        "ignored: T_oil [°C]",
        "left out: line 2, column slip [%]: '#DIV/0!' is no value",
        "4 points: 4 thrustRatio, 4 slip, 4 efficiency",
    ):
        assert part in said
    path.write_text("n_P;slip\n1;2\n", encoding="utf-8")
    assert __main__.main([str(path), "--check"]) == 1
    printed = capsys.readouterr()
    assert "there is no column ratio.geometric or ratio.speed" in printed.err
    assert "column n_P: no unit; write primary.speed [rad/s] or primary.speed [rpm]" in printed.err
    assert "slip: slip, 0 values" in printed.out
