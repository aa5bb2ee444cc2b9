//! The state that a run starts from: unloaded or steady as the parameters want it, else the nearest that exists.

use crate::contact::full_slip_torque;
use crate::pulley::{PerPulley, Pulley};
use crate::solver::continuation::Settled;
use crate::solver::newton::{Counts, Newton};
use crate::solver::sdirk::Stalled;
use crate::variator::belt::ring::BeltRing;
use crate::variator::pulleys::loads::{Boundary, ShaftMode};
use crate::variator::run::course::Held;
use crate::variator::run::pace::Pace;
use crate::variator::run::soft_start::{LOAD_RAMP, SoftStart};
use crate::variator::run::variator::{InitialisationError, Variator};
use crate::variator::settings::parameters::{Axial, Drive, Initial};
use crate::variator::settings::signals::{Inputs, StartState, Work};
use crate::variator::steady::equilibrium::{Equilibrium, solve_equilibrium};
use crate::variator::steady::solve::{self, SteadyTask, geometric_ratio};
use crate::variator::steady::start::{Start, kinematic_state};
use crate::variator::survey::belt_survey::{NO_FORCE, Survey};
use crate::variator::survey::ledger::Ledger;
use crate::variator::survey::observe::macro_slip;
use std::sync::Arc;

/// First step from a steady state, s.
const WARM_STEP: f64 = 1.0e-4;

/// Most Newton solves for a steady state.
const STEADY_SOLVES: usize = 400;

/// Share of the torques below which no smaller one is tried, and the factor to which the largest is found.
const LEAST_SHARE: f64 = 0.05;
const CLOSE_SHARE: f64 = 1.05;

/// Share of full slip up to which a torque isn't beyond capacity: braking in underdrive it is, from 0.57 on.
const CARRIED_AT_LEAST: f64 = 0.5;

/// Slip of a pushbelt at capacity, as a first guess: measured variators begin to slip through between 1 and 3 %.
const SLIP_AT_CAPACITY: f64 = 0.015;

/// Pitch radius on the primary pulley as a share of the distance of the axes, for a first guess: 0.35 at ratio 1, 0.2 in
/// underdrive.
const USUAL_RADIUS: f64 = 0.3;

/// Speed of the primary pulley below which there is nothing steady to solve for, rad/s.
const STANDSTILL: f64 = 1.0e-3;

impl Variator {
    /// Finds the state to start from at `time`.
    ///
    /// A state that can't be solved for is replaced by the nearest one, with a warning that names it and the reason.
    ///
    /// # Errors
    /// Inputs out of range, or no state found.
    pub fn initialise(&mut self, time: f64, inputs: &Inputs) -> Result<(), InitialisationError> {
        inputs.validate()?;
        self.system.round(0.0);
        self.clamp_initial_ratio();
        let start = self.start_point(inputs);
        self.start_state = self.find_state(time, inputs, &start)?;
        self.warn_of_held_sheaves();
        if self.real_time.is_some() && self.soft_start.from == time {
            // A ring without tension is a mechanism, too rough for ticks of bounded work.
            if let Err(stalled) = self.clamp_softly(inputs) {
                self.warn_of_no_clamping(&stalled);
            }
        }
        self.state.y_dot.fill(0.0);
        self.held = Held::constant(time, inputs);
        self.pace = Pace::new(inputs);
        self.integrator.newton.counts = Counts::default();
        if let Some(real_time) = &mut self.real_time {
            real_time.begin(&self.state, time);
        }
        self.work = Work::default();
        self.apply();
        self.ledger = Ledger::open(&self.system, self.state.view());
        self.macro_slip = macro_slip(&self.system, self.state.view(), &self.ledger.last.sums, false);
        self.warn_of_slip();
        self.hold_external();
        self.initial_energy =
            self.ledger.last.belt_energy(&self.system.belt) + self.system.pulleys.energy(self.state.view());
        self.stale = true;
        Ok(())
    }

    /// Moves an initial ratio beyond an end stop to the stop.
    fn clamp_initial_ratio(&mut self) {
        let (lowest, highest) = self.system.parameters.ratio_range();
        let asked = self.system.parameters.initial.ratio;
        let ratio = asked.clamp(lowest, highest);
        if ratio != asked {
            self.system.parameters.initial.ratio = ratio;
            self.log(
                false,
                format!(
                    "initial.ratio = {asked} lies beyond an end stop, where only a loaded belt rests: the run starts at {ratio:.6}"
                ),
            );
        }
    }

