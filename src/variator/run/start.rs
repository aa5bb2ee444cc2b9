//! The state that a run starts from: unloaded or steady by the parameters, else the nearest.

use super::outcome::{InitialisationError, OtherStart, StepError};
use super::simulation::Simulation;
use super::steady_start::NoSteadyState;
use super::stepper::Stepper;
use super::tuning::{
    COLD_STEP, CREEP_SPEED, CREEP_VELOCITY, SETTLING, SETTLING_TOLERANCE, SOFT_START, STANDSTILL,
};
use crate::pulley::{PerPulley, Pulley};
use crate::solver::State;
use crate::solver::newton::Counts;
use crate::variator::belt::ring::MaterialMesh;
use crate::variator::diagnostics::belt::NO_FORCE;
use crate::variator::pulleys::loads::InputProfile;
use crate::variator::settings::capacity::{given_speed, short};
use crate::variator::settings::{Axial, Drive, Inputs, Mode, StartState};
use crate::variator::steady::start::{Start, kinematic_state};

impl Simulation {
    /// Finds the state to start from at `time`, with sheaves at rest; instead of the requested one
    /// perhaps the nearest, with a warning that names it and the reason.
    pub fn find_start(&mut self, time: f64, inputs: &Inputs) -> Result<StartState, InitialisationError> {
        (self.start_work, self.time, self.given) = (Counts::default(), time, *inputs);
        self.other_start = None;
        let start = self.start_point();
        let found = self.find_state(&start)?;
        if let Some(why) = self.other_start.take() {
            if self.system.parameters.initial.strict {
                let text = format!("{why}; with initial.strict = true this start is an error");
                return Err(InitialisationError::NoState(text));
            }
            self.log(true, why);
        }
        self.warn_of_held_sheaves(found);
        if self.system.parameters.solver.mode == Mode::RealTime && self.soft_since == time {
            // A ring without tension is a mechanism, which takes too much work for real time.
            if let Err(why) = self.clamp(SOFT_START.duration) {
                self.log(true, format!("the belt was not clamped before the start: {why}"));
            }
        }
        // After clamping they move by a tenth of a millimetre a second. Flows that depend on no
        // input close no loop.
        for pulley in Pulley::BOTH {
            self.state.y[self.system.belt.layout.sheave(pulley)] = 0.0;
        }
        Ok(found)
    }

    /// The kinematic state to start from. An initial ratio beyond an end stop is moved to the stop,
    /// and a set point of a shaft replaces `initial.primarySpeed`.
    fn start_point(&mut self) -> Start {
        let start = self.wanted_start();
        let Start {
            ratio, primary_speed, ..
        } = start;
        let initial = &mut self.system.parameters.initial;
        let (given_ratio, given_speed) = (initial.ratio, initial.primary_speed);
        initial.ratio = ratio;
        if ratio != given_ratio {
            let text = format!(
                "initial.ratio = {given_ratio} lies beyond an end stop, where only a loaded belt rests: the run starts at {ratio:.6}"
            );
            self.log(false, text);
        }
        if primary_speed != given_speed {
            let text = format!(
                "a shaft follows its set point: the run starts near {primary_speed} rad/s at the primary pulley, not at \
                 initial.primarySpeed = {given_speed} rad/s"
            );
            self.log(false, text);
        }
        start
    }

    /// The same without a message.
    pub fn wanted_start(&self) -> Start {
        let (parameters, inputs) = (&self.system.parameters, &self.given);
        let range = parameters.ratio_range();
        let ratio = parameters.initial.ratio.clamp(*range.start(), *range.end());
        let primary_speed = match (parameters.primary.drive, parameters.secondary.drive) {
            (Drive::Speed, _) => inputs.primary.speed_setpoint,
            (Drive::Torque, Drive::Speed) => inputs.secondary.speed_setpoint * ratio,
            (Drive::Torque, Drive::Torque) => parameters.initial.primary_speed,
        };
        Start {
            ratio,
            primary_speed,
            clamping: parameters.total_clamping_forces(inputs, ratio, primary_speed),
        }
    }

