//! Starts of a belt at rest: brought to rest from a slow motion, or clamped from the unloaded state.

use crate::pulley::Pulley;
use crate::solver::sdirk::Stalled;
use crate::variator::diagnostics::belt::NO_FORCE;
use crate::variator::run::inputs::InputProfile;
use crate::variator::run::plant::Plant;
use crate::variator::run::soft_start::{SHARPENING, SoftStart};
use crate::variator::run::stepper::{Accurate, COLD_STEP, Stepper};
use crate::variator::settings::parameters::{Axial, Drive};
use crate::variator::settings::signals::Inputs;

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
        let mut before = self.before(SHARPENING, self.settling_tolerance());
        before.soft_start = SoftStart { from: before.time };
        self.settle(before, &Inputs::ZERO)?;
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
        let mut still = *inputs;
        (still.primary.speed_setpoint, still.secondary.speed_setpoint) = (0.0, 0.0);
        let span = if self.system.parameters.holds_a_sheave() {
            STANDING
        } else {
            CLAMPING
        };
        let mut before = self.before(span, self.settling_tolerance());
        let p = &mut before.system.parameters;
        (p.primary.drive, p.secondary.drive) = (Drive::Speed, Drive::Speed);
        self.settle(before, &still)
    }

    fn settling_tolerance(&self) -> f64 {
        self.system.parameters.solver.tolerance.max(SETTLING_TOLERANCE)
    }

    /// Lets the clamping forces act on an unloaded belt in the `span` before the start, s. Torques come with the run.
    fn clamp_before(&mut self, span: f64, tolerance: f64, inputs: &Inputs) -> Result<(), Unsettled> {
        let mut quiet = *inputs;
        (quiet.primary.torque, quiet.secondary.torque) = (0.0, 0.0);
        let mut before = self.before(span, tolerance);
        before.soft_start = SoftStart { from: before.time };
        self.settle(before, &quiet)
    }

    /// A copy at a time `span` before the start, s, for steps of another tolerance.
    fn before(&self, span: f64, tolerance: f64) -> Self {
        let mut before = self.clone();
        before.time -= span;
        before.soft_start = SoftStart::NONE;
        before.system.parameters.solver.tolerance = tolerance;
        before
    }

    /// Advances a copy to the start under constant inputs, and takes over its state.
    fn settle(&mut self, mut before: Self, inputs: &Inputs) -> Result<(), Unsettled> {
        let mut accurate = Accurate::new(&before.system, COLD_STEP);
        let profile = InputProfile::constant(before.time, inputs);
        let outcome = loop {
            match accurate.step(&mut before, &profile, self.time) {
                Ok(false) if accurate.counts().residuals > MOST_RESIDUALS => break Err(Unsettled::Exhausted),
                Ok(false) => {}
                Ok(true) => break Ok(()),
                Err(stalled) => break Err(stalled.into()),
            }
        };
        before.start_work += accurate.counts();
        self.take_start(before);
        outcome
    }

    /// Takes over the state that another plant of the same belt has found, with its loads and work.
    pub fn take_start(&mut self, found: Self) {
        self.state = found.state;
        self.system.loads = found.system.loads;
        self.start_work = found.start_work;
        self.end_soft_start();
    }
}
