//! A ring alone in motion: residual, integration with fixed steps, small oscillations, shape.

use crate::system::RingSystem;
use nalgebra::{DVector, Vector2};
use pushbelt::solver::arrow::{Arrow, ArrowLu};
use pushbelt::solver::sdirk::{Evolution, Sdirk, Stalled};
use pushbelt::solver::{State, System, View};
use pushbelt_paper::ring::model::RingFormulation;

use pushbelt_support::noise;

pub fn residual<M: RingFormulation<D, N>, const D: usize, const N: usize>(
    system: &mut RingSystem<M, D, N>,
    view: View<'_>,
) -> DVector<f64> {
    let mut out = vec![0.0; view.y.len()];
    system.residual(0.0, view, &mut out);
    DVector::from_vec(out)
}

/// Integrator with fixed steps. Errors of Newton's method in the velocities accumulate over the
/// steps of the finest resolution, so its tolerance is below the default.
pub fn fixed_steps<M: RingFormulation<D, N>, const D: usize, const N: usize>(
    system: &mut RingSystem<M, D, N>,
    step: f64,
) -> Sdirk {
    system.tolerance = f64::INFINITY;
    let mut integrator = Sdirk::new(system, step, step);
    integrator.newton_tolerance = 0.05;
    integrator
}

/// Advances a state from one time to exactly another, s.
///
/// # Errors
/// The step size fell below the integrator's smallest.
pub fn advance(
    integrator: &mut Sdirk,
    system: &mut impl Evolution,
    state: &mut State,
    [from, to]: [f64; 2],
) -> Result<(), Stalled> {
    let mut time = from;
    while time < to {
        integrator.step(system, state, &mut time, to)?;
    }
    Ok(())
}

pub fn run<M: RingFormulation<D, N>, const D: usize, const N: usize>(
    system: &mut RingSystem<M, D, N>,
    integrator: &mut Sdirk,
    state: &mut State,
    from: f64,
    to: f64,
) {
    advance(integrator, system, state, [from, to]).expect("the free ring can be integrated");
}

/// A small oscillation.
pub struct Mode {
    /// Angular frequency, rad/s.
    pub omega: f64,
    /// Its shape.
    pub shape: Vec<f64>,
}

/// The small oscillation about the rest state `state` nearest to the angular frequency `near`,
/// rad/s.
pub fn mode<M: RingFormulation<D, N>, const D: usize, const N: usize>(
    system: &RingSystem<M, D, N>,
    state: &State,
    near: f64,
) -> Mode {
    let mut system = system.clone();
    if M::LAGRANGIAN {
        // s follows from the other unknowns.
        let s = system.drift();
        system.held.push(s);
    }
    let n = state.y.len();
    let matrix = |system: &mut RingSystem<M, D, N>, alpha: f64, beta: f64| {
        let mut a = Arrow::new(system.shape());
        system.jacobian(0.0, state.view(), alpha, beta, &mut a);
        a
    };
    let (mass, stiffness) = (matrix(&mut system, 1.0, 0.0), matrix(&mut system, 0.0, 1.0));
    let mut factors = ArrowLu::new(system.shape());
    let mut omega2 = near * near;
    factors.factor(&matrix(&mut system, -omega2, 1.0)).unwrap();
    let mut random = noise(5);
    let mut v: Vec<f64> = (0..n).map(|_| random()).collect();
    let mut product = vec![0.0; n];
    let held = system.held.clone();
    let clear = |v: &mut [f64]| held.iter().for_each(|&i| v[i] = 0.0);
    for _ in 0..60 {
        clear(&mut v);
        mass.multiply(&v, &mut product);
        clear(&mut product);
        let norm = v.iter().zip(&product).map(|(a, b)| a * b).sum::<f64>().sqrt();
        v.iter_mut().for_each(|x| *x /= norm);
        stiffness.multiply(&v, &mut product);
        clear(&mut product);
        omega2 = v.iter().zip(&product).map(|(a, b)| a * b).sum();
        mass.multiply(&v, &mut product);
        clear(&mut product);
        factors.solve(&mut product);
        std::mem::swap(&mut v, &mut product);
    }
    Mode {
        omega: omega2.sqrt(),
        shape: v,
    }
}

/// Mean square extent along x less that along y, m²: zero when round.
pub fn ovality<M: RingFormulation>(system: &RingSystem<M>, state: &State) -> f64 {
    let length = system.model.length();
    let mean = |f: &dyn Fn(Vector2<f64>) -> f64| system.integrate(state.view(), |p| f(p.r)) / length;
    let (x, y) = (mean(&|r| r.x), mean(&|r| r.y));
    mean(&|r| (r.x - x).powi(2) - (r.y - y).powi(2))
}

/// Places of the nodes, m.
pub fn nodes<M: RingFormulation>(system: &RingSystem<M>, view: View<'_>) -> Vec<Vector2<f64>> {
    (0..system.model.elements())
        .map(|i| system.particle(view, i, -1.0).r)
        .collect()
}