    /// The kinematic state to start from: a set point of a shaft's speed comes before `initial.primarySpeed`.
    fn start_point(&mut self, inputs: &Inputs) -> Start {
        let parameters = &self.system.parameters;
        let Initial {
            ratio,
            primary_speed: asked,
            ..
        } = parameters.initial;
        let primary_speed = match (parameters.primary.drive, parameters.secondary.drive) {
            (Drive::Speed, _) => inputs.primary.speed_setpoint,
            (Drive::Torque, Drive::Speed) => inputs.secondary.speed_setpoint * ratio,
            (Drive::Torque, Drive::Torque) => asked,
        };
        if primary_speed != asked {
            self.log(
                false,
                format!(
                    "a shaft follows its set point: the run starts near {primary_speed} rad/s at the primary pulley, not at \
                     initial.primarySpeed = {asked} rad/s"
                ),
            );
        }
        Start {
            ratio,
            primary_speed,
            clamping: clamping(inputs),
        }
    }

    /// Warns where both sheaves are held: clamping forces have no effect in the run.
    fn warn_of_held_sheaves(&mut self) {
        if !self.system.parameters.holds_both_sheaves() {
            return;
        }
        let text = if matches!(self.start_state, StartState::Steady | StartState::ReducedTorque) {
            "both sheaves are held: the belt's tension follows from secondary.clampingForce at the start, later clamping \
             forces are ignored"
        } else {
            "both sheaves are held in a start without load: the belt has no tension and carries next to nothing, clamping \
             forces are ignored"
        };
        self.log(true, text.into());
    }

    fn warn_of_no_clamping(&mut self, stalled: &Stalled) {
        self.log(true, format!("the belt was not clamped before the start: {stalled}"));
    }

    /// Warns where the belt slips through from the start.
    fn warn_of_slip(&mut self) {
        if !self.macro_slip {
            return;
        }
        let speeds = self.system.belt.shaft_speeds(self.state.view());
        self.log(
            true,
            format!(
                "the belt slips through (macro-slip) in the state that the run starts from: {:.4} rad/s at the primary \
                 pulley, {:.4} rad/s at the secondary, geometric ratio {:.4}",
                speeds.primary,
                speeds.secondary,
                geometric_ratio(&self.system, self.state.view())
            ),
        );
    }

    /// Sets the state that a run starts from.
    fn find_state(&mut self, time: f64, inputs: &Inputs, start: &Start) -> Result<StartState, InitialisationError> {
        self.time = time;
        (self.buckled, self.slipped) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        self.forget_history();
        if let Some(ring) = self.system.belt.ring.starts_on() {
            self.start_on(ring, inputs, start)
        } else if !self.system.parameters.initial.steady {
            self.start_unloaded(inputs, start)?;
            Ok(StartState::Unloaded)
        } else if start.primary_speed.abs() > STANDSTILL {
            self.start_cold(inputs, start)?;
            self.solve_steady(inputs, start)
        } else {
            self.start_unloaded(inputs, start)?;
            match self.clamp_at_rest(inputs) {
                Ok(true) => Ok(StartState::Clamped),
                Ok(false) => Ok(StartState::Unloaded),
                Err(stalled) => {
                    self.warn_of_no_clamping(&stalled);
                    self.start_unloaded(inputs, start)?;
                    Ok(StartState::Unloaded)
                }
            }
        }
    }

    /// Starts in the kinematic state, the secondary pulley at its set point if it has one.
    fn start_cold(&mut self, inputs: &Inputs, start: &Start) -> Result<(), InitialisationError> {
        self.state =
            kinematic_state(&self.system.belt, start).map_err(|e| InitialisationError::NoState(e.to_string()))?;
        if self.system.parameters.secondary.drive == Drive::Speed {
            let i = self.system.belt.layout.shaft_speed(Pulley::Secondary);
            self.state.y[i] = inputs.secondary.speed_setpoint;
        }
        Ok(())
    }

    /// Starts unloaded; loads and friction come in softly.
    fn start_unloaded(&mut self, inputs: &Inputs, start: &Start) -> Result<(), InitialisationError> {
        let unloaded = Start {
            clamping: PerPulley::default(),
            ..*start
        };
        self.start_cold(inputs, &unloaded)?;
        self.soft_start = SoftStart { from: self.time };
        Ok(())
    }

