//! The steady state that a run starts from, at the given torques or at the largest possible
//! fraction.

use super::outcome::OtherStart;
use super::simulation::Simulation;
use super::tuning::{
    CLOSE_FRACTION, LEAST_FRACTION, NEXT_FRACTION, REAL_TIME, SLIP_AT_CAPACITY, STEADY_WORK,
};
use crate::pulley::{PerPulley, Pulley};
use crate::solver::continuation::NotSteady;
use crate::solver::newton::{Newton, WorkBound};
use crate::variator::belt::ring::BeltRing;
use crate::variator::diagnostics::belt::{BeltDiagnostics, NO_FORCE};
use crate::variator::diagnostics::observe::Observer;
use crate::variator::pulleys::loads::{Boundary, InputProfile, ShaftMode};
use crate::variator::settings::capacity::{TorqueDemand, excessive_speed};
use crate::variator::settings::{Axial, Drive, Inputs, Outputs, Parameters, StartState};
use crate::variator::steady::FORCE_ERROR;
use crate::variator::steady::refine::Neighbour;
use crate::variator::steady::solve::{SteadySolver, SteadyTask, geometric_ratio, reaction, unbalance};
use crate::variator::steady::tangent::Tangent;
use std::sync::Arc;

/// Why there is no steady state to start from.
#[derive(Debug, thiserror::Error)]
pub(super) enum NoSteadyState {
    /// The inputs can't be intended.
    #[error("no steady state: {0}")]
    Hopeless(String),
    /// None was found, for this reason.
    #[error("{0}")]
    NotFound(String),
}

/// A steady start and its tangent, for derivatives over parameters and inputs.
#[derive(Debug)]
pub struct SteadyTangent {
    near: Neighbour,
    tangent: Tangent,
}

impl SteadyTangent {
    /// Outputs of the steady start with valid parameters and inputs that differ by some millionths;
    /// none if they differ too much.
    #[must_use]
    pub fn outputs(
        &mut self,
        parameters: &Parameters,
        ring: Arc<dyn BeltRing>,
        inputs: &Inputs,
    ) -> Option<Outputs> {
        let mut of = Simulation::new(parameters, ring);
        of.given = *inputs;
        of.state = of.cold_state(&of.wanted_start()).ok()?;
        let task = of.steady_task(of.clamped().other(), 1.0);
        if !self.near.move_to(&of.system.belt, &mut of.state, &task.shaft) {
            return None;
        }
        self.tangent.settle(&mut of.system, &mut of.state, &task).ok()?;
        of.restore(InputProfile::constant(inputs));
        let (view, mut outputs) = (of.state.view(), Outputs::default());
        let belt = BeltDiagnostics::new(&of.system, view);
        Observer::default().observe(&of.system, 0.0, view, &belt, &mut outputs);
        Some(outputs)
    }
}

impl Simulation {
    /// Solves for the steady state of the parameters, or for the nearest one.
    pub fn solve_steady(&mut self) -> Result<StartState, NoSteadyState> {
        let mut newton = Newton::new(&self.system);
        newton.bound = WorkBound {
            remaining: STEADY_WORK,
            jacobian: REAL_TIME.jacobian,
            geometry: REAL_TIME.geometry,
            overdraft: f64::INFINITY,
            ..WorkBound::NONE
        };
        let found = self.solve_within(&mut newton);
        self.start_work += newton.counts;
        found
    }

    /// [`Simulation::solve_steady`] within the work of `newton`.
    fn solve_within(&mut self, newton: &mut Newton) -> Result<StartState, NoSteadyState> {
        let parameters = &self.system.parameters;
        let (ratio, speed) = (parameters.initial.ratio, self.primary_speed());
        let clamped = self.clamped();
        let force = parameters.total_clamping_forces(&self.given, ratio, speed)[clamped];
        if force < NO_FORCE {
            let name = parameters.clamping_variable(clamped);
            let text = format!(
                "no steady state without a clamping force ({}.{name} = {force} N)",
                clamped.name()
            );
            return Err(NoSteadyState::NotFound(text));
        }
        if let Some(why) = excessive_speed(parameters, &self.given, ratio, speed) {
            return Err(NoSteadyState::Hopeless(why));
        }
        let free = !parameters.holds_a_sheave();
        let balance = self.balances();
        let demand = TorqueDemand::new(parameters, &self.given, clamped, ratio, speed);
        let whole = self.steady_task(clamped.other(), 1.0);
        let fraction = self.solve_largest_torque(newton, clamped.other(), demand)?;
        let mut found = StartState::Steady;
        if fraction < 1.0 {
            let other = OtherStart {
                why: "no steady state was found at the torques, which may be beyond the capacity of the clamping forces",
                instead: &format!("the steady state at torques of {:.0} % of them", 100.0 * fraction),
                helps: "larger clamping forces or smaller torques",
            };
            found = self.start_from(StartState::ReducedTorque, &other);
        }
        if balance {
            found = self.balance_forces(newton, &whole, found);
        }
        if free {
            let passive = self.system.pulleys().passive_force(Pulley::Primary, self.state.view());
            let excess = whole.clamping.primary + passive - self.sums().axial.primary;
            let text = format!("steady start: primary clamping force less axial belt force is {excess:.1} N");
            self.log(false, text);
        }
        Ok(found)
    }

