//! Steady states, solved directly: in the Eulerian description they are fixed points.
//!
//! Pseudo-transient continuation from the kinematic state. A stiff spring on Θ holds the ratio. After each step its force is
//! moved to the reaction, and its set point until the pressure-weighted radii have the specified ratio. A solution from the
//! kinematic state starts on a coarse mesh (`refine`).

use crate::pulley::{PerPulley, Pulley};
use crate::reference_curve::{GeometryError, ratio_of_theta};
use crate::solver::continuation::{Settled, Settling, Trial, settle};
use crate::solver::newton::Newton;
use crate::solver::{State, View};
use crate::variator::belt::Belt;
use crate::variator::diagnostics::belt::BeltDiagnostics;
use crate::variator::pulleys::loads::{Boundary, Loads, ShaftMode, SheaveMode};
use crate::variator::steady::refine::{coarser, prolong};
use crate::variator::steady::start::{Start, kinematic_state};
use crate::variator::system::VariatorSystem;

/// A steady state to find.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyTask {
    /// i_g of the pressure-weighted radii.
    pub ratio: f64,
    /// The pulley whose clamping force follows from the ratio.
    pub reaction: Pulley,
    /// Forces of clamp and pressure, N; the reaction's entry is a first guess.
    pub clamping: PerPulley<f64>,
    /// Conditions of the shafts.
    pub shaft: PerPulley<ShaftMode>,
    /// First guess of the slip.
    pub slip: f64,
    /// The initial state is a neighbouring steady one, so the belt already grips.
    pub warm: bool,
}

impl SteadyTask {
    /// The pulley whose speed is solved for, if any.
    fn free(&self) -> Option<Pulley> {
        Pulley::BOTH
            .into_iter()
            .find(|&pulley| self.shaft[pulley] != ShaftMode::Fixed)
    }
}

/// First pseudo-time step, s: 5 to 13 % less work than with 1e-2 from a steady state and 1e-6 from the kinematic one.
pub(super) const FIRST_STEP: f64 = 1.0e-3;
/// Pseudo-time step from which on the friction velocity is reduced, and which is kept meanwhile, s. With [`FIRST_STEP`] instead, one start in
/// a hundred is not found.
const SOFT_STEP: f64 = 5.0e-3;

/// Time from which the state counts as steady, s: a belt revolution lasts 0.05 s, a ratio change some seconds.
pub(super) const LAST_STEP: f64 = 200.0;

/// Friction velocity that the solution starts with, m/s: stick and slip are then one smooth law, and Newton's method does
/// not alternate between them. And the factor of each reduction, down to the specified one.
const SOFT_VELOCITY: f64 = 0.05;
const SHARPENING: f64 = 0.4;

/// Clamping force below which a belt may be too loose to be found from a kinematic state, N, and the factor of the force whose steady state
/// is then solved for first: without, three of nine stiff belts are not found.
const FIRM: f64 = 1.0e4;
const FIRMER: f64 = 3.0;

/// Distance in ln(ratio) of a neighbouring state, from which the specified friction velocity is tried first: without, 5 to 15 % more work.
pub(super) const NEAR: f64 = 0.02;

/// Factor on the inertia of a pulley whose speed is solved for: a tenth more work without, and one start in a hundred is not found.
const PSEUDO_INERTIA: f64 = 40.0;

/// Slip of a shaft whose speed is solved for, beyond which its pulley has run away: only drag would limit its speed, at many
/// times the specified one. Without it, half of the starts beyond capacity end in such a state.
const RUN_AWAY: f64 = 0.3;

/// Times in which the reaction force and the set point of Θ are corrected, s: 1 to 9 % more work with 0.05 s for both.
const FORCE_TIME: f64 = 0.02;
const RATIO_TIME: f64 = 0.2;

