//! The reference motion alone (paper fig. 6).

use std::fmt::Debug;

use crate::system::RingSystem;
use pushbelt::solver::State;
use pushbelt_paper::reference_curve::ReferenceCurve;
use pushbelt_paper::ring::ale_ring::AleRing;
use pushbelt_paper::ring::mesh::RingMesh;

use super::motion::{fixed_steps, mode, run};
use super::record::{Record, record};
use super::specimens::{solid, solid_curve};

/// The solid ring that follows its reference curve.
pub fn rigid<C: ReferenceCurve + Debug>(curve: C, mesh: RingMesh) -> RingSystem<AleRing<C>> {
    RingSystem::new(AleRing::rigid(solid(), curve, mesh))
}

/// Energy and inertia of the reference motion at a Θ.
pub struct ReferenceNumbers {
    /// Θ.
    pub theta: f64,
    /// Bending energy, J.
    pub energy: f64,
    /// M_ΘΘ, kg·m².
    pub mass: f64,
    /// M_sΘ, kg·m.
    pub coupling: f64,
}

/// Reference values for the solid ring.
pub const REFERENCE_NUMBERS: [ReferenceNumbers; 2] = [
    ReferenceNumbers {
        theta: 0.0,
        energy: 1_151_453.8,
        mass: 3.10883,
        coupling: 0.0,
    },
    ReferenceNumbers {
        theta: 0.4,
        energy: 1_298_705.6,
        mass: 2.04239,
        coupling: 0.0,
    },
];

/// Reference value of the frequency of its small oscillation, rad/s.
pub const REFERENCE_FREQUENCY: f64 = 718.05;

/// Those of the reference motion at Θ. All of its energy is that of bending.
pub fn reference_numbers(theta: f64) -> ReferenceNumbers {
    let system = rigid(solid_curve(), RingMesh::even(&[4, 4, 8, 4, 4], 5));
    let state = system.rest(theta);
    let mass = system.mass_matrix(&state.q);
    let (s, at) = (system.drift(), system.theta());
    ReferenceNumbers {
        theta,
        energy: system.energy(state.view()).total(),
        mass: mass[(at, at)],
        coupling: mass[(s, at)],
    }
}

/// Frequency of the reference motion's small oscillation, rad/s.
pub fn reference_frequency() -> f64 {
    let system = rigid(solid_curve(), RingMesh::even(&[4, 4, 8, 4, 4], 5));
    mode(&system, &system.rest(0.0), 700.0).omega
}

/// An oscillation about the reference motion.
pub struct Oscillation<C: ReferenceCurve> {
    pub system: RingSystem<AleRing<C>>,
    pub record: Record,
    /// Its energy, J.
    pub swing: f64,
}

/// The reference oscillation (paper fig. 6) from Θ = 0.4 at rest, over 20 ms.
pub fn reference_oscillation<C: ReferenceCurve + Debug>(
    curve: C,
    mesh: RingMesh,
    tolerance: f64,
) -> Oscillation<C> {
    oscillation(rigid(curve, mesh), tolerance, 2.0e-4)
}

/// The same with any ring, over 100 times `step`, s.
pub fn oscillation<C: ReferenceCurve + Debug>(
    mut system: RingSystem<AleRing<C>>,
    tolerance: f64,
    step: f64,
) -> Oscillation<C> {
    system.tolerance = tolerance;
    let start = system.rest(0.4);
    let energy = |state: &State| system.energy(state.view()).total();
    let swing = energy(&start) - energy(&system.rest(0.0));
    let record = record(&mut system, start, 0.05 * step, step, 100, 1.0);
    Oscillation { system, record, swing }
}

/// Error of Θ after 5 ms of the reference oscillation with fixed steps.
pub fn reference_time_errors(steps: [f64; 3]) -> [f64; 3] {
    let theta = |step: f64| {
        let mut system = rigid(solid_curve(), RingMesh::even(&[1, 1, 2, 1, 1], 5));
        let mut integrator = fixed_steps(&mut system, step);
        let mut state = system.rest(0.4);
        run(&mut system, &mut integrator, &mut state, 0.0, 5.0e-3);
        state.q[system.theta()]
    };
    let exact = theta(1.0e-6);
    steps.map(|step| (theta(step) - exact).abs())
}
