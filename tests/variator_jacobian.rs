//! The Jacobian of the assembled variator: against differences, and its updates.

use std::sync::Arc;

use pushbelt::reference_curve::TwoPulley;
use pushbelt::solver::arrow::Arrow;
use pushbelt::solver::{State, System};
use pushbelt::variator::belt_ring::{Ale, Ale0, BeltRing, deflecting_equations, guided_equations};
use pushbelt::variator::settings::{Parameters, RingModel};
use pushbelt::variator::system::VariatorSystem;
use pushbelt_support::disturbed::{
    Equations, TIME, assert_derivatives_by_hand, assert_jacobian, assert_update_of_slopes, disturbed, product, small,
};

/// The small variator in space.
fn spatial() -> Parameters {
    Parameters {
        spatial: true,
        ..small(RingModel::Ale)
    }
}

#[test]
fn hand_written_derivatives_are_those_of_forward_differentiation() {
    let of = |parameters: &Parameters, ring: Arc<dyn BeltRing>, tilt: f64, equations: Equations| {
        let mut parameters = parameters.clone();
        parameters.primary.tilt.stiffness = tilt;
        assert_derivatives_by_hand(&parameters, &ring, equations);
    };
    let ale = deflecting_equations::<2, TwoPulley>;
    of(&small(RingModel::Ale), Arc::new(Ale::<2>), 7e5, ale);
    let in_space = deflecting_equations::<3, TwoPulley>;
    of(&spatial(), Arc::new(Ale::<3>), 7e5, in_space);
    let ale0 = guided_equations::<TwoPulley>;
    of(&small(RingModel::Ale0), Arc::new(Ale0), 1e12, ale0);
}

/// Cached derivatives are used where nothing has changed. A cell that begins to slip gets updated constitutive tangents, with
/// the cells that share its face; after another step size all cells are differentiated again.
#[test]
fn cached_derivatives_are_used_until_they_change() {
    let (mut system, mut state) = disturbed(&small(RingModel::Ale), 200.0);
    let shape = system.shape();
    let renewed = |system: &mut VariatorSystem, state: &State, alpha: f64| {
        let (before, mut matrix) = (system.differentiations(), Arrow::new(shape));
        system.renew_jacobian(TIME, state.view(), alpha, 1.0 / alpha, &mut matrix);
        let after = system.differentiations();
        ([0, 1].map(|k| after[k] - before[k]), product(&matrix))
    };
    let packs = system.belt.mesh.groups.len() as u64;
    let (all, first) = renewed(&mut system, &state, 1.0e4);
    let (none, again) = renewed(&mut system, &state, 1.0e4);
    assert_eq!((all, none), ([packs, 0], [0, 0]));
    assert_eq!(first, again);
    // In the middle of the primary arc, where the belt sticks.
    let face = system.belt.layout.belt_speed(14);
    state.y[face] += 0.5;
    let ([differentiated, some], changed) = renewed(&mut system, &state, 1.0e4);
    assert_eq!(differentiated, 0);
    assert!((1..=2).contains(&some), "{some} of {packs}");
    let mut exact = Arrow::new(shape);
    system.jacobian(TIME, state.view(), 1.0e4, 1.0e-4, &mut exact);
    let exact = product(&exact)[face];
    let (before, after) = (first[face] - exact, changed[face] - exact);
    assert!(after.abs() < 0.02 * before.abs(), "{before:e}, {after:e}");
    assert_eq!(renewed(&mut system, &state, 2.0e4).0, [packs, 0]);
}

#[test]
fn an_update_of_constitutive_tangents_gives_the_current_jacobian() {
    assert_update_of_slopes(&small(RingModel::Ale), &(Arc::new(Ale::<2>) as Arc<dyn BeltRing>));
    assert_update_of_slopes(&spatial(), &(Arc::new(Ale::<3>) as Arc<dyn BeltRing>));
    assert_update_of_slopes(&small(RingModel::Ale0), &(Arc::new(Ale0) as Arc<dyn BeltRing>));
}

#[test]
fn jacobian_of_ale_matches_differences() {
    for speed in [200.0, -200.0] {
        assert_jacobian(disturbed(&small(RingModel::Ale), speed), 0.4);
    }
}

#[test]
fn jacobian_in_space_matches_differences() {
    for speed in [200.0, -200.0] {
        assert_jacobian(disturbed(&spatial(), speed), 0.2);
    }
}

#[test]
fn jacobian_of_ale0_matches_differences() {
    for speed in [200.0, 0.0] {
        assert_jacobian(disturbed(&small(RingModel::Ale0), speed), 0.4);
    }
}
