//! Steady states, solved directly: in the Eulerian description they are fixed points.
//!
//! Pseudo-transient continuation from the kinematic state, on a coarse mesh at first (`refine`). A
//! stiff spring on Θ holds the ratio. After each step its force is moved to the reaction, and its
//! set point until the pressure-weighted radii have the specified ratio.

use super::refine::{Neighbour, coarser, prolong};
use super::start::{Start, kinematic_state};
use super::{
    FEW_SOLVES, FIRM, FIRST_PSEUDO_STEP, FORCE_ERROR, HOMOTOPY_STEP, HOMOTOPY_VELOCITY, MOST_SOLVES,
    NEGLIGIBLE, RATIO_TIME, RUN_AWAY, STEADY_TIME, VELOCITY_REDUCTION,
};
use crate::pulley::{PerPulley, Pulley};
use crate::reference_curve::{GeometryError, ratio_of_theta};
use crate::solver::continuation::{ContinuationSettings, NotSteady, Trial, continue_to_steady, settle};
use crate::solver::newton::Newton;
use crate::solver::{State, View};
use crate::variator::belt::Belt;
use crate::variator::diagnostics::belt::BeltDiagnostics;
use crate::variator::pulleys::loads::{Boundary, FORCE_TIME, Loads, RATIO_STIFFNESS, ShaftMode, SheaveMode};
use crate::variator::pulleys::rows::CLOSING_SIGN;
use crate::variator::settings::{Inputs, Parameters};
use crate::variator::system::VariatorSystem;
use std::ops::RangeInclusive;

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
    /// Whether the initial state is a neighbouring steady one, so the belt already grips.
    pub warm: bool,
}

impl SteadyTask {
    /// Whether both speeds are given.
    fn is_held(&self) -> bool {
        self.shaft == Boundary::HELD.shaft
    }
}

/// Solves for steady states of a system, which is then under their boundary conditions.
#[derive(Debug)]
pub struct SteadySolver<'a> {
    /// Equations.
    pub system: &'a mut VariatorSystem,
    /// Newton's method, which may have a bound on its work.
    pub newton: &'a mut Newton,
}

