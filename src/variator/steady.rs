//! Steady states, solved for directly: the Eulerian view has them as fixed points.
//!
//! Pseudo-transient continuation from the kinematic state. The ratio is held by a stiff spring on Θ whose force is
//! moved to the reaction after each step, and its set point until the pressure-weighted radii have the wanted quotient.
//! A cold solution goes by way of a coarse mesh ([`super::refine`]).

use super::boundary::{Boundary, SheaveMode, SpeedMode};
use super::layout::Global;
use super::mesh::{P, S};
use super::parameters::Parameters;
use super::refine::{coarser, prolong};
use super::start::{Start, kinematic_state};
use super::system::VariatorSystem;
use crate::reference_curve::{GeometryError, ratio_of_theta};
use crate::solver::continuation::{Settled, Settling, Trial, settle};
use crate::solver::newton::Newton;
use crate::solver::{State, View};

/// A steady state to find.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyTask {
    /// i_g of the pressure-weighted radii.
    pub ratio: f64,
    /// The pulley, [`S`] or [`P`], whose clamping force follows from the ratio.
    pub reaction: usize,
    /// Clamping forces over pulleys, N; the reaction's entry is a first guess.
    pub clamping: [f64; 2],
    /// Shafts.
    pub speed: [SpeedMode; 2],
    /// First guess of the slip.
    pub slip: f64,
    /// The state at hand is a steady one near by: no grip to wait for.
    pub warm: bool,
}

/// Largest relative change of a speed, and change of Θ, in one pseudo-time step: beyond lies another branch (a pulley
/// that slips for ever).
const LARGEST_SPEED_CHANGE: f64 = 0.02;
const LARGEST_THETA_CHANGE: f64 = 0.02;

/// Time from which the state counts as steady, s: a belt revolution takes 0.05 s, ratio changes some seconds.
const LAST_STEP: f64 = 200.0;

/// Friction velocity that the solution starts with, m/s: stick and slip are then one smooth law, and the start-up does
/// not chatter between them. It is sharpened to the true one on the way.
const SOFT_VELOCITY: f64 = 0.05;
/// From a neighbouring state no further off in ln(ratio) than this, sharp friction is tried first, for so many Newton
/// solves.
const SHARP_WAY: f64 = 0.01;
const SHARP_SOLVES: usize = 30;
/// Factor of each sharpening.
const SHARPENING: f64 = 0.4;
/// Factor on the inertia of a pulley whose speed is solved for.
const PSEUDO_INERTIA: f64 = 40.0;
/// Pseudo-time step at which sharpening begins, and which it keeps, s.
const SOFT_STEP: f64 = 5.0e-3;

/// First pseudo-time step from a kinematic and from a steady state, s.
const COLD_STEP: f64 = 1.0e-6;
const WARM_STEP: f64 = 1.0e-2;
/// Force that an end stop carries where a sheave rests against it, N.
const STOP_FORCE: f64 = 10.0;
/// First pseudo-time step of sheaves that are let go, s.
const STOP_STEP: f64 = 1.0e-4;
/// Stages in which the force comes in there, one attempt after the other.
const STOP_STAGES: [u32; 2] = [1, 8];
/// Relative force error of an equilibrium.
const EQUILIBRIUM_TOLERANCE: f64 = 1.0e-6;
const EQUILIBRIUM_ITERATIONS: usize = 150;
/// Most Newton solves for one state on the way.
const EQUILIBRIUM_SOLVES: usize = 200;
/// Largest change of ln(ratio) between two states on the way: solved for anew, which takes as long from near as from
/// far; from the last one; in small changes, for which friction stays sharp. Each where the one before finds no state.
const COLD_RATIO_STEP: f64 = 0.5;
const LARGEST_RATIO_STEP: f64 = 0.05;
const SMALL_RATIO_STEP: f64 = 0.8 * SHARP_WAY;
/// Times in which the reaction force and the set point of Θ are corrected, s.
const FORCE_TIME: f64 = 0.02;
const RATIO_TIME: f64 = 0.2;

/// Finds the steady state from `state`, in place.
///
/// # Errors
/// What was reached, when there is no steady state near by; `state` is then the last one solved.
pub fn solve(
    system: &mut VariatorSystem,
    newton: &mut Newton,
    state: &mut State,
    task: &SteadyTask,
    max_solves: usize,
) -> Result<Settled, Settled> {
    let sharp = system.law.parameters.friction.velocity;
    let soft = sharp.max(SOFT_VELOCITY);
    let way = (task.ratio / geometric_ratio(system, state.view())).ln().abs();
    if task.warm && way < SHARP_WAY {
        let near = state.clone();
        if let Ok(settled) = solve_from(system, newton, state, task, SHARP_SOLVES.min(max_solves), sharp) {
            return Ok(settled);
        }
        *state = near;
    }
    if let (false, Some(parameters)) = (task.warm, coarser(&system.law.parameters)) {
        let mut nearby = state.clone();
        if start_on_coarse_mesh(system, newton, &mut nearby, &parameters, task, max_solves) {
            let task = SteadyTask { warm: true, ..*task };
            if let Ok(settled) = solve(system, newton, &mut nearby, &task, max_solves) {
                *state = nearby;
                return Ok(settled);
            }
        }
    }
    solve_from(system, newton, state, task, max_solves, soft)
}

