"""Time series of rigs: their plateaus are the points."""

import datetime
import gzip
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rig_tables import COLUMNS, POINTS, ROWS, TITLES, UNITS, is_right, values, written

from pushbelt.calibrate import __main__
from pushbelt.tables import points
from pushbelt.tables.sheet import Reading, TableError

HEAD = ["t [s]", *TITLES]
UNNAMED = ("t_rel", "Elapsed time", "X_Value", "Sekunden", "[s]", "master", "Messzeit [s]", "Prüfstandszeit", "K1 / s", "K1 [ms]", "Nr")


def recorded(step: float = 0.01, length: float = 2.0, ramp: float = 0.0, noise: float = 0.005, points: int = 5) -> np.ndarray:
    """A time series of the points with time in its first column; `ramp` is the time of the change between two of them."""
    held = [np.tile(point, (round(length / step), 1)) for point in POINTS[:points]]
    parts = [held[0]]
    for before, after in zip(held, held[1:], strict=False):
        parts += [np.linspace(before[0], after[0], round(ramp / step) + 2)[1:-1], after]
    values = np.concatenate(parts)
    scatter = noise * np.abs(POINTS).mean(axis=0) * np.random.default_rng(62).standard_normal(values.shape)
    scatter[:, 0] = 0.0
    return np.column_stack([step * np.arange(len(values)), values + scatter])


def shown(row: np.ndarray) -> list[str]:
    return [f"{value:.6g}" for value in row]


def series(path: Path, rows: Iterable[Sequence[object]], head: Sequence[str] = HEAD, separator: str = ",") -> points.Rig:
    return points.read(written(path / "series.csv", [head, *rows], separator))


@pytest.mark.parametrize(
    ("step", "length", "ramp", "noise"),
    [(0.01, 1.0, 0.3, 0.01), (0.1, 5.0, 1.0, 0.005), (1.0, 15.0, 0.0, 0.005), (0.01, 2.0, 2.0, 0.002), (0.02, 2.0, 0.0, 0.0)],
)
def test_plateaus_of_a_time_series_are_the_points(step: float, length: float, ramp: float, noise: float, tmp_path: Path) -> None:
    is_right(series(tmp_path, map(shown, recorded(step, length, ramp, noise, 12))), rel=0.02)