    /// The pulley whose clamping force is given in a steady state; the other one's holds the ratio.
    fn clamped(&self) -> Pulley {
        let parameters = &self.system.parameters;
        match (parameters.primary.axial, parameters.secondary.axial) {
            (Axial::Force, Axial::Held) => Pulley::Primary,
            _ => Pulley::Secondary,
        }
    }

    /// Whether both clamping forces are given, and the ratio follows.
    pub fn balances(&self) -> bool {
        let parameters = &self.system.parameters;
        !parameters.holds_a_sheave() && parameters.initial.equilibrium
    }

    /// Speed of the primary pulley in the present state, rad/s.
    pub fn primary_speed(&self) -> f64 {
        self.system.belt.shaft_speeds(self.state.view()).primary
    }

    /// The steady state with a fraction of the torques.
    fn steady_task(&self, reaction: Pulley, fraction: f64) -> SteadyTask {
        let (p, inputs) = (&self.system.parameters, self.given);
        let own = fraction * inputs.secondary.torque;
        let primary = fraction * inputs.primary.torque;
        let (of_secondary, of_primary) = match (p.secondary.drive, p.primary.drive) {
            (Drive::Speed, Drive::Speed) => (ShaftMode::Fixed, ShaftMode::Fixed),
            (Drive::Speed, Drive::Torque) => (ShaftMode::Fixed, ShaftMode::Torque(primary)),
            (Drive::Torque, Drive::Speed) => (ShaftMode::Torque(own), ShaftMode::Fixed),
            (Drive::Torque, Drive::Torque) => (ShaftMode::Balanced { own, primary }, ShaftMode::Fixed),
        };
        SteadyTask {
            ratio: p.initial.ratio,
            reaction,
            clamping: PerPulley::from_fn(|pulley| inputs.pulley(pulley).force(&p.pulley(pulley).cylinder)),
            shaft: PerPulley {
                secondary: of_secondary,
                primary: of_primary,
            },
            warm: false,
        }
    }

    /// Guesses the slip of a shaft whose speed is solved for: in proportion to the torques.
    fn guess_slip(&mut self, task: &SteadyTask, demand: TorqueDemand, fraction: f64) {
        let utilisation = (-fraction * demand.utilisation()).clamp(-1.0, 1.0);
        let slip = SLIP_AT_CAPACITY * self.primary_speed().signum() * utilisation;
        for (pulley, sign) in [(Pulley::Secondary, 1.0), (Pulley::Primary, -1.0)] {
            if task.shaft[pulley] != ShaftMode::Fixed {
                self.state.y[self.system.belt.layout.shaft_speed(pulley)] *= 1.0 - slip * sign;
            }
        }
    }