    /// Starts in the state of another ring.
    fn start_on(
        &mut self,
        ring: Arc<dyn BeltRing>,
        inputs: &Inputs,
        start: &Start,
    ) -> Result<StartState, InitialisationError> {
        let mut other = Self::with_ring(self.system.parameters.clone(), ring)?;
        let found = other.find_state(self.time, inputs, start)?;
        self.messages.append(&mut other.messages);
        self.soft_start = other.soft_start;
        let belt = &self.system.belt;
        self.state = belt.ring.start_from(belt, &other.system.belt, &other.state);
        Ok(found)
    }

    fn steady_task(&self, inputs: &Inputs, torque_share: f64) -> SteadyTask {
        let p = &self.system.parameters;
        let own = inputs.secondary.torque * torque_share;
        let primary = inputs.primary.torque * torque_share;
        let (of_secondary, of_primary) = match (p.secondary.drive, p.primary.drive) {
            (Drive::Speed, Drive::Speed) => (ShaftMode::Fixed, ShaftMode::Fixed),
            (Drive::Speed, Drive::Torque) => (ShaftMode::Fixed, ShaftMode::Torque(primary)),
            (Drive::Torque, Drive::Speed) => (ShaftMode::Torque(own), ShaftMode::Fixed),
            (Drive::Torque, Drive::Torque) => (ShaftMode::Balanced { own, primary }, ShaftMode::Fixed),
        };
        let reaction = if p.secondary.axial == Axial::Held && p.primary.axial == Axial::Force {
            Pulley::Secondary
        } else {
            Pulley::Primary
        };
        SteadyTask {
            ratio: p.initial.ratio,
            reaction,
            clamping: clamping(inputs),
            shaft: PerPulley {
                secondary: of_secondary,
                primary: of_primary,
            },
            slip: self.slip_guess(inputs, torque_share),
            warm: false,
        }
    }

    /// Slip in the direction of the power, in proportion to the torque.
    fn slip_guess(&self, inputs: &Inputs, torque_share: f64) -> f64 {
        let direction = self.system.belt.shaft_speeds(self.state.view()).primary.signum();
        SLIP_AT_CAPACITY * direction * (torque_share * self.of_full_slip(inputs)).clamp(-1.0, 1.0)
    }

    /// The torque at the primary pulley as a share of about what the secondary clamping force carries in full slip.
    fn of_full_slip(&self, inputs: &Inputs) -> f64 {
        let p = &self.system.parameters;
        let torque = match p.primary.drive {
            Drive::Torque => inputs.primary.torque,
            Drive::Speed => -inputs.secondary.torque / p.initial.ratio,
        };
        let (force, radius) = (
            inputs.secondary.clamping_force,
            USUAL_RADIUS * p.geometry.center_distance,
        );
        torque / full_slip_torque(&p.friction, self.system.belt.law.wedge[1], force, radius).max(1.0e-6)
    }

    /// Solves for the steady state that the parameters want, or for the nearest one; returns which it is.
    fn solve_steady(&mut self, inputs: &Inputs, start: &Start) -> Result<StartState, InitialisationError> {
        let mut newton = Newton::new(&self.system);
        let task = self.steady_task(inputs, 1.0);
        let clamped = task.reaction.other();
        if task.clamping[clamped] < NO_FORCE {
            let (name, force) = (clamped.name(), task.clamping[clamped]);
            let why = format!("no steady state without a clamping force ({name}.clampingForce = {force} N)");
            return self.start_without_steady_state(&why, inputs, start);
        }
        let found = match self.carry(&mut newton, inputs) {
            Ok(1.0) => StartState::Steady,
            Ok(share) => {
                self.warn_of_reduced_torque(inputs, share);
                StartState::ReducedTorque
            }
            Err(Settled { step, solves }) => {
                let why = format!("no steady state was found (pseudo-time step {step:.1e} s after {solves} solves)");
                return self.start_without_steady_state(&why, inputs, start);
            }
        };
        self.integrator.step = WARM_STEP;
        let p = &self.system.parameters;
        let free = p.primary.axial == Axial::Force && p.secondary.axial == Axial::Force;
        let found = if p.initial.equilibrium && free {
            self.balance_forces(&mut newton, inputs, found)
        } else {
            found
        };
        if free {
            let axial = Survey::of(&self.system, self.state.view()).sums.axial.primary;
            self.log(
                false,
                format!(
                    "steady start: primary clamping force less axial belt force is {:.1} N",
                    inputs.primary.clamping_force - axial
                ),
            );
        }
        Ok(found)
    }

