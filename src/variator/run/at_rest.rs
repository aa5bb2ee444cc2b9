//! Starts of a belt at rest: brought to rest from a slow motion, or clamped from the unloaded state.

use crate::pulley::Pulley;
use crate::solver::sdirk::Stalled;
use crate::variator::diagnostics::belt::NO_FORCE;
use crate::variator::pulleys::loads::InputProfile;
use crate::variator::run::simulation::Simulation;
use crate::variator::run::soft_start::SoftStart;
use crate::variator::run::stepper::{Accurate, Stepper};
use crate::variator::run::tuning::{
    COLD_STEP, FRICTION_RAMP, SETTLING, SETTLING_RESIDUALS, SETTLING_TOLERANCE, STANDING,
};
use crate::variator::settings::parameters::{Axial, Drive};
use crate::variator::settings::signals::Inputs;

/// Why a belt was not clamped or brought to rest.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unsettled {
    /// A step is not possible.
    #[error(transparent)]
    Stalled(#[from] Stalled),
    /// It takes more work than a start may.
    #[error("it does not settle within {SETTLING_RESIDUALS} residuals")]
    Exhausted,
}

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
    pub fn clamp_at_rest(&mut self, inputs: &Inputs) -> Result<bool, Unsettled> {
        if self.system.parameters.holds_both_sheaves() || !self.is_clamped(inputs) {
            return Ok(false);
        }
        self.settle(SETTLING, SETTLING_TOLERANCE, &without_torques(inputs), |_| ())?;
        Ok(true)
    }

    /// Lets clamping forces come in over the first milliseconds, so that a run without load begins clamped.
    ///
    /// # Errors
    /// As [`Simulation::clamp_at_rest`].
    pub fn clamp_softly(&mut self, inputs: &Inputs) -> Result<(), Unsettled> {
        self.settle(FRICTION_RAMP, 0.0, &without_torques(inputs), |_| ())
    }

    /// Lets a belt that nothing clamps hang before a start at a standstill, without loads. From the kinematic state, whose elements all touch,
    /// the film between them makes the first millisecond of a run take as many steps as seconds do.
    ///
    /// # Errors
    /// As [`Simulation::clamp_at_rest`].
    pub fn let_hang(&mut self) -> Result<(), Unsettled> {
        self.settle(FRICTION_RAMP, SETTLING_TOLERANCE, &Inputs::ZERO, |_| ())?;
        self.soft_start = SoftStart { from: self.time };
        Ok(())
    }

    /// Stops belt and shafts where they are, and holds the shafts while the clamping forces act. Places and the distribution of the
    /// elements remain, and so do ring tension and push force. Friction depends on the sliding speed: it returns within microseconds.
    /// Where both sheaves are under force, the clamping force replaces the one that held the ratio.
    ///
    /// # Errors
    /// As [`Simulation::clamp_at_rest`].
    pub fn bring_to_rest(&mut self, inputs: &Inputs) -> Result<(), Unsettled> {
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
        let span = if self.system.parameters.holds_a_sheave() {
            STANDING
        } else {
            FRICTION_RAMP
        };
        self.settle(span, SETTLING_TOLERANCE, &still, |before| {
            before.soft_start = SoftStart::NONE;
            let p = &mut before.system.parameters;
            (p.primary.drive, p.secondary.drive) = (Drive::Speed, Drive::Speed);
        })
    }

    /// Advances a copy, changed, under constant inputs in the `span` before the start, s, and takes over its state. Loads and friction
    /// come in softly. The tolerance of the steps is that of the parameters or `tolerance`, whichever is larger.
    fn settle(
        &mut self,
        span: f64,
        tolerance: f64,
        inputs: &Inputs,
        change: impl FnOnce(&mut Self),
    ) -> Result<(), Unsettled> {
        let mut before = self.clone();
        before.time -= span;
        before.soft_start = SoftStart { from: before.time };
        let solver = &mut before.system.parameters.solver;
        solver.tolerance = solver.tolerance.max(tolerance);
        change(&mut before);
        let mut accurate = Accurate::new(&before.system, COLD_STEP);
        let profile = InputProfile::constant(inputs);
        let outcome = loop {
            match accurate.step(&mut before, &profile, self.time) {
                Ok(false) if accurate.counts().residuals > SETTLING_RESIDUALS => break Err(Unsettled::Exhausted),
                Ok(false) => {}
                Ok(true) => break Ok(()),
                Err(stalled) => break Err(stalled.into()),
            }
        };
        before.start_work += accurate.counts();
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
