"""Tables of rigs: one table in many notations gives the same points; faults are named with line and column, all at once."""

import itertools
import random
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import reports
from pushbelt_validation.outcome import SPELLED as SHOWN
from pushbelt_validation.outcome import UNSCALED
from rig_tables import COLUMNS, ROWS, RPM, TITLES, UNITS, columns, is_right, table, values, written

from pushbelt import tables
from pushbelt.calibrate import __main__
from pushbelt.errors import ArgumentError
from pushbelt.tables import columns as known
from pushbelt.tables import names, numerals, points, units
from pushbelt.tables.sheet import Reading, TableError

POUND = 4.4482216152605

SPELLED = {
    "signs": ("-", "1/min", "1/min", "Nm", "N m", "kN", "kN"),
    "typographic": ("1", "min⁻¹", "min⁻¹", "N·m", "N⋅m", "KN", "kn"),
    "german": ("[-]", "U/min", "U/min", "N m", "Nm", "kN", "kN"),
    "english": ("–", "RPM", "rev/min", "N*m", "N.m", "kN", "kN"),
}
NAMES = {
    "own": ("ratio.geometric", *(f"{pulley}.{what}" for what in ("speed", "torque") for pulley in ("primary", "secondary")),
            "secondary.clampingForce", "PRIMARY.CLAMPINGFORCE"),
    "words": ("Geometric Ratio", "primary speed", "secondary_speed", "Primary Torque", "secondary torque", "secondary clamping force",
              "Primary_Clamping_Force"),
    "letters": COLUMNS,
    "numbers": ("i_geo", "n1", "n2", "T1", "T2", "F2", "F1"),
    "greek": ("i_geo", "ω₁", "ω₂", "M1", "M2", "F₂", "F₁"),
}  # fmt: skip
STYLES = {"brackets": "{} [{}]", "parentheses": "{} ({})", "slash": "{} / {}", "in": "{} in {}", "tight": "{}[{}]", "row": "", "bracketed row": ""}
NUMBERS = [(".", ""), (",", ""), (".", ","), (",", "."), (".", " "), (",", "\N{NO-BREAK SPACE}"), (".", "'"), (",", "\N{NARROW NO-BREAK SPACE}")]
MEASURED = [*TITLES[:2], TITLES[3], *TITLES[5:], "slip [%]", "efficiency [%]"]
LONG = [[repr(float(columns()[t.split(" ")[0].replace("efficiency", "eta")][k])) for t in MEASURED] for k in range(len(ROWS))]
"""The table with slip and efficiency in place of the secondary speed and torque."""
MISSPELLED = ("primery.torque [Nm]", "primary.torqe [Nm]", "secondary.clampForces [kN]", "ratio.geometrc", "efficency")
UNKNOWN = ("T_oil", "humidity [%]", "belt noise [dB]", "p_line [bar]", "u", "axle torque sensor", "primary secondary speed [rpm]", "総変速比i", "油温T")
HEADER = "ratio.geometric,primary.speed [rpm],primary.torque [N.m],secondary.clampingForce [kN]"


def numeral(value: float, decimal: str, thousands: str) -> str:
    whole, _, part = f"{value:,.3f}".rstrip("0").partition(".")
    return whole.replace(",", thousands) + (decimal + part if part else "")


def rows_of(decimal: str = ".", thousands: str = "") -> list[list[str]]:
    return [[numeral(value, decimal, thousands) for value in row] for row in ROWS]


def titled(titles: Sequence[str], spelled: Sequence[str], style: str) -> list[list[str]]:
    """The header: units in brackets, in parentheses, after a word, or in a row of their own."""
    plain = [unit.strip("[]") for unit in spelled]
    if "row" in style:
        return [list(titles), [f"[{unit}]" if "bracketed" in style else unit for unit in plain]]
    without = ("-", "–", "1") if style != "brackets" else ()
    return [[title if unit in without else STYLES[style].format(title, unit) for title, unit in zip(titles, plain, strict=True)]]


def joined(rows: Sequence[Sequence[str]], separator: str = ",", newline: str = "\n", quotes: bool = False) -> str:
    def cell(value: str) -> str:
        return f'"{value}"' if quotes or (separator.strip() and separator in value) else value

    return newline.join(separator.join(map(cell, row)) for row in rows) + newline


def file(tmp_path: Path, content: str | bytes, encoding: str = "utf-8") -> Path:
    path = tmp_path / "table.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode(encoding))
    return path


