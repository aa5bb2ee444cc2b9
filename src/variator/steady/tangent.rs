//! The tangent of steady states over parameters and loads, for their derivatives.
//!
//! A steady state x solves F(x, λ, p) = 0 and g(x, p) = 0. λ is the force of the reacting pulley,
//! and g what it holds: the ratio, or its own clamping force. Newton's method for both is a bordered
//! system, solved by block elimination with the factors of one Jacobian:
//!
//!   dx = −J⁻¹ F + dx/dλ dλ,   dx/dλ = −J⁻¹ ∂F/∂λ,   dλ = −g/(dg/dx dx/dλ)
//!
//! J is that of implicit Euler over `STEADY_TIME`, which keeps the total content of the elements.
//! With it states beside this one are solved in two or three corrections.

use super::solve::{SteadyTask, geometric_ratio, hold, reaction, unbalance};
use super::{FEW_SOLVES, FORCE_ERROR, NEGLIGIBLE, STEADY_TIME};
use crate::solver::arrow::{Arrow, ArrowLu};
use crate::solver::continuation::NotSteady;
use crate::solver::{State, System};
use crate::variator::belt::Belt;
use crate::variator::pulleys::loads::{Loads, SheaveMode};
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
    /// At a steady state of a task, which its ratio or, with `balance`, both clamping forces hold;
    /// none where the Jacobian is singular. The state is solved more accurately before: an error of
    /// its ratio of 3e-7 is one of 1 % of small derivatives.
    pub fn new(
        system: &mut VariatorSystem,
        state: &mut State,
        task: &SteadyTask,
        balance: bool,
    ) -> Option<Self> {
        hold(system, state, task);
        let mut first = Self::at(system, state, task, balance)?;
        first.settle(system, state, task).ok()?;
        Self::at(system, state, task, balance)
    }

    fn at(system: &mut VariatorSystem, state: &State, task: &SteadyTask, balance: bool) -> Option<Self> {
        let mut matrix = Arrow::new(system.shape());
        system.jacobian(0.0, state.view(), 1.0 / STEADY_TIME, STEADY_TIME, &mut matrix);
        let mut factors = ArrowLu::new(system.shape());
        factors.factor(&matrix).ok()?;
        let mut along = vec![0.0; state.y.len()];
        along[system.belt.layout.sheave(task.reaction)] = 1.0;
        factors.solve(&mut along);
        let mut tangent = Self {
            factors,
            balance,
            along,
            slope: 1.0,
        };
        let step = FORCE_ERROR * reaction(system, state.view(), task.reaction).abs().max(1.0);
        let [after, before] = [step, -step].map(|force| {
            let mut state = state.clone();
            advance(&system.belt, &mut state, &tangent.along, force);
            tangent.defect(system, &state, task)
        });
        tangent.slope = (after - before) / (2.0 * step);
        Some(tangent)
    }

    /// Solves for a steady state beside this one, until two corrections are negligible.
    ///
    /// # Errors
    /// The state is not near enough.
    pub fn settle(
        &mut self,
        system: &mut VariatorSystem,
        state: &mut State,
        task: &SteadyTask,
    ) -> Result<(), NotSteady> {
        hold(system, state, task);
        let mut step = vec![0.0; state.y.len()];
        let mut before = f64::INFINITY;
        for _ in 0..FEW_SOLVES {
            system.residual(0.0, state.view(), &mut step);
            self.factors.solve(&mut step);
            advance(&system.belt, state, &step, -1.0);
            let defect = self.defect(system, state, task);
            let force = -defect / self.slope;
            advance(&system.belt, state, &self.along, force);
            if let Loads::Steady(boundary) = &mut system.loads
                && let SheaveMode::Ratio { force: holding, .. } = &mut boundary.sheave[task.reaction]
            {
                *holding += force;
            }
            if defect.abs().max(before) < NEGLIGIBLE {
                return Ok(());
            }
            before = defect.abs();
        }
        Err(NotSteady::default())
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
/// the positions over `STEADY_TIME`.
fn advance(belt: &Belt, state: &mut State, step: &[f64], factor: f64) {
    for (i, change) in step.iter().enumerate() {
        if belt.has_position[i] && i != belt.layout.drift() {
            state.q[i] += factor * change * STEADY_TIME;
        } else {
            state.y[i] += factor * change;
        }
    }
}
