//! How a plant is advanced within a communication step: one trait, and the accurate integrator.

use std::fmt::Debug;

use crate::archive::Archive;
use crate::solver::newton::Counts;
use crate::solver::sdirk::{Sdirk, Span, Stalled};
use crate::variator::run::inputs::{InputProfile, SHORTEST_STEP};
use crate::variator::run::plant::Plant;
use crate::variator::settings::signals::Work;
use crate::variator::system::VariatorSystem;

/// First step from a kinematic state, s.
pub(super) const COLD_STEP: f64 = 1.0e-6;
/// First step from a steady state, s.
pub(super) const WARM_STEP: f64 = 1.0e-4;

/// Newton's tolerance at the default solver tolerance, in units of the Newton scale: tenfold changes no output of the
/// manoeuvre in the fourth digit.
pub(super) const NEWTON_TOLERANCE: f64 = 20.0;

/// How many times wider it is where steps err as much as is tolerated. What an iteration then leaves is some tenth of such an error,
/// as in CVODE (Hindmarsh et al. 2005). Less so at tighter tolerances: they serve to compare small differences.
const NEWTON_WIDENING: f64 = 60.0;

/// Advances a plant to the end of a communication step in own steps.
pub(super) trait Stepper: Debug + Send + Sync {
    /// A copy.
    fn boxed(&self) -> Box<dyn Stepper>;

    /// Begins a communication step between two times, s.
    fn begin(&mut self, span: [f64; 2]);

    /// Takes note that the inputs, or the end of the communication step, have changed: from now to the end, s.
    fn restart(&mut self, span: [f64; 2]);

    /// One own step towards a time, s. Returns whether that time is reached.
    ///
    /// # Errors
    /// A step that can't be done.
    fn step(&mut self, plant: &mut Plant, profile: &InputProfile, to: f64) -> Result<bool, Stalled>;

    /// Ends a communication step at the plant's time. Returns the work since the start, and what the step left.
    fn finish(&mut self, plant: &mut Plant, profile: &InputProfile) -> Work;

    /// Work since the start.
    fn counts(&self) -> Counts;

    /// ÿ of an unknown at the end of the last step, as far as it is known; else 0.
    fn slope_rate(&self, _unknown: usize) -> f64 {
        0.0
    }

    /// Starts again from the plant's state, where a communication step began that can't be done: with the step size of then, without
    /// anything else from earlier steps. The counts remain. A stepper that can do each step needs nothing.
    fn start_again(&mut self, _plant: &Plant) {}

    /// Takes note that the laws have changed.
    fn change_laws(&mut self) {}

    /// Writes to an archive, or reads from it, all that later steps depend on beside the plant.
    fn serialize(&mut self, archive: &mut Archive<'_>);
}

impl Clone for Box<dyn Stepper> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

/// Work as outputs, with a defect as a share of what accurate steps tolerate.
pub(super) fn work(counts: Counts, defect: f64) -> Work {
    let output = |count: u64| i32::try_from(count).unwrap_or(i32::MAX);
    Work {
        steps: output(counts.steps + counts.rejected + counts.failed),
        jacobians: output(counts.factorizations),
        residuals: output(counts.residuals),
        defect,
        behind: 0.0,
        rollbacks: 0,
    }
}

/// Steps as the error control requires.
#[derive(Clone, Debug)]
pub(super) struct Accurate {
    sdirk: Sdirk,
    /// Time over which loads change alike, in steps; none before the first of them.
    span: Option<Span>,
    /// Preferred step where the communication step began, s.
    first_step: f64,
}

impl Accurate {
    pub fn new(system: &VariatorSystem, first_step: f64) -> Self {
        let solver = &system.parameters.solver;
        let mut sdirk = Sdirk::new(system, first_step, solver.max_step);
        let share = solver.tolerance / 1.0e-4;
        sdirk.newton_tolerance = (NEWTON_TOLERANCE * share).clamp(0.05, 100.0);
        sdirk.newton_widening = NEWTON_WIDENING * share.min(1.0);
        Self {
            sdirk,
            span: None,
            first_step,
        }
    }
}

impl Stepper for Accurate {
    fn boxed(&self) -> Box<dyn Stepper> {
        Box::new(self.clone())
    }

    fn begin(&mut self, span: [f64; 2]) {
        self.sdirk.newton.left = 0.0;
        self.first_step = self.sdirk.step;
        self.restart(span);
    }

    fn restart(&mut self, _span: [f64; 2]) {
        self.span = None;
    }

    fn step(&mut self, plant: &mut Plant, profile: &InputProfile, to: f64) -> Result<bool, Stalled> {
        let mut span = self.span.take().unwrap_or_else(|| {
            let segment = profile.segment(plant.time);
            let piece = plant.time + plant.soft_start.piece(plant.time);
            plant.apply(segment);
            Span::new(plant.time, to.min(piece).min(segment.until))
        });
        let (mut running, state) = plant.running();
        if let Err(stalled) = self.sdirk.step(&mut running, state, &mut span) {
            plant.time = stalled.time;
            return Err(stalled);
        }
        plant.time = span.reached();
        if !span.is_over() {
            self.span = Some(span);
            return Ok(false);
        }
        let is_over = to - plant.time < SHORTEST_STEP;
        if is_over {
            plant.time = to;
        }
        Ok(is_over)
    }

    fn finish(&mut self, _plant: &mut Plant, _profile: &InputProfile) -> Work {
        work(self.counts(), self.sdirk.newton.left)
    }

    fn counts(&self) -> Counts {
        self.sdirk.newton.counts
    }

    fn slope_rate(&self, unknown: usize) -> f64 {
        self.sdirk.slope_rate(unknown)
    }

    fn start_again(&mut self, plant: &Plant) {
        let counts = self.counts();
        *self = Self::new(&plant.system, self.first_step);
        self.sdirk.newton.counts = counts;
    }

    fn change_laws(&mut self) {
        self.sdirk.newton.forget_rate();
    }

    fn serialize(&mut self, archive: &mut Archive<'_>) {
        self.sdirk.serialize(archive);
    }
}
