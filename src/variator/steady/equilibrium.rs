//! The ratio at which the clamping forces balance.

use crate::pulley::Pulley;
use crate::solver::continuation::{Settled, Settling, settle};
use crate::solver::newton::Newton;
use crate::solver::{State, View};
use crate::variator::pulleys::loads::{Boundary, Loads, ShaftMode, SheaveMode};
use crate::variator::steady::solve::{self, LAST_STEP, SHARP_WAY, SteadyTask, cold_start, geometric_ratio};
use crate::variator::system::VariatorSystem;

/// Force that an end stop carries where a sheave rests against it, N.
const STOP_FORCE: f64 = 10.0;

/// First pseudo-time step of sheaves that are released, s.
const STOP_STEP: f64 = 1.0e-4;

/// Numbers of stages in which the force is applied there, one for each attempt.
const STOP_STAGES: [u32; 2] = [1, 8];

/// Relative force error of an equilibrium.
const EQUILIBRIUM_TOLERANCE: f64 = 1.0e-6;

/// Most steps of the secant method.
const EQUILIBRIUM_ITERATIONS: usize = 150;

/// Most Newton solves for one intermediate state.
const EQUILIBRIUM_SOLVES: usize = 200;

/// Largest change of ln(ratio) to a state that is solved for from the kinematic one. A small change needs as many solves as
/// a large one.
const COLD_RATIO_STEP: f64 = 0.5;

/// Largest change of ln(ratio) to a state that is solved for from the last one, where there is none by [`COLD_RATIO_STEP`].
const LARGEST_RATIO_STEP: f64 = 0.05;

/// Largest change of ln(ratio) with the specified friction velocity, where there is no state by [`LARGEST_RATIO_STEP`].
const SMALL_RATIO_STEP: f64 = 0.8 * SHARP_WAY;

/// Releases the sheaves near an end stop: under the task's clamping forces they come to rest against it. A force that is
/// far from the holding force is applied by stages.
fn rest_at_stop(
    system: &mut VariatorSystem,
    newton: &mut Newton,
    state: &mut State,
    task: &SteadyTask,
) -> Result<Settled, Settled> {
    let settings = Settling {
        time: 0.0,
        first_step: STOP_STEP,
        last_step: LAST_STEP,
        max_solves: EQUILIBRIUM_SOLVES,
    };
    let push = system.pulleys().push(task.reaction, state.view());
    let holding = (solve::reaction(system, state.view(), task.reaction) + push).max(1.0);
    let before = state.clone();
    let mut outcome = Err(Settled::default());
    for stages in STOP_STAGES {
        state.clone_from(&before);
        outcome = (1..=stages).try_fold(Settled::default(), |_, stage| {
            let mut clamping = task.clamping;
            let force = &mut clamping[task.reaction];
            let share = ((*force + push).max(0.0) / holding).powf(f64::from(stage) / f64::from(stages));
            *force = holding * share - push;
            system.loads = Loads::Constant(Boundary {
                sheave: clamping.map(SheaveMode::Force),
                shaft: task.shaft,
            });
            settle(system, newton, state, &settings, |_, _| Some(LAST_STEP))
        });
        if outcome.is_ok() {
            break;
        }
    }
    outcome
}

/// The state in which the clamping forces balance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equilibrium {
    /// r_S/r_P of the pressure-weighted radii.
    pub ratio: f64,
    /// Whether a sheave rests against its end stop.
    pub at_stop: bool,
}

impl Equilibrium {
    fn at(system: &VariatorSystem, view: View<'_>) -> Self {
        let carries = |pulley| system.pulleys().stop_force(pulley, view).abs();
        Self {
            ratio: geometric_ratio(system, view),
            at_stop: carries(Pulley::Secondary).max(carries(Pulley::Primary)) > STOP_FORCE,
        }
    }
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

/// Finds the ratio at which the task's reaction is exactly its clamping force, from a steady state at the task's ratio:
/// secant method on ln(force/reaction) over ln(ratio), each state solved for from the kinematic one or, where it is near,
/// from the last. At the ends of `range`, where the sheaves are near their stops, they are released.
///
/// # Errors
/// The report of the last solution, if an intermediate state was not found or the forces don't balance in the end.
pub fn solve_equilibrium(
    system: &mut VariatorSystem,
    newton: &mut Newton,
    state: &mut State,
    task: &SteadyTask,
    range: (f64, f64),
) -> Result<Equilibrium, Settled> {
    let reaction = task.reaction;
    let defect = |system: &VariatorSystem, state: &State| {
        let push = system.pulleys().push(reaction, state.view());
        let [wanted, holding] = [task.clamping[reaction], solve::reaction(system, state.view(), reaction)];
        ((wanted + push).max(1.0) / (holding + push).max(1.0)).ln()
    };
    let (lowest, highest) = (range.0.ln(), range.1.ln());
    let mut x = task.ratio.ln();
    let mut f = defect(system, state);
    // More force on P lowers the ratio; ln i_F falls by about 0.5 per unit of ln i.
    let mut slope = if reaction == Pulley::Primary { 0.5 } else { -0.5 };
    let (mut longest, mut shorter) = (COLD_RATIO_STEP, [LARGEST_RATIO_STEP, SMALL_RATIO_STEP].into_iter());
    let mut near = state.clone();
    let mut last = Settled::default();
    for _ in 0..EQUILIBRIUM_ITERATIONS {
        if f.abs() < EQUILIBRIUM_TOLERANCE {
            return Ok(Equilibrium::at(system, state.view()));
        }
        let wanted = x - (f / slope).clamp(-longest, longest);
        let next = wanted.clamp(lowest, highest);
        if next != wanted && (next - x).abs() < 1.0e-9 {
            rest_at_stop(system, newton, state, task)?;
            return Ok(Equilibrium::at(system, state.view()));
        }
        let there = SteadyTask {
            ratio: next.exp(),
            warm: (next - x).abs() <= LARGEST_RATIO_STEP,
            ..*task
        };
        if !there.warm {
            restart(system, state, &there);
        }
        match solve::solve(system, newton, state, &there, EQUILIBRIUM_SOLVES) {
            Ok(report) => last = report,
            Err(report) => {
                longest = shorter.next().ok_or(report)?;
                state.clone_from(&near);
                continue;
            }
        }
        near.clone_from(state);
        let reached = defect(system, state);
        let secant = (reached - f) / (next - x);
        if secant * slope > 0.0 {
            slope = secant;
        }
        (x, f) = (next, reached);
    }
    Err(last)
}