impl SteadySolver<'_> {
    /// Finds the steady state from `state`, in place. From a kinematic state by way of a coarse
    /// mesh, else of a firmer clamping force, else directly, which reverse running needs.
    ///
    /// # Errors
    /// There is no steady state near by; `state` is the last one solved.
    pub fn solve(&mut self, state: &mut State, task: &SteadyTask) -> Result<(), NotSteady> {
        let own = self.system.parameters.friction.velocity;
        if task.warm {
            return self.continuation(state, task, own);
        }
        let kinematic = state.clone();
        if let Some(coarse) = coarser(&self.system.parameters) {
            let warm = SteadyTask { warm: true, ..*task };
            let mut outcome = self.solve_coarsely(&coarse, state, task);
            outcome = outcome.and_then(|()| self.solve(state, &warm));
            let passive =
                PerPulley::from_fn(|pulley| self.system.pulleys().passive_force(pulley, kinematic.view()));
            let clamping = |pulley: Pulley| task.clamping[pulley] + passive[pulley];
            let present = clamping(task.reaction.other());
            if outcome.is_err() && 0.0 < present && present < FIRM {
                let factor = FIRM / present;
                state.copy_from(&kinematic);
                // Springs and rotating oil stay as they are.
                let clamping = PerPulley::from_fn(|pulley| factor * clamping(pulley) - passive[pulley]);
                outcome = self.solve(state, &SteadyTask { clamping, ..*task });
                outcome = outcome.and_then(|()| self.solve(state, &warm));
            }
            if outcome.is_ok() {
                return outcome;
            }
        }
        *state = kinematic;
        self.continuation(state, task, own.max(HOMOTOPY_VELOCITY))
    }

    /// Finds the steady state from a neighbouring one; `state` is the kinematic state. Where
    /// parameters and loads differ by some per cent, this takes one to five Jacobians instead of a
    /// hundred.
    ///
    /// # Errors
    /// The neighbour is not near enough; `state` is then meaningless.
    pub fn solve_near(
        &mut self,
        state: &mut State,
        task: &SteadyTask,
        near: &Neighbour,
    ) -> Result<(), NotSteady> {
        if !near.move_to(&self.system.belt, state, &task.shaft) {
            return Err(NotSteady::default());
        }
        let task = SteadyTask { warm: true, ..*task };
        let mut control = Control {
            correction: Some(f64::INFINITY),
            ..Control::new(self.system, state, &task)
        };
        self.system.loads = Loads::Steady(control.boundary());
        settle(
            self.system,
            self.newton,
            state,
            STEADY_TIME,
            FEW_SOLVES,
            |system, trial| {
                control.correct(system, trial)?;
                Some(control.correction < Some(NEGLIGIBLE))
            },
        )
    }

    /// Moves a kinematic state near the steady one of a mesh with fewer elements.
    fn solve_coarsely(
        &mut self,
        parameters: &Parameters,
        state: &mut State,
        task: &SteadyTask,
    ) -> Result<(), NotSteady> {
        let Self { system, newton } = self;
        let mut coarse = VariatorSystem::with_ring(parameters, system.belt.ring.clone());
        let speeds = system.belt.shaft_speeds(state.view());
        let kinematic = cold_start(&coarse, task, speeds).map_err(|_| NotSteady::default())?;
        let (mut found, mut coarse_newton) = (kinematic.clone(), Newton::new(&coarse));
        coarse_newton.bound = newton.bound;
        let mut solver = SteadySolver {
            system: &mut coarse,
            newton: &mut coarse_newton,
        };
        let settled = solver.solve(&mut found, task);
        newton.counts += coarse_newton.counts;
        newton.bound = coarse_newton.bound;
        if settled.is_ok() {
            prolong(&coarse.belt, &kinematic, &found, &system.belt, state);
        }
        settled
    }

    /// Pseudo-transient continuation, with the friction velocity `velocity` at first, m/s.
    fn continuation(&mut self, state: &mut State, task: &SteadyTask, velocity: f64) -> Result<(), NotSteady> {
        let mut control = Control::new(self.system, state, task);
        self.system.friction_velocity = velocity;
        let outcome = self.continue_to_steady(state, control.boundary(), |system, trial| {
            control.correct(system, trial)
        });
        self.system.friction_velocity = self.system.parameters.friction.velocity;
        outcome
    }

    /// Finds the ratio at which the task's reaction is exactly its clamping force, from a steady
    /// state at the task's ratio: secant method on ln(force/reaction) over ln(ratio). At an end of
    /// `ratios`, where the sheaves are near their stops, they are released under the clamping
    /// forces, and come to rest against a stop. Returns whether they do.
    ///
    /// # Errors
    /// There is no such state.
    pub fn balance(
        &mut self,
        state: &mut State,
        task: &SteadyTask,
        ratios: &RangeInclusive<f64>,
    ) -> Result<bool, NotSteady> {
        let mut x = task.ratio.ln();
        let mut f = unbalance(self.system, state, task);
        // More force on P lowers the ratio; ln i_F falls by about 0.5 per unit of ln i.
        let mut slope = if task.reaction == Pulley::Primary { 0.5 } else { -0.5 };
        for _ in 0..MOST_SOLVES {
            let balances = f.abs() < FORCE_ERROR;
            let wanted = x - f / slope;
            let next = wanted.clamp(ratios.start().ln(), ratios.end().ln());
            let is_at_end = next == x && next != wanted;
            if is_at_end && !balances {
                let sheave = task.clamping.map(SheaveMode::Force);
                let released = Boundary {
                    sheave,
                    shaft: task.shaft,
                };
                self.continue_to_steady(state, released, |_, _| Some(STEADY_TIME))?;
            }
            if is_at_end || balances {
                let pulleys = self.system.pulleys();
                let rests = |pulley| pulleys.stop_reached(pulley, state.view()).is_some();
                return Ok(Pulley::BOTH.into_iter().any(rests));
            }
            let next_task = SteadyTask {
                ratio: next.exp(),
                ..*task
            };
            let mut speeds = self.system.belt.shaft_speeds(state.view());
            if task.shaft.secondary != ShaftMode::Fixed {
                speeds.secondary = speeds.primary / next_task.ratio;
            }
            if let Ok(kinematic) = cold_start(self.system, &next_task, speeds) {
                *state = kinematic;
            }
            self.solve(state, &next_task)?;
            let reached = unbalance(self.system, state, task);
            let secant = (reached - f) / (next - x);
            if secant * slope > 0.0 {
                slope = secant;
            }
            (x, f) = (next, reached);
        }
        Err(NotSteady::default())
    }

    /// Settles under boundary conditions, which `control` may correct.
    fn continue_to_steady(
        &mut self,
        state: &mut State,
        boundary: Boundary,
        control: impl FnMut(&mut VariatorSystem, &Trial<'_>) -> Option<f64>,
    ) -> Result<(), NotSteady> {
        let settings = ContinuationSettings {
            time: 0.0,
            first_step: FIRST_PSEUDO_STEP,
            last_step: STEADY_TIME,
            max_solves: MOST_SOLVES,
        };
        self.system.loads = Loads::Steady(boundary);
        continue_to_steady(self.system, self.newton, state, &settings, control)
    }
}

/// The kinematic state at a task's ratio with shafts at `speeds`, rad/s.
fn cold_start(
    system: &VariatorSystem,
    task: &SteadyTask,
    speeds: PerPulley<f64>,
) -> Result<State, GeometryError> {
    let belt = &system.belt;
    let passive = system
        .parameters
        .total_clamping_forces(&Inputs::ZERO, task.ratio, speeds.primary);
    let start = Start {
        ratio: task.ratio,
        primary_speed: speeds.primary,
        clamping: PerPulley::from_fn(|pulley| task.clamping[pulley] + passive[pulley]),
    };
    let mut state = kinematic_state(belt, &start)?;
    for pulley in Pulley::BOTH {
        state.y[belt.layout.shaft_speed(pulley)] = speeds[pulley];
    }
    Ok(state)
}

