//! The Jacobian of the assembled variator: against differences, and its updates.

use pushbelt::solver::arrow::Arrow;
use pushbelt::solver::{State, System};
use pushbelt::variator::ring_models::{Ale, Ale0, BeltRing, eulerian_equations};
use pushbelt::variator::settings::{BeltKind, Parameters, RingModel};
use pushbelt::variator::system::VariatorSystem;
use pushbelt_support::disturbed::{
    Equations, TIME, assert_derivatives_by_hand, assert_jacobian, assert_update_of_tangents, disturbed,
    product, small,
};
use std::sync::Arc;

pub const KINDS: [BeltKind; 2] = [BeltKind::PushBelt, BeltKind::PullChain];

/// Small variators of a kind: `ALE`, `ALE` in space, `ALE0` between sheaves of which one hardly
/// tilts.
pub fn variators(kind: BeltKind) -> [Parameters; 3] {
    let [ale, mut space, mut ale0] =
        [RingModel::Ale, RingModel::Ale, RingModel::Ale0].map(|model| Parameters { kind, ..small(model) });
    space.spatial = true;
    ale0.primary.tilt.stiffness = 1e12;
    [ale, space, ale0]
}

/// Those of forward differentiation, and after an update of the constitutive tangents alone the
/// current ones.
#[test]
fn hand_written_derivatives_are_exact() {
    let rings: [(Arc<dyn BeltRing>, Equations); 3] = [
        (Arc::new(Ale::<2>), |belt, by_hand| {
            eulerian_equations(Ale::<2>, belt, by_hand)
        }),
        (Arc::new(Ale::<3>), |belt, by_hand| {
            eulerian_equations(Ale::<3>, belt, by_hand)
        }),
        (Arc::new(Ale0), |belt, by_hand| eulerian_equations(Ale0, belt, by_hand)),
    ];
    for kind in KINDS {
        for (parameters, (ring, equations)) in variators(kind).iter().zip(&rings) {
            assert_derivatives_by_hand(parameters, ring, *equations);
            assert_update_of_tangents(parameters, ring);
        }
    }
}

/// Where a cell begins to slip, the constitutive tangents are updated; after another step size or a
/// rotation of the ring, and where Θ or the centres of arcs have changed, the geometry is evaluated
/// again.
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

/// Forward, in reverse and at rest.
#[test]
fn jacobians_match_differences() {
    for kind in KINDS {
        for (parameters, step) in variators(kind).iter().zip([0.1, 0.05, 0.1]) {
            let step = if kind == BeltKind::PullChain { 1e-2 } else { step };
            let slow = if parameters.ring_model == RingModel::Ale {
                -200.0
            } else {
                0.0
            };
            for speed in [200.0, slow] {
                assert_jacobian(disturbed(parameters, speed), step);
            }
        }
    }
}
