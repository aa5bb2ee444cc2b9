//! The state that a run starts from: unloaded or steady as the parameters choose, else the nearest that exists.

use crate::pulley::{PerPulley, Pulley};
use crate::solver::State;
use crate::solver::newton::Counts;
use crate::variator::belt::ring::BeltRing;
use crate::variator::run::outcome::{InitialisationError, Message, StepError};
use crate::variator::run::simulation::Simulation;
use crate::variator::run::soft_start::SoftStart;
use crate::variator::run::steady_start::{NoSteadyState, StartSearch};
use crate::variator::run::tuning::{CREEP_SPEED, CREEP_VELOCITY, RAMP, STANDSTILL};
use crate::variator::settings::parameters::{Drive, Mode};
use crate::variator::settings::signals::{Inputs, StartState};
use crate::variator::steady::start::{Start, kinematic_state};
use std::sync::Arc;

/// Finds the state to start from at `time`: steady or unloaded as the parameters choose, else the nearest that exists, with a warning that
/// gives it and the reason. Returns what it is.
pub(super) fn find_start(
    simulation: &mut Simulation,
    messages: &mut Vec<Message>,
    time: f64,
    inputs: &Inputs,
) -> Result<StartState, InitialisationError> {
    simulation.start_work = Counts::default();
    simulation.time = time;
    let mut search = StartSearch {
        simulation,
        messages,
        inputs,
    };
    search.clamp_initial_ratio();
    let start = search.start_point();
    let found = search.find_state(&start)?;
    search.warn_of_held_sheaves(found);
    if simulation.system.parameters.solver.mode == Mode::RealTime && simulation.soft_start.from == time {
        // A ring without tension is a mechanism, too rough for steps of bounded work.
        if let Err(why) = simulation.clamp_softly(inputs) {
            messages.push(no_clamping(&why));
        }
    }
    Ok(found)
}

fn no_clamping(why: &StepError) -> Message {
    Message {
        warning: true,
        text: format!("the belt was not clamped before the start: {why}"),
    }
}