def test_one_table_in_every_notation_gives_the_same_points(tmp_path: Path) -> None:
    """Encodings, separators, decimal and thousands signs, names, units and their place, ends of lines, quotes."""
    encodings = ("utf-8", "utf-8-sig", "utf-16", "cp1252")
    parts = (encodings, (";", "\t", ",", "|"), NUMBERS, NAMES, SPELLED, STYLES, ("\n", "\r\n", "\r"), (False, True))
    tried = 0
    for one in random.Random(52).sample(list(itertools.product(*map(tuple, parts))), 80):
        encoding, separator, numbers, titles, spelled, style, newline, quotes = one
        content = joined([*titled(NAMES[titles], SPELLED[spelled], style), *rows_of(*numbers)], separator, newline, quotes)
        if encoding != "cp1252" or not set(content) - set(content.encode("cp1252", "ignore").decode("cp1252")):
            tried += 1
            is_right(points.read(file(tmp_path, content, encoding)))
    assert tried > 60


def long_with(title: str, cell: str) -> str:
    return joined([[*MEASURED, title], *([*row, cell] for row in LONG)])


HABITS = {
    "sep": "sep=;\n" + joined([TITLES, *rows_of()], ";"),
    "sep that no row has twice": "sep=|\r\n" + joined([TITLES, *rows_of(",")], "|", "\r\n"),
    "index": joined([["", *MEASURED], *([str(k), *row] for k, row in enumerate(LONG))]),
    "hash": joined([["#", *MEASURED], *([str(k), *row] for k, row in enumerate(LONG))]),
    "a temperature that is named like a torque": long_with("T_P [°C]", "81.5"),
    "date and time": joined([["Date", "Clock", *TITLES], *(["27.11.2026", "10:05:11", *row] for row in rows_of(","))], ";"),
    "a time that is a word": joined([["Datum", *TITLES], *(["Monday", *row] for row in rows_of(","))], ";"),
    "empty lines": joined([TITLES]) + "\n\n" + joined(rows_of(), newline="\n,,,,,\n") + "\n",
    "separators at the ends": "".join(line + ";;\n" for line in joined([TITLES, *rows_of(",")], ";").splitlines()),
    "blanks": joined([TITLES, *rows_of()], "   "),
    "remarks": "# rig 3\n#; made by hand\n" + joined([TITLES, *rows_of()]).replace("\n", "\n# between\n", 2),
    "header in a remark": "# rig 3\n# " + joined([TITLES, *rows_of()]),
    "preamble": "Rig;3\nOperator;N. N.\n\n" + joined([TITLES, *rows_of(",")], ";"),
    "as many names with another separator": "; ".join(COLUMNS) + "\n" + joined([TITLES, *rows_of()], "\t"),
    "title over two lines": joined([['"primary.speed\n[rpm]"' if "n_P" in t else t for t in TITLES], *rows_of()]),
    "per cent in the cells": joined([[t.replace(" [%]", "") for t in MEASURED], *([*r[:5], r[5] + "%", r[6] + " %"] for r in LONG)]),
    "shares": joined([[t.replace(" [%]", "") for t in MEASURED], *([*r[:5], *(repr(float(c) / 100) for c in r[5:])] for r in LONG)]),
    "typographic minus": joined([TITLES, *rows_of()]).replace("-", "\N{MINUS SIGN}"),
    "exponents with commas": joined([TITLES, *([f"{float(cell):.6e}".replace(".", ",") for cell in row] for row in rows_of())], "\t"),
    "other order": joined([TITLES[::-1], *(row[::-1] for row in rows_of())]),
    "a column without values": long_with("ds/dt [1/s]", "NaN"),
    "units after underscores": joined([["i_geo", "n_P_rpm", "n_S_rpm", "T_P_Nm", "T_S_Nm", "F_S_kN", "F_P_kN"], *rows_of()]),
    "units above an empty row": joined([COLUMNS, ["", "rpm", "rpm", "Nm", "Nm", "kN", "kN"], [""] * 7, *rows_of(",")], ";"),
    "a title without a pulley beside one with it": long_with("Drehmoment [Nm]", "7"),
    "rows with error values": joined([TITLES, rows_of()[0], ["#DIV/0!", *rows_of()[0][1:]], *rows_of()[1:]]),
    "rows without a needed value": joined([TITLES, *rows_of(","), ["1,5", "", *rows_of(",")[0][2:]]], ";"),
    "rows with NaN": joined([TITLES, *rows_of(), ["1.5", *rows_of()[0][1:6], "nan"]]),
}  # fmt: skip

HEADS = Path(__file__).with_name("rig_headers.txt").read_text(encoding="utf-8").splitlines()
DESCRIPTIONS = ["ratio", "speed", "speed", "torque", "torque", "force", "force"]
PULLEYS = ["geometric", "primary", "secondary", "primary", "secondary", "secondary", "primary"]
HEADERS = {
    **{name: [titles.split(";")] for name, _, titles in (line.partition(": ") for line in HEADS)},
    "description, units": [COLUMNS, DESCRIPTIONS, UNITS],
    "description above": [DESCRIPTIONS, COLUMNS, UNITS],
    "units above": [UNITS, COLUMNS],
    "letters of which three are units, units": [COLUMNS, ["calc", *"PSPSSP"], UNITS],
    "titles that span two rows": [["i_geo", *["Primary", "", "Secondary", ""], "F_S", "F_P"], ["", "n", "T", "n", "T", "", ""],
                                  ["-", "rpm", "Nm", "rpm", "Nm", "kN", "kN"]],
    "titles over two rows": [PULLEYS, DESCRIPTIONS, UNITS],
}
SPANNED = [[row[k] for k in (0, 1, 3, 2, 4, 5, 6)] for row in ROWS]
BELOW = {name: SPANNED if "span" in name else ROWS for name in HEADERS}
HABITS |= {f"header: {name}": joined([[*map(str, row)] for row in [*head, *BELOW[name]]], ";") for name, head in HEADERS.items()}
HABITS["header: every title over two lines"] = joined([[f'"{t.replace(" ", chr(10))}"' for t in TITLES], *rows_of()])


