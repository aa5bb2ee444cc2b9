//! The equations of the ring alone: Jacobians against differences, and packs against their
//! elements.

use pushbelt::solver::System as _;
use pushbelt_paper::reference_curve::TwoPulley;
use pushbelt_paper::ring::Ring;
use pushbelt_paper::ring::ale_ring::{AleRing, OverlayDirections};
use pushbelt_paper::ring::ancf::Ancf;
use pushbelt_paper::ring::mesh::RingMesh;
use pushbelt_paper::ring::model::RingFormulation;
use pushbelt_paper::ring::rcm::Rcm;
use pushbelt_paper_lab::RingSystem;
use pushbelt_support::differences::compare;
use pushbelt_support::noise;

fn jacobian_matches_differences<const D: usize, const N: usize>(model: impl RingFormulation<D, N>) {
    let mut system = RingSystem::new(model);
    let mut state = system.rest(0.2);
    let n = state.y.len();
    let mut random = noise(3);
    for i in 0..n {
        let size = if i < system.drift() && system.is_length(i) {
            0.004
        } else {
            0.02
        };
        state.q[i] += size * random();
        state.y[i] = 3.0 * random();
        state.y_dot[i] = 100.0 * random();
    }
    compare(
        &mut system,
        0.0,
        &state,
        [300.0, 0.01],
        |_| 1.0e-4,
        |entry| {
            assert!(
                (entry.difference - entry.exact).abs() < 1e-6 * entry.largest,
                "row {}: {entry:?}",
                entry.row
            );
        },
    );
}

/// A soft ring, so that no stiffness dominates the other terms.
fn ring() -> Ring {
    Ring {
        mass_per_length: 0.24,
        axial_stiffness: 5.57e3,
        bending_stiffness: 0.0159,
        lateral_bending_stiffness: 0.031,
        damping: 2.0e-4,
    }
}

#[test]
fn jacobians_match_differences() {
    let ring = ring();
    let curve = TwoPulley::new(0.168, 0.703);
    let mesh = RingMesh::even(&[1, 1, 2, 1, 1], 3);
    for directions in [OverlayDirections::Fixed, OverlayDirections::Reference] {
        let mut planar = AleRing::flexible(ring.clone(), curve.clone(), mesh.clone());
        planar.directions = directions;
        jacobian_matches_differences(planar);
        let mut spatial = AleRing::spatial(ring.clone(), curve.clone(), mesh.clone());
        spatial.directions = directions;
        jacobian_matches_differences(spatial);
    }
    jacobian_matches_differences(Ancf::new(ring.clone(), curve.clone(), 8, 3));
    jacobian_matches_differences(Rcm::new(ring, curve, 9, 5));
}

/// The last pack is not full.
#[test]
fn packs_are_the_sum_of_their_elements() {
    let mut system = RingSystem::new(Ancf::new(ring(), TwoPulley::new(0.168, 0.703), 11, 3));
    let mut state = system.rest(0.2);
    let mut random = noise(4);
    for i in 0..state.y.len() {
        state.q[i] += 0.01 * random();
        state.y[i] = random();
        state.y_dot[i] = random();
    }
    let (mut packed, mut summed) = (vec![0.0; state.y.len()], vec![0.0; state.y.len()]);
    system.residual(0.0, state.view(), &mut packed);
    for element in 0..11 {
        let rows = system
            .model
            .balance(&(), element, &system.values(state.view(), element));
        for (i, row) in system.model.directions(element).into_iter().zip(rows) {
            summed[i] += row;
        }
    }
    let largest = summed.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (i, (a, b)) in packed.iter().zip(&summed).enumerate() {
        assert!(
            system.held.contains(&i) || (a - b).abs() < 1e-12 * largest,
            "row {i}: {a}, {b}"
        );
    }
}