/// The kinematic state at a task's ratio with shafts at `speeds`, rad/s, over pulleys.
fn cold(system: &VariatorSystem, task: &SteadyTask, speeds: [f64; 2]) -> Result<State, GeometryError> {
    let start = Start {
        ratio: task.ratio,
        primary_speed: speeds[P],
        clamping: task.clamping,
    };
    let mut state = kinematic_state(system, &start)?;
    for j in [S, P] {
        state.y[system.layout.global(Global::Speed, j)] = speeds[j];
    }
    Ok(state)
}

/// Moves a kinematic state near the steady one, as a mesh with fewer elements knows it; says whether there is one.
fn start_on_coarse_mesh(
    system: &VariatorSystem,
    newton: &mut Newton,
    state: &mut State,
    parameters: &Parameters,
    task: &SteadyTask,
    max_solves: usize,
) -> bool {
    let mut coarse = VariatorSystem::new(parameters);
    let speeds = [S, P].map(|j| state.y[system.layout.global(Global::Speed, j)]);
    let Ok(mut found) = cold(&coarse, task, speeds) else {
        return false;
    };
    let mut coarse_newton = Newton::new(&coarse);
    let outcome = solve(&mut coarse, &mut coarse_newton, &mut found, task, max_solves);
    newton.counts += coarse_newton.counts;
    if outcome.is_ok() {
        prolong(&coarse, &found, system, state);
    }
    outcome.is_ok()
}

/// [`solve`] with friction that is as soft as `velocity` at first, m/s.
fn solve_from(
    system: &mut VariatorSystem,
    newton: &mut Newton,
    state: &mut State,
    task: &SteadyTask,
    max_solves: usize,
    velocity: f64,
) -> Result<Settled, Settled> {
    let mut control = Control::new(system, state, task);
    system.boundary = control.boundary();
    let settings = Settling {
        time: 0.0,
        first_step: if task.warm { WARM_STEP } else { COLD_STEP },
        last_step: LAST_STEP,
        max_solves,
    };
    system.law.parameters.friction.velocity = velocity;
    system.inertia_factor = PSEUDO_INERTIA;
    let outcome = settle(system, newton, state, &settings, |system, trial| {
        control.judge(system, trial)
    });
    system.law.parameters.friction.velocity = control.sharp;
    system.inertia_factor = 1.0;
    outcome
}

/// What is moved on the way to a steady state: the reaction, the set point of Θ, the grip of the shafts, the softness
/// of friction.
struct Control<'a> {
    task: &'a SteadyTask,
    /// Clamping forces; the reaction's follows the force that holds the sheave, N.
    clamping: [f64; 2],
    /// Set point of Θ.
    theta: f64,
    /// Until the belt grips, both speeds are kept at a small slip: torque on a belt that does not yet grip leads to the
    /// branch where a pulley slips for ever.
    gripping: bool,
    /// The friction velocity to end with, m/s.
    sharp: f64,
}

impl<'a> Control<'a> {
    /// At the state to start from, which gets the first guess of the slip where a shaft's speed is solved for.
    fn new(system: &VariatorSystem, state: &mut State, task: &'a SteadyTask) -> Self {
        let mut clamping = task.clamping;
        if task.warm {
            let axial = system.surveyed(state.view()).sums.axial[task.reaction];
            clamping[task.reaction] = system.holding_force(task.reaction, state.view(), axial);
        }
        let free = [S, P].into_iter().find(|&j| task.speed[j] != SpeedMode::Fixed);
        if let (Some(j), false) = (free, task.warm) {
            let i = system.layout.global(Global::Speed, j);
            state.y[i] *= 1.0 - task.slip * if j == S { 1.0 } else { -1.0 };
        }
        Self {
            task,
            clamping,
            theta: state.q[system.layout.global(Global::Theta, 0)],
            gripping: free.is_none() || task.warm,
            sharp: system.law.parameters.friction.velocity,
        }
    }

    fn boundary(&self) -> Boundary {
        let reaction = self.task.reaction;
        let mut sheave = self.clamping.map(SheaveMode::Force);
        sheave[reaction] = SheaveMode::Ratio {
            theta: self.theta,
            force: self.clamping[reaction],
        };
        Boundary {
            sheave,
            speed: if self.gripping {
                self.task.speed
            } else {
                [SpeedMode::Fixed; 2]
            },
        }
    }