def test_a_plateau_has_its_scatter_and_count(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = recorded(points=7)
    rig = series(tmp_path, map(shown, data))
    is_right(rig, 7, rel=0.01)
    (remark,) = [remark for remark in rig.sheet.remarks if remark.startswith("plateau 3:")]
    inside = data[425:576]
    assert "lines 427 to 577, 151 samples" in remark
    assert f"T_P [Nm] {inside[:, 4].mean():.4g}" in remark and f"± {inside[:, 4].std(ddof=1):.2g}" in remark
    # The standard error is small beside the assumed deviation of a thrust ratio, 1 %.
    ratio = rig.points[2].measured[0]
    shares = [inside[:, k].std(ddof=1) / inside[:, k].mean() / np.sqrt(151) for k in (6, 7)]
    assert ratio.deviation == pytest.approx(ratio.value * np.hypot(0.01, np.hypot(*shares)), rel=1e-3)
    assert __main__.main([str(rig.sheet.path), "--check"]) == 0
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
    is_right(series(tmp_path, ([TIMES[title](row[0]), *shown(row[1:])] for row in recorded()), [title, *TITLES]), 5, rel=0.01)


@pytest.mark.parametrize("title", UNNAMED)
def test_any_ascending_column_in_seconds_is_time_and_a_recording_needs_none(title: str, tmp_path: Path) -> None:
    rows = [[f"{row[0] * (1e3 if 'ms' in title else 1.0):g}", *shown(row[1:])] for row in recorded(ramp=1.0)]
    rig = series(tmp_path, rows, [title, *TITLES])
    is_right(rig, 5, rel=0.01)
    assert rig.sheet.ignored == ["Nr"] * (title == "Nr") and any("outside are not used" in remark for remark in rig.sheet.remarks)


@pytest.mark.parametrize(("every", "timed"), [(20, True), (20, False), (40, True), (50, False)])
def test_a_short_recording_is_no_table_of_points(every: int, timed: bool, tmp_path: Path) -> None:
    """Down to four samples of each plateau."""
    rows = list(map(shown, recorded()[::every]))
    is_right(series(tmp_path, rows if timed else [row[1:] for row in rows], HEAD if timed else TITLES), 5, rel=0.02)


def test_rows_are_equally_apart_if_the_times_do_not_ascend(tmp_path: Path) -> None:
    data = recorded()
    # A second recording in the same file; whole seconds, which do not time samples.
    for times in (data[:, 0] % 6.0, data[:, 0] // 1.0):
        rig = series(tmp_path, map(shown, np.column_stack([times, data[:, 1:]])))
        is_right(rig, 5, rel=0.01)
        assert "the times do not ascend: the rows are taken as equally apart" in rig.sheet.remarks


def test_rows_of_a_step_are_averaged_and_different_points_are_not(tmp_path: Path) -> None:
    rows = [[k // 4, *shown(row[1:])] for k, row in enumerate(recorded()[::50])]
    is_right(series(tmp_path, rows, ["Stufe", *TITLES]), 5, rel=0.02)
    assert len(series(tmp_path, ([k // 3, *row] for k, row in enumerate(ROWS)), ["step", *TITLES]).points) == 12
    # 300 points in any order, also with their times.
    many = np.tile(POINTS, (25, 1)) * np.repeat(np.linspace(0.9, 1.1, 25), 12)[:, None] ** [0, 1, 1, 1, 1, 1, 1]
    for points in (many, np.random.default_rng(300).permutation(many)):
        assert len(series(tmp_path, points.tolist(), TITLES).points) == 300
        assert len(series(tmp_path, ([60 * k, *row] for k, row in enumerate(points)), HEAD).points) == 300


def test_a_slow_ramp_without_times_is_refused_and_read_if_the_user_says_so(tmp_path: Path) -> None:
    data = np.tile(POINTS[1], (150, 1))
    data[:, 3] = np.linspace(20.0, 22.0, 150) + 0.1 * np.random.default_rng(1).standard_normal(150)
    with pytest.raises(TableError, match="drift.*--as-written"):
        series(tmp_path, data.tolist(), TITLES)
    assert len(points.read(tmp_path / "series.csv", Reading(as_written=True)).points) == 150


def test_a_date_beside_a_clock_and_no_times_at_all(tmp_path: Path) -> None:
    rows = [["27.11.2026", clock(row[0] - 20).strftime("%H:%M:%S.%f"), *shown(row[1:])] for row in recorded()]
    for head, some in ((["Datum", "Uhrzeit", *TITLES], rows), (TITLES, [row[2:] for row in rows])):
        is_right(series(tmp_path, some, head, ";"), 5, rel=0.01)


def test_channels_with_their_own_rasters(tmp_path: Path) -> None:
    rows = [[cell if line % every == 0 else "" for cell, every in zip(shown(row), (1, 3, 3, 1, 2, 10, 5, 1), strict=True)]
            for line, row in enumerate(recorded(points=12))]  # fmt: skip
    is_right(series(tmp_path, rows), rel=0.01)


def test_a_pause_of_the_recording_and_unequal_times_cost_no_memory(tmp_path: Path) -> None:
    """The channels' times differ by less than a microsecond, and the recorder pauses for a year."""
    data = recorded()
    data[500:, 0] += 3e7
    pairs = (([f"{row[0]:.3f}", *shown(row[1:5]), *[""] * 3], [f"{row[0] + 5e-7:.7f}", *[""] * 4, *shown(row[5:])]) for row in data)
    is_right(series(tmp_path, (cells for pair in pairs for cells in pair)), 5, rel=0.01)


def test_spikes_and_lost_samples_do_not_split_a_plateau(tmp_path: Path) -> None:
    rows = list(map(shown, recorded()))
    for line, cell in ((60, "-9999"), (61, "n/a"), (470, "99.9"), (700, "99.9")):
        rows[line][6] = cell
    rig = series(tmp_path, rows)
    is_right(rig, 5, rel=0.01)
    assert [fault.line for fault in rig.sheet.left_out] == [62, 63]


def test_a_ramp_has_no_plateau_and_points_with_their_times_are_no_series(tmp_path: Path) -> None:
    data = np.tile(recorded(points=1)[0], (4800, 1))
    data[:, 0], data[:, 4] = 0.01 * np.arange(4800), np.linspace(0.0, 60.0, 4800)
    with pytest.raises(TableError, match="without a plateau"):
        series(tmp_path, map(shown, data))
    assert len(series(tmp_path, ([600 * k, *row] for k, row in enumerate(ROWS * 2))).points) == 24


def test_parquet(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    data = recorded()
    frame = pandas.DataFrame(data[:, 1:], columns=TITLES, index=pandas.to_datetime(1.7e9 + data[:, 0], unit="s"))
    frame.loc[frame.index[1::2], "F_S [kN]"] = np.nan
    frame.to_parquet(tmp_path / "series.parquet")
    is_right(points.read(tmp_path / "series.parquet"), 5, rel=0.01)


def mf4(path: Path, signals: Iterable[Sequence[Any]]) -> Path:
    """A file of channels, each with values, times, name and unit. As of INCA, each is listed with and without its device."""
    asammdf = pytest.importorskip("asammdf")
    with asammdf.MDF() as file:
        for values, times, name, unit in signals:
            file.append(asammdf.Signal(values, times, name=name, unit=unit, display_names={f"{name}\\ETKC:1": "display"}))
        file.save(path, overwrite=True)
    return path


def test_mf4_with_channels_at_their_own_times(tmp_path: Path) -> None:
    data, rasters = recorded()[:, [0, *range(1, 8), 7]], (1, 2, 2, 5, 5, 10, 10, 1)
    channels = zip(data.T[1:], rasters, [*COLUMNS, "noise"], [*UNITS, "dB"], strict=True)
    path = mf4(tmp_path / "series.mf4", [(own[::every], data[::every, 0], name, unit) for own, every, name, unit in channels])
    rig = points.read(path)
    is_right(rig, 5, rel=0.01)
    assert rig.sheet.source == "MDF"
    packed = tmp_path / "series.mf4.gz"
    packed.write_bytes(gzip.compress(path.read_bytes()))
    assert values(points.read(packed)) == pytest.approx(values(rig))


def test_channels_of_one_name_are_told_apart(tmp_path: Path) -> None:
    """The speed is recorded by two devices."""
    data, path = recorded(), tmp_path / "series.mf4"
    own = [(data[:, k], data[:, 0], name, unit) for k, (name, unit) in enumerate(zip(COLUMNS, UNITS, strict=True), 1)]
    mf4(path, [*own, (1.3 * data[:, 2], data[:, 0], "n_P", "rpm")])
    with pytest.raises(TableError, match="no column primary.speed") as error:
        points.read(path)
    first, second = (found.split("=") for found in re.findall('--map "([^"]*)"', str(error.value)))
    assert second[0] == "n_P group 7 channel 1"
    is_right(points.read(path, Reading(renamed=dict([first]))), 5, rel=0.01)
