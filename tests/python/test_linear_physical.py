"""Linear models in physical coordinates: the transform, interpolation, discrete time, and the loop of the page."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import cont2discrete

from pushbelt import ArgumentError, LinearGrid, LinearModel, LinearPointError, Variator, points
from pushbelt.linear.physical import LOG_RATIO, NotPhysicalError, modes_needed, physical

ALL = ("primary.torque", "primary.clampingForce", "secondary.torque", "secondary.clampingForce")
OUTPUTS = ("primary.speed", "secondary.speed", "ratio.geometric", "slip")


@pytest.fixture(scope="module")
def grid(coarse: Variator) -> LinearGrid:
    return coarse.linear_grid([0.7, 0.8, 1.5], [30.0, 700.0], force=11e3, states="physical", sample_time=0.004)


def invented(blocks: list[complex], inputs: tuple[str, ...] = ALL, seed: int = 3) -> LinearModel:
    """A modal model with these poles; one of a pair is given."""
    random, size = np.random.default_rng(seed), sum(2 if pole.imag else 1 for pole in blocks)
    a, poles, k = np.zeros((size, size)), [], 0
    for pole in map(complex, blocks):
        if pole.imag:
            a[k : k + 2, k : k + 2] = [[pole.real, pole.imag], [-pole.imag, pole.real]]
            poles += [pole, pole.conjugate()]
        else:
            a[k, k] = pole.real
            poles.append(pole)
        k = len(poles)
    numbers = dict.fromkeys(inputs, 1.0)
    return LinearModel(
        a=a, b=random.normal(size=(size, len(inputs))), c=random.normal(size=(4, size)), d=random.normal(size=(4, len(inputs))),
        inputs=inputs, outputs=OUTPUTS, states=tuple(f"mode{n + 1}" for n in range(size)), poles=np.array(poles),
        held=numbers, given=numbers, values=dict(zip(OUTPUTS, (180.0, 120.0, 1.5, 0.01), strict=True)),
        units=dict.fromkeys((*inputs, *OUTPUTS), "1"), frequency=200.0, slip=0.01, macro_slip=False, remarks=(),
    )  # fmt: skip


def test_real_modes_are_transformed_without_loss() -> None:
    model = invented([-0.2, -1.1, -170.0])
    found = physical(model)
    assert found.states == ("primary.speed", "secondary.speed", LOG_RATIO)
    assert found.poles == pytest.approx(model.poles)
    w = np.geomspace(0.01, 1e3, 9)
    assert np.abs(found.response(w) - model.response(w)).max() < 1e-9 * np.abs(model.response(w)).max()
    # The states are the outputs without their direct feedthrough, and i times ln i.
    assert found.c[:2] == pytest.approx(np.eye(3)[:2], abs=1e-9)
    assert found.c[2] == pytest.approx([0.0, 0.0, 1.5], abs=1e-9)


def test_a_pair_becomes_a_lag() -> None:
    model = invented([-0.2 + 0.1j, -60.0 + 170.0j, -500.0])
    found = physical(model)
    assert modes_needed(model) == 4
    assert found.poles == pytest.approx([-0.2 + 0.1j, -0.2 - 0.1j, -abs(-60.0 + 170.0j)])
    assert found.response(0.0) == pytest.approx(model.response(0.0))
    assert found.c[:2] == pytest.approx(np.eye(3)[:2], abs=1e-9)
    assert np.abs(found.response(0.5) - model.response(0.5)).max() < 0.02 * np.abs(model.response(0.5)).max()


@pytest.mark.parametrize(
    ("inputs", "states"),
    [
        (ALL, ("primary.speed", "secondary.speed", LOG_RATIO)), ((ALL[0], *ALL[1::2], "secondary.speedSetpoint"), ("primary.speed", LOG_RATIO)),
        ((ALL[0], *ALL[2:]), ("primary.speed", "secondary.speed")), (("primary.speedSetpoint", "secondary.speedSetpoint", *ALL[1::2]), (LOG_RATIO,)),
    ],
)  # fmt: skip
def test_coordinates_that_are_held_drop_out(inputs: tuple[str, ...], states: tuple[str, ...]) -> None:
    found = physical(invented([-0.3, -2.0, -140.0], inputs))
    assert found.states == states and found.a.shape == (len(states), len(states))


def test_what_has_no_physical_coordinates_is_refused() -> None:
    with pytest.raises(NotPhysicalError, match="both speeds and the ratio are held"):
        physical(invented([-0.3], ("primary.speedSetpoint", "secondary.speedSetpoint")))
    with pytest.raises(NotPhysicalError, match="2 modes .* 3 are needed"):
        physical(invented([-0.3, -2.0]))
    model = invented([-0.3, -2.0, -140.0])
    nearly = model.c.copy()
    nearly[1] = nearly[0] * 120.0 / 180.0 + 1e-7 * nearly[1]
    with pytest.raises(NotPhysicalError, match=r"condition number .* is \d\.\de\+\d\d, above 1e\+06"):
        physical(replace(model, c=nearly))


def test_the_belt_has_them(coarse: Variator, grid: LinearGrid) -> None:
    modal, found = coarse.linearize(0.8, 30.0, force=11e3, frequency=120.0), grid[1, 0]
    assert found.coordinates == "physical" and len(found.states) == 3
    w, loads = np.array([0.3, 2.0]), ["primary.clampingForce", "secondary.torque"]
    expected = modal.select(["ratio.geometric", "primary.speed"], loads).response(w)
    near = found.select(["ratio.geometric", "primary.speed"], loads).response(w)
    assert np.abs(near - expected).max(axis=0) == pytest.approx(0.0, abs=0.02 * np.abs(expected).max())
    assert found.poles[:2] == pytest.approx(modal.poles[:2], rel=1e-5)


def test_more_modes_are_searched_until_they_are_enough() -> None:
    asked = []
    modes = [-0.3, -2.0, -700.0, -4000.0]

    def linearise(frequency: float) -> dict[str, Any]:
        asked.append(frequency)
        return invented([one for one in modes if abs(one) < 2.0 * np.pi * frequency]).document()

    solver = SimpleNamespace(linearise=linearise)
    assert points.model_of(solver, 30.0, "physical", None).poles == pytest.approx([-0.3, -2.0, -700.0])
    assert asked == [30.0, 60.0, 120.0]
    modes = modes[:2]
    with pytest.raises(NotPhysicalError, match="2 modes"):
        points.model_of(solver, 30.0, "physical", None)
    assert max(asked) < 4e3


def test_discrete_matrices_are_those_of_constant_inputs(grid: LinearGrid) -> None:
    model = grid[0, 0]
    for found, expected in zip(model.discrete(), cont2discrete((model.a, model.b, model.c, model.d), 0.004), strict=False):
        assert found == pytest.approx(expected)
    # Ten samples of a unit step are the continuous step response.
    state = np.zeros_like(model.b)
    for _ in range(10):
        state = model.ad @ state + model.bd
    assert model.cd @ state + model.dd == pytest.approx(model.step(0.04)[0], rel=1e-7, abs=1e-12)


def test_a_sampled_model_stays_sampled() -> None:
    model = invented([-0.4, complex(-3.0, 8.0)]).sampled(0.05)
    system = model.to_control()
    assert system.dt == 0.05
    assert np.sort_complex(system.poles()) == pytest.approx(np.sort_complex(np.exp(0.05 * model.poles)))
    found, continuous = model.response(20.0)[0], replace(model, sample_time=None).response(20.0)[0]
    assert found == pytest.approx(system(np.exp(20.0j * 0.05)))
    assert np.abs(found - continuous).max() > 0.1 * np.abs(continuous - model.d).max()
    assert model.gain("slip", ALL[0], 20.0) == pytest.approx(found[3, 0])
    assert model.select(["slip"]).to_control().dt == 0.05


def test_poles_at_zero_integrate() -> None:
    """A double pole at zero, whose eigenvectors are no base: x₂ = b₂ t, x₁ = b₁ t + b₂ t²/2."""
    model = replace(invented([-1.0, -2.0]), a=np.array([[0.0, 1.0], [0.0, 0.0]]), poles=np.zeros(2, dtype=complex))
    time = 3.0
    states = np.array([model.b[0] * time + model.b[1] * time**2 / 2.0, model.b[1] * time])
    assert model.step(time)[0] == pytest.approx(model.c @ states + model.d)
    single = replace(invented([-1.0]), a=np.zeros((1, 1)))
    assert single.step([0.0, 2.0])[1] == pytest.approx(single.c @ (2.0 * single.b) + single.d)
    assert np.isnan(single.response(0.0)).any() and np.isfinite(single.response(1.0)).all()


def test_points_of_the_grid_are_their_own_interpolation(grid: LinearGrid) -> None:
    for k, ratio in enumerate((0.7, 0.8, 1.5)):
        found = grid.interpolate(ratio=ratio, torque=30.0)
        for name in "abcd":
            expected = getattr(grid[k, 0], name)
            assert np.abs(getattr(found, name) - expected).max() < 1e-8 * np.abs(expected).max()
        assert found.held == pytest.approx(grid[k, 0].held)
    # Half way in the logarithm of the ratio.
    force, (low, high) = "primary.clampingForce", (grid[k, 0].held for k in (1, 2))
    assert grid.interpolate(ratio=1.2**0.5, torque=30.0).held[force] == pytest.approx(0.5 * (low[force] + high[force]))


def test_a_slow_pole_stays_between_its_neighbours(grid: LinearGrid, coarse: Variator) -> None:
    """The elements of A by themselves do not have this property."""
    found, ends = grid.interpolate(ratio=0.75, torque=30.0), (grid[0, 0], grid[1, 0])
    for k in range(2):
        low, high = sorted(end.poles[k].real for end in ends)
        assert low - 0.15 < found.poles[k].real < high + 0.15
    elements = 0.5 * ends[0].a + 0.5 * ends[1].a
    assert abs(np.sort(np.linalg.eigvals(elements).real)[-2] - found.poles[1].real) > 0.5
    # About 0.75 this coarse mesh has two steady states.
    near, there = grid.interpolate(ratio=0.77, torque=30.0), coarse.linearize(0.77, 30.0, force=11e3)
    assert near.held["primary.clampingForce"] == pytest.approx(there.held["primary.clampingForce"], rel=0.03)


@pytest.mark.parametrize("sampled", [True, False])
def test_models_of_other_kinds_are_not_mixed(sampled: bool, tmp_path: Path) -> None:
    """With and without a sample time, and in modal coordinates, which have no mean."""
    one = physical(invented([-0.3, -4.0, -90.0]))
    models = np.array([one, one.sampled(0.05)] if sampled else [invented([-0.3, -2.0]), invented([-0.4, -1.0])], dtype=object)
    grid = LinearGrid({"ratio": np.array([1.0, 2.0])}, models, np.full(2, "", dtype=object))
    with pytest.raises(ArgumentError, match="sample times" if sampled else "physical"):
        grid.interpolate(ratio=1.5)
    if sampled:
        with pytest.raises(ArgumentError, match="sample times"):
            grid.save(tmp_path / "models.npz")
        assert [system.dt for system in grid.to_control()] == [0, 0.05]


def test_too_few_modes_are_a_reason(coarse: Variator, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(points, "MOST_HERTZ", 0.0)
    with pytest.raises(LinearPointError, match=r"at ratio 1, 30 N·m.*modes are below 1 Hz, but \d are needed"):
        coarse.linearize(1.0, 30.0, force=9e3, states="physical", frequency=1.0)
