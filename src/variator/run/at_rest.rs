//! Starts of a belt at rest: brought to rest from a slow motion, or clamped from the unloaded state.

use crate::pulley::Pulley;
use crate::solver::sdirk::Stalled;
use crate::variator::run::inputs::InputProfile;
use crate::variator::run::plant::Plant;
use crate::variator::run::soft_start::{SHARPENING, SoftStart};
use crate::variator::run::stepper::{Accurate, COLD_STEP, Stepper};
use crate::variator::settings::parameters::{Axial, Drive};
use crate::variator::settings::signals::Inputs;
use crate::variator::survey::belt_survey::NO_FORCE;

/// Time in which a belt that is clamped at a standstill settles, s, and the tolerance of the steps: only the end counts.
const SETTLING: f64 = 0.2;
const SETTLING_TOLERANCE: f64 = 1.0e-2;

/// Time for which a belt that was brought to rest stands before the start, s: friction returns. Where both sheaves are under force,
/// the clamping force replaces the one that held the ratio.
const STANDING: f64 = 5.0e-4;
const CLAMPING: f64 = 1.0e-2;

/// Residuals that this may take.
const MOST_RESIDUALS: u64 = 20_000;

/// Why a belt was not clamped or brought to rest.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unsettled {
    /// A step is not possible.
    #[error(transparent)]
    Stalled(#[from] Stalled),
    /// It takes more work than a start may.
    #[error("it does not settle within {MOST_RESIDUALS} residuals")]
    Exhausted,
}

impl Plant {
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
        self.clamp_before(SETTLING, self.settling_tolerance(), inputs)?;
        Ok(true)
    }

    /// Lets clamping forces come in over the first milliseconds, so that a run without load begins clamped.
    ///
    /// # Errors
    /// As [`Plant::clamp_at_rest`].
    pub fn clamp_softly(&mut self, inputs: &Inputs) -> Result<(), Unsettled> {
        self.clamp_before(SHARPENING, self.system.parameters.solver.tolerance, inputs)
    }

    /// Lets a belt that nothing clamps hang before a start at a standstill, without loads. From the kinematic state, whose elements all touch,
    /// the film between them makes the first millisecond of a run take as many steps as seconds do.
    ///
    /// # Errors
    /// As [`Plant::clamp_at_rest`].
    pub fn let_hang(&mut self) -> Result<(), Unsettled> {
        self.settle_before(SHARPENING, self.settling_tolerance(), &Inputs::ZERO, |from| SoftStart {
            from,
        })?;
        self.soft_start = SoftStart { from: self.time };
        Ok(())
    }

    /// Stops belt and shafts where they are, and holds the shafts while the clamping forces act. Places and the distribution of the
    /// elements remain, and so do ring tension and push force. Friction depends on the sliding speed: it returns within microseconds.
    ///
    /// # Errors
    /// As [`Plant::clamp_at_rest`].
    pub fn bring_to_rest(&mut self, inputs: &Inputs) -> Result<(), Unsettled> {
        let belt = &self.system.belt;
        for (speed, has_position) in self.state.y.iter_mut().zip(&belt.has_position) {
            if *has_position {
                *speed = 0.0;
            }
        }
        for cell in &belt.cells_at {
            self.state.y[cell.speed] = 0.0;
        }
        for pulley in Pulley::BOTH {
            self.state.y[belt.layout.shaft_speed(pulley)] = 0.0;
        }
        self.state.y_dot.fill(0.0);
        let own = self.system.parameters.clone();
        let mut still = *inputs;
        (still.primary.speed_setpoint, still.secondary.speed_setpoint) = (0.0, 0.0);
        let p = &mut self.system.parameters;
        (p.primary.drive, p.secondary.drive) = (Drive::Speed, Drive::Speed);
        let span = if p.holds_a_sheave() { STANDING } else { CLAMPING };
        let outcome = self.settle_before(span, self.settling_tolerance(), &still, |_| SoftStart::NONE);
        self.system.parameters = own;
        outcome
    }

    fn settling_tolerance(&self) -> f64 {
        self.system.parameters.solver.tolerance.max(SETTLING_TOLERANCE)
    }

    /// Lets the clamping forces act on an unloaded belt in the `span` before the start, s. Torques come with the run.
    fn clamp_before(&mut self, span: f64, tolerance: f64, inputs: &Inputs) -> Result<(), Unsettled> {
        let mut quiet = *inputs;
        (quiet.primary.torque, quiet.secondary.torque) = (0.0, 0.0);
        self.settle_before(span, tolerance, &quiet, |from| SoftStart { from })
    }

    /// Advances the belt through the `span` before the start, s, under constant inputs; `soft_start` gets the time at which it begins.
    fn settle_before(
        &mut self,
        span: f64,
        tolerance: f64,
        inputs: &Inputs,
        soft_start: impl FnOnce(f64) -> SoftStart,
    ) -> Result<(), Unsettled> {
        let start = self.time;
        self.time = start - span;
        self.soft_start = soft_start(self.time);
        let own = std::mem::replace(&mut self.system.parameters.solver.tolerance, tolerance);
        let mut accurate = Accurate::new(&self.system, COLD_STEP);
        let profile = InputProfile::constant(self.time, inputs);
        let outcome = loop {
            match accurate.step(self, &profile, start) {
                Ok(false) if accurate.counts().residuals > MOST_RESIDUALS => break Err(Unsettled::Exhausted),
                Ok(false) => {}
                Ok(true) => break Ok(()),
                Err(stalled) => break Err(stalled.into()),
            }
        };
        self.start_work += accurate.counts();
        self.system.parameters.solver.tolerance = own;
        self.time = start;
        self.end_soft_start();
        outcome
    }
}
