//! The ratio at which the clamping forces balance.

use crate::pulley::Pulley;
use crate::solver::State;
use crate::solver::continuation::Settled;
use crate::variator::pulleys::loads::{Boundary, ShaftMode, SheaveMode};
use crate::variator::steady::solve::{SteadySolver, SteadyTask, cold_start, reaction};
use crate::variator::steady::{FORCE_ERROR, MOST_SOLVES, STEADY_TIME};
use crate::variator::system::VariatorSystem;

impl SteadySolver<'_> {
    /// Finds the ratio at which the task's reaction is exactly its clamping force, from a steady state at the task's ratio:
    /// secant method on ln(force/reaction) over ln(ratio), each state solved for from the last. At the ends of `range`,
    /// where the sheaves are near their stops, they are released. Whether a sheave then rests against its end stop.
    ///
    /// # Errors
    /// The report of the last solution, if an intermediate state was not found or the forces don't balance in the end.
    pub fn balance(&mut self, state: &mut State, task: &SteadyTask, range: (f64, f64)) -> Result<bool, Settled> {
        let defect = |system: &VariatorSystem, state: &State| {
            let push = system.pulleys().push(task.reaction, state.view());
            let holding = reaction(system, state.view(), task.reaction);
            ((task.clamping[task.reaction] + push).max(1.0) / (holding + push).max(1.0)).ln()
        };
        let (lowest, highest) = (range.0.ln(), range.1.ln());
        let mut x = task.ratio.ln();
        let mut f = defect(self.system, state);
        // More force on P lowers the ratio; ln i_F falls by about 0.5 per unit of ln i.
        let mut slope = if task.reaction == Pulley::Primary { 0.5 } else { -0.5 };
        let mut last = Settled::default();
        for _ in 0..MOST_SOLVES {
            if f.abs() < FORCE_ERROR {
                return Ok(is_at_stop(self.system, state));
            }
            let wanted = x - f / slope;
            let next = wanted.clamp(lowest, highest);
            if next != wanted && (next - x).abs() < 1.0e-9 {
                self.rest_at_stop(state, task)?;
                return Ok(is_at_stop(self.system, state));
            }
            let there = SteadyTask {
                ratio: next.exp(),
                ..*task
            };
            restart(self.system, state, &there);
            last = self.solve(state, &there)?;
            let reached = defect(self.system, state);
            let secant = (reached - f) / (next - x);
            if secant * slope > 0.0 {
                slope = secant;
            }
            (x, f) = (next, reached);
        }
        Err(last)
    }

    /// Releases the sheaves near an end stop: under the task's clamping forces they come to rest against it.
    fn rest_at_stop(&mut self, state: &mut State, task: &SteadyTask) -> Result<Settled, Settled> {
        let boundary = Boundary {
            sheave: task.clamping.map(SheaveMode::Force),
            shaft: task.shaft,
        };
        self.settle(state, boundary, |_, _| Some(STEADY_TIME))
    }
}

fn is_at_stop(system: &VariatorSystem, state: &State) -> bool {
    let reached = |pulley| system.pulleys().stop_reached(pulley, state.view()).is_some();
    Pulley::BOTH.into_iter().any(reached)
}

/// Replaces a state by the kinematic one at the ratio of the task, if there is one.
fn restart(system: &VariatorSystem, state: &mut State, task: &SteadyTask) {
    let mut speeds = system.belt.shaft_speeds(state.view());
    if task.shaft.secondary != ShaftMode::Fixed {
        speeds.secondary = speeds.primary / task.ratio;
    }
    if let Ok(found) = cold_start(system, task, speeds) {
        *state = found;
    }
}