    /// Warns where both sheaves are held: clamping forces have no effect in the run.
    fn warn_of_held_sheaves(&mut self, found: StartState) {
        if !self.system.parameters.holds_both_sheaves() {
            return;
        }
        let text = match found {
            StartState::Unloaded | StartState::NotFound => {
                "both sheaves are held in a start without load: the belt has no tension and carries next to nothing, clamping \
                 forces are ignored"
            }
            _ => {
                "both sheaves are held: the belt's tension follows from secondary.clampingForce at the start, later clamping \
                 forces are ignored"
            }
        };
        self.log(true, text.into());
    }

    /// Sets the state that a run starts from.
    fn find_state(&mut self, start: &Start) -> Result<StartState, InitialisationError> {
        self.end_soft_start();
        if let Some(material) = self.system.belt.material_mesh.clone() {
            return self.start_on(material, start);
        }
        if !self.system.parameters.initial.steady {
            return self.start_slack(start);
        }
        if start.primary_speed.abs() <= STANDSTILL {
            return self.start_at_rest(start);
        }
        self.state = self.cold_state(start)?;
        self.solve_steady().or_else(|why| match why {
            NoSteadyState::Hopeless(_) => Err(InitialisationError::NoState(why.to_string())),
            NoSteadyState::NotFound(why) => {
                self.start_unloaded(start)?;
                let duration = SOFT_START.duration;
                let other = OtherStart {
                    why: &why,
                    instead: &format!("the belt without load, and friction sharpens over {duration} s"),
                    helps: "larger clamping forces, another initial.ratio, or forces that come in after a start with initial.steady = false",
                };
                Ok(self.start_from(StartState::NotFound, &other))
            }
        })
    }

    /// Notes another start than the requested one, with its reason.
    pub fn start_from(&mut self, found: StartState, other: &OtherStart<'_>) -> StartState {
        let (of, inputs) = (&self.system.parameters, &self.given);
        let ratio = of.initial.ratio;
        let (name, speed) = given_speed(of, inputs);
        let clamping = of.total_clamping_forces(inputs, ratio, self.primary_speed()).map(short);
        let OtherStart { why, instead, helps } = other;
        let [first, second] = [inputs.primary.torque, inputs.secondary.torque];
        self.other_start = Some(format!(
            "{why}; asked for: ratio {ratio}, {name} = {speed} rad/s, torques {first} and {second} N·m and clamping forces {} and {} N \
             (primary, secondary); found: {instead} (initial.found = {}, {found:?}); what helps: {helps}",
            clamping.primary, clamping.secondary, found as i32
        ));
        found
    }

    /// Starts at a standstill: as a belt that crept, else clamped from the unloaded state.
    fn start_at_rest(&mut self, start: &Start) -> Result<StartState, InitialisationError> {
        if let Some(found) = self.stop_creeping(start)? {
            return Ok(found);
        }
        if self.system.parameters.holds_both_sheaves() || !self.is_clamped() {
            return self.start_slack(start);
        }
        self.start_unloaded(start)?;
        let Err(why) = self.clamp(SETTLING) else {
            return Ok(StartState::Clamped);
        };
        self.start_unloaded(start)?;
        let other = OtherStart {
            why: &format!("the belt was not clamped at a standstill: {why}"),
            instead: "the belt without load",
            helps: "other clamping forces, or a start with initial.steady = false",
        };
        Ok(self.start_from(StartState::NotFound, &other))
    }

    /// Whether a belt at a standstill may have crept: both pulleys stand still under clamping
    /// forces, and a sheave is held or the torques drive the belt.
    fn may_creep(&self, start: &Start) -> bool {
        let (p, inputs) = (&self.system.parameters, self.given);
        let stands =
            p.secondary.drive == Drive::Torque || inputs.secondary.speed_setpoint.abs() <= STANDSTILL;
        let free = p.primary.drive == Drive::Torque && p.secondary.drive == Drive::Torque;
        let torque = inputs.primary.torque + inputs.secondary.torque / start.ratio;
        let driven = free && torque * creep_speed(start) > 0.0;
        stands && self.is_clamped() && (p.holds_a_sheave() || driven)
    }