    /// Solves for the steady state at the given torques, or at nearly the largest fraction of them
    /// that has one: torque beyond capacity has none, and isn't tried. Returns the fraction.
    fn solve_largest_torque(
        &mut self,
        newton: &mut Newton,
        reaction: Pulley,
        demand: Option<TorqueDemand>,
    ) -> Result<f64, NoSteadyState> {
        let cold = self.state.clone();
        if self.solve_near(newton, reaction) {
            return Ok(1.0);
        }
        self.state.clone_from(&cold);
        let is_beyond = |fraction| demand.filter(|demand| demand.is_beyond(fraction));
        let (mut fraction, mut beyond) = (1.0, 1.0);
        loop {
            let task = self.steady_task(reaction, fraction);
            let is_least = fraction <= LEAST_FRACTION;
            if let Some(demand) = demand {
                self.guess_slip(&task, demand, fraction);
            }
            match is_beyond(fraction) {
                Some(demand) if is_least => return Err(NoSteadyState::Hopeless(demand.to_string())),
                Some(_) => {}
                None => match self.solve(newton, &task) {
                    // Past the peak of traction a state may be steady too.
                    Ok(_) if fraction == 1.0 || is_least || !self.sums().past_peak() => break,
                    Err(report) if is_least || task.shaft == Boundary::HELD.shaft => {
                        let why = demand.map(|demand| format!(": {demand}")).unwrap_or_default();
                        return Err(NoSteadyState::NotFound(format!("{report}{why}")));
                    }
                    _ => self.state.clone_from(&cold),
                },
            }
            (beyond, fraction) = (fraction, NEXT_FRACTION * fraction);
        }
        while beyond > CLOSE_FRACTION * fraction {
            let middle = (fraction * beyond).sqrt();
            let task = SteadyTask {
                warm: true,
                ..self.steady_task(reaction, middle)
            };
            let feasible = self.state.clone();
            let found = is_beyond(middle).is_none() && self.solve(newton, &task).is_ok();
            if found && !self.sums().past_peak() {
                fraction = middle;
            } else {
                beyond = middle;
                self.state = feasible;
            }
        }
        Ok(fraction)
    }

    /// Whether the steady state is found from that of another variator, not past the peak of
    /// traction.
    fn solve_near(&mut self, newton: &mut Newton, reaction: Pulley) -> bool {
        let Some(near) = self.near.take() else {
            return false;
        };
        let task = self.steady_task(reaction, 1.0);
        let Simulation { system, state, .. } = self;
        let found = SteadySolver { system, newton }.solve_near(state, &task, &near);
        found.is_ok() && !self.sums().past_peak()
    }

    /// The present state, in which the run has started, for steady states near by.
    pub fn neighbour(&self) -> Option<Neighbour> {
        Some(Neighbour {
            belt: self.system.belt.clone(),
            kinematic: self.cold_state(&self.wanted_start()).ok()?,
            state: self.state.clone(),
        })
    }

    /// The same with its tangent; none where the Jacobian is singular or the forces press a sheave
    /// against its stop.
    pub fn tangent(&self) -> Option<SteadyTangent> {
        let (mut system, balance) = (self.system.clone(), self.balances());
        let task = self.steady_task(self.clamped().other(), 1.0);
        if balance && unbalance(&system, &self.state, &task).abs() > FORCE_ERROR {
            return None;
        }
        let mut near = self.neighbour()?;
        let tangent = Tangent::new(&mut system, &mut near.state, &task, balance)?;
        Some(SteadyTangent { near, tangent })
    }

    fn solve(&mut self, newton: &mut Newton, task: &SteadyTask) -> Result<(), NotSteady> {
        let Simulation { system, state, .. } = self;
        SteadySolver { system, newton }.solve(state, task)
    }

    /// Solves for the ratio at which the clamping forces balance, too, from the state `found`.
    fn balance_forces(&mut self, newton: &mut Newton, task: &SteadyTask, found: StartState) -> StartState {
        let Simulation { system, state, .. } = self;
        let range = system.parameters.ratio_range();
        let at_ratio = state.clone();
        let outcome = SteadySolver { system, newton }.balance(state, task, &range);
        let ratio = geometric_ratio(system, state.view());
        match outcome {
            Ok(at_stop) => {
                let text = if at_stop {
                    format!(
                        "the clamping forces drive the variator to an end stop: the run starts at the ratio {ratio:.4}"
                    )
                } else {
                    format!("equilibrium of the clamping forces at the ratio {ratio:.6}")
                };
                self.log(at_stop, text);
                self.other_start = None;
                StartState::Steady
            }
            Err(_) => {
                *state = at_ratio;
                if found != StartState::Steady {
                    return found;
                }
                let passive = system.pulleys().passive_force(Pulley::Primary, state.view());
                let holding = passive + reaction(system, state.view(), Pulley::Primary);
                let other = OtherStart {
                    why: "no equilibrium of the two clamping forces was found",
                    instead: &format!(
                        "the steady state at the ratio, where the primary force would have to be {holding:.1} N"
                    ),
                    helps: "that primary force, another initial.ratio, or initial.equilibrium = false",
                };
                self.start_from(StartState::NoEquilibrium, &other)
            }
        }
    }
}