@pytest.mark.parametrize("habit", HABITS)
def test_habits_of_rigs_and_spreadsheets(habit: str, tmp_path: Path) -> None:
    rig = points.read(file(tmp_path, HABITS[habit], "utf-8" if "\N{MINUS SIGN}" in HABITS[habit] else "cp1252"))
    is_right(rig)
    assert bool(rig.sheet.left_out) == habit.startswith("rows")


@pytest.mark.parametrize(
    ("spelling", "dimension", "si"),
    [
        ("N·m", "torque", 1.0), ("N⋅m", "torque", 1.0), ("N m", "torque", 1.0), ("kNm", "torque", 1e3), ("lb-ft", "torque", 1.3558179483314),
        ("min⁻¹", "speed", RPM), ("min^-1", "speed", RPM), ("1/min", "speed", RPM), ("rad s⁻¹", "speed", 1.0), ("s^-1", "rate", 1.0),
        ("KN", "force", 1e3), ("[kN]", "force", 1e3), ("(kN)", "force", 1e3), ("Prozent", "ratio", 0.01), ("pct", "ratio", 0.01),
        ("lbf ft", "torque", 1.3558179483314), ("lbf", "force", POUND), ("klbf", "force", 1e3 * POUND),
        ("N", "force", 1.0), ("bar", "pressure", 1e5), ("MPa", "pressure", 1e6), ("N/mm²", "pressure", 1e6), ("psi", "pressure", 6894.757293168),
        ("bara", "pressure", 1e5 - 101325.0), ("psia", "pressure", 6894.757293168 - 101325.0), ("kg/cm²", "pressure", 98066.5), ("N・m", "torque", 1.0),
        ("cm²", "area", 1e-4), ("l/min", "flow", 1.0 / 6e4),
        ("mPA", "pressure", None), ("1/s", "speed", None), ("kNm", "force", None), ("", "force", None),
    ],
)  # fmt: skip
def test_spellings_of_units(spelling: str, dimension: str, si: float | None) -> None:
    """Those without a certain meaning are refused."""
    found = units.find(spelling, dimension)
    assert (found and found.si(1.0)) == (si and pytest.approx(si, rel=1e-12))


def test_units_in_other_cases_have_the_same_factor_or_none() -> None:
    """A prefix in the wrong case never changes the factor silently."""
    for dimension, spellings in units.spellings().items():
        for spelling, unit in spellings.items():
            assert units.find(spelling, dimension) == unit
            for other in (spelling.lower(), spelling.upper(), spelling.capitalize()):
                assert units.find(other, dimension) in (unit, None) or other in known


def test_units_of_the_fmu_have_its_factors(description: Any) -> None:
    for definition in description.unitDefinitions:
        dimensions = units.dimensions(definition.name)
        assert units.find(definition.name, units.OF_FMU[definition.name]) == units.Unit(1.0)
        for display in definition.displayUnits:
            found = [unit.si(display.factor) for dimension in dimensions if (unit := units.find(display.name, dimension)) is not None]
            assert found == pytest.approx([1.0] * len(found), rel=1e-12) and found, display.name


def test_a_title_close_to_a_known_name_is_a_fault_and_others_are_named_and_ignored(tmp_path: Path) -> None:
    for title in MISSPELLED:
        with pytest.raises(TableError) as error:
            points.read(file(tmp_path, long_with(title, "1")))
        assert [(fault.line, fault.column) for fault in error.value.faults] == [(1, title)]
    for title in UNKNOWN:
        rig = points.read(file(tmp_path, long_with(title, "x")))
        is_right(rig)
        assert rig.sheet.ignored == [title]


