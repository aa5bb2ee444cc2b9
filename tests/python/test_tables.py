"""CSV files: titles with units, written by one function and read by the readers of the project."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import pushbelt
from pushbelt import tables
from pushbelt.tables import names, units
from pushbelt_validation.outcome import SPELLED, UNSCALED

PACKAGE = Path(pushbelt.__file__).parent
WRITERS = re.compile(r"csv\.writer\(|DictWriter\(|\.to_csv\(|savetxt\(")
OTHERS = {"maps/files.py"}
"""Modules with a writer of their own: tables for vehicle simulations, with the units in a row below the names or in the names."""


def test_no_other_module_writes_csv() -> None:
    sources = {path.relative_to(PACKAGE).as_posix(): path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    found = {name for name, text in sources.items() if WRITERS.search(text)}
    assert found == {"tables/__init__.py", *OTHERS}


@pytest.mark.parametrize("unit", ["rad/s", "N.m", "1", "kg.m2", "N.m.s/rad", "Pa"])
@pytest.mark.parametrize("name", ["primary.speed", "profile.pushForce[12]", "equivalentAmplitude, primary"])
def test_titles_are_read_as_they_are_written(name: str, unit: str) -> None:
    assert tables.split(tables.title(name, unit)) == (name, unit)
    assert tables.split(name) == (name, None)
    assert (name, unit) in list(names.splits(tables.title(name, unit)))


def test_a_variable_without_a_unit_has_the_unit_1() -> None:
    assert tables.titles(["slip", "belt.speed"], {"slip": None, "belt.speed": "m/s"}) == ["slip [1]", "belt.speed [m/s]"]
    with pytest.raises(KeyError):
        tables.titles(["slip"], {})


def test_numbers_without_a_unit_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    tables.write(path, ["case", "count", "slip [1]"], [("a", 1, 0.25), ("b", 2, float("nan"))], remark="made up")
    assert path.read_text(encoding="utf-8").startswith("# made up\ncase,count,slip [1]\n")
    assert tables.by_name(path) == [{"case": "a", "count": "1", "slip": "0.25"}, {"case": "b", "count": "2", "slip": "nan"}]
    with pytest.raises(tables.TitleError, match="slip"):
        tables.write(path, ["case", "slip"], [("a", 0.25)])
    tables.write(path, ["slip [1]"], [(1.0 / 3.0,)], digits=None)
    assert float(tables.by_name(path)[0]["slip"]) == 1.0 / 3.0


def test_units_of_shown_columns_have_one_in_files() -> None:
    for unit in {*SPELLED.values(), *UNSCALED.values()}:
        assert any(units.find(unit, dimension) == units.Unit(1.0) for dimension in units.SPELLED), unit
