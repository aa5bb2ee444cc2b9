"""What cannot be on a variator is refused before any fit, with the reading that would be plausible."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
from rig_tables import RPM, TITLES, columns, table, values

from pushbelt.calibrate import __main__
from pushbelt.tables import points
from pushbelt.tables.sheet import Reading, TableError

Columns = dict[str, np.ndarray]
TITLE = dict(zip(columns(), [*TITLES, "slip [%]", "eta [%]"], strict=True))
FULL = ("i_geo", "n_P", "n_S", "T_P", "T_S", "F_S", "F_P")
WITHOUT_OUTPUT = ("i_geo", "n_P", "T_P", "F_S", "F_P", "slip", "eta")
WITHOUT_RATIO = ("n_P", "n_S", "T_P", "T_S", "F_S", "F_P")
LEAST = ("n_P", "n_S", "T_P", "F_S", "F_P")


def scaled(factor: float, *names: str) -> Callable[[Columns], Columns]:
    return lambda c: {**c, **{name: factor * c[name] for name in names if name in c}}


def exchanged(*quantities: str) -> Callable[[Columns], Columns]:
    names = {f"{q}_{one}": f"{q}_{other}" for q in quantities for one, other in ("PS", "SP")}
    return lambda c: {name: c[names.get(name, name)] for name in c}


FAULTS: Mapping[str, tuple[Callable[[Columns], Columns], tuple[tuple[str, ...], ...], tuple[str, ...]]] = {
    "rad/s under rpm": (scaled(RPM, "n_P", "n_S"), (FULL, WITHOUT_OUTPUT, WITHOUT_RATIO, LEAST), ("n_P [rpm]=primary.speed [rad/s]",)),
    "one speed in rad/s": (scaled(RPM, "n_P"), (FULL, WITHOUT_RATIO, LEAST), ("n_P [rpm]=primary.speed [rad/s]",)),
    "1/s under rpm": (scaled(1 / 60, "n_P", "n_S"), (FULL, LEAST), ("n_P [rpm]=primary.speed [Hz]", "n_S [rpm]=secondary.speed [Hz]")),
    "sign of the torque": (scaled(-1.0, "T_P"), (FULL, WITHOUT_OUTPUT, WITHOUT_RATIO, LEAST), ("T_P [Nm]=-primary.torque [Nm]",)),
    "sign of the slip": (scaled(-1.0, "slip"), (WITHOUT_OUTPUT,), ("slip [%]=-slip [%]",)),
    "ratio": (lambda c: {**c, "i_geo": 1.0 / c["i_geo"]}, (FULL, WITHOUT_OUTPUT), ("i_geo [-]=1/ratio.geometric",)),
    "speeds of P and S": (exchanged("n"), (FULL, WITHOUT_RATIO, LEAST), ("n_P [rpm]=secondary.speed [rpm]", "n_S [rpm]=primary.speed [rpm]")),
    "torques of P and S": (exchanged("T"), (FULL, WITHOUT_RATIO), ("T_P [Nm]=secondary.torque [Nm]",)),
    "forces of P and S": (exchanged("F"), (FULL, WITHOUT_OUTPUT, LEAST), ("F_P [kN]=secondary.clampingForce [kN]",)),
    "kN.m under Nm": (scaled(1e-3, "T_P", "T_S"), (FULL, WITHOUT_OUTPUT), ("T_P [Nm]=primary.torque [kN.m]",)),
    "N.mm under Nm": (scaled(1e3, "T_P"), (LEAST,), ("T_P [Nm]=primary.torque [mN.m]",)),
    "N under kN": (scaled(1e3, "F_P", "F_S"), (FULL,), ("F_S [kN]=secondary.clampingForce [N]",)),
    "shares under %": (scaled(0.01, "slip"), (WITHOUT_OUTPUT,), ("slip [%]=slip [1]",)),
}  # fmt: skip


def of(some: tuple[str, ...], fault: Callable[[Columns], Columns] = dict) -> Columns:
    """The titled columns of a table with a fault."""
    return {TITLE[name]: column for name, column in fault({name: columns()[name] for name in some}).items()}


@pytest.mark.parametrize("some", [FULL, WITHOUT_OUTPUT, WITHOUT_RATIO, LEAST])
def test_a_right_table_is_read_without_a_warning(some: tuple[str, ...], tmp_path: Path) -> None:
    rig = points.read(table(tmp_path / "table.csv", of(some)))
    assert len(rig.points) == 12 and not any("warning" in remark for remark in rig.sheet.remarks)


@pytest.mark.parametrize(("fault", "some"), [(name, some) for name, (_, tables, _) in FAULTS.items() for some in tables])
def test_a_wrong_column_is_named_with_the_reading_that_is_right(fault: str, some: tuple[str, ...], tmp_path: Path) -> None:
    """The options of the message, taken as they are, give the points of the right table."""
    change, _, options = FAULTS[fault]
    path = table(tmp_path / "wrong.csv", of(some, change))
    with pytest.raises(TableError) as error:
        points.read(path)
    said = str(error.value)
    assert all(f'--map "{option}"' in said for option in options)
    # The first reading that has the first of these options.
    named = next(one for one in re.findall(r"\(((?:--map \"[^\"]+\" ?)+)\)", said) if f'"{options[0]}"' in one)
    renamed = dict(text.split("=") for text in re.findall(r'--map "([^"]+)"', named))
    if fault == "N under kN":
        renamed["F_P [kN]"] = "primary.clampingForce [N]"
    right = points.read(table(tmp_path / "right.csv", of(some)))
    assert values(points.read(path, Reading(renamed=renamed))) == pytest.approx(values(right), rel=1e-9)


def test_rpm_under_rad_per_second_are_named_and_a_fast_table_is_read(tmp_path: Path) -> None:
    c, path = columns(), tmp_path / "table.csv"
    with pytest.raises(TableError, match=re.escape('--map "n_P [rad/s]=primary.speed [rpm]"')):
        points.read(table(path, {**of(("i_geo", "T_P", "F_S", "slip")), "n_P [rad/s]": c["n_P"]}))
    some = {title: column[c["i_geo"] == 0.5] for title, column in of(("i_geo", "T_P", "F_S", "slip")).items()}
    assert len(points.read(table(path, {**some, "n_P [rpm]": np.full(4, 6000.0)})).points) == 4


def test_an_offset_of_the_ratio_and_torques_near_zero_are_no_reason_to_refuse(tmp_path: Path) -> None:
    """The slip from a ratio 1 % too high has the wrong sign in drive, and an idle rig has the noise of its torque sensor."""
    drive, path = columns()["T_P"] > 0.0, tmp_path / "table.csv"
    some = {title: column[drive] for title, column in of(FULL).items()}
    some["i_geo [-]"] = 1.015 * some["i_geo [-]"]
    assert len(points.read(table(path, some)).points) == drive.sum()
    assert len(points.read(table(path, {**of(LEAST), "T_P [Nm]": np.linspace(-0.3, 0.3, 12)})).points) == 12


def test_a_ratio_of_speeds_is_no_geometric_one(tmp_path: Path) -> None:
    wrong = of(FULL, lambda c: {**c, "i_geo": c["n_P"] / c["n_S"]})
    with pytest.raises(TableError, match=r'--map "i_geo \[-\]=ratio.speed \[-\]"'):
        points.read(table(tmp_path / "table.csv", wrong))


def test_values_are_taken_as_written_if_the_user_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = table(tmp_path / "table.csv", of(FULL, FAULTS["rad/s under rpm"][0]))
    rig = points.read(path, Reading(as_written=True))
    assert rig.points[0].speed == pytest.approx(1425.8 * RPM**2)
    assert any("belt speed" in remark for remark in rig.sheet.remarks)
    assert __main__.main([str(path), "--check"]) == 1
    assert "belt speeds of" in capsys.readouterr().err
    assert __main__.main([str(path), "--check", "--as-written"]) == 0