    /// Starts at rest with the forces of a belt that creeps at the torques: Coulomb friction does
    /// not determine the forces of a belt at rest. Returns none where the belt may not creep; with
    /// a warning, where there is no such state; and where both sheaves are under force and friction
    /// holds the torques: a belt that crept would roll back.
    fn stop_creeping(&mut self, start: &Start) -> Result<Option<StartState>, InitialisationError> {
        if !self.may_creep(start) {
            return Ok(None);
        }
        let primary_speed = creep_speed(start);
        let mut creeping = self.clone();
        creeping.state = self.kinematic_state(&Start {
            primary_speed,
            ..*start
        })?;
        creeping.system.parameters.friction.velocity = CREEP_VELOCITY;
        let before = self.messages.len();
        let found = creeping.solve_steady();
        let of_belt = creeping.sums().shaft_torque.primary;
        self.take_start(creeping);
        let holds = (self.given.primary.torque + of_belt) * primary_speed <= 0.0;
        if found.is_ok() && holds && !self.system.parameters.holds_a_sheave() {
            self.messages.truncate(before);
            self.other_start = None;
            return Ok(None);
        }
        let stopped = found.and_then(|found| {
            let rests = self.bring_to_rest().map(|()| found);
            rests.map_err(|why| NoSteadyState::NotFound(format!("the belt was not brought to rest: {why}")))
        });
        Ok(match stopped {
            Ok(StartState::Steady) => Some(StartState::Clamped),
            Ok(found) => Some(found),
            Err(why) => {
                self.other_start = None;
                self.log(
                    true,
                    format!("{why}: the run starts at rest without the forces of a belt that has run before"),
                );
                None
            }
        })
    }

    fn kinematic_state(&self, start: &Start) -> Result<State, InitialisationError> {
        kinematic_state(&self.system.belt, start).map_err(|e| InitialisationError::NoState(e.to_string()))
    }

    /// The kinematic state, the secondary pulley at its set point if it has one.
    pub fn cold_state(&self, start: &Start) -> Result<State, InitialisationError> {
        let mut state = self.kinematic_state(start)?;
        if self.system.parameters.secondary.drive == Drive::Speed {
            let i = self.system.belt.layout.shaft_speed(Pulley::Secondary);
            state.y[i] = self.given.secondary.speed_setpoint;
        }
        Ok(state)
    }

    /// Starts unloaded; the friction velocity falls from a larger one.
    fn start_unloaded(&mut self, start: &Start) -> Result<(), InitialisationError> {
        let clamping = PerPulley::default();
        self.state = self.cold_state(&Start { clamping, ..*start })?;
        self.soft_since = self.time;
        Ok(())
    }

    /// Starts unloaded. At a standstill the belt is relaxed before: in the kinematic state all
    /// elements touch, and the first millisecond of a run would take as many steps as seconds do.
    fn start_slack(&mut self, start: &Start) -> Result<StartState, InitialisationError> {
        self.start_unloaded(start)?;
        if start.primary_speed.abs() <= STANDSTILL {
            let relaxed = self.relax(SOFT_START.duration, &Inputs::ZERO, |_| ());
            self.soft_since = self.time;
            if relaxed.is_err() {
                self.start_unloaded(start)?;
            }
        }
        Ok(StartState::Unloaded)
    }

    fn start_on(&mut self, material: MaterialMesh, start: &Start) -> Result<StartState, InitialisationError> {
        let parameters = &self.system.parameters;
        material.starts_on.check(parameters)?;
        let mut other = Simulation::new(parameters, material.starts_on);
        (other.time, other.given) = (self.time, self.given);
        let found = other.find_state(start);
        self.messages.append(&mut other.messages);
        let found = found?;
        self.soft_since = other.soft_since;
        self.start_work = other.start_work;
        self.other_start = other.other_start;
        self.state = (material.start)(&self.system.belt, &other.system.belt, &other.state);
        Ok(found)
    }

