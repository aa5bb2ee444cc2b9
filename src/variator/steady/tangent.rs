//! The tangent of steady states over parameters and loads, for their derivatives.
//!
//! A steady state x solves F(x, p) = 0 and g(x, p) = 0, where g is what the force λ of the reacting
//! pulley holds: the ratio, or its own clamping force. So
//!
//!   ∂F/∂x dx + ∂F/∂λ dλ + ∂F/∂p dp = 0,   dg = 0
//!
//! is a bordered system, solved by block elimination with the factors of one Jacobian. It is that of
//! implicit Euler over [`TANGENT_TIME`], which keeps the total content of the elements.

use super::solve::{SteadyTask, geometric_ratio, unbalance};
use super::{TANGENT_FORCE, TANGENT_TIME};
use crate::solver::arrow::{Arrow, ArrowLu, Singular};
use crate::solver::{State, System};
use crate::variator::belt::Belt;
use crate::variator::system::VariatorSystem;

/// Factors of the bordered Jacobian of a steady state.
#[derive(Clone, Debug)]
pub struct Tangent {
    factors: ArrowLu,
    /// Whether the clamping force is held, not the ratio.
    balance: bool,
    /// dx/dλ.
    along: Vec<f64>,
    /// dg/dλ, 1/N.
    slope: f64,
}

impl Tangent {
    /// At a steady state of a system under its loads.
    pub(super) fn new(
        system: &mut VariatorSystem,
        state: &State,
        task: &SteadyTask,
        balance: bool,
    ) -> Result<Self, Singular> {
        let mut matrix = Arrow::new(system.shape());
        system.jacobian(0.0, state.view(), 1.0 / TANGENT_TIME, TANGENT_TIME, &mut matrix);
        let mut factors = ArrowLu::new(system.shape());
        factors.factor(&matrix)?;
        let mut along = vec![0.0; state.y.len()];
        along[system.belt.layout.sheave(task.reaction)] = 1.0;
        factors.solve(&mut along);
        let mut tangent = Self {
            factors,
            balance,
            along,
            slope: 1.0,
        };
        let [after, before] = [TANGENT_FORCE, -TANGENT_FORCE].map(|force| {
            let mut state = state.clone();
            advance(&system.belt, &mut state, &tangent.along, force);
            tangent.defect(system, &state, task)
        });
        tangent.slope = (after - before) / (2.0 * TANGENT_FORCE);
        Ok(tangent)
    }

    /// Newton's correction of a state near by with the factors of this one.
    pub(super) fn correct(&self, system: &mut VariatorSystem, state: &mut State, task: &SteadyTask) {
        let mut step = vec![0.0; state.y.len()];
        system.residual(0.0, state.view(), &mut step);
        self.factors.clone().solve(&mut step);
        advance(&system.belt, state, &step, -1.0);
        let force = -self.defect(system, state, task) / self.slope;
        advance(&system.belt, state, &self.along, force);
    }

    /// g.
    fn defect(&self, system: &VariatorSystem, state: &State, task: &SteadyTask) -> f64 {
        if self.balance {
            unbalance(system, state, task)
        } else {
            (geometric_ratio(system, state.view()) / task.ratio).ln()
        }
    }
}

/// Moves a state by a multiple of a step of Newton's method. Its velocities are left out: they move
/// the positions over [`TANGENT_TIME`].
fn advance(belt: &Belt, state: &mut State, step: &[f64], factor: f64) {
    for (i, change) in step.iter().enumerate() {
        if belt.has_position[i] && i != belt.layout.drift() {
            state.q[i] += factor * change * TANGENT_TIME;
        } else {
            state.y[i] += factor * change;
        }
    }
}