    /// Corrects the system after a solved step and says how long the next one may be; none refuses the step.
    fn judge(&mut self, system: &mut VariatorSystem, trial: &Trial<'_>) -> Option<f64> {
        if leaps(system, trial) {
            return None;
        }
        // Slower than the belt settles, or the two integrators would swing up against it.
        let gain = |time: f64| (trial.step / time).min(1.0);
        let reaction = self.task.reaction;
        let holding = system.holding_force(reaction, trial.after, system.belt_load(reaction));
        self.clamping[reaction] += (holding - self.clamping[reaction]) * gain(FORCE_TIME);
        let present = geometric_ratio(system, trial.after);
        self.theta += (ratio_of_theta(self.task.ratio) - ratio_of_theta(present)) * gain(RATIO_TIME);
        let soft = trial.step >= SOFT_STEP;
        let was_gripping = self.gripping;
        self.gripping |= soft;
        system.boundary = self.boundary();
        let velocity = &mut system.law.parameters.friction.velocity;
        if *velocity <= self.sharp {
            return Some(LAST_STEP);
        }
        if soft && was_gripping {
            *velocity = (*velocity * SHARPENING).max(self.sharp);
        }
        Some(SOFT_STEP)
    }
}

/// Whether a pseudo-time step changes speeds or Θ by more than leads to the same branch.
fn leaps(system: &VariatorSystem, trial: &Trial<'_>) -> bool {
    let fast = |j: usize| {
        let i = system.layout.global(Global::Speed, j);
        let (before, after) = (trial.before.y[i], trial.after.y[i]);
        (after - before).abs() > LARGEST_SPEED_CHANGE * before.abs() + 0.1
    };
    let theta = system.layout.global(Global::Theta, 0);
    fast(S) || fast(P) || (trial.after.q[theta] - trial.before.q[theta]).abs() > LARGEST_THETA_CHANGE
}

/// Lets go of the sheaves near an end stop: under the task's clamping forces they come to rest against it. A force far
/// from what holds the sheave comes in by stages.
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
    let holding = reaction(system, state.view(), task.reaction).max(1.0);
    let before = state.clone();
    let mut outcome = Err(Settled::default());
    for stages in STOP_STAGES {
        state.clone_from(&before);
        outcome = (1..=stages).try_fold(Settled::default(), |_, stage| {
            let mut clamping = task.clamping;
            let force = &mut clamping[task.reaction];
            *force = holding * (*force / holding).powf(f64::from(stage) / f64::from(stages));
            system.boundary = Boundary {
                sheave: clamping.map(SheaveMode::Force),
                speed: task.speed,
            };
            settle(system, newton, state, &settings, |system, trial| {
                (!leaps(system, trial)).then_some(LAST_STEP)
            })
        });
        if outcome.is_ok() {
            break;
        }
    }
    outcome
}

/// Where the clamping forces balance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equilibrium {
    /// r_S/r_P of the pressure-weighted radii.
    pub ratio: f64,
    /// Whether a sheave rests against its end stop.
    pub at_stop: bool,
}

impl Equilibrium {
    fn at(system: &VariatorSystem, view: View<'_>) -> Self {
        let carries = |j: usize| system.holding_force(j, view, 0.0).abs();
        Self {
            ratio: geometric_ratio(system, view),
            at_stop: carries(S).max(carries(P)) > STOP_FORCE,
        }
    }
}

/// Finds the ratio at which the task's reaction is exactly its clamping force, from a steady state at the task's ratio:
/// secant method on ln(force/reaction) over ln(ratio), each state solved for anew or, where it is near, from the last. At
/// the ends of `range`, where the sheaves are near their stops, they are let go.
///
/// # Errors
/// What was reached, when a state on the way could not be found, or the forces don't balance in the end.
pub fn solve_equilibrium(
    system: &mut VariatorSystem,
    newton: &mut Newton,
    state: &mut State,
    task: &SteadyTask,
    range: (f64, f64),
) -> Result<Equilibrium, Settled> {
    let reaction = task.reaction;
    let wanted = task.clamping[reaction].max(1.0);
    let defect = |system: &VariatorSystem, state: &State| {
        (wanted / self::reaction(system, state.view(), reaction).max(1.0)).ln()
    };
    let (lowest, highest) = (range.0.ln(), range.1.ln());
    let mut x = task.ratio.ln();
    let mut f = defect(system, state);
    // More force on P lowers the ratio; ln i_F falls by about 0.5 per unit of ln i.
    let mut slope = if reaction == P { 0.5 } else { -0.5 };
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
            let [s, p] = [S, P].map(|j| state.y[system.layout.global(Global::Speed, j)]);
            let fixed = task.speed[S] == SpeedMode::Fixed;
            if let Ok(found) = cold(system, &there, [if fixed { s } else { p / there.ratio }, p]) {
                *state = found;
            }
        }
        match solve(system, newton, state, &there, EQUILIBRIUM_SOLVES) {
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

/// Clamping force on pulley `j` that would hold its sheave where it is, N.
#[must_use]
pub fn reaction(system: &VariatorSystem, view: View<'_>, j: usize) -> f64 {
    system.holding_force(j, view, system.surveyed(view).sums.axial[j])
}

/// r_S/r_P of the pressure-weighted pitch radii; the reference curve's where nothing presses.
#[must_use]
pub fn geometric_ratio(system: &VariatorSystem, view: View<'_>) -> f64 {
    let sums = system.surveyed(view).sums;
    let radii = system.mean_radii(view, &sums);
    radii[S] / radii[P]
}
