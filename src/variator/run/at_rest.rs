//! Starts of a belt that clamping forces hold: they act on the unloaded belt before the run begins.

use crate::pulley::Pulley;
use crate::solver::sdirk::Stalled;
use crate::variator::run::course::Course;
use crate::variator::run::soft_start::SHARPENING;
use crate::variator::run::variator::{Variator, integrator};
use crate::variator::settings::parameters::Axial;
use crate::variator::settings::signals::Inputs;
use crate::variator::survey::belt_survey::NO_FORCE;

/// Time in which a clamped belt settles at a standstill, s, and the tolerance of the way there: only its end counts.
const SETTLING: f64 = 0.2;
const SETTLING_TOLERANCE: f64 = 1.0e-2;

impl Variator {
    /// Clamps and settles an unloaded belt at a standstill. Whether there is something to clamp it with.
    ///
    /// # Errors
    /// The time at which it stalled; the belt is then clamped in part.
    pub(super) fn clamp_at_rest(&mut self, inputs: &Inputs) -> Result<bool, Stalled> {
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
    /// As [`Variator::clamp_at_rest`].
    pub(super) fn clamp_softly(&mut self, inputs: &Inputs) -> Result<(), Stalled> {
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
        self.integrator = integrator(&self.system);
        let course = Course::new(0.0, [self.time, start], &quiet, &quiet, &Inputs::ZERO);
        let outcome = self.integrate_along(&course, start);
        self.system.parameters.solver.tolerance = own;
        self.time = start;
        self.forget_history();
        outcome
    }
}
