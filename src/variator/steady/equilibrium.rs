//! The ratio at which the clamping forces balance.

use crate::pulley::Pulley;
use crate::solver::State;
use crate::solver::continuation::{Settled, Settling, settle};
use crate::solver::newton::Newton;
use crate::variator::pulleys::loads::{Boundary, Loads, ShaftMode, SheaveMode};
use crate::variator::steady::solve::{FIRST_STEP, LAST_STEP, NEAR, SteadyTask, cold_start, reaction, solve};
use crate::variator::system::VariatorSystem;

/// Relative force error of an equilibrium.
const TOLERANCE: f64 = 1.0e-6;

/// Number of stages in which the force is applied to a sheave that comes to rest at its end stop.
const STOP_STAGES: i32 = 8;

/// Largest change of ln(ratio) from one state to the next, both solved for from the kinematic one: a small change needs as many solves
/// as a large one. Where there is no such state, it is [`NEAR`], from the last state.
const FAR: f64 = 0.5;

/// Finds the ratio at which the task's reaction is exactly its clamping force, from a steady state at the task's ratio:
/// secant method on ln(force/reaction) over ln(ratio), each state solved for from the kinematic one or, where it is near,
/// from the last. At the ends of `range`, where the sheaves are near their stops, they are released. Whether a sheave then rests
/// against its end stop.
///
/// # Errors
/// The report of the last solution, if an intermediate state was not found or the forces don't balance in the end.
pub fn solve_equilibrium(
    system: &mut VariatorSystem,
    newton: &mut Newton,
    state: &mut State,
    task: &SteadyTask,
    range: (f64, f64),
    max_solves: usize,
) -> Result<bool, Settled> {
    let defect = |system: &VariatorSystem, state: &State| {
        let push = system.pulleys().push(task.reaction, state.view());
        let holding = reaction(system, state.view(), task.reaction);
        ((task.clamping[task.reaction] + push).max(1.0) / (holding + push).max(1.0)).ln()
    };
    let (lowest, highest) = (range.0.ln(), range.1.ln());
    let mut x = task.ratio.ln();
    let mut f = defect(system, state);
    // More force on P lowers the ratio; ln i_F falls by about 0.5 per unit of ln i.
    let mut slope = if task.reaction == Pulley::Primary { 0.5 } else { -0.5 };
    let mut longest = FAR;
    let mut last = Settled::default();
    for _ in 0..max_solves {
        if f.abs() < TOLERANCE {
            return Ok(is_at_stop(system, state));
        }
        let wanted = x - (f / slope).clamp(-longest, longest);
        let next = wanted.clamp(lowest, highest);
        if next != wanted && (next - x).abs() < 1.0e-9 {
            rest_at_stop(system, newton, state, task, max_solves)?;
            return Ok(is_at_stop(system, state));
        }
        let there = SteadyTask {
            ratio: next.exp(),
            warm: (next - x).abs() <= NEAR,
            ..*task
        };
        let mut trial = state.clone();
        if !there.warm {
            restart(system, &mut trial, &there);
        }
        match solve(system, newton, &mut trial, &there, max_solves) {
            Ok(report) => last = report,
            Err(report) if longest == NEAR => return Err(report),
            Err(_) => {
                longest = NEAR;
                continue;
            }
        }
        *state = trial;
        let reached = defect(system, state);
        let secant = (reached - f) / (next - x);
        if secant * slope > 0.0 {
            slope = secant;
        }
        (x, f) = (next, reached);
    }
    Err(last)
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

/// Releases the sheaves near an end stop: under the task's clamping forces they come to rest against it. The force, which may be
/// far from the holding force, is applied by stages.
fn rest_at_stop(
    system: &mut VariatorSystem,
    newton: &mut Newton,
    state: &mut State,
    task: &SteadyTask,
    max_solves: usize,
) -> Result<Settled, Settled> {
    let settings = Settling {
        time: 0.0,
        first_step: FIRST_STEP,
        last_step: LAST_STEP,
        max_solves,
    };
    let push = system.pulleys().push(task.reaction, state.view());
    let holding = (reaction(system, state.view(), task.reaction) + push).max(1.0);
    let whole = (task.clamping[task.reaction] + push).max(0.0) / holding;
    (1..=STOP_STAGES).try_fold(Settled::default(), |_, stage| {
        let mut clamping = task.clamping;
        clamping[task.reaction] = holding * whole.powf(f64::from(stage) / f64::from(STOP_STAGES)) - push;
        system.loads = Loads::Constant(Boundary {
            sheave: clamping.map(SheaveMode::Force),
            shaft: task.shaft,
        });
        settle(system, newton, state, &settings, |_, _| Some(LAST_STEP))
    })
}