@pytest.mark.parametrize(
    "title", ["F_P指令値 [kN]", "F_P зад [kN]", "F_P* [kN]", "F_P' [kN]", "ΔF_P [kN]", "Messung/F_P [kN]", "AVG_F_P [kN]", "F_P_act [kN]",
              "F_P (Mean)", "F_P\\ETKC:1"]
)  # fmt: skip
def test_a_title_is_known_whole_and_the_option_that_takes_it_is_printed(title: str, tmp_path: Path) -> None:
    """A command, a difference or a mean is not the measured force. The options are taken as they are."""

    def options(text: str) -> dict[str, str]:
        return dict(found.split("=") for found in re.findall('--map "([^"]*)"', text))

    path = file(tmp_path, joined([[*TITLES[:6], title], ["-", *UNITS[1:]], *rows_of()], ";"))
    rig = points.read(path)
    assert rig.sheet.ignored == [title] and [m.quantity for m in rig.points[0].measured] == ["slip", "efficiency"]
    is_right(points.read(path, Reading(renamed=options(" ".join(rig.sheet.remarks)))))
    # Required ones are in the error, also below other rows.
    path = file(tmp_path, joined([["rig 3"], [title.replace("F_P", name) for name in COLUMNS], ["-", *UNITS[1:]], *rows_of()], ";"))
    with pytest.raises(TableError, match="no column ratio.geometric or ratio.speed, primary.speed, primary.torque") as error:
        points.read(path)
    if "[kN]" not in title:
        is_right(points.read(path, Reading(renamed=options(str(error.value)))))


def test_names_by_the_user(tmp_path: Path) -> None:
    titles = ["k", "Drehzahl", "Moment vorn", "Kraft hinten", "Kraft vorn", "slip [%]", "efficiency [%]"]
    path = file(tmp_path, joined([titles, *([repr(-float(c)) if k == 2 else c for k, c in enumerate(row)] for row in LONG)]))
    renamed = {
        "k": "ratio.geometric", "Drehzahl": "primary.speed [rpm]", "Moment vorn": "-T_P [Nm]", "Kraft hinten": "F_S [kN]", "Kraft vorn": "F_P [kN]",
    }  # fmt: skip
    is_right(points.read(path, Reading(renamed=renamed)))
    for wrong, named in ((renamed | {"Drehmoment": "primary.torque"}, "Drehmoment"), ({"k": "gear"}, "gear is not a known name")):
        with pytest.raises(TableError, match=named):
            points.read(path, Reading(renamed=wrong))


def test_a_ratio_is_that_of_the_speeds_or_inverse_if_its_title_or_the_user_says_so(tmp_path: Path) -> None:
    c = columns()
    others = {title: c[name] for title, name in zip(MEASURED[1:], ("n_P", "T_P", "F_S", "F_P", "slip", "eta"), strict=True)}
    for title, geometric in (("i", False), ("Übersetzung", False), ("n_S/n_P", False), ("i (n2/n1)", False), ("r_P/r_S", True)):
        ratio = c["i_geo"] if title in ("i", "Übersetzung") else 1.0 / c["i_geo"]
        found = points.read(table(tmp_path / "table.csv", {title: ratio, **others}))
        assert all((point.ratio is not None) == geometric for point in found.points)
        assert values(found)[:, 0] == pytest.approx(c["i_geo"])
    is_right(points.read(table(tmp_path / "table.csv", {"i": c["i_geo"], **others}), Reading(renamed={"i": "ratio.geometric"})))
    is_right(points.read(table(tmp_path / "table.csv", {"x": 1.0 / c["i_geo"], **others}), Reading(renamed={"x": "1/ratio.geometric"})))


@pytest.mark.parametrize(
    ("cells", "separator", "decimal"),
    [
        (["1,234", "5,25"], ";", "comma"), (["1,234", "5.25"], ";", "point"), (["1.234", "0.617"], ";", "point"), (["1.234,5"], "\t", "comma"),
        (["1,234.5"], "\t", "point"), (["1.500", "2.125"], ",", "point"), (["12", "-3"], ";", "point"), (["1.234.567", "1.000"], ";", "comma"),
        (["nan", "", "1,5"], ";", "comma"), (["1,234", "5"], ";", None), (["2.125", "1.500"], ";", None), (["1,234", "12,500", "-3"], ";", None),
    ],
)  # fmt: skip
def test_the_whole_file_settles_the_decimal_sign(cells: list[str], separator: str, decimal: str | None) -> None:
    if decimal is None:
        with pytest.raises(ArgumentError, match=f"{cells[0]}.*--decimal"):
            numerals.settle(cells, separator)
    else:
        assert numerals.settle(cells, separator) == decimal


def test_the_user_settles_the_decimal_sign(tmp_path: Path) -> None:
    content = "i_geo;n_P [rpm];T_P [Nm];F_S [kN];thrustRatio\n1,250;1,500;40;10;1,125\n"
    for decimal, named in ((None, "--decimal"), ("comma", r"line 2, column n_P \[rpm\]: 1,500")):
        with pytest.raises(TableError, match=named):
            points.read(file(tmp_path, content), Reading(decimal=decimal))
    (point,) = points.read(file(tmp_path, content.replace("1,500", "1500")), Reading(decimal="comma")).points
    assert (point.ratio, point.measured[0].value) == (1.25, 1.125)