/// Finds the steady state from `state`, in place.
///
/// # Errors
/// The report of the solution, when there is no steady state near by; `state` is then the last one solved.
pub fn solve(
    system: &mut VariatorSystem,
    newton: &mut Newton,
    state: &mut State,
    task: &SteadyTask,
    max_solves: usize,
) -> Result<Settled, Settled> {
    let sharp = system.parameters.friction.velocity;
    let from_there = SteadyTask { warm: true, ..*task };
    let mut near = state.clone();
    if task.warm {
        let way = (task.ratio / geometric_ratio(system, state.view())).ln().abs();
        if way < NEAR
            && let Ok(settled) = continuation(system, newton, &mut near, task, max_solves, sharp)
        {
            *state = near;
            return Ok(settled);
        }
        return continuation(system, newton, state, task, max_solves, sharp.max(SOFT_VELOCITY));
    }
    for start in [start_on_coarse_mesh, start_at_firmer_force] {
        near.copy_from(state);
        if start(system, newton, &mut near, task, max_solves)
            && let Ok(settled) = solve(system, newton, &mut near, &from_there, max_solves)
        {
            *state = near;
            return Ok(settled);
        }
    }
    continuation(system, newton, state, task, max_solves, sharp.max(SOFT_VELOCITY))
}

/// The kinematic state at a task's ratio with shafts at `speeds`, rad/s.
pub(super) fn cold_start(
    system: &VariatorSystem,
    task: &SteadyTask,
    speeds: PerPulley<f64>,
) -> Result<State, GeometryError> {
    let belt = &system.belt;
    let pushes = system.parameters.pushes([task.ratio, speeds.primary]);
    let start = Start {
        ratio: task.ratio,
        primary_speed: speeds.primary,
        clamping: PerPulley::from_fn(|pulley| task.clamping[pulley] + pushes[pulley]),
    };
    let mut state = kinematic_state(belt, &start)?;
    for pulley in Pulley::BOTH {
        state.y[belt.layout.shaft_speed(pulley)] = speeds[pulley];
    }
    Ok(state)
}

/// Moves a kinematic state of a loose belt to the steady one under a firmer clamping force; returns whether there is one. Not on the coarse
/// mesh itself, which is solved for directly.
fn start_at_firmer_force(
    system: &mut VariatorSystem,
    newton: &mut Newton,
    state: &mut State,
    task: &SteadyTask,
    max_solves: usize,
) -> bool {
    let firmer = SteadyTask {
        clamping: task.clamping.map(|force| FIRMER * force),
        ..*task
    };
    let is_loose = task.clamping[task.reaction.other()] < FIRM && coarser(&system.parameters).is_some();
    is_loose && solve(system, newton, state, &firmer, max_solves).is_ok()
}

/// Moves a kinematic state near the steady one of a mesh with fewer elements; returns whether there is one.
fn start_on_coarse_mesh(
    system: &mut VariatorSystem,
    newton: &mut Newton,
    state: &mut State,
    task: &SteadyTask,
    max_solves: usize,
) -> bool {
    let Some(parameters) = coarser(&system.parameters) else {
        return false;
    };
    let mut coarse = VariatorSystem::with_ring(&parameters, system.belt.ring.clone());
    let Ok(mut found) = cold_start(&coarse, task, system.belt.shaft_speeds(state.view())) else {
        return false;
    };
    let mut coarse_newton = Newton::new(&coarse);
    coarse_newton.bound = newton.bound;
    let outcome = solve(&mut coarse, &mut coarse_newton, &mut found, task, max_solves);
    newton.counts += coarse_newton.counts;
    newton.bound = coarse_newton.bound;
    if outcome.is_ok() {
        prolong(&coarse, &found, system, state);
    }
    outcome.is_ok()
}

/// Pseudo-transient continuation, with the friction velocity `velocity` at first, m/s.
fn continuation(
    system: &mut VariatorSystem,
    newton: &mut Newton,
    state: &mut State,
    task: &SteadyTask,
    max_solves: usize,
    velocity: f64,
) -> Result<Settled, Settled> {
    let mut control = Control::new(system, state, task);
    system.loads = Loads::Constant(control.boundary());
    let settings = Settling {
        time: 0.0,
        first_step: FIRST_STEP,
        last_step: LAST_STEP,
        max_solves,
    };
    system.friction_velocity = velocity;
    system.inertia_factor = PSEUDO_INERTIA;
    let outcome = settle(system, newton, state, &settings, |system, trial| {
        control.correct(system, trial)
    });
    system.friction_velocity = control.sharp;
    system.inertia_factor = 1.0;
    outcome
}

