"""The figures of linear models: phases on one branch, colours and dashes of the points."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pushbelt.linear.grid import LinearGrid
from pushbelt.linearize.report import COLOURS, DASHES, chosen, phases


def response(*ends: float) -> Any:
    """A response whose phase goes from one angle to another, °."""
    return np.exp(1j * np.radians(np.linspace(*ends, 60)))


def test_phases_have_no_jumps_and_keep_their_distance() -> None:
    found = phases([response(170.0, 400.0), response(195.0, 425.0)])
    assert np.abs(np.diff(found)).max() < 10.0
    assert found[1] - found[0] == pytest.approx(25.0)


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (3, 1, 0, 2), (2, 3, 1, 0)])
def test_similar_responses_are_on_one_branch(order: tuple[int, ...]) -> None:
    """Also where they start on other sides of 180°, or turn in other directions."""
    given = [response(-110.0, -90.0), response(-130.0, -95.0), response(-200.0, -450.0), response(175.0, -100.0)]
    found = dict(zip(order, phases([given[k] for k in order]), strict=True))
    assert [found[k][-1] for k in range(4)] == pytest.approx([-90.0, -95.0, -90.0, -100.0])
    assert np.ptp([phase.mean() for phase in found.values()]) < 180.0
    opposite = phases([response(0.0, 1.0), response(179.0, 178.0), response(-179.0, -178.0)])
    assert abs(opposite[1][0] - opposite[2][0]) == pytest.approx(2.0)


def grid(**axes: list[float]) -> LinearGrid:
    shape = tuple(map(len, axes.values()))
    models = np.array([object() for _ in range(np.prod(shape))], dtype=object).reshape(shape)
    return LinearGrid({name: np.array(values) for name, values in axes.items()}, models, np.full(shape, "", dtype=object))


def test_the_ratio_has_a_colour_and_the_torque_a_dash() -> None:
    found = chosen(grid(ratio=[0.5, 1.0, 2.0], torque=[20.0, 50.0], speed=[100.0, 200.0, 300.0]))
    looks = {one.name: (one.colour, one.dash) for one in found}
    assert looks == {
        f"ratio {ratio}, torque {torque} N·m, speed 1910 rpm": (COLOURS[k], DASHES[m])
        for k, ratio in enumerate(("0.5", "1", "2"))
        for m, torque in enumerate((20, 50))
    }
    many = chosen(grid(ratio=list(np.linspace(0.5, 2.0, 9)), torque=list(np.linspace(10.0, 90.0, 9))))
    assert len({(one.colour, one.dash) for one in many}) == len(many) == 12
    assert many[0].name == "ratio 0.5, torque 10 N·m" and many[-1].name == "ratio 2, torque 90 N·m"
