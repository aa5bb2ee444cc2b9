"""What a calibration names as the cause of a misfit, on a law in place of the FMU; and deviations that follow from those of the channels."""

import json
import re
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from rig_tables import written

from pushbelt.calibrate import fit, friction, misfit, report
from pushbelt.calibrate.causes import Cause, with_causes
from pushbelt.calibrate.model import Model
from pushbelt.calibrate.parameters import Parameter
from pushbelt.calibrate.worker import Found, Job
from pushbelt.tables import points as tables
from pushbelt.tables.points import Rig
from pushbelt.tables.sheet import Reading, TableError

PARAMETERS = [
    Parameter("friction.pulley", ("friction.pulley",), "1", 0.09, 0.0, 0.19),
    Parameter("belt.play", ("belt.play",), "m", 3e-4, 0.0, np.inf),
]
Columns = dict[str, np.ndarray]
Fault = Callable[[Columns], Columns]


def law(friction: float, play: float, ratio: float, speed: float, torque: float, force: float) -> dict[str, float]:
    used = torque * ratio**0.6 / (friction * force)
    thrust = ratio**-0.4 * (1.1 + 0.25 * np.tanh(3.0 * used) + 0.2 * used) + 0.01 * speed**2 / force
    return {"thrustRatio": thrust, "slip": play * used * (20.0 + 25.0 * used**2), "efficiency": 1.0 - (1.0 + 0.003 * speed) / abs(torque)}


def solve(jobs: Sequence[Job]) -> list[Found]:
    return [Found(law(values["friction.pulley"], values["belt.play"], p.ratio, p.speed, p.torque, p.force)) for values, p in jobs]