/// Quantities that change during the solution.
struct Control<'a> {
    task: &'a SteadyTask,
    /// Clamping forces, N; the reaction's follows the force that holds the sheave.
    clamping: PerPulley<f64>,
    /// Set point of Θ.
    theta: f64,
    /// From a neighbouring state the last correction, of Θ or relative to the force.
    correction: Option<f64>,
    /// Whether the belt grips. Before, both speeds are kept: torque on a belt that does not grip
    /// leads to the branch on which a pulley slips permanently.
    gripping: bool,
}

impl<'a> Control<'a> {
    /// At the initial state.
    fn new(system: &VariatorSystem, state: &State, task: &'a SteadyTask) -> Self {
        let mut clamping = task.clamping;
        if task.warm {
            clamping[task.reaction] = reaction(system, state.view(), task.reaction);
        }
        Self {
            task,
            clamping,
            theta: system.belt.theta(state.view()),
            correction: None,
            gripping: task.is_held() || task.warm,
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

    /// Corrects the system after a solved step. Returns the largest next step; `None` rejects the
    /// step.
    fn correct(&mut self, system: &mut VariatorSystem, trial: &Trial<'_>) -> Option<f64> {
        let present = geometric_ratio(system, trial.after);
        if self.gripping && !self.task.is_held() && runs_away(&system.belt, trial, present) {
            return None;
        }
        // Faster than the belt settles, the two integral corrections would oscillate and grow.
        let gain = |time: f64| (trial.step / time).min(1.0);
        let reaction = self.task.reaction;
        let holding = system
            .pulleys()
            .holding_force(reaction, trial.after, system.of_belt[reaction].axial);
        let of_force = (holding - self.clamping[reaction]) * gain(FORCE_TIME);
        let of_theta = (ratio_of_theta(self.task.ratio) - ratio_of_theta(present)) * gain(RATIO_TIME);
        self.clamping[reaction] += of_force;
        self.theta += of_theta;
        if let Some(correction) = &mut self.correction {
            // The force takes over the load of the spring.
            self.theta -= CLOSING_SIGN[reaction] * of_force / RATIO_STIFFNESS;
            *correction = of_theta.abs().max((of_force / holding).abs());
        }
        let is_long = trial.step >= HOMOTOPY_STEP;
        let was_gripping = self.gripping;
        self.gripping |= is_long;
        system.loads = Loads::Steady(self.boundary());
        let (velocity, own) = (system.friction_velocity, system.parameters.friction.velocity);
        if velocity <= own {
            return Some(STEADY_TIME);
        }
        if is_long && was_gripping {
            system.friction_velocity = (velocity * VELOCITY_REDUCTION).max(own);
        }
        Some(HOMOTOPY_STEP)
    }
}

/// Whether the slip at the geometric ratio `ratio` grows beyond that of a pulley that has run away.
/// After a poor first guess of a speed it may be as large, but decreases.
fn runs_away(belt: &Belt, trial: &Trial<'_>, ratio: f64) -> bool {
    let slip = |view| {
        let speeds = belt.shaft_speeds(view);
        (1.0 - ratio * speeds.secondary / speeds.primary).abs()
    };
    slip(trial.after) > RUN_AWAY.max(slip(trial.before))
}

/// Applies the loads that hold a steady state of a task.
pub(super) fn hold(system: &mut VariatorSystem, state: &State, task: &SteadyTask) {
    let task = SteadyTask { warm: true, ..*task };
    system.loads = Loads::Steady(Control::new(system, state, &task).boundary());
}

/// ln of the task's clamping force on its reacting pulley over the force that holds this state.
pub(crate) fn unbalance(system: &VariatorSystem, state: &State, task: &SteadyTask) -> f64 {
    let passive = system.pulleys().passive_force(task.reaction, state.view());
    let holding = reaction(system, state.view(), task.reaction);
    ((task.clamping[task.reaction] + passive).max(1.0) / (holding + passive).max(1.0)).ln()
}

/// Force of clamp and pressure on a pulley that would hold its sheave where it is, N.
pub(crate) fn reaction(system: &VariatorSystem, view: View<'_>, pulley: Pulley) -> f64 {
    let axial = BeltDiagnostics::new(system, view).sums.axial[pulley];
    system.pulleys().holding_force(pulley, view, axial)
}

/// r_S/r_P of the pressure-weighted pitch radii; the reference curve's where nothing presses.
pub(crate) fn geometric_ratio(system: &VariatorSystem, view: View<'_>) -> f64 {
    BeltDiagnostics::new(system, view)
        .sums
        .geometric_ratio(&system.belt, view)
}
