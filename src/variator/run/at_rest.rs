//! Starts of a belt at rest: brought to rest from a slow motion, or clamped from the unloaded state.

use crate::pulley::Pulley;
use crate::variator::diagnostics::belt::NO_FORCE;
use crate::variator::pulleys::loads::InputProfile;
use crate::variator::run::outcome::StepError;
use crate::variator::run::simulation::Simulation;
use crate::variator::run::soft_start::SoftStart;
use crate::variator::run::stepper::Stepper;
use crate::variator::run::tuning::{COLD_STEP, RAMP, RAMP_PARTS, SETTLING, SETTLING_TOLERANCE};
use crate::variator::settings::parameters::{Axial, Drive};
use crate::variator::settings::signals::Inputs;

impl Simulation {
    /// Whether each sheave is held or closed by a force at the initial ratio.
    pub fn is_clamped(&self, inputs: &Inputs) -> bool {
        let parameters = &self.system.parameters;
        let closing = parameters.closing_forces(inputs, [parameters.initial.ratio, 0.0]);
        let held = |pulley: Pulley| parameters.pulley(pulley).axial == Axial::Held;
        Pulley::BOTH
            .into_iter()
            .all(|pulley| held(pulley) || closing[pulley] >= NO_FORCE)
    }

    /// Clamps and settles an unloaded belt at a standstill. Whether there is something to clamp it with.
    ///
    /// # Errors
    /// The belt is then clamped in part.
    pub fn clamp_at_rest(&mut self, inputs: &Inputs) -> Result<bool, StepError> {
        if self.system.parameters.holds_both_sheaves() || !self.is_clamped(inputs) {
            return Ok(false);
        }
        self.settle(SETTLING, &without_torques(inputs), |_| ())?;
        Ok(true)
    }

    /// Lets clamping forces come in over the first milliseconds, so that a run without load begins clamped.
    ///
    /// # Errors
    /// As [`Simulation::clamp_at_rest`].
    pub fn clamp_softly(&mut self, inputs: &Inputs) -> Result<(), StepError> {
        self.settle(RAMP, &without_torques(inputs), |_| ())
    }

    /// Lets a belt that nothing clamps hang before a start at a standstill, without loads. From the kinematic state, whose elements all touch,
    /// the film between them makes the first millisecond of a run take as many steps as seconds do.
    ///
    /// # Errors
    /// As [`Simulation::clamp_at_rest`].
    pub fn let_hang(&mut self) -> Result<(), StepError> {
        self.settle(RAMP, &Inputs::ZERO, |_| ())?;
        self.soft_start = SoftStart { from: self.time };
        Ok(())
    }

    /// Stops belt and shafts where they are, and holds the shafts while the clamping forces act. Places and the distribution of the
    /// elements remain, and so do ring tension and push force. Friction depends on the sliding speed: it returns within microseconds.
    /// Where both sheaves are under force, the clamping force replaces the one that held the ratio. Between held sheaves the belt loses
    /// tension, 6 % in 10 ms, so it stands for a part of the ramp only.
    ///
    /// # Errors
    /// As [`Simulation::clamp_at_rest`].
    pub fn bring_to_rest(&mut self, inputs: &Inputs) -> Result<(), StepError> {
        let belt = &self.system.belt;
        let shafts = Pulley::BOTH.map(|pulley| belt.layout.shaft_speed(pulley));
        let elements = belt.cells_at.iter().map(|cell| cell.speed);
        let places = (0..belt.layout.len()).filter(|&i| belt.has_position[i]);
        for i in places.chain(elements).chain(shafts) {
            self.state.y[i] = 0.0;
        }
        self.state.y_dot.fill(0.0);
        let mut still = *inputs;
        (still.primary.speed_setpoint, still.secondary.speed_setpoint) = (0.0, 0.0);
        let holds = self.system.parameters.holds_a_sheave();
        self.settle(if holds { RAMP / RAMP_PARTS } else { RAMP }, &still, |before| {
            before.soft_start = SoftStart::NONE;
            let p = &mut before.system.parameters;
            (p.primary.drive, p.secondary.drive) = (Drive::Speed, Drive::Speed);
        })
    }

    /// Advances a copy, changed, under constant inputs in the `span` before the start, s, and takes over its state, where possible.
    /// Friction comes in softly.
    fn settle(&mut self, span: f64, inputs: &Inputs, change: impl FnOnce(&mut Self)) -> Result<(), StepError> {
        let mut before = self.clone();
        before.time -= span;
        before.soft_start = SoftStart { from: before.time };
        let solver = &mut before.system.parameters.solver;
        solver.tolerance = solver.tolerance.max(SETTLING_TOLERANCE);
        change(&mut before);
        let mut stepper = Stepper::accurate(&before, COLD_STEP);
        let profile = InputProfile::constant(inputs);
        let outcome = loop {
            match stepper.step(&mut before, &profile, self.time) {
                Ok(false) => {}
                Ok(true) => break Ok(()),
                Err(error) => break Err(error),
            }
        };
        before.start_work += stepper.counts();
        self.take_start(before);
        outcome
    }

    /// Takes over the state that another simulation of the same belt has found, with its work.
    pub fn take_start(&mut self, found: Self) {
        self.state = found.state;
        self.start_work = found.start_work;
        self.end_soft_start();
    }
}

/// Torques come with the run.
fn without_torques(inputs: &Inputs) -> Inputs {
    let mut quiet = *inputs;
    (quiet.primary.torque, quiet.secondary.torque) = (0.0, 0.0);
    quiet
}