impl StartSearch<'_> {
    /// Moves an initial ratio beyond an end stop to the stop.
    fn clamp_initial_ratio(&mut self) {
        let parameters = &mut self.simulation.system.parameters;
        let (lowest, highest) = parameters.ratio_range();
        let given = parameters.initial.ratio;
        let ratio = given.clamp(lowest, highest);
        if ratio != given {
            parameters.initial.ratio = ratio;
            let text = format!(
                "initial.ratio = {given} lies beyond an end stop, where only a loaded belt rests: the run starts at {ratio:.6}"
            );
            self.log(false, text);
        }
    }

    /// The kinematic state to start from: a set point of a shaft's speed comes before `initial.primarySpeed`.
    fn start_point(&mut self) -> Start {
        let (parameters, inputs) = (&self.simulation.system.parameters, self.inputs);
        let (ratio, given) = (parameters.initial.ratio, parameters.initial.primary_speed);
        let primary_speed = match (parameters.primary.drive, parameters.secondary.drive) {
            (Drive::Speed, _) => inputs.primary.speed_setpoint,
            (Drive::Torque, Drive::Speed) => inputs.secondary.speed_setpoint * ratio,
            (Drive::Torque, Drive::Torque) => given,
        };
        let clamping = parameters.closing_forces(inputs, [ratio, primary_speed]);
        if primary_speed != given {
            let text = format!(
                "a shaft follows its set point: the run starts near {primary_speed} rad/s at the primary pulley, not at \
                 initial.primarySpeed = {given} rad/s"
            );
            self.log(false, text);
        }
        Start {
            ratio,
            primary_speed,
            clamping,
        }
    }

    /// Warns where both sheaves are held: clamping forces have no effect in the run.
    fn warn_of_held_sheaves(&mut self, found: StartState) {
        if !self.simulation.system.parameters.holds_both_sheaves() {
            return;
        }
        let text = if matches!(
            found,
            StartState::Steady | StartState::ReducedTorque | StartState::Clamped
        ) {
            "both sheaves are held: the belt's tension follows from secondary.clampingForce at the start, later clamping \
             forces are ignored"
        } else {
            "both sheaves are held in a start without load: the belt has no tension and carries next to nothing, clamping \
             forces are ignored"
        };
        self.log(true, text.into());
    }

    /// Sets the state that a run starts from.
    fn find_state(&mut self, start: &Start) -> Result<StartState, InitialisationError> {
        self.simulation.end_soft_start();
        if let Some(ring) = self.simulation.system.belt.ring.starts_on() {
            return self.start_on(ring, start);
        }
        if !self.simulation.system.parameters.initial.steady {
            return self.start_slack(start);
        }
        if start.primary_speed.abs() <= STANDSTILL {
            return self.start_at_rest(start);
        }
        self.start_cold(start)?;
        self.solve_steady().or_else(|why| match why {
            NoSteadyState::Beyond(_) | NoSteadyState::TooFast(_) => Err(InitialisationError::NoState(why.to_string())),
            why => {
                self.log(
                    true,
                    format!("{why}: the run starts unloaded, with soft friction that sharpens over {RAMP} s"),
                );
                self.start_unloaded(start)?;
                Ok(StartState::NotFound)
            }
        })
    }

    /// Starts at a standstill: as a belt that crept, or else clamped from the unloaded state.
    fn start_at_rest(&mut self, start: &Start) -> Result<StartState, InitialisationError> {
        if self.may_creep(start)
            && let Some(found) = self.stop_creeping(start)?
        {
            return Ok(found);
        }
        self.start_unloaded(start)?;
        match self.simulation.clamp_at_rest(self.inputs) {
            Ok(true) => Ok(StartState::Clamped),
            Ok(false) => self.start_slack(start),
            Err(why) => {
                self.messages.push(no_clamping(&why));
                self.start_unloaded(start)?;
                Ok(StartState::Unloaded)
            }
        }
    }

    /// Whether a start at a standstill may be that of a belt that crept: both pulleys stand still under clamping forces, and a sheave
    /// is held or the torques drive the belt.
    fn may_creep(&self, start: &Start) -> bool {
        let (p, inputs) = (&self.simulation.system.parameters, self.inputs);
        let stands = p.secondary.drive == Drive::Torque || inputs.secondary.speed_setpoint.abs() <= STANDSTILL;
        let free = p.primary.drive == Drive::Torque && p.secondary.drive == Drive::Torque;
        let torque = inputs.primary.torque + inputs.secondary.torque / start.ratio;
        let driven = free && torque * creep_speed(start) > 0.0;
        stands && self.simulation.is_clamped(inputs) && (p.holds_a_sheave() || driven)
    }

    /// Starts at rest with the forces of a belt that creeps at the torques: Coulomb friction leaves the forces of a belt at rest
    /// open, so they are those of the motion before. None with a warning where there is no such state, and none where both sheaves are
    /// under force and friction holds the torques: a belt that crept would roll back.
    fn stop_creeping(&mut self, start: &Start) -> Result<Option<StartState>, InitialisationError> {
        let primary_speed = creep_speed(start);
        let mut creeping = self.simulation.clone();
        creeping.state = self.kinematic_state(&Start {
            primary_speed,
            ..*start
        })?;
        creeping.system.parameters.friction.velocity = CREEP_VELOCITY;
        let before = self.messages.len();
        let mut search = StartSearch {
            simulation: &mut creeping,
            messages: self.messages,
            inputs: self.inputs,
        };
        let found = search.solve_steady();
        let of_belt = creeping.sums().shaft_torque.primary;
        self.simulation.take_start(creeping);
        let holds = (self.inputs.primary.torque + of_belt) * primary_speed <= 0.0;
        if found.is_ok() && holds && !self.simulation.system.parameters.holds_a_sheave() {
            self.messages.truncate(before);
            return Ok(None);
        }
        let stopped = found.and_then(|found| {
            self.simulation.bring_to_rest(self.inputs)?;
            Ok(found)
        });
        Ok(match stopped {
            Ok(StartState::Steady) => Some(StartState::Clamped),
            Ok(found) => Some(found),
            Err(why) => {
                self.log(
                    true,
                    format!("{why}: the run starts at rest without the forces of a belt that has run before"),
                );
                None
            }
        })
    }

    fn kinematic_state(&self, start: &Start) -> Result<State, InitialisationError> {
        kinematic_state(&self.simulation.system.belt, start).map_err(|e| InitialisationError::NoState(e.to_string()))
    }

    /// Starts in the kinematic state, the secondary pulley at its set point if it has one.
    fn start_cold(&mut self, start: &Start) -> Result<(), InitialisationError> {
        self.simulation.state = self.kinematic_state(start)?;
        if self.simulation.system.parameters.secondary.drive == Drive::Speed {
            let i = self.simulation.system.belt.layout.shaft_speed(Pulley::Secondary);
            self.simulation.state.y[i] = self.inputs.secondary.speed_setpoint;
        }
        Ok(())
    }

    /// Starts unloaded; friction comes in softly.
    fn start_unloaded(&mut self, start: &Start) -> Result<(), InitialisationError> {
        let clamping = PerPulley::default();
        self.start_cold(&Start { clamping, ..*start })?;
        self.simulation.soft_start = SoftStart {
            from: self.simulation.time,
        };
        Ok(())
    }

    /// Starts unloaded; at a standstill the belt has come to hang.
    fn start_slack(&mut self, start: &Start) -> Result<StartState, InitialisationError> {
        self.start_unloaded(start)?;
        if start.primary_speed.abs() <= STANDSTILL && self.simulation.let_hang().is_err() {
            self.start_unloaded(start)?;
        }
        Ok(StartState::Unloaded)
    }

    /// Starts in the state of another ring.
    fn start_on(&mut self, ring: Arc<dyn BeltRing>, start: &Start) -> Result<StartState, InitialisationError> {
        let parameters = &self.simulation.system.parameters;
        ring.check(parameters)?;
        let mut other = Simulation::new(parameters, ring);
        other.time = self.simulation.time;
        let mut search = StartSearch {
            simulation: &mut other,
            messages: self.messages,
            inputs: self.inputs,
        };
        let found = search.find_state(start)?;
        self.simulation.soft_start = other.soft_start;
        self.simulation.start_work = other.start_work;
        let belt = &self.simulation.system.belt;
        self.simulation.state = belt.ring.start_from(belt, &other.system.belt, &other.state);
        Ok(found)
    }
}

/// Speed of the primary pulley of the belt that creeps into a standstill, rad/s: forward unless the given speed is negative.
fn creep_speed(start: &Start) -> f64 {
    CREEP_SPEED.copysign(start.primary_speed)
}
