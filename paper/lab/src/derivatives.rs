//! Kinematics, elasticity and inertia of a ring against differences.

use crate::system::RingSystem;
use nalgebra::{DMatrix, DVector};
use pushbelt::solver::State;
use pushbelt_paper::ring::model::RingFormulation;

use super::cases::Case;
use super::motion::residual;
use super::specimens::{solid, solid_curve, without_stiffness};
use pushbelt_support::noise;

/// Number of elements in the tests of derivatives. It is large enough for every kind of
/// neighbourhood.
pub const FEW: usize = 12;

/// A ring on the reference curve at Θ with deflections of a few per cent, in motion.
pub fn waving<M: RingFormulation<D, N>, const D: usize, const N: usize>(
    system: &RingSystem<M, D, N>,
    theta: f64,
    amplitude: f64,
) -> State {
    let mut state = system.rest(theta);
    let length = system.model.length();
    let mut random = noise(11);
    for i in 0..system.drift() {
        let length = if system.model.is_length(i % M::BLOCK) {
            length
        } else {
            1.0
        };
        let step = length * amplitude / system.model.elements() as f64;
        state.q[i] += 0.05 * step * random();
        state.y[i] = 5.0 * step * random();
        state.y_dot[i] = 200.0 * step * random();
    }
    let (s, theta) = (system.drift(), system.theta());
    state.y[s] = 6.0 * length;
    state.y_dot[s] = 90.0;
    if !system.held.contains(&theta) {
        state.y[theta] = 8.0;
        state.y_dot[theta] = -70.0;
    }
    state
}

pub fn lagrangian<M: RingFormulation<D, N>, const D: usize, const N: usize>(_: &RingSystem<M, D, N>) -> bool {
    M::LAGRANGIAN
}

/// Number of unknowns whose rows are force balances: without s and Θ on a travelling mesh.
fn forces<M: RingFormulation<D, N>, const D: usize, const N: usize>(system: &RingSystem<M, D, N>) -> usize {
    if M::LAGRANGIAN {
        system.drift()
    } else {
        system.theta() + 1
    }
}

pub const PLACES: [f64; 8] = [0.01, 0.093, 0.2, 0.31, 0.505, 0.62, 0.81, 0.97];

/// (13) and (14) from differences of the mass matrix: M q̈ + Ṁ q̇ − ∂T/∂q.
pub fn inertia_by_differences<M: RingFormulation<D, N>, const D: usize, const N: usize>(
    system: &RingSystem<M, D, N>,
    state: &State,
) -> DVector<f64> {
    let rate = DVector::from_column_slice(&state.y);
    let moved = |i: Option<usize>, h: f64| {
        let mut q = state.q.clone();
        match i {
            Some(i) => q[i] += h,
            None => q.iter_mut().zip(&state.y).for_each(|(q, y)| *q += h * y),
        }
        system.mass_matrix(&q)
    };
    let h = 1.0e-6;
    let along = (moved(None, h) - moved(None, -h)) / (2.0 * h);
    let mut force = system.mass_matrix(&state.q) * DVector::from_column_slice(&state.y_dot) + along * &rate;
    for i in 0..state.q.len() {
        let slope: DMatrix<f64> = (moved(Some(i), h) - moved(Some(i), -h)) / (2.0 * h);
        force[i] -= 0.5 * rate.dot(&(slope * &rate));
    }
    force
}

/// P (12): the velocity at a unit rate is that of the particle at ξ = x̄ + s. Largest difference of
/// the columns, m.
pub fn velocity_error<S: Case<D, N>, const D: usize, const N: usize>() -> f64 {
    let system = S::system(solid(), solid_curve(), FEW);
    let mut state = waving(&system, 0.25, 1.0);
    let (s, h) = (system.drift(), 3.0e-6);
    let mut off = 0.0_f64;
    for xi in PLACES {
        for i in 0..state.y.len() {
            if lagrangian(&system) && i > s {
                continue;
            }
            state.y.fill(0.0);
            state.y[i] = 1.0;
            let velocity = system.particle_at(state.view(), xi).velocity;
            let place = |h: f64| {
                let mut moved = state.clone();
                moved.q[i] += h;
                system.particle_at(moved.view(), if i == s { xi + h } else { xi }).r
            };
            off = off.max((velocity - (place(h) - place(-h)) / (2.0 * h)).norm());
        }
    }
    off
}

/// The residual at rest is ∂V/∂q, including moving arc borders, where the curvature jumps. Largest
/// difference relative to the largest force.
pub fn elastic_force_error<S: Case<D, N>, const D: usize, const N: usize>() -> f64 {
    let mut system = S::system(solid(), solid_curve(), FEW);
    system.held.clear();
    let mut state = waving(&system, 0.25, 0.3);
    state.y.fill(0.0);
    state.y_dot.fill(0.0);
    let force = residual(&mut system, state.view());
    let h = 1.0e-6;
    let mut off = 0.0_f64;
    for i in 0..forces(&system) {
        let energy = |h: f64| {
            let mut moved = state.clone();
            moved.q[i] += h;
            let energy = system.energy(moved.view());
            energy.membrane + energy.bending
        };
        off = off.max((force[i] - (energy(h) - energy(-h)) / (2.0 * h)).abs());
    }
    off / force.amax()
}

/// Inertia is M q̈ + Ṁq̇ − ∂T/∂q of the discrete ring. Largest difference relative to the largest
/// force.
pub fn inertia_error<S: Case<D, N>, const D: usize, const N: usize>() -> f64 {
    let mut system = S::system(solid(), solid_curve(), FEW);
    *system.model.ring_mut() = without_stiffness(system.model.ring());
    system.held.clear();
    let state = waving(&system, 0.25, 1.0);
    let rows = forces(&system);
    let direct = residual(&mut system, state.view());
    let expected = inertia_by_differences(&system, &state);
    (direct - &expected).rows(0, rows).amax() / expected.rows(0, rows).amax()
}