@pytest.mark.parametrize("cell", ["-9999", "-999", "---", "n/a", "NaN", "defect", "#NV", "#N/A", "-nan", "1e9"])
@pytest.mark.parametrize("column", [1, 3, 6])
def test_a_cell_without_a_number_loses_its_row(cell: str, column: int, tmp_path: Path) -> None:
    rows = rows_of()
    rows[4][column] = cell
    rig = points.read(written(tmp_path / "table.csv", [TITLES, *rows], ";"))
    assert [p.line for p in rig.points] == [line for line in range(2, 14) if line != 6]
    (fault,) = rig.sheet.left_out
    assert (fault.line, fault.column) == (6, TITLES[column]) and cell in fault.text


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "empty"), (f"{HEADER},slip\n", "nothing is measured"), (f"{HEADER},slip\n1,2000,50,10,nan\n", "nothing is measured"),
        (f"{HEADER},slip [%]\n1,2000,50,10,abc\n", r"line 2, column slip \[%\]: 'abc'"),
        ("i_geo;n_P [rpm];T_P [Nm];F_S [kN];slip [%]\n1.25;2000;50;10;0,5\n1.5;2000;50;10;1\n", r"line 2, column slip \[%\]: '0,5'"),
        (f"{HEADER},slip\n1,2000,50,10,0.8\n", "line 2, column slip: 0.8"),
        (f"{HEADER},slip [%]\n\n1,2000,50,10000,1\n", r"line 3, column secondary.clampingForce .*: 10000 .* 0.1 to 500 kN; plausible is N \(--map"),
        (joined([[*MEASURED[:5], "Wirkungsgrad"], *([*row[:5], row[6]] for row in LONG)]), r"plausible is % \(--map"),
        (f"{HEADER},efficiency [%]\n1,2000,50,10,104\n", r"line 2, column efficiency \[%\]: 104"),
        (f"{HEADER},slip,slip.sd\n1,2000,50,10,0.01,0\n", "line 2, column slip.sd: 0"),
        (f"{HEADER},slip\n1,,50,10,0.01\n", r"line 2, column primary.speed \[rpm\]"),
        (f"{HEADER},slip\n,2000,50,10,0.01\n", "line 2: neither ratio.geometric nor ratio.speed"),
        (f"{HEADER},slip\n1,2000,50,10,0.01,2\n", "line 2: 6 cells"), (f"{HEADER},slip.sd\n1,2000,50,10,1\n", "no column slip"),
        (f"{HEADER},slip,slip [%]\n1,2000,50,10,.1,1\n", "column slip: "), (f"{HEADER},slip [mm]\n1,2000,50,10,1\n", "slip is 1 or %, not mm"),
        (f"{HEADER.replace(' [rpm]', '')},slip\n1,2000,50,10,0.01\n", r"no unit; write primary.speed \[rad/s\]"),
        (f"{HEADER.replace('ratio.geometric,', '')},slip\n2000,50,10,0.01\n", "ratio.geometric or ratio.speed"),
        (f"{HEADER},ds/dt [1/s]\n1,2000,50,10,0.5\n", "primary.clampingForce: ds/dt"),
        (f"{HEADER},ds/dt [1/s],slip\n1,2000,50,10,0.5,0.01\n", "ds/dt the ratio moves"),
        (f"{HEADER},p_S [bar],slip\n1,2000,50,,10,0.01\n", r"column p_S \[bar\]: .*secondary\.cylinder\.area"),
        (b"\xff\xfe", "empty"), (b"\xd0\xcf\x11\xe0" + bytes(60), "no text has; export it as CSV"), (b"PK\x03\x04rest", ".xlsx"), (b"\x1f\x8brest", "gzip"),
        (b'{"n_P": [1, 2]}', "this is JSON"), (b'\xef\xbb\xbf [\n {"n_P": 1}]', "this is JSON"), (b"<?xml ?><a/>", "this is XML"),
        (b"MDF     4.10    rest", "MDF"), (b"PAR1rest", ".parquet"), (bytes(range(256)) * 8, "bytes that no text has"),
        *((joined(list(zip(*head, *rows_of(), strict=True))), "transposed") for head in ([TITLES], [COLUMNS, UNITS])),
    ],
)  # fmt: skip
def test_bad_tables_give_one_clear_error(text: str | bytes, why: str, tmp_path: Path) -> None:
    path = file(tmp_path, text)
    with pytest.raises(TableError, match=why) as error:
        points.read(path)
    assert str(error.value).startswith(f"{path}: ") and "\n" not in str(error.value)


@pytest.mark.parametrize("title", ["Nr", "Messpunkt", "", "name"])
def test_rows_of_means_and_extremes_are_no_points(title: str, tmp_path: Path) -> None:
    words = ("Mittelwert", "Max.", "min", "Std-Abw." if title else "Mean")
    rows = [[*(["max" if title == "name" and k == 3 else f"{k}"]), *row] for k, row in enumerate(ROWS)]
    rig = points.read(written(tmp_path / "table.csv", [[title, *TITLES], *rows, *([word, *ROWS[0]] for word in words)], ";"))
    is_right(rig)
    assert [fault.line for fault in rig.sheet.left_out] == [14, 15, 16, 17]


