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

/// Where a cell begins to slip, the constitutive tangents are updated; after another step size or a rotation of the ring, and where
/// Θ or the centres of arcs have changed, the geometry is evaluated again.
#[test]
fn cached_derivatives_are_used_until_the_geometry_changes() {
    let renewed = |system: &mut VariatorSystem, state: &State, alpha: f64| {
        let mut matrix = Arrow::new(system.shape());
        let share = system.renew_jacobian(TIME, state.view(), alpha, 1.0 / alpha, &mut matrix);
        (share, product(&matrix))
    };
    let (mut system, mut state) = disturbed(&small(RingModel::Ale), 200.0);
    let (all, first) = renewed(&mut system, &state, 1.0e4);
    let (none, again) = renewed(&mut system, &state, 1.0e4);
    assert_eq!((all, none), (1.0, 0.0));
    assert_eq!(first, again);
    // In the middle of the primary arc, where the belt sticks.
    let face = system.belt.layout.belt_speed(14);
    state.y[face] += 0.5;
    let (share, changed) = renewed(&mut system, &state, 1.0e4);
    assert_eq!(share, 0.0);
    let mut exact = Arrow::new(system.shape());
    system.jacobian(TIME, state.view(), 1.0e4, 1.0e-4, &mut exact);
    let exact = product(&exact)[face];
    let (before, after) = (first[face] - exact, changed[face] - exact);
    assert!(after.abs() < 0.02 * before.abs(), "{before:e}, {after:e}");
    assert_eq!(renewed(&mut system, &state, 2.0e4).0, 1.0);

    let reused_until = |system: &mut VariatorSystem, state: &State, at: usize, by: f64| {
        renewed(system, state, 1.0e4);
        for (share, by) in [(0.0, 0.1 * by), (1.0, by)] {
            let mut moved = state.clone();
            moved.q[at] += by;
            assert_eq!(renewed(system, &moved, 1.0e4).0, share, "unknown {at} by {by}");
        }
    };
    let layout = system.belt.layout;
    reused_until(&mut system, &state, layout.node(3, 1), 0.02);
    reused_until(&mut system, &state, layout.node(3, 0), 1e-3);
    reused_until(&mut system, &state, layout.theta(), 0.02);
    let (mut system, state) = disturbed(&small(RingModel::Ale0), 200.0);
    let centre = system.belt.layout.centre(0);
    reused_until(&mut system, &state, centre, 2e-3);
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