    /// Clamps an unloaded belt in the `span` before the start, s, without torques. After an error
    /// it is clamped in part.
    fn clamp(&mut self, span: f64) -> Result<(), StepError> {
        let mut quiet = self.given;
        (quiet.primary.torque, quiet.secondary.torque) = (0.0, 0.0);
        self.relax(span, &quiet, |_| ())
    }

    /// Whether each sheave is held or closed by a force at the initial ratio.
    fn is_clamped(&self) -> bool {
        let parameters = &self.system.parameters;
        let clamping = parameters.total_clamping_forces(&self.given, parameters.initial.ratio, 0.0);
        let held = |pulley: Pulley| parameters.pulley(pulley).axial == Axial::Held;
        Pulley::BOTH
            .into_iter()
            .all(|pulley| held(pulley) || clamping[pulley] >= NO_FORCE)
    }

    /// Stops belt and shafts where they are, and holds the shafts while the clamping forces act.
    /// Friction depends on the sliding speed: it returns within microseconds. Where both sheaves
    /// are under force, the clamping force replaces the one that held the ratio. Between held
    /// sheaves the belt loses tension, 6 % in 10 ms, so it stands for a part of the soft start
    /// only.
    fn bring_to_rest(&mut self) -> Result<(), StepError> {
        let belt = &self.system.belt;
        let shafts = Pulley::BOTH.map(|pulley| belt.layout.shaft_speed(pulley));
        let elements = belt.cells_at.iter().map(|cell| cell.speed);
        let rates = (0..belt.layout.len()).filter(|&i| belt.has_position[i]);
        for i in rates.chain(elements).chain(shafts) {
            self.state.y[i] = 0.0;
        }
        self.state.y_dot.fill(0.0);
        let mut still = self.given;
        (still.primary.speed_setpoint, still.secondary.speed_setpoint) = (0.0, 0.0);
        let holds = self.system.parameters.holds_a_sheave();
        let parts = if holds { SOFT_START.parts } else { 1.0 };
        self.relax(SOFT_START.duration / parts, &still, |before| {
            before.soft_since = f64::NEG_INFINITY;
            let p = &mut before.system.parameters;
            (p.primary.drive, p.secondary.drive) = (Drive::Speed, Drive::Speed);
        })
    }

    /// Advances a changed copy under constant inputs in the `span` before the start, s, as far as
    /// possible, and takes its state. The friction velocity falls from a larger one.
    fn relax(&mut self, span: f64, inputs: &Inputs, change: impl FnOnce(&mut Self)) -> Result<(), StepError> {
        let mut before = self.clone();
        before.time -= span;
        before.soft_since = before.time;
        let solver = &mut before.system.parameters.solver;
        (solver.mode, solver.tolerance) = (Mode::Accurate, solver.tolerance.max(SETTLING_TOLERANCE));
        change(&mut before);
        let mut stepper = Stepper::new(&before, COLD_STEP);
        let mut step = stepper.begin(&before, self.time, inputs, InputProfile::constant(inputs));
        let mut outcome = Ok(());
        while outcome.is_ok() && !step.is_over() {
            outcome = stepper.step(&mut before, &mut step);
        }
        before.start_work += stepper.counts();
        self.take_start(before);
        outcome
    }

    /// Takes the state that another simulation of the same belt has found, with its work.
    fn take_start(&mut self, found: Self) {
        self.state = found.state;
        self.start_work = found.start_work;
        self.messages = found.messages;
        self.other_start = found.other_start;
        self.end_soft_start();
    }
}

/// Speed of the primary pulley of the belt that creeps into a standstill, rad/s.
fn creep_speed(start: &Start) -> f64 {
    CREEP_SPEED.copysign(start.primary_speed)
}