@pytest.mark.parametrize(("title", "good", "bad"), [("valid", "1", "0"), ("Gültig", "ja", "nein"), ("outlier", "", "x")])
def test_rows_that_a_column_says_are_not_valid_are_left_out(title: str, good: str, bad: str, tmp_path: Path) -> None:
    rows = [*([*row, good] for row in ROWS), [*ROWS[0], bad]]
    rig = points.read(written(tmp_path / "table.csv", [[*TITLES, title], *rows], ";"))
    is_right(rig)
    assert [(fault.line, fault.column) for fault in rig.sheet.left_out] == [(14, title)] and not rig.sheet.ignored


def test_a_unit_is_no_name_and_a_deviation_has_the_unit_of_its_column(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    for rows in ([[*MEASURED[:5], "slip [rpm]"]], [[*MEASURED[:5], "slip"], ["-", "rpm", "Nm", "kN", "kN", "rpm"]]):
        with pytest.raises(TableError, match="the unit of slip is 1 or %, not rpm"):
            points.read(written(path, [*rows, *(row[:6] for row in LONG)], ";"))
    rig = points.read(written(path, [["slip.sd", *MEASURED], *(["0.08", *row] for row in LONG)], ";"))
    assert all(point.measured[1].deviation == pytest.approx(8e-4) for point in rig.points)
    rows = [["a", "b", "c", "d"], ["-", "rpm", "rpm", "kN"], *(row[:4] for row in LONG)]
    with pytest.raises(TableError, match="unknown are a, b, c, d"):
        points.read(written(path, rows, ";"))


@pytest.mark.parametrize(("encoding", "title"), [("shift_jis", "軸力"), ("gbk", "夹紧力"), ("euc_kr", "추력"), ("cp1251", "Усилие")])
def test_encodings_by_name(encoding: str, title: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = file(tmp_path, joined([[*TITLES[:6], f"{title} [kN]"], *rows_of()], ";"), encoding)
    assert any("--encoding" in remark for remark in points.read(path).sheet.remarks)
    assert __main__.main([str(path), "--check", "--encoding", encoding, "--map", f"{title} [kN]=F_P [kN]"]) == 0
    assert "12 thrustRatio" in capsys.readouterr().out
    with pytest.raises(TableError, match="unknown encoding"):
        points.read(path, Reading(encoding="latin1o"))


def test_all_faults_of_a_file_are_in_one_answer_at_once(tmp_path: Path) -> None:
    path = file(
        tmp_path,
        "ratio.geometric;n_P [rpm];primary.torque [kN];F_S [kN];thrustRato;slip [%];colour\n"
        "2,1;1500;60;14;1,1;0,5;red\n2,1;15x0;60;14;1,1;80;red\n0,01;1500;60;14;1,1;0,5;red;7\n",
    )
    with pytest.raises(TableError) as error:
        points.read(path)
    assert {(fault.line, fault.column) for fault in error.value.faults} == {
        (1, "primary.torque [kN]"), (1, "thrustRato"), (3, "n_P [rpm]"), (3, "slip [%]"), (4, None), (4, "ratio.geometric"),
    }  # fmt: skip
    assert str(error.value).startswith(f"{path}: 6 faults\n")


def test_values_and_standard_deviations_of_a_point(tmp_path: Path) -> None:
    (point,) = points.read(file(
        tmp_path,
        f"# a remark\n\nname,{HEADER},thrustRatio,slip [%],slip.sd [%],efficiency [%],#oil [C]\n"
        "first,2,1500,-40,12,1.05,0.8,0.05,,85\n\n,1,1500,0,12,,,,,\n",
    )).points  # fmt: skip
    assert (point.line, point.name, point.ratio, point.speed_ratio, point.shifting) == (4, "first", 2.0, None, False)
    assert (point.speed, point.torque, point.force) == pytest.approx((157.0796, -40.0, 12e3))
    found = [(m.quantity, m.given, pytest.approx(m.value), pytest.approx(m.deviation)) for m in point.measured]
    assert found == [("thrustRatio", False, 1.05, 0.0105), ("slip", True, 0.008, 5e-4)]


def test_primary_force_gives_the_thrust_ratio_or_goes_with_a_shift(tmp_path: Path) -> None:
    content = f"{HEADER.replace(',', ';')};primary.clampingForce [N];di/dt [1/s]\n1;2000;50;10;14000;\n1;2000;50;10;16000;-0.5\n"
    steady, shift = points.read(file(tmp_path, content)).points
    for point, quantity, value, force in ((steady, "thrustRatio", 1.4, None), (shift, "di/dt", -0.5, 16e3)):
        assert [(m.quantity, m.value) for m in point.measured] == [(quantity, pytest.approx(value))]
        assert (point.shifting, point.primary_force) == (point is shift, force)


def test_efficiency_takes_the_torque_of_any_sign_and_overrun_inverts_it(tmp_path: Path) -> None:
    rows = [[2000, 1000, 50, -96, 10], [2000, 1000, 50, 96, 10], [2000, 1000, -48, 100, 10], [2000, 1000, 0, 3, 10]]
    path = written(tmp_path / "table.csv", [["n_P [rpm]", "n_S [rpm]", "T_P [Nm]", "T_S [Nm]", "F_S [kN]"], *rows])
    assert [p.measured[0].value for p in points.read(path).points] == pytest.approx([0.96, 0.96, 0.96])
    rows = [[1, 2000, -40, 10, 104], [1, 2000, 40, 10, 96], [1, 2000, 40, 10, 104]]
    rig = points.read(written(path, [["i_geo", "n_P [rpm]", "T_P [Nm]", "F_S [kN]", "eta [%]"], *rows]))
    assert [p.measured[0].value for p in rig.points] == pytest.approx([1.0 / 1.04, 0.96])
    assert [(fault.line, fault.column) for fault in rig.sheet.left_out] == [(4, "eta [%]")]


def test_pressures_give_forces(tmp_path: Path) -> None:
    path = written(tmp_path / "table.csv", [["i_geo", "n_P [rpm]", "T_P [Nm]", "p_S [bar]", "p_P [psi]"], [2, 3000, 40, 10, 12e5 / 6894.757293168]])
    areas = {"primary.cylinder.area": 0.02, "secondary.cylinder.area": 0.01}
    more = {"primary.cylinder.centrifugal": 0.01, "secondary.cylinder.centrifugal": 0.02, "secondary.cylinder.springForce": 300.0}
    speed = 3000 * RPM
    turning = 1e4 + 300.0 + 0.02 * (speed / 2) ** 2
    for oil, force, primary in ((areas, 1e4, 2.4e4), (areas | more, turning, 2.4e4 + 0.01 * speed**2)):
        rig = points.read(path, parameters=oil)
        (point,) = rig.points
        assert (point.force, point.measured[0].value) == pytest.approx((force, primary / force))
        assert any("without the centrifugal force" in remark for remark in rig.sheet.remarks) == (oil is areas)


def test_series_of_samples_are_recorded_shifts(tmp_path: Path) -> None:
    titles = ["series", "time [ms]", "n_P [rpm]", "T_P [Nm]", "F_P [kN]", "F_S [kN]", "ratio.geometric"]
    rows = [
        [name, time, 1500, 20, 12, 10, f"{ratio:g}"]
        for name, start in (("up", 1.5), ("down", 0.8))
        for time, ratio in ((10, start), (60, start + 0.05), (110, start + 0.09))
    ]
    path = tmp_path / "table.csv"
    rig = points.read(written(path, [titles, *rows]))
    assert rig.recorded
    up, down = rig.points
    assert [m.value for m in down.measured] == pytest.approx([0.85, 0.89])
    assert [m.time for m in up.measured] == pytest.approx([0.05, 0.1])
    assert up.samples[0][:3] == pytest.approx((0.0, 50 * np.pi, 20.0))
    rows[1][1] = 10
    without = [[*row[:4], *row[5:]] for row in (titles, *rows)]
    for wrong, named in (([titles, *rows], r"line 3, column time \[ms\]: 0.01 s"), (without, "primary.clampingForce")):
        with pytest.raises(TableError, match=named):
            points.read(written(path, wrong))


def test_spreadsheets_are_read(tmp_path: Path) -> None:
    """Numbers, per cent formats, error values, a second sheet, text with decimal commas."""
    book = pytest.importorskip("openpyxl").Workbook()
    book.active.append(["Rig 3", "made by hand"])
    sheet = book.create_sheet("Points")
    for row in (["made by hand"], [], [t.replace(" [%]", "") for t in MEASURED], *LONG):
        sheet.append([float(cell) if cell[-1:].isdigit() and cell[0] in "-0123456789" else cell for cell in row])
    for line in range(4, 16):
        for column in (6, 7):
            sheet.cell(line, column).value /= 100.0
            sheet.cell(line, column).number_format = "0.00%"
    sheet.cell(5, 2).value = LONG[1][1].replace(".", ",")
    sheet.append([*map(float, LONG[0][:6]), "#DIV/0!"])
    path = tmp_path / "table.xlsx"
    book.save(path)
    rig = points.read(path)
    is_right(rig)
    assert rig.sheet.source == "sheet Points"
    assert [point.line for point in rig.points] == list(range(4, 16))
    assert [fault.line for fault in rig.sheet.left_out] == [16]
    with pytest.raises(TableError, match="Data; .* Sheet, Points"):
        points.read(path, Reading(sheet="Data"))


def test_of_sheets_with_the_same_columns_one_is_asked_for_and_what_is_hidden_is_named(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book, path = openpyxl.Workbook(), tmp_path / "table.xlsx"
    old, sheet = book.active, book.create_sheet("Data")
    old.title = "Old"
    for one, rows in ((old, ROWS[:3]), (sheet, [*ROWS, ROWS[0], ROWS[1]])):
        one.append([title.replace(" ", "\n") for title in TITLES])
        for row in rows:
            one.append(row)
    book.save(path)
    with pytest.raises(TableError, match="Old, Data have the same columns: --sheet"):
        points.read(path)
    assert len(points.read(path, Reading(sheet="Old")).points) == 3
    old.sheet_state = "hidden"
    sheet.row_dimensions[14].hidden = True
    for cell in sheet[15]:
        cell.font = openpyxl.styles.Font(strike=True)
    book.save(path)
    rig = points.read(path)
    is_right(rig)
    said = "; ".join(rig.sheet.remarks)
    assert "sheet Old is hidden and not read" in said and "hidden and not read: 14" in said and "struck out and not read: 15" in said
    assert len(points.read(path, Reading(sheet="Old")).points) == 3


def test_check_prints_what_is_understood_and_needs_no_fmu(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [[*row[:3], "n/a" if k % 3 == 0 else row[3], *row[4:]] for k, row in enumerate(rows_of(","))]
    path = file(tmp_path, joined([[*TITLES, "T_oil [°C]"], *([*row, "80"] for row in rows)], ";"), "cp1252")
    assert __main__.main([str(path), "--check"]) == 0
    said = capsys.readouterr().out
    for part in (
        "CP1252, semicolon between columns, decimal comma", "n_P [rpm]: primary.speed [rpm], 8 values, 150.28 to 261.97 rad/s",
        "T_oil [°C]", "4 lines, 2, 5, 8, 11: column T_P [Nm]: 'n/a'", "8 points: 8 thrustRatio, 8 slip, 8 efficiency",
    ):  # fmt: skip
        assert part in said
    assert __main__.main([str(file(tmp_path, "n_P;slip\n1;2\n")), "--check"]) == 1
    printed = capsys.readouterr()
    assert "column n_P: no unit" in printed.err and "slip: slip, 0 values" in printed.out


def test_template_is_a_table(tmp_path: Path) -> None:
    path = tmp_path / "template.csv"
    assert __main__.main(["--fmu", "none.fmu", "--output", "nowhere", "--template", str(path)]) == 0
    assert [point.name for point in points.read(path).points] == ["underdrive", "ratio 1", "overdrive", "upshift"]
    text = path.read_text(encoding="utf-8")
    assert all(f"#     {column} [" in text for column in [*known.CONDITIONS, *known.QUANTITIES])


@pytest.mark.parametrize("unit", ["rad/s", "N.m", "1", "kg.m2", "N.m.s/rad", "Pa"])
@pytest.mark.parametrize("name", ["primary.speed", "profile.pushForce[12]", "equivalentAmplitude, primary"])
def test_titles_are_read_as_they_are_written(name: str, unit: str) -> None:
    assert tables.split(tables.title(name, unit)) == (name, unit)
    assert tables.split(name) == (name, None)
    assert (name, unit) in list(names.splits(tables.title(name, unit)))


def test_numbers_of_programs_have_a_unit(tmp_path: Path) -> None:
    """That of a variable without one is 1. No other module writes CSV but the maps, with units in a row of their own, and calls, which write a frame of the user."""
    assert tables.titles(["slip", "belt.speed"], {"slip": None, "belt.speed": "m/s"}) == ["slip [1]", "belt.speed [m/s]"]
    path = tmp_path / "table.csv"
    tables.write(path, ["case", "count", "slip [1]"], [("a", 1, 0.25), ("b", 2, float("nan"))], remark="made up")
    assert path.read_text(encoding="utf-8").startswith("# made up\ncase,count,slip [1]\n")
    assert reports.by_name(path) == [{"case": "a", "count": "1", "slip": "0.25"}, {"case": "b", "count": "2", "slip": "nan"}]
    with pytest.raises(ArgumentError, match="slip"):
        tables.write(path, ["case", "slip"], [("a", 0.25)])
    tables.write(path, ["slip [1]"], [(1.0 / 3.0,)], digits=None)
    assert float(reports.by_name(path)[0]["slip"]) == 1.0 / 3.0
    for unit in {*SHOWN.values(), *UNSCALED.values()}:
        assert any(units.find(unit, dimension) == units.Unit(1.0) for dimension in units.SPELLED), unit
    package = Path(tables.__file__).parents[1]
    sources = {path.relative_to(package).as_posix(): path.read_text(encoding="utf-8") for path in package.rglob("*.py")}
    writers = {name for name, text in sources.items() if re.search(r"csv\.writer\(|DictWriter\(|\.to_csv\(|savetxt\(", text)}
    assert writers == {"tables/__init__.py", "maps/files.py", "calls.py"}