    /// Starts unloaded, with a warning that has the reason `why`.
    fn start_without_steady_state(
        &mut self,
        why: &str,
        inputs: &Inputs,
        start: &Start,
    ) -> Result<StartState, InitialisationError> {
        self.log(
            true,
            format!("{why}: the run starts unloaded and the loads ramp in over {LOAD_RAMP} s"),
        );
        self.start_unloaded(inputs, start)?;
        Ok(StartState::NotFound)
    }

    /// Warns that the run starts with this `share` of the given torques.
    fn warn_of_reduced_torque(&mut self, inputs: &Inputs, share: f64) {
        let why = if self.of_full_slip(inputs).abs() > CARRIED_AT_LEAST {
            " (beyond the capacity of the clamping forces)"
        } else {
            " was found"
        };
        self.log(
            true,
            format!(
                "no steady state at the given torques{why}: the run starts from the steady state at {:.0} % of them",
                100.0 * share
            ),
        );
    }

    /// Solves for the steady state at the given torques, or at nearly the largest share of them that has one: torque
    /// beyond capacity has none. The share, or how far the last attempt came.
    fn carry(&mut self, newton: &mut Newton, inputs: &Inputs) -> Result<f64, Settled> {
        let cold = self.state.clone();
        let (mut share, mut beyond) = (1.0, 1.0);
        loop {
            let task = self.steady_task(inputs, share);
            match solve::solve(&mut self.system, newton, &mut self.state, &task, STEADY_SOLVES) {
                // Beyond capacity a pulley that slips for ever may be steady too.
                Ok(_) if share == 1.0 || share <= LEAST_SHARE || !self.slips() => break,
                Err(report) if share <= LEAST_SHARE || task.shaft == Boundary::HELD.shaft => return Err(report),
                _ => (beyond, share) = (share, 0.7 * share),
            }
            self.state.clone_from(&cold);
        }
        while beyond > CLOSE_SHARE * share {
            let middle = (share * beyond).sqrt();
            let task = SteadyTask {
                warm: true,
                ..self.steady_task(inputs, middle)
            };
            let carried = self.state.clone();
            let solved = solve::solve(&mut self.system, newton, &mut self.state, &task, STEADY_SOLVES / 4);
            if solved.is_ok() && !self.slips() {
                share = middle;
            } else {
                beyond = middle;
                self.state = carried;
            }
        }
        Ok(share)
    }

    /// Whether the belt slips through, from the state alone.
    fn slips(&self) -> bool {
        let view = self.state.view();
        macro_slip(&self.system, view, &Survey::of(&self.system, view).sums, false)
    }

    /// Solves for the ratio too at which the clamping forces balance. `found` is the state that the search starts from.
    fn balance_forces(&mut self, newton: &mut Newton, inputs: &Inputs, found: StartState) -> StartState {
        let task = self.steady_task(inputs, 1.0);
        let holding = solve::reaction(&self.system, self.state.view(), Pulley::Primary);
        let at_ratio = self.state.clone();
        let range = self.system.parameters.ratio_range();
        match solve_equilibrium(&mut self.system, newton, &mut self.state, &task, range) {
            Ok(Equilibrium { ratio, at_stop: true }) => {
                self.log(
                    true,
                    format!(
                        "the clamping forces drive the variator to an end stop: the run starts at the ratio {ratio:.4}"
                    ),
                );
                StartState::Steady
            }
            Ok(Equilibrium { ratio, .. }) => {
                self.log(
                    false,
                    format!("equilibrium of the clamping forces at the ratio {ratio:.6}"),
                );
                StartState::Steady
            }
            Err(_) => {
                self.state = at_ratio;
                self.log(
                    true,
                    format!(
                        "no equilibrium of the two clamping forces was found: the run starts from the steady state at the \
                         initial ratio, where the primary force would have to be {holding:.1} N"
                    ),
                );
                if found == StartState::Steady {
                    StartState::NoEquilibrium
                } else {
                    found
                }
            }
        }
    }
}

/// Clamping forces among the inputs, N.
fn clamping(inputs: &Inputs) -> PerPulley<f64> {
    PerPulley::from_fn(|pulley| inputs.pulley(pulley).clamping_force)
}