/// Quantities that change during the solution: the reaction, the set point of Θ, the conditions of the shafts, the friction
/// velocity.
struct Control<'a> {
    task: &'a SteadyTask,
    /// Clamping forces, N; the reaction's follows the force that holds the sheave.
    clamping: PerPulley<f64>,
    /// Set point of Θ.
    theta: f64,
    /// Whether the belt grips. Before, both speeds are kept at a small slip: torque on a belt that does not yet grip leads to
    /// the branch on which a pulley slips permanently.
    gripping: bool,
    /// The specified friction velocity, m/s.
    sharp: f64,
}

impl<'a> Control<'a> {
    /// At the initial state, which gets the first guess of the slip where a shaft's speed is solved for.
    fn new(system: &VariatorSystem, state: &mut State, task: &'a SteadyTask) -> Self {
        let mut clamping = task.clamping;
        if task.warm {
            clamping[task.reaction] = reaction(system, state.view(), task.reaction);
        }
        let free = task.free();
        if let (Some(pulley), false) = (free, task.warm) {
            let sign = if pulley == Pulley::Secondary { 1.0 } else { -1.0 };
            state.y[system.belt.layout.shaft_speed(pulley)] *= 1.0 - task.slip * sign;
        }
        Self {
            task,
            clamping,
            theta: system.belt.theta(state.view()),
            gripping: free.is_none() || task.warm,
            sharp: system.parameters.friction.velocity,
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
            shaft: if self.gripping {
                self.task.shaft
            } else {
                Boundary::HELD.shaft
            },
        }
    }

    /// Corrects the system after a solved step. Returns the largest next step; `None` rejects the step.
    fn correct(&mut self, system: &mut VariatorSystem, trial: &Trial<'_>) -> Option<f64> {
        let present = geometric_ratio(system, trial.after);
        let free = self.gripping && self.task.free().is_some();
        if free && runs_away(&system.belt, trial, present) {
            return None;
        }
        // Slower than the belt settles: otherwise the two integral corrections oscillate with growing amplitude.
        let gain = |time: f64| (trial.step / time).min(1.0);
        let reaction = self.task.reaction;
        let holding = system
            .pulleys()
            .holding_force(reaction, trial.after, system.of_belt[reaction].axial);
        self.clamping[reaction] += (holding - self.clamping[reaction]) * gain(FORCE_TIME);
        self.theta += (ratio_of_theta(self.task.ratio) - ratio_of_theta(present)) * gain(RATIO_TIME);
        let soft = trial.step >= SOFT_STEP;
        let was_gripping = self.gripping;
        self.gripping |= soft;
        system.loads = Loads::Constant(self.boundary());
        let velocity = system.friction_velocity;
        if velocity <= self.sharp {
            return Some(LAST_STEP);
        }
        if soft && was_gripping {
            system.friction_velocity = (velocity * SHARPENING).max(self.sharp);
        }
        Some(SOFT_STEP)
    }
}

/// Whether the slip at the geometric ratio `ratio` grows beyond that of a pulley that has run away. With a poor first guess of
/// a speed the slip may be as large, but it decreases.
fn runs_away(belt: &Belt, trial: &Trial<'_>, ratio: f64) -> bool {
    let slip = |view| {
        let speeds = belt.shaft_speeds(view);
        (1.0 - ratio * speeds.secondary / speeds.primary).abs()
    };
    slip(trial.after) > RUN_AWAY.max(slip(trial.before))
}

/// Force of clamp and pressure on a pulley that would hold its sheave where it is, N.
pub(crate) fn reaction(system: &VariatorSystem, view: View<'_>, pulley: Pulley) -> f64 {
    let axial = BeltDiagnostics::of(system, view).sums.axial[pulley];
    system.pulleys().holding_force(pulley, view, axial)
}

/// r_S/r_P of the pressure-weighted pitch radii; the reference curve's where nothing presses.
pub(crate) fn geometric_ratio(system: &VariatorSystem, view: View<'_>) -> f64 {
    BeltDiagnostics::of(system, view)
        .sums
        .geometric_ratio(&system.belt, view)
}