def table(path: Path, seed: int, fault: Fault = dict, slope: float = 0.0, steps: float = 1e-3) -> Rig:
    """A table of 24 points of the friction 0.1 and the play 4e-4 m, with noise, and with a fault. The friction changes with the temperature by `slope`."""
    random, rows = np.random.default_rng(seed), []
    for ratio in (2.0, 1.0, 0.6):
        for k, torque in enumerate((-30.0, 20.0, 40.0, 60.0) * 2):
            speed, force, oil = (100.0, 250.0, 400.0)[(k + len(rows)) % 3], (8e3, 11e3)[k // 4], random.uniform(60.0, 110.0) // steps * steps
            found = law(0.1 + slope * (oil - 85.0), 4e-4, ratio, speed, torque, force)
            thrust, slip, efficiency = (value + sd * random.standard_normal() for value, sd in zip(found.values(), (2e-3, 1e-4, 2e-3), strict=True))
            rows.append([ratio, speed, torque, force, thrust * force, slip, efficiency, oil])
    titles = ("i_geo", "n_P [rad/s]", "T_P [Nm]", "F_S [N]", "F_P [N]", "slip", "eta", "T_oil [°C]")
    columns = fault(dict(zip(titles, np.transpose(rows), strict=True)))
    written(path, [list(columns), *np.column_stack(list(columns.values())).tolist()])
    return tables.read(path, Reading(as_written=True, accuracy={"F_P": "0.2%", "slip": "1e-4", "eta": "2e-3"}))


def searched(rig: Rig, *laws: Cause) -> tuple[Model, fit.Fit, list[misfit.Named]]:
    opened, parameters = with_causes(Model(rig.points, solve), laws), [*PARAMETERS, *(law.size for law in laws)]
    found = fit.fit(opened, parameters)
    return opened, found, misfit.search(rig, opened, parameters, found)


@pytest.mark.parametrize(
    ("fault", "name", "size"),
    [
        (lambda c: c | {"T_P [Nm]": c["T_P [Nm]"] + 2.0}, "offset of T_P [Nm]", 2.0),
        (lambda c: c | {"F_S [N]": 0.5 * c["F_S [N]"], "F_P [N]": 0.5 * c["F_P [N]"]}, "factor of F_P [N] and F_S [N]", 0.5),
        (lambda c: c | {"T_P [Nm]": c["T_P [Nm]"] * c["i_geo"]}, "power of the ratio in T_P [Nm] (1: it is that of the other shaft)", 1.0),
        (lambda c: c | {"T_P [Nm]": np.abs(c["T_P [Nm]"])}, "opposite sign of T_P [Nm] in 6 rows", 1.0),
        (lambda c: c | {"F_P [N]": c["F_P [N]"] * np.exp(0.2 * np.gradient(np.log(c["i_geo"])))}, "change of the thrust ratio", 0.2),
    ],
)  # fmt: skip
def test_a_fault_is_named_with_its_size(fault: Fault, name: str, size: float, tmp_path: Path) -> None:
    rig = table(tmp_path / "table.csv", 1, fault)
    _, found, named = searched(rig)
    own = next(one for one in named if one.estimate.parameter.name.startswith(name))
    low, high = own.estimate.interval
    assert low < size < high and high - low < 0.4 * size
    assert own.fit.rms[1] < 1.3 and all(one.loss <= own.loss + 5.0 for one in named)
    assert f"{name}" in misfit.sentence(rig, found, own)


def test_clean_tables_name_nothing(tmp_path: Path) -> None:
    assert sum(bool(searched(table(tmp_path / "table.csv", seed))[2]) for seed in range(20)) <= 1


def test_a_friction_over_the_temperature_is_named_and_fitted(tmp_path: Path) -> None:
    slope = -6e-4
    rig = table(tmp_path / "table.csv", 2, slope=slope)
    _, found, named = searched(rig)
    assert named[0].estimate.parameter.name == "slope of friction.pulley over T_oil [°C]"
    assert '--friction-over "T_oil [°C]"' in misfit.sentence(rig, found, named[0])
    fitted = friction.over_column(rig, "T_oil", PARAMETERS)
    opened, found, named = searched(rig, fitted)
    mean = rig.sheet.others["T_oil [°C]"].mean()
    for estimate, true in zip(found.estimates, (0.1 + slope * (mean - 85.0), 4e-4, slope), strict=True):
        low, high = estimate.interval
        assert low < true < high and high - low < 0.6 * abs(true)
    assert not named
    report.write_parameters(report.Results("t.csv", "1", "v", {}, opened, found, laws=[fitted.advice]), tmp_path / "parameters.json")
    entries = json.loads((tmp_path / "parameters.json").read_text(encoding="utf-8"))["parameters"]
    assert entries.keys() == {"friction.pulley", "belt.play"} and f"at the mean of T_oil [°C], {mean:.5g}; slope" in entries["friction.pulley"]["note"]
    with pytest.raises(TableError, match="no column T_air"):
        friction.over_column(rig, "T_air", PARAMETERS)


@pytest.mark.parametrize(("slope", "verdict"), [(-6e-4, "3 groups differ (chance"), (0.0, "3 groups differ by no more than scatter")])
def test_frictions_of_groups_have_intervals_and_are_compared(slope: float, verdict: str, tmp_path: Path) -> None:
    rig = table(tmp_path / "table.csv", 4, lambda c: c | {"day": np.ones(24)}, slope, 25.0)
    groups = friction.by_group(rig, "T_oil", PARAMETERS)
    opened, found, named = searched(rig, *groups.causes)
    *lines, last = friction.compared(groups, found)
    assert verdict in last and len(lines) == 3 and not named
    for line in lines:
        oil, points, low, high = map(float, re.findall(r"= (\d+) \((\d+) points\).*: (\S+) to (\S+)\)", line)[0])
        assert low < 0.1 + slope * (oil - 85.0) < high < 1.15 * low and points == np.sum(rig.sheet.others["T_oil [°C]"] == oil)
    # Points of other groups are not solved again.
    before, slopes = opened.solves, opened.slopes([one.parameter for one in found.estimates], {}, found.place, found.after)
    assert np.abs(slopes).max(axis=0).min() > 1.0 and opened.solves - before < 0.9 * 2 * slopes.size
    for title, why in (("T_air", "no column T_air"), ("day", "all cells are 1"), ("row order", r"24 groups are empty or have one point: 0 \(1\)")):
        with pytest.raises(TableError, match=why):
            friction.by_group(rig, title, PARAMETERS)


@pytest.mark.parametrize("slip", [0.0, 1.0])
def test_a_ratio_of_the_speeds_is_certain(slip: float, tmp_path: Path) -> None:
    def speeds(c: Columns) -> Columns:
        turns = c["i_geo"] / (1.0 - c["slip"])
        return c | {"n_S [rad/s]": c["n_P [rad/s]"] / turns, "i_geo": turns * (1.0 - slip * c["slip"])}

    rig = table(tmp_path / "table.csv", 5, speeds)
    named = misfit.ratio_of_speeds(rig, fit.fit(Model(rig.points, solve), PARAMETERS))
    assert ['--map "i_geo=ratio.speed"' in text for text in named] == [True] * (slip == 0.0)


def test_a_trend_over_an_unknown_column_is_found(tmp_path: Path) -> None:
    rig = table(tmp_path / "table.csv", 3, lambda c: c | {"slip": c["slip"] + 2e-5 * (c["T_oil [°C]"] - 85.0)})
    opened = Model(rig.points, solve)
    first, *others = misfit.trends(rig, opened, fit.fit(opened, PARAMETERS))
    assert (first.quantity, first.column) == ("slip", "T_oil [°C]") and first.significant
    assert first.rise == pytest.approx(-10.0, rel=0.2) and first.tests == len(others) + 1 == 18


def test_accuracies_give_deviations(tmp_path: Path) -> None:
    """Thrust ratio, slip and efficiency from the channels, to first order. An own column counts before an option."""
    titles = ["i_geo", "n_P [rpm]", "n_S [rpm]", "T_P [Nm]", "T_P.sd", "T_S [Nm]", "F_S [kN]", "F_P [kN]"]
    path = written(tmp_path / "table.csv", [titles, [2, 2000, 990, 50, 0.4, 96, 10, 12]])
    own = {"i_geo": "0.1%", "n_S": "0.5", "T_P": "9", "secondary.torque": "0.5%", "F_S": "0.05", "F_P": "0.5%"}
    thrust, slip, efficiency = tables.read(path, Reading(accuracy=own)).points[0].measured
    turns, power = 2000 / 990, 96 / 50 / (2000 / 990)
    assert thrust.deviation == pytest.approx(1.2 * np.hypot(0.005, 0.005))
    assert slip.deviation == pytest.approx(2 / turns * np.hypot(0.001, 0.5 / 990))
    assert efficiency.deviation == pytest.approx(power * np.sqrt(0.005**2 + 0.008**2 + (0.5 / 990) ** 2))
    assert all(one.given for one in (thrust, slip, efficiency))
    with pytest.raises(TableError, match="--accuracy T_oil=1"):
        tables.read(path, Reading(accuracy={"T_oil": "1"}))


def test_an_efficiency_above_1_within_its_deviation_is_kept(tmp_path: Path) -> None:
    """Measured or computed, also in overrun, where scatter about 1 is not its inverse."""
    titles = ["i_geo", "n_P [rpm]", "T_P [Nm]", "F_S [kN]", "eta [%]", "eta.sd"]
    rows = [[1, 2000, torque, 10, efficiency, 0.3] for torque, efficiency in ((40, 100.2), (-40, 100.2), (40, 101.2), (-40, 97), (-40, 96))]
    rig = tables.read(written(tmp_path / "table.csv", [titles, *rows]))
    assert [p.measured[0].value for p in rig.points] == pytest.approx([1.002, 1.002, 0.97, 0.96])
    assert [fault.line for fault in rig.sheet.left_out] == [4]
    rows = [[1, 2000, 2000, 50, 50.1, 10, 10], [1, 2000, 2000, 50, 51.0, 10, 10], [1, 2000, 2000, 50, 48, 10, 10]]
    titles = ["i_geo", "n_P [rpm]", "n_S [rpm]", "T_P [Nm]", "T_S [Nm]", "F_S [kN]", "F_P [kN]"]
    first, second, _ = tables.read(written(tmp_path / "table.csv", [titles, *rows]), Reading(accuracy={"T_S": "0.3%"})).points
    assert first.measured[2].value == pytest.approx(1.002) and first.measured[2].deviation == pytest.approx(0.003, rel=1e-2)
    assert [one.quantity for one in second.measured] == ["thrustRatio", "slip"]
