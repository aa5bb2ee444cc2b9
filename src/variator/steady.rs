//! Steady states, solved for directly: the Eulerian view has them as fixed points.
//!
//! Pseudo-transient continuation from the kinematic state. The ratio is held by a stiff spring on Θ whose force is moved
//! to the reaction after each step, and its set point until the pressure-weighted radii have the wanted quotient.

use super::layout::Global;
use super::mesh::{P, S};
use super::system::{Boundary, SheaveMode, SpeedMode, State, VariatorSystem};
use crate::reference_curve::ratio_of_theta;
use crate::solver::View;
use crate::solver::continuation::{Settled, Settling, Trial, settle};
use crate::solver::newton::Newton;

/// What the ratio of a steady state is determined by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RatioTask {
    /// The geometric ratio is given; pulley `reaction`'s clamping force follows.
    Given {
        /// i_g of the pressure-weighted radii.
        ratio: f64,
        /// [`S`] or [`P`].
        reaction: usize,
    },
    /// Both clamping forces are given; the ratio follows, or an end stop.
    Equilibrium,
}

/// A steady state to find.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyTask {
    /// Ratio.
    pub ratio: RatioTask,
    /// Clamping forces over pulleys, N; the reaction's entry is a first guess.
    pub clamping: [f64; 2],
    /// Shafts.
    pub speed: [SpeedMode; 2],
}

/// Largest relative change of a speed, and change of Θ, in one pseudo-time step: beyond lies another branch (a pulley
/// that slips for ever).
const LARGEST_SPEED_CHANGE: f64 = 0.02;
const LARGEST_THETA_CHANGE: f64 = 0.02;

/// Time from which the state counts as steady, s: a belt revolution takes 0.05 s, ratio changes some seconds.
const LAST_STEP: f64 = 200.0;

/// Finds the steady state from `state`, in place.
///
/// # Errors
/// What was reached, when there is no steady state near by; `state` is then the last one solved.
pub fn solve(system: &mut VariatorSystem, newton: &mut Newton, state: &mut State, task: &SteadyTask, max_solves: usize) -> Result<Settled, Settled> {
    let layout = system.layout;
    let theta_index = layout.global(Global::Theta, 0);
    let mut clamping = task.clamping;
    let mut theta = state.q[theta_index];
    let boundary = |clamping: [f64; 2], theta: f64| {
        let mut sheave = clamping.map(SheaveMode::Force);
        if let RatioTask::Given { reaction, .. } = task.ratio {
            sheave[reaction] = SheaveMode::Ratio {
                theta,
                force: clamping[reaction],
            };
        }
        Boundary {
            sheave,
            speed: task.speed,
        }
    };
    system.boundary = boundary(clamping, theta);
    let settings = Settling {
        first_step: 1.0e-6,
        last_step: LAST_STEP,
        max_solves,
    };
    let State { y, y_dot, q } = state;
    let judge = |system: &mut VariatorSystem, trial: &Trial<'_>| {
        for j in [S, P] {
            let i = layout.global(Global::Speed, j);
            let (before, after) = (trial.before.y[i], trial.after.y[i]);
            if (after - before).abs() > LARGEST_SPEED_CHANGE * before.abs() + 0.1 {
                return false;
            }
        }
        if (trial.after.q[theta_index] - trial.before.q[theta_index]).abs() > LARGEST_THETA_CHANGE {
            return false;
        }
        if let RatioTask::Given { ratio, reaction } = task.ratio {
            clamping[reaction] = system.belt_load(reaction).0.max(0.0);
            if trial.step > 1.0e-3 {
                let present = geometric_ratio(system, trial.after);
                theta += ratio_of_theta(ratio) - ratio_of_theta(present);
            }
            system.boundary = boundary(clamping, theta);
        }
        true
    };
    settle(system, newton, y, y_dot, q, &settings, judge)
}

/// r_S/r_P of the pressure-weighted pitch radii; the reference curve's where nothing presses.
#[must_use]
pub fn geometric_ratio(system: &VariatorSystem, view: View<'_>) -> f64 {
    let sums = system.belt_sums::<false>(view);
    let radii = system.mean_radii(view, &sums);
    radii[S] / radii[P]
}
