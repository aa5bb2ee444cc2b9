"""The variator against the continuum theory, in the theory's limit.

The limit: no ring friction, no play, pitch line on the ring's centre line, stiff contact and chain, softened tilt,
fine mesh. From a traction of 0.2 to 85 % of the theory's capacity the thrust ratio is within 5 %, and tends to the theory's.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import pytest

from pushbelt.fmu.unit import Archive
from pushbelt_validation import limit
from pushbelt_validation.bench import Bench
from pushbelt_validation.limit import Deviation

TOLERANCE = 0.05


@pytest.fixture(scope="module")
def bench(archive: Archive) -> Iterator[Bench]:
    with Bench(archive) as opened:
        yield opened


def limit_case(bench: Bench, *case: float | limit.Level) -> Deviation:
    """A case in the limit, at a ratio, a traction and optionally a level."""
    result = limit.compare(bench, limit.limit_case(bench, *case), str(case))
    assert result, bench.failures[-1]
    return result


@pytest.mark.parametrize(
    "ratio",
    [ratio if ratio == 1.0 else pytest.param(ratio, marks=pytest.mark.slow) for ratio in limit.RATIOS],
)
def test_thrust_ratio_in_the_limit(bench: Bench, ratio: float) -> None:
    """Driving and braking, at each traction that is compared."""
    tractions = [r for i, r in limit.cases(bench) if i == ratio]
    assert min(tractions) < 0.0 < max(tractions)
    for traction in tractions:
        result = limit_case(bench, ratio, traction)
        assert result.compression <= 0.05 and result.strain <= 0.02 and result.regularisation <= 0.02
        assert result.theory.traction == pytest.approx(traction, abs=0.02)
        assert result.thrust_error == pytest.approx(0.0, abs=TOLERANCE), traction
        # Without clearance the tilt is the theory's moment over the tilt stiffness.
        assert result.tilt_error == pytest.approx(0.0, abs=TOLERANCE), traction


def ladder_errors(bench: Bench, ratio: float, traction: float) -> list[float]:
    """Size of the relative error of the thrust ratio on each level of stiffness and mesh."""
    return [abs(limit_case(bench, ratio, traction, level).thrust_error) for level in limit.LADDER]


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "traction"), [(1.0, -0.35), (2.2, 0.35)])
def test_every_step_of_the_ladder_comes_closer(bench: Bench, ratio: float, traction: float) -> None:
    """The last error is less than half of the first."""
    errors = ladder_errors(bench, ratio, traction)
    assert all(later < earlier for earlier, later in pairwise(errors)), errors
    assert errors[-1] < 0.5 * errors[0]
    assert errors[-1] <= TOLERANCE


@pytest.mark.slow
def test_the_ladder_is_close_throughout_in_overdrive(bench: Bench) -> None:
    """Errors of stiffness and mesh cancel there, so that they don't fall step by step; the last is below 1 %."""
    errors = ladder_errors(bench, 0.45, 0.35)
    assert max(errors) < 0.02
    assert errors[-1] < 0.01


def test_own_strand_forces_carry_the_torque(bench: Bench) -> None:
    """The tractions of the strands' net forces, of torque and clamping force agree: F = T - Q, with sigma V^2."""
    result = limit_case(bench, 1.0, 0.35)
    r = limit.strand_traction(bench.states.unit.profile(), result.outputs, bench)
    assert r == pytest.approx(result.theory.traction, rel=0.05)
