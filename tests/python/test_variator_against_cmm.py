"""The variator against the continuum theory, in the theory's limit: `cargo fmu validate` compares many cases, this file one of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import pytest

from pushbelt.fmu.results import Profile
from pushbelt.fmu.unit import Archive
from pushbelt_validation import limit
from pushbelt_validation.bench import Bench
from pushbelt_validation.sections.continuum import TOLERANCE


@pytest.fixture(scope="module")
def bench(archive: Archive) -> Iterator[Bench]:
    with Bench(archive) as opened:
        yield opened


def test_the_limit_is_that_of_the_theory(bench: Bench) -> None:
    """Driving and braking; without clearance the tilt is the theory's moment over the tilt stiffness."""
    for traction in (-0.35, 0.35):
        result = limit.compare(bench, limit.limit_case(bench, 1.0, traction), str(traction))
        assert result, bench.failures[-1]
        assert result.compression <= 0.05 and result.strain <= 0.02 and result.regularisation <= 0.02
        assert result.theory.traction == pytest.approx(traction, abs=0.02)
        assert result.thrust_error == pytest.approx(0.0, abs=TOLERANCE)
        assert result.tilt_error == pytest.approx(0.0, abs=TOLERANCE)
        # The tractions of the strands' net forces, of torque and clamping force agree: F = T - Q, with sigma V^2.
        r = strand_traction(bench.states.unit.profile(), result.outputs, bench)
        assert r == pytest.approx(result.theory.traction, rel=0.05)


def strand_traction(profile: Profile, out: Mapping[str, float], bench: Bench) -> float:
    """r from the FMU's strand forces F = T - Q at the middle of both strands."""
    length = bench.given("geometry.beltLength")
    count = len(profile.position)

    def force(xi: float) -> float:
        k = round(xi / length * count) % count
        return float(profile.ring_tension[k] - profile.push_force[k])

    mass = bench.given("belt.massPerLength") + bench.given("ring.massPerLength")
    centrifugal = mass * out["belt.speed"] ** 2
    # From xi = 0 to the middle of the upper strand: half the wrap of S and half a strand.
    radius_p, radius_s = out["primary.radius"], out["secondary.radius"]
    wrap_p, wrap_s = limit.wraps(radius_p, radius_s, bench.given("geometry.centerDistance"))
    half_arc = radius_s * wrap_s / 2.0
    middle = half_arc + (length - radius_s * wrap_s - radius_p * wrap_p) / 4.0
    upper, lower = force(middle) - centrifugal, force(length - middle) - centrifugal
    return (upper - lower) / (upper + lower)
