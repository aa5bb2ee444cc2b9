//! The Jacobian of a variator with each of the paper's rings: against differences, and its updates.

use std::sync::Arc;

use pushbelt::solver::System;
use pushbelt::variator::ring_models::{Ale, Ale0, BeltRing, eulerian_equations};
use pushbelt::variator::settings::{Parameters, RingModel};
use pushbelt_paper::belts::{EvenMesh, Rotated};
use pushbelt_paper_lab::{ancf, rcm, travelling};
use pushbelt_support::disturbed::{
    Equations, TIME, assert_derivatives_by_hand, assert_jacobian, assert_update_of_tangents, disturbed_with,
    small,
};

/// The small variator in the plane.
fn plane() -> Parameters {
    small(RingModel::Ale)
}

/// The small variator in space.
fn space() -> Parameters {
    Parameters {
        spatial: true,
        ..plane()
    }
}

/// The rings on an even mesh in the plane.
fn even() -> [(Parameters, Arc<dyn BeltRing>); 2] {
    [
        (plane(), Arc::new(EvenMesh(Ale::<2>))),
        (small(RingModel::Ale0), Arc::new(EvenMesh(Ale0))),
    ]
}

#[test]
fn analytic_derivatives_on_an_even_mesh_match_forward_differentiation() {
    let equations: [Equations; 2] = [
        |belt, by_hand| eulerian_equations(EvenMesh(Ale::<2>), belt, by_hand),
        |belt, by_hand| eulerian_equations(EvenMesh(Ale0), belt, by_hand),
    ];
    for ((mut parameters, ring), equations) in even().into_iter().zip(equations) {
        parameters.primary.tilt.stiffness = 7e5;
        assert_derivatives_by_hand(&parameters, &ring, equations);
    }
}

#[test]
fn updated_tangents_on_an_even_mesh_yield_the_current_jacobian() {
    for (parameters, ring) in even() {
        assert_update_of_tangents(&parameters, &ring);
    }
}

/// The nodes of a travelling ring are interchangeable: the residual is the same with node numbers
/// and s shifted by one element.
#[test]
fn the_residual_is_invariant_to_the_choice_of_the_first_node() {
    for ring in travelling() {
        let (mut system, state) = disturbed_with(&plane(), ring, 200.0);
        let (layout, n) = (system.belt.layout, state.y.len());
        let (count, block) = (layout.nodes, layout.per_node);
        let length = system.belt.curve.length() / count as f64;
        // Index of an unknown when node numbers start at the previous node.
        let counted_on = |i: usize| {
            let first = layout.node(0, 0);
            let nodes = first..first + count * block;
            if nodes.contains(&i) {
                first + (i - first + block) % nodes.len()
            } else {
                i
            }
        };
        let mut other = state.clone();
        for i in 0..n {
            other.y[counted_on(i)] = state.y[i];
            other.y_dot[counted_on(i)] = state.y_dot[i];
            other.q[counted_on(i)] = state.q[i];
        }
        for _ in 0..count + 1 {
            other.q[layout.drift()] -= length;
        }
        let mut residuals = [vec![0.0; n], vec![0.0; n]];
        system.residual(TIME, state.view(), &mut residuals[0]);
        system.residual(TIME, other.view(), &mut residuals[1]);
        let largest = residuals[0].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        for i in 0..n {
            let [one, two] = [residuals[0][i], residuals[1][counted_on(i)]];
            assert!((one - two).abs() < 1e-9 * largest, "row {i}: {one} {two}, {largest}");
        }
    }
}

#[test]
fn jacobians_of_travelling_rings_match_differences() {
    for (ring, speed) in [(rcm(), 200.0), (ancf(), -200.0)] {
        assert_jacobian(disturbed_with(&plane(), ring, speed), 0.4);
    }
}

#[test]
fn jacobian_on_evenly_spaced_elements_matches_differences() {
    let cases: [(Parameters, Arc<dyn BeltRing>, f64); 3] = [
        (plane(), Arc::new(EvenMesh(Ale::<2>)), 200.0),
        (space(), Arc::new(EvenMesh(Ale::<3>)), -200.0),
        (small(RingModel::Ale0), Arc::new(EvenMesh(Ale0)), 200.0),
    ];
    for (parameters, ring, speed) in cases {
        assert_jacobian(disturbed_with(&parameters, ring, speed), 0.1);
    }
}

/// Friction is more nonlinear over a step of these coordinates, so the steps are shorter.
#[test]
fn jacobian_in_directions_of_the_curve_matches_differences() {
    let cases: [(Parameters, Arc<dyn BeltRing>, f64); 2] = [
        (plane(), Arc::new(Rotated::<2>), 200.0),
        (space(), Arc::new(Rotated::<3>), -200.0),
    ];
    for (parameters, ring, speed) in cases {
        assert_jacobian(disturbed_with(&parameters, ring, speed), 0.16);
    }
}
