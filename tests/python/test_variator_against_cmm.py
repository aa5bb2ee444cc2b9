"""The variator against the continuum theory, in the theory's limit.

The limit: no ring friction, no play, pitch line on the ring's centre line, stiff contact and chain, softened tilt,
fine mesh. From a traction of 0.2 to 85 % of the theory's capacity the thrust ratio is within 5 %, and tends to the theory's.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import cmm_limit
import pytest

TOLERANCE = 0.05


@pytest.fixture(scope="module")
def unit(fmu: Path) -> Iterator[cmm_limit.Unit]:
    with cmm_limit.unit(fmu) as opened:
        yield opened


@pytest.mark.parametrize("ratio", cmm_limit.RATIOS)
def test_thrust_ratio_in_the_limit(unit: cmm_limit.Unit, ratio: float) -> None:
    """Driving and braking, at each traction that is compared."""
    tractions = [r for i, r in cmm_limit.cases(unit) if i == ratio]
    assert min(tractions) < 0.0 < max(tractions)
    for traction in tractions:
        result = cmm_limit.compare(unit, cmm_limit.limit_case(unit, ratio, traction), traction)
        print(cmm_limit.row("limit", result))
        assert result.compression <= 0.05 and result.strain <= 0.02 and result.regularisation <= 0.02
        assert result.theory.traction == pytest.approx(traction, abs=0.02)
        assert result.thrust_error == pytest.approx(0.0, abs=TOLERANCE), traction


def ladder_errors(unit: cmm_limit.Unit, ratio: float, traction: float) -> list[float]:
    """Size of the relative error of the thrust ratio on each level of stiffness and mesh."""
    errors = []
    for level in cmm_limit.LADDER:
        result = cmm_limit.compare(unit, cmm_limit.limit_case(unit, ratio, traction, level), traction)
        print(cmm_limit.row("ladder", result))
        errors.append(abs(result.thrust_error))
    return errors


@pytest.mark.parametrize(("ratio", "traction"), [(1.0, -0.35), (2.2, 0.35)])
def test_every_step_of_the_ladder_comes_closer(unit: cmm_limit.Unit, ratio: float, traction: float) -> None:
    """And the last is less than half as far off as the first."""
    errors = ladder_errors(unit, ratio, traction)
    assert all(later < earlier for earlier, later in pairwise(errors)), errors
    assert errors[-1] < 0.5 * errors[0]
    assert errors[-1] <= TOLERANCE


def test_the_ladder_is_close_throughout_in_overdrive(unit: cmm_limit.Unit) -> None:
    """Errors of stiffness and mesh cancel there, so that they don't fall step by step; the last is below 1 %."""
    errors = ladder_errors(unit, 0.45, 0.35)
    assert max(errors) < 0.02
    assert errors[-1] < 0.01


def test_own_strand_forces_carry_the_torque(unit: cmm_limit.Unit) -> None:
    """The tractions of the strands' net forces, of torque and clamping force agree: F = T - Q, with sigma V^2."""
    values = cmm_limit.limit_case(unit, 1.0, 0.35)
    result = cmm_limit.compare(unit, values, 0.35)
    mass = unit.start("belt.massPerLength") + unit.start("ring.massPerLength")
    r = cmm_limit.strand_traction(result.outputs, unit.start("geometry.beltLength"), mass)
    assert r == pytest.approx(result.theory.traction, rel=0.05)
