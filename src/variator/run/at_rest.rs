//! Starts of a belt that clamping forces hold: they act on the unloaded belt before the run begins.

use crate::pulley::Pulley;
use crate::solver::sdirk::Stalled;
use crate::variator::run::inputs::InputProfile;
use crate::variator::run::plant::Plant;
use crate::variator::run::soft_start::SHARPENING;
use crate::variator::run::stepper::{Accurate, COLD_STEP, Stepper};
use crate::variator::settings::parameters::Axial;
use crate::variator::settings::signals::Inputs;
use crate::variator::survey::belt_survey::NO_FORCE;

/// Time in which a clamped belt settles at a standstill, s, and the tolerance of the steps: only the end counts.
const SETTLING: f64 = 0.2;
const SETTLING_TOLERANCE: f64 = 1.0e-2;

impl Plant {
    /// Clamps and settles an unloaded belt at a standstill. Whether there is something to clamp it with.
    ///
    /// # Errors
    /// The time at which it stalled; the belt is then clamped in part.
    pub fn clamp_at_rest(&mut self, inputs: &Inputs) -> Result<bool, Stalled> {
        let p = &self.system.parameters;
        let loose =
            |pulley: Pulley| p.pulley(pulley).axial == Axial::Force && inputs.pulley(pulley).clamping_force < NO_FORCE;
        if p.holds_both_sheaves() || Pulley::BOTH.into_iter().any(loose) {
            return Ok(false);
        }
        let tolerance = p.solver.tolerance.max(SETTLING_TOLERANCE);
        self.clamp_before(SETTLING, tolerance, inputs)?;
        Ok(true)
    }

    /// Lets clamping forces come in over the first milliseconds, so that a run without load begins clamped.
    ///
    /// # Errors
    /// As [`Plant::clamp_at_rest`].
    pub fn clamp_softly(&mut self, inputs: &Inputs) -> Result<(), Stalled> {
        self.clamp_before(SHARPENING, self.system.parameters.solver.tolerance, inputs)
    }

    /// Lets the clamping forces act on an unloaded belt in the `span` before the start, s. Torques come with the run.
    fn clamp_before(&mut self, span: f64, tolerance: f64, inputs: &Inputs) -> Result<(), Stalled> {
        let mut quiet = *inputs;
        (quiet.primary.torque, quiet.secondary.torque) = (0.0, 0.0);
        let start = self.time;
        self.time = start - span;
        self.soft_start.from = self.time;
        let own = std::mem::replace(&mut self.system.parameters.solver.tolerance, tolerance);
        let mut accurate = Accurate::new(&self.system, COLD_STEP);
        let profile = InputProfile::constant(self.time, &quiet);
        let outcome = loop {
            match accurate.step(self, &profile, start) {
                Ok(false) => {}
                outcome => break outcome,
            }
        };
        self.system.parameters.solver.tolerance = own;
        self.time = start;
        self.end_soft_start();
        outcome.map(drop)
    }
}
